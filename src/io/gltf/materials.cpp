// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>

#include "base/tasks.h"
#include "gnomon/error.h"
#include "io/gltf/build.h"
#include "io/gltf/image_header.h"
#include "io/gltf/specular_glossiness.h"
#include "io/image/image_file.h"
#include "scene/material_layers.h"

namespace gnomon::io::gltf {

namespace {

// A use of a texture without the texture: which coordinates, and how they are transformed.
scene::TextureUse place_of(const TextureInfo& info)
{
    scene::TextureUse result;
    result.texcoord = static_cast<int>(std::min<std::uint64_t>(info.texcoord, 1));
    result.offset = info.offset;
    result.scale = info.scale;
    result.rotation = info.rotation;
    return result;
}

scene::Wrap wrap(int code)
{
    constexpr int clamp_to_edge = 33071, mirrored_repeat = 33648;
    return code == clamp_to_edge     ? scene::Wrap::clamp
           : code == mirrored_repeat ? scene::Wrap::mirror
                                     : scene::Wrap::repeat;
}

scene::Sampler sampler_of(const Sampler& s)
{
    // OpenGL's codes: NEAREST, LINEAR, then both with mipmaps.
    constexpr int nearest = 9728, linear = 9729, nearest_mip_nearest = 9984, nearest_mip_linear = 9986;
    scene::Sampler result;
    result.wrap_u = wrap(s.wrap_s);
    result.wrap_v = wrap(s.wrap_t);
    if (s.magnify == nearest) result.magnify = scene::Filter::nearest;
    if (s.minify == nearest || s.minify == nearest_mip_nearest || s.minify == nearest_mip_linear)
        result.minify = scene::Filter::nearest;
    result.mipmaps = s.minify != nearest && s.minify != linear;
    return result;
}

}   // namespace

Materials::Materials(const Model& model, Data& data, scene::Scene& out, Context& context)
    : model_(model), data_(data), out_(out), context_(context), first_(model.images.size(), k_absent)
{
    // Images may overlap in a buffer, as accessors may.
    pixels_left_ = context.limits.pixels + context.limits.pixels_per_byte * data.total_bytes();
    view_bytes_left_ = context.limits.numbers + context.limits.numbers_per_byte * data.total_bytes();
}

// Images with the same source are decoded once, as the first of them.
Index Materials::first_of(Index index)
{
    Index& first = first_[index];
    if (first != k_absent) return first;
    const Image& image = model_.images[index];
    std::string source;
    if (image.uri) {
        const std::string place = at(at("/images", index), "uri");
        bool missing = false;
        source = data_.resource_file(*image.uri, place, missing).string();
        if (missing) {
            context_.repair(Fault::missing_image, place,
                            [&] { return fmt::format("'{}' does not exist", image.uri->substr(0, 200)); });
            images_[index].read = true;
        }
    } else if (image.view != k_absent) {
        const BufferView& view = model_.views[image.view];
        // Paths are absolute, so this key differs from every path.
        source = fmt::format("{} {} {}", view.buffer, view.offset, view.length);
    }
    first = source.empty() ? index : by_source_.try_emplace(std::move(source), index).first->second;
    return first;
}

std::optional<std::vector<std::uint8_t>> Materials::bytes_of(Index index)
{
    const Image& image = model_.images[index];
    const std::string here = at("/images", index);
    if (image.uri) {
        std::string mime_type = image.mime_type;
        return data_.resource_bytes(*image.uri, at(here, "uri"), mime_type);
    }
    if (image.view == k_absent) return std::vector<std::uint8_t>();
    const auto bytes = data_.view_bytes(image.view);
    return std::vector<std::uint8_t>(bytes.begin(), bytes.end());
}

// Decodes an image when it is first asked for.
Materials::DecodedImage& Materials::known_image(Index index)
{
    index = first_of(index);
    DecodedImage& image = images_[index];
    if (image.read) return image;
    image.read = true;
    const std::string here = at("/images", index);
    const std::optional<std::vector<std::uint8_t>> contents = bytes_of(index);
    if (!contents) return image;
    const std::vector<std::uint8_t>& bytes = *contents;
    if (bytes.empty()) {
        context_.warn(here, "has no data: its textures are left out");
        return image;
    }
    if (format_of(bytes) == ImageFormat::other) {
        context_.warn(here, "is neither PNG nor JPEG nor WebP: its textures are left out");
        return image;
    }
    // Bound the decoded pixels by the size of the data. Bytes of buffers are already counted.
    if (model_.images[index].uri) {
        pixels_left_ += bytes.size() * context_.limits.pixels_per_byte;
    } else {
        if (bytes.size() > view_bytes_left_)
            context_.fail(here, "the images overlap so much that reading them would take too long");
        view_bytes_left_ -= bytes.size();
    }
    decode(index, bytes, pixels_left_);
    return image;
}

void Materials::decode(Index index, std::span<const std::uint8_t> bytes, std::uint64_t most_pixels)
{
    DecodedImage& image = images_[index];
    const std::string here = at("/images", index);
    ImageLimits limits;
    limits.stored_values = true;   // [glTF 2.0, 3.8.3]: colour space information in PNG files is ignored
    limits.max_pixels = std::min(limits.max_pixels, most_pixels);
    try {
        const ImageNeeds needs = image_needs(bytes, here, limits);
        const bool first = image.width == 0;
        if (first && !ahead_.contains(index)) decode_ahead(index, bytes, needs.bytes + bytes.size());
        make_room(needs.bytes + bytes.size(), here, "the image");
        if (auto known = ahead_.extract(index)) {
            image.image = std::move(known.mapped());
            ahead_bytes_ -= image.image.data.size();
        } else {
            image.image = decode_image(bytes, here, limits);
        }
    } catch (const InputError& error) {
        context_.fail(here, error.problem());
    }
    image.width = image.image.width, image.height = image.image.height, image.channels = image.image.channels;
    decoded_bytes_ += image.image.data.size();
}

// Whether an image can be read without a repair or a warning.
bool Materials::is_at_hand(Index index) const
{
    const Image& image = model_.images[index];
    if (image.view != k_absent) return !data_.view_bytes(image.view).empty();
    if (!image.uri) return false;
    if (image.uri->starts_with("data:")) return true;
    bool missing = false;
    return !data_.resource_file(*image.uri, at(at("/images", index), "uri"), missing).empty() && !missing;
}

// Decodes an image, and in parallel the next ones that materials will ask for, as far as there is plenty of memory for
// it. What is wrong with one of them is found when it is asked for.
// @param needed  bytes that decoding the image takes
void Materials::decode_ahead(Index index, std::span<const std::uint8_t> bytes, std::uint64_t needed)
{
    constexpr std::size_t k_images = 16, k_tries = 64;
    constexpr std::uint64_t k_bytes = 256ull << 20;
    struct Job {
        Index image;
        std::vector<std::uint8_t> own;
        std::span<const std::uint8_t> bytes;
        Image8 decoded;
    };
    ImageLimits limits;
    limits.stored_values = true;
    std::vector<Job> jobs;
    jobs.push_back({index, {}, bytes, {}});
    std::uint64_t pixels = 0;
    std::size_t tries = 0;
    // Adds a job for a texture's image. Returns whether the image need not be looked at again.
    const auto consider = [&](const TextureInfo& info) {
        if (info.texture == k_absent) return true;
        const Index source = model_.textures[info.texture].source;
        if (source == k_absent) return true;
        try {
            if (!is_at_hand(source)) return true;
            const Index image = first_of(source);
            const auto known = images_.find(image);
            if ((known != images_.end() && known->second.read) || ahead_.contains(image)) return true;
            if (std::ranges::any_of(jobs, [&](const Job& job) { return job.image == image; })) return true;
            if (jobs.size() == k_images || ++tries > k_tries) return false;
            Job job{image, {}, {}, {}};
            if (const Index view = model_.images[image].view; view != k_absent)
                job.bytes = data_.view_bytes(view);
            else
                job.bytes = job.own = bytes_of(image).value_or(std::vector<std::uint8_t>());
            if (format_of(job.bytes) == ImageFormat::other) return true;
            const ImageNeeds needs = image_needs(job.bytes, "", limits);
            const auto size = static_cast<std::uint64_t>(needs.width) * static_cast<std::uint64_t>(needs.height);
            const std::uint64_t more = needs.bytes + job.bytes.size();
            if (more > k_bytes || size > pixels_left_) return true;
            const std::uint64_t all = needed + more + ahead_bytes_;
            if (all > k_bytes || !context_.memory.has_room(decoded_bytes_ + 2 * all)) return false;
            if (pixels + size > pixels_left_) return false;
            needed += more, pixels += size;
            jobs.push_back(std::move(job));
        } catch (const InputError&) {
            return true;
        }
        return true;
    };
    // Collect images of the materials that follow.
    for (; next_ahead_ < model_.materials.size(); ++next_ahead_) {
        const Material& m = model_.materials[next_ahead_];
        if (!(consider(m.base_color_texture) && consider(m.metallic_roughness_texture) && consider(m.normal_texture) &&
              consider(m.emissive_texture)))
            break;
    }
    if (jobs.size() == 1) return;
    Tasks().for_each(jobs.size(), [&](std::size_t i, int) {
        try {
            jobs[i].decoded = decode_image(jobs[i].bytes, "", limits);
        } catch (const InputError&) {
        }
    });
    for (Job& job : jobs) {
        if (job.decoded.empty()) continue;
        ahead_bytes_ += job.decoded.data.size();
        ahead_.emplace(job.image, std::move(job.decoded));
    }
}

// The pixels of an image that is usable. A released one is decoded again.
const Image8& Materials::decoded_image(Index index)
{
    index = first_of(index);
    const DecodedImage& image = images_[index];
    if (image.image.empty())
        decode(index, bytes_of(index).value_or(std::vector<std::uint8_t>()),
               static_cast<std::uint64_t>(image.width) * image.height);
    return image.image;
}

// Makes room for `bytes` that are needed for a moment beside the images that are decoded.
void Materials::make_room(std::uint64_t bytes, const std::string& pointer, const char* what)
{
    // What was decoded ahead does not ask for room.
    if (ahead_bytes_ > 0 && !context_.memory.has_room(decoded_bytes_ + ahead_bytes_ + bytes)) {
        ahead_.clear();
        ahead_bytes_ = 0;
    }
    context_.memory.make_room(decoded_bytes_ + bytes, out_.textures, {context_.file(), pointer, what});
}

// Releases decoded pixels if they have become many. Textures that were made of them keep their own.
void Materials::release_images()
{
    constexpr std::uint64_t k_most = 16ull << 20;
    if (decoded_bytes_ <= k_most) return;
    for (auto& [index, image] : images_) image.image = {};
    decoded_bytes_ = 0;
}

// Makes a texture of an image, which is decoded or among `bytes` that are held for a moment.
scene::TextureId Materials::add_texture(std::string name, const Image8& image, bool srgb, const scene::Sampler& sampler,
                                        bool without_alpha, std::uint64_t bytes, const std::string& pointer)
{
    const auto id = static_cast<scene::TextureId>(out_.textures.size());
    const scene::MemoryBudget::Expected expected = context_.memory.expect(image.width, image.height);
    // Leaving out alpha takes a copy.
    constexpr std::uint64_t k_rgba = 4;
    const std::uint64_t copied =
        without_alpha ? k_rgba * image.data.size() / static_cast<std::uint64_t>(image.channels) : 0;
    make_room(bytes + copied, pointer, "the texture");
    out_.textures.push_back(context_.memory.make(expected, std::move(name), image, srgb, sampler, without_alpha));
    context_.memory.made(expected, id);
    return id;
}

void Materials::check_unused()
{
    for (Index i = 0; i < model_.images.size(); ++i) {
        if (first_of(i) != i) continue;
        if (const auto known = images_.find(i); known != images_.end() && known->second.read) continue;
        const Image& image = model_.images[i];
        const std::string fault = !image.uri && image.view != k_absent
                                      ? header_fault(data_.view_bytes(image.view))
                                      : header_fault(bytes_of(i).value_or(std::vector<std::uint8_t>()));
        if (!fault.empty()) context_.fail(at("/images", i), fault);
    }
    images_.clear();
    ahead_.clear();
    ahead_bytes_ = 0;
}

const Materials::DecodedImage* Materials::known_image_for(const TextureInfo& info, const std::string& pointer)
{
    if (info.texture == k_absent) return nullptr;
    const Texture& texture = model_.textures[info.texture];
    if (texture.source == k_absent) {
        context_.warn(pointer, texture.compressed
                                   ? fmt::format("texture {} has only a KTX 2 image (KHR_texture_basisu): left out; "
                                                 "convert it, for example with 'gltf-transform ktxdecompress'",
                                                 info.texture)
                                   : fmt::format("texture {} has no image: left out", info.texture));
        return nullptr;
    }
    constexpr std::uint64_t sets = 2;
    if (info.texcoord >= sets) {
        context_.warn(pointer,
                      fmt::format("uses texture coordinates {}: only 0 and 1 are supported; left out", info.texcoord));
        return nullptr;
    }
    const DecodedImage& image = known_image(texture.source);
    return image.usable() ? &image : nullptr;
}

const Image8* Materials::image_for(const TextureInfo& info, const std::string& pointer)
{
    return known_image_for(info, pointer) ? &decoded_image(model_.textures[info.texture].source) : nullptr;
}

scene::Sampler Materials::sampler_for(const TextureInfo& info) const
{
    const Index sampler = model_.textures[info.texture].sampler;
    return sampler == k_absent ? scene::Sampler() : sampler_of(model_.samplers[sampler]);
}

scene::TextureUse Materials::use(const TextureInfo& info, bool srgb, bool alpha, const std::string& pointer)
{
    release_images();
    const DecodedImage* const found = known_image_for(info, pointer);
    if (!found) return {};
    scene::TextureUse result = place_of(info);
    const DecodedImage& image = *found;
    const Texture& texture = model_.textures[info.texture];
    const scene::Sampler sampler = sampler_for(info);
    const Index first = first_of(texture.source);
    // Drop alpha where it is not used, because coarser mip levels would weight the other channels by it.
    const bool drop_alpha = !alpha && (image.channels == 2 || image.channels == 4);
    const std::tuple key(first, static_cast<int>(sampler.wrap_u), static_cast<int>(sampler.wrap_v),
                         static_cast<int>(sampler.magnify) * 2 + static_cast<int>(sampler.minify),
                         static_cast<int>(sampler.mipmaps), srgb, drop_alpha);
    auto [made, fresh] = textures_.try_emplace(key, scene::none);
    if (fresh) {
        const auto pixels = static_cast<std::uint64_t>(image.width) * static_cast<std::uint64_t>(image.height);
        if (pixels > pixels_left_)
            context_.fail(pointer, "the textures are far larger than the size of the file allows");
        pixels_left_ -= pixels;
        const Image& source = model_.images[texture.source];
        std::string name = !texture.name.empty()  ? texture.name
                           : !source.name.empty() ? source.name
                                                  : fmt::format("image {}", texture.source);
        made->second =
            add_texture(std::move(name), decoded_image(texture.source), srgb, sampler, drop_alpha, 0, pointer);
    }
    result.texture = made->second;
    return result;
}

// Converts specular-glossiness to metallic-roughness: the factors alone, or new textures.
void Materials::use_glossiness(const Glossiness& g, bool alpha, const std::string& pointer, scene::Material& out)
{
    const glm::vec3 diffuse(g.diffuse[0], g.diffuse[1], g.diffuse[2]);
    const glm::vec3 specular(g.specular[0], g.specular[1], g.specular[2]);
    out.alpha = g.diffuse[3];
    release_images();
    const Image8* const diffuse_image = image_for(g.diffuse_texture, at(pointer, "diffuseTexture"));
    const Image8* const specular_image = image_for(g.specular_texture, at(pointer, "specularGlossinessTexture"));
    if (!diffuse_image && !specular_image) {
        const MetallicRoughness converted = metallic_from_specular(diffuse, specular);
        out.base_color = converted.base_color;
        out.metallic = converted.metallic;
        out.roughness = 1 - g.glossiness;
        return;
    }
    // The images are laid over each other, by the coordinates of the first that there is.
    const Image8 none;
    const Image8 &first = diffuse_image ? *diffuse_image : none, &second = specular_image ? *specular_image : none;
    const std::uint64_t pixels = static_cast<std::uint64_t>(std::max(first.width, second.width)) *
                                 static_cast<std::uint64_t>(std::max(first.height, second.height));
    if (2 * pixels > pixels_left_)
        context_.fail(pointer, "the textures are far larger than the size of the file allows");
    pixels_left_ -= 2 * pixels;
    constexpr std::uint64_t k_bytes_per_pixel = 4 + 3;   // of both results
    make_room(k_bytes_per_pixel * pixels, pointer, "the texture");
    const ConvertedImages images = metallic_from_specular(first, second, diffuse, specular, g.glossiness);
    const std::uint64_t held = images.base_color.data.size() + images.metallic_roughness.data.size();
    const TextureInfo& shared = diffuse_image ? g.diffuse_texture : g.specular_texture;
    const auto add = [&](const char* name, const Image8& image, bool srgb) {
        scene::TextureUse result = place_of(shared);
        result.texture =
            add_texture(name, image, srgb, sampler_for(shared), !alpha && image.channels == 4, held, pointer);
        return result;
    };
    out.base_color = glm::vec3(1);
    out.base_color_texture = add("base colour of specular-glossiness", images.base_color, true);
    out.metallic = out.roughness = 1;
    out.metallic_roughness_texture = add("metallic-roughness of specular-glossiness", images.metallic_roughness, false);
}

// Fills in the layers. Without KHR_materials_volume, or with a thickness of 0, transmission is that of a thin wall.
void Materials::use_layers(const Material& material, const std::string& pointer, scene::Material& out)
{
    const Layers& l = *material.layers;
    const auto color = [](const std::array<float, 3>& c) { return glm::vec3(c[0], c[1], c[2]); };
    scene::MaterialLayers to;
    to.specular = l.specular, to.specular_color = color(l.specular_color);
    to.clearcoat = l.clearcoat, to.clearcoat_roughness = l.clearcoat_roughness;
    to.clearcoat_normal_scale = l.clearcoat_normal_texture.factor;
    to.sheen_color = color(l.sheen_color), to.sheen_roughness = l.sheen_roughness;
    to.anisotropy = l.anisotropy, to.anisotropy_rotation = l.anisotropy_rotation;
    to.iridescence = l.iridescence, to.iridescence_ior = l.iridescence_ior;
    to.iridescence_thickness_least = l.iridescence_thickness_least;
    to.iridescence_thickness_most = l.iridescence_thickness_most;
    to.thin_walled = !(l.thickness > 0);
    to.thickness = l.thickness, to.dispersion = l.dispersion;
    to.attenuation_distance = l.attenuation_distance, to.attenuation_color = color(l.attenuation_color);
    static_assert(std::size(k_layer_textures) == std::size(scene::k_layer_textures));
    constexpr scene::TextureUse scene::MaterialLayers::*targets[] = {
        &scene::MaterialLayers::specular_texture,         &scene::MaterialLayers::specular_color_texture,
        &scene::MaterialLayers::clearcoat_texture,        &scene::MaterialLayers::clearcoat_roughness_texture,
        &scene::MaterialLayers::clearcoat_normal_texture, &scene::MaterialLayers::sheen_color_texture,
        &scene::MaterialLayers::sheen_roughness_texture,  &scene::MaterialLayers::anisotropy_texture,
        &scene::MaterialLayers::iridescence_texture,      &scene::MaterialLayers::iridescence_thickness_texture,
        &scene::MaterialLayers::transmission_texture,     &scene::MaterialLayers::thickness_texture};
    for (std::size_t i = 0; i < std::size(targets); ++i) {
        const LayerTexture& from = k_layer_textures[i];
        const bool srgb = from.info == &Layers::specular_color_texture || from.info == &Layers::sheen_color_texture;
        const bool alpha = from.info == &Layers::specular_texture || from.info == &Layers::sheen_roughness_texture;
        to.*targets[i] = use(l.*from.info, srgb, alpha, at(at(pointer, from.extension), from.property));
    }
    // A block that says what holds without it is left out, so that the material costs what others do.
    scene::MaterialLayers plain;
    plain.thin_walled = out.transmission == 0 && to.thin_walled;
    const bool says_nothing = scene::same_values(to, plain);
    if (!says_nothing) out.layers = std::make_shared<const scene::MaterialLayers>(std::move(to));
}

scene::MaterialId Materials::get(Index index, const std::array<bool, 2>& has_texcoords)
{
    Material m = index == k_absent ? Material() : model_.materials[index];
    // Leave out the textures whose coordinates the primitive lacks.
    std::array<bool, 2> without{};
    bool emits_nowhere = false;
    std::vector<TextureInfo*> infos{&m.base_color_texture, &m.metallic_roughness_texture, &m.normal_texture,
                                    &m.occlusion_texture, &m.emissive_texture};
    if (m.glossiness) infos.insert(infos.end(), {&m.glossiness->diffuse_texture, &m.glossiness->specular_texture});
    if (m.layers)
        for (const LayerTexture& texture : k_layer_textures) infos.push_back(&(*m.layers.*texture.info));
    for (TextureInfo* info : infos) {
        if (!info || info->texture == k_absent || info->texcoord >= 2 || has_texcoords[info->texcoord]) continue;
        without[info->texcoord] = true;
        if (info == &m.emissive_texture) emits_nowhere = true;   // only the texture says where it emits
        info->texture = k_absent;
    }
    Made by_default{default_, false};
    Made& made = index == k_absent ? by_default : made_[{index, without}];
    if (made.id != scene::none) return made.id;
    const std::string here = at("/materials", index);
    const std::string pbr = at(here, "pbrMetallicRoughness");

    scene::Material out;
    out.name = m.name;
    out.model = m.unlit ? scene::ShadingModel::unlit : scene::ShadingModel::metallic_roughness;
    out.base_color = {m.base_color[0], m.base_color[1], m.base_color[2]};
    out.alpha = m.base_color[3];
    out.double_sided = m.double_sided;
    out.alpha_mode = m.alpha_mode == "MASK"    ? scene::AlphaMode::mask
                     : m.alpha_mode == "BLEND" ? scene::AlphaMode::blend
                                               : scene::AlphaMode::opaque;
    out.alpha_cutoff = m.alpha_cutoff;
    const bool has_alpha = out.alpha_mode != scene::AlphaMode::opaque;
    if (!m.glossiness) {
        out.base_color_texture = use(m.base_color_texture, true, has_alpha, at(pbr, "baseColorTexture"));
        out.metallic = m.metallic;
        out.roughness = m.roughness;
        out.metallic_roughness_texture =
            use(m.metallic_roughness_texture, false, false, at(pbr, "metallicRoughnessTexture"));
    }
    if (m.glossiness)
        use_glossiness(*m.glossiness, has_alpha, at(at(here, "extensions"), "KHR_materials_pbrSpecularGlossiness"),
                       out);
    out.normal_texture = use(m.normal_texture, false, false, at(here, "normalTexture"));
    out.normal_scale = m.normal_texture.factor;
    out.occlusion_texture = use(m.occlusion_texture, false, false, at(here, "occlusionTexture"));
    out.occlusion_strength = m.occlusion_texture.factor;
    out.emissive = m.emissive_strength * glm::vec3(m.emissive[0], m.emissive[1], m.emissive[2]);
    out.emissive_texture = use(m.emissive_texture, true, false, at(here, "emissiveTexture"));
    if (m.emissive_texture.texture != k_absent && out.emissive_texture.texture == scene::none) emits_nowhere = true;
    if (emits_nowhere) out.emissive = {0, 0, 0};
    out.transmission = m.transmission;
    out.ior = m.ior > 0 ? m.ior : 1.5f;   // 0 selects an old gloss model [KHR_materials_ior]
    if (m.layers && !m.unlit) use_layers(m, at(here, "extensions"), out);

    made = {static_cast<scene::MaterialId>(out_.materials.size()), emits_nowhere};
    if (index == k_absent) default_ = made.id;
    out_.materials.push_back(std::move(out));
    return made.id;
}

std::vector<Materials::Made> Materials::made_of(Index material) const
{
    std::vector<Made> result;
    for (auto at = made_.lower_bound({material, {}}); at != made_.end() && at->first.first == material; ++at)
        if (at->second.id != scene::none) result.push_back(at->second);
    return result;
}

}   // namespace gnomon::io::gltf
