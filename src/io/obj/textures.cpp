// SPDX-License-Identifier: Apache-2.0
#include "io/obj/textures.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <tuple>
#include <unordered_set>

#include "base/interruption.h"
#include "base/tasks.h"
#include "gnomon/error.h"
#include "io/image/image_file.h"

namespace gnomon::io {

namespace {

constexpr std::uint64_t k_largest_image_file = 1ull << 30;
// Limit on texels beyond those of each file: one file may be used with many options of its map or with many masks.
constexpr std::uint64_t k_most_repeated_texels = 1ull << 26;
constexpr std::size_t k_batch = 4;                     // textures that are made before limits are checked
constexpr std::uint64_t k_batch_bytes = 64ull << 20;   // for a moment: with so much, a batch has no further texture
constexpr float k_texels_per_height = 4;               // for -bm 1, white is this many texels higher than black
constexpr int k_grey_tolerance = 12;                   // of 255: in a grey JPEG, channels differ by rounding

enum class Role : std::uint8_t { color, masked_color, bump, normal, roughness_metallic };

// A texture to make from one or two files.
struct Job {
    Role role = Role::color;
    MtlMap first, second;   // colour and mask; roughness and metallic
    const std::string& name() const { return first.used() ? first.file : second.file; }
    auto key() const
    {
        return std::tuple(role, first.file, second.file, first.clamp, second.channel, first.bump, second.range.x,
                          second.range.y);
    }
};

// An image file before it is decoded.
struct Source {
    std::vector<std::uint8_t> bytes;
    ImageNeeds needs;
    bool used() const { return needs.width > 0; }
    std::uint64_t pixels() const
    {
        return static_cast<std::uint64_t>(needs.width) * static_cast<std::uint64_t>(needs.height);
    }
};

struct Made {
    Source first, second;   // until they are decoded; the second is empty if it is the first
    scene::MemoryBudget::Expected expected = 0;
    std::optional<scene::Texture> texture;
    std::vector<std::pair<std::filesystem::path, std::uint64_t>> files;   // with their numbers of pixels
    std::vector<std::string> warnings;
};

void leave_out(const MtlMap& map, const std::string& problem, Made& made)
{
    made.warnings.push_back(fmt::format("texture '{}' is left out: {}", shown(map.file), problem));
}

Source open(const SceneFolder& folder, const MtlMap& map, Made& made)
{
    Source source;
    if (!map.used()) return source;
    std::string problem;
    if (const auto path = folder.find(map.file, problem)) {
        try {
            source.bytes = read_whole_file(*path, map.file, k_largest_image_file);
            source.needs = image_needs(source.bytes, map.file);
            made.files.emplace_back(*path, source.pixels());
            if (!problem.empty()) made.warnings.push_back(fmt::format("texture '{}' {}", shown(map.file), problem));
            return source;
        } catch (const InputError& error) {
            problem = error.problem();
        }
    }
    leave_out(map, problem, made);
    return {};
}

std::optional<Image8> decode(Source source, const MtlMap& map, Made& made)
{
    if (!source.used()) return std::nullopt;
    try {
        return decode_image(source.bytes, map.file);
    } catch (const InputError& error) {
        leave_out(map, error.problem(), made);
        return std::nullopt;
    }
}

// The texel of an image that corresponds to (x, y) in an image of another size.
const std::uint8_t* nearest(const Image8& image, int x, int y, const Image8& like)
{
    return image.pixel(static_cast<int>(static_cast<std::int64_t>(x) * image.width / like.width),
                       static_cast<int>(static_cast<std::int64_t>(y) * image.height / like.height));
}

// Opacity, 0 to 255: the channel given by -imfchan, else alpha if the image has it, else brightness.
std::uint8_t opacity(const std::uint8_t* p, int channels, const MtlMap& map)
{
    const bool has_alpha = channels == 2 || channels == 4;
    float value = p[0];
    if (channels >= 3) {
        if (map.channel == 'g')
            value = p[1];
        else if (map.channel == 'b')
            value = p[2];
        else if (map.channel != 'r')
            value = (p[0] + p[1] + p[2]) / 3.0f;
    }
    if (has_alpha && (map.channel == 0 || map.channel == 'm')) value = p[channels - 1];
    value = 255 * map.range.x + map.range.y * value;
    return static_cast<std::uint8_t>(std::clamp(value + 0.5f, 0.0f, 255.0f));
}

Image8 with_mask(const std::optional<Image8>& color, const Image8& mask, const MtlMap& map)
{
    // Use the size of the larger image.
    const bool mask_larger = !color || static_cast<std::int64_t>(mask.width) * mask.height >
                                           static_cast<std::int64_t>(color->width) * color->height;
    const Image8& like = mask_larger ? mask : *color;
    Image8 result(like.width, like.height, 4);
    for (int y = 0; y < result.height; ++y) {
        for (int x = 0; x < result.width; ++x) {
            std::uint8_t* const out = result.pixel(x, y);
            out[0] = out[1] = out[2] = 255;
            if (color) {
                const std::uint8_t* const p = nearest(*color, x, y, result);
                const bool grey = color->channels < 3;
                for (int c = 0; c < 3; ++c) out[c] = p[grey ? 0 : c];
            }
            out[3] = opacity(nearest(mask, x, y, result), mask.channels, map);
        }
    }
    return result;
}

bool is_grey(const Image8& image)
{
    if (image.channels < 3) return true;
    for (int y = 0; y < image.height; ++y) {
        for (int x = 0; x < image.width; ++x) {
            const std::uint8_t* const p = image.pixel(x, y);
            const auto [low, high] = std::minmax({p[0], p[1], p[2]});
            if (high - low > k_grey_tolerance) return false;
        }
    }
    return true;
}

// Computes normals of a height field: x to the right, y up the image, z out of it.
Image8 normals_from_heights(const Image8& heights, float bump)
{
    const int w = heights.width, h = heights.height;
    const auto height = [&](int x, int y) { return heights.pixel((x + w) % w, (y + h) % h)[0] / 255.0f; };
    Image8 result(w, h, 3);
    for (int y = 0; y < h; ++y) {
        for (int x = 0; x < w; ++x) {
            const float scale = 0.5f * bump * k_texels_per_height;
            const glm::vec3 n = glm::normalize(glm::vec3(scale * (height(x - 1, y) - height(x + 1, y)),
                                                         scale * (height(x, y + 1) - height(x, y - 1)), 1.0f));
            for (int c = 0; c < 3; ++c)
                result.pixel(x, y)[c] =
                    static_cast<std::uint8_t>(std::clamp((0.5f * n[c] + 0.5f) * 255.0f + 0.5f, 0.0f, 255.0f));
        }
    }
    return result;
}

Image8 roughness_metallic(const std::optional<Image8>& roughness, const std::optional<Image8>& metallic)
{
    const Image8& like = roughness ? *roughness : *metallic;
    Image8 result(like.width, like.height, 3);
    for (int y = 0; y < result.height; ++y) {
        for (int x = 0; x < result.width; ++x) {
            std::uint8_t* const out = result.pixel(x, y);
            out[0] = 255;
            out[1] = roughness ? nearest(*roughness, x, y, result)[0] : 255;
            out[2] = metallic ? nearest(*metallic, x, y, result)[0] : 255;
        }
    }
    return result;
}

// Opens the files of a job, and counts its texture. Returns what making it takes for a moment.
std::uint64_t open(const Job& job, const SceneFolder& folder, scene::MemoryBudget& memory, Made& made)
{
    made.first = open(folder, job.first, made);
    if (job.second.file != job.first.file) made.second = open(folder, job.second, made);
    const ImageNeeds &a = made.first.needs, &b = made.second.needs;
    // A texture of two files is as large as one of them; the other may turn out to be broken.
    const std::uint64_t pixels = std::max(made.first.pixels(), made.second.pixels());
    if (pixels == 0) return 0;
    const ImageNeeds& like = made.second.pixels() > made.first.pixels() ? b : a;
    made.expected = memory.expect(like.width, like.height);
    constexpr std::uint64_t k_bytes_per_pixel = 4;   // of an image that is made of the files'
    const bool copied = job.role != Role::color || a.channels % 2 == 0;
    return a.bytes + b.bytes + made.first.bytes.size() + made.second.bytes.size() +
           (copied ? k_bytes_per_pixel * pixels : 0);
}

void make(const Job& job, const scene::MemoryBudget& memory, Made& made)
{
    const std::optional<Image8> first = decode(std::move(made.first), job.first, made);
    const bool one_file = job.second.file == job.first.file;
    const std::optional<Image8> other = decode(std::move(made.second), job.second, made);
    const std::optional<Image8>& second = one_file ? first : other;
    if (!first && !second) return;

    // A colour file that is also its own mask means its alpha channel.
    const bool own_mask =
        one_file && job.second.channel == 0 && first && (first->channels == 1 || first->channels == 3);
    Image8 derived;   // if the texture is not that of the first file
    switch (job.role) {
        case Role::masked_color:
            if (own_mask) made.warnings.push_back(fmt::format("mask '{}' has no alpha", shown(job.second.file)));
            if (second && !own_mask) derived = with_mask(first, *second, job.second);
            break;
        case Role::bump:
            if (is_grey(*first)) derived = normals_from_heights(*first, job.first.bump);
            break;
        case Role::roughness_metallic:
            derived = roughness_metallic(first, second);
            break;
        case Role::color:
        case Role::normal:
            break;
    }
    const bool srgb = job.role == Role::color || job.role == Role::masked_color;
    scene::Sampler sampler;
    if (job.first.clamp) sampler.wrap_u = sampler.wrap_v = scene::Wrap::clamp;
    made.texture =
        memory.make(made.expected, job.name(), derived.empty() ? *first : derived, srgb, sampler, derived.empty());
}

}   // namespace

void add_obj_textures(scene::Scene& scene, const std::vector<MtlMaterial>& mtl, const SceneFolder& folder,
                      scene::MemoryBudget& memory)
{
    // List the textures to make, each once.
    struct Use {
        std::size_t job;
        std::size_t material;
        scene::TextureUse scene::Material::*slot;
        scene::TextureUse placed;
    };
    std::vector<Job> jobs;
    std::vector<Use> uses;
    std::map<decltype(Job().key()), std::size_t> known;
    const auto want = [&](std::size_t material, scene::TextureUse scene::Material::*slot, Job job) {
        if (!job.first.used() && !job.second.used()) return;
        const auto [at, added] = known.try_emplace(job.key(), jobs.size());
        const MtlMap& map = job.first.used() ? job.first : job.second;
        // OBJ counts v from the bottom row, the scene from the top: 1 - (o + s v) = (1 - o - s) + s (1 - v).
        scene::TextureUse placed;
        placed.scale = map.scale;
        placed.offset = {map.offset.x, 1 - map.offset.y - map.scale.y};
        uses.push_back({at->second, material, slot, placed});
        if (added) jobs.push_back(std::move(job));
    };
    for (std::size_t i = 0; i < mtl.size(); ++i) {
        const MtlMaterial& m = mtl[i];
        if (m.dissolve_map.used())
            want(i, &scene::Material::base_color_texture, {Role::masked_color, m.diffuse_map, m.dissolve_map});
        else
            want(i, &scene::Material::base_color_texture, {Role::color, m.diffuse_map, {}});
        if (m.normal_map.used())
            want(i, &scene::Material::normal_texture, {Role::normal, m.normal_map, {}});
        else
            want(i, &scene::Material::normal_texture, {Role::bump, m.bump_map, {}});
        want(i, &scene::Material::emissive_texture, {Role::color, m.emissive_map, {}});
        want(i, &scene::Material::metallic_roughness_texture,
             {Role::roughness_metallic, m.roughness_map, m.metallic_map});
    }

    // Decode several textures in parallel, as far as there is memory for it.
    std::vector<Made> made(jobs.size());
    Tasks tasks;
    std::set<std::filesystem::path> seen;
    std::uint64_t repeated = 0;
    std::vector<scene::TextureId> ids(jobs.size(), scene::none);
    for (std::size_t begin = 0; begin < jobs.size();) {
        report_progress("loading", 0.8 + 0.2 * static_cast<double>(begin) / static_cast<double>(jobs.size()));
        std::size_t end = begin;
        for (std::uint64_t moment = 0; end < std::min(begin + k_batch, jobs.size()) && moment < k_batch_bytes; ++end) {
            moment += open(jobs[end], folder, memory, made[end]);
            memory.make_room(moment, scene.textures, {shown(jobs[end].name()), "", "the texture"});
        }
        tasks.for_each(end - begin, [&](std::size_t i, int) { make(jobs[begin + i], memory, made[begin + i]); });
        for (std::size_t i = begin; i < end; ++i) {
            if (made[i].files.empty()) continue;
            if (!made[i].texture) {
                memory.left_out(made[i].expected);
                continue;
            }
            const scene::Texture& texture = *made[i].texture;
            std::uint64_t own = 0, most = 0;
            for (const auto& [file, pixels] : made[i].files) {
                most = std::max(most, pixels);
                if (seen.insert(file).second) own += pixels;
            }
            repeated += most - std::min(most, own);
            if (repeated > k_most_repeated_texels)
                throw InputError(texture.name(), "",
                                 fmt::format("is used for too many textures: more than {} texels repeat files",
                                             k_most_repeated_texels));
            // Ids are in the order of the jobs, which does not depend on threads.
            ids[i] = static_cast<scene::TextureId>(scene.textures.size());
            memory.made(made[i].expected, ids[i]);
            scene.textures.push_back(std::move(*made[i].texture));
            made[i].texture.reset();
        }
        begin = end;
    }
    report_progress("loading", 1);

    std::unordered_set<std::string> told;
    for (Made& one : made)
        for (std::string& warning : one.warnings)
            if (told.insert(warning).second) scene.warnings.push_back(std::move(warning));
    for (const Use& use : uses) {
        scene::Material& material = scene.materials[use.material];
        material.*use.slot = use.placed;
        (material.*use.slot).texture = ids[use.job];
    }
    // Remove masks that could not be read.
    for (scene::Material& material : scene.materials) {
        if (material.alpha_mode != scene::AlphaMode::mask) continue;
        const scene::TextureId texture = material.base_color_texture.texture;
        if (texture == scene::none || !scene.textures[texture].has_alpha())
            material.alpha_mode = scene::AlphaMode::opaque;
    }
}

}   // namespace gnomon::io
