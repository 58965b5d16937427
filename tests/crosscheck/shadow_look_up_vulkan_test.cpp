// SPDX-License-Identifier: Apache-2.0
// The shadow look-up on the device equals its CPU reference for the same points and buffers: by the comparison of
// distances, and as printed by the colour of the receivers' textures, with the counts of what that decides wrongly.
#include "vk_helpers.h"

#ifdef GNOMON_VULKAN
#include "light_script.h"
#include "raster/shadow_visibility.h"
#include "shadow_textures/vulkan/gpu_visibility.h"

namespace gnomon::shadow_textures {
namespace {

class ShadowLookUpVulkan : public test::VulkanTest {};

constexpr std::uint32_t k_side = 48;   // the side of the image of points

struct Points {
    std::vector<glm::vec4> positions, normals;
    std::vector<std::uint32_t> objects;   // + 1
};

// Random points on random triangles of all visible objects, seen from a random side.
// @param all  of objects that cast no shadow, too
Points points_of(const scene::SceneState& state, const light_views::Casters& casters, std::uint64_t seed,
                 bool all = false)
{
    Points points;
    Random random(seed);
    const scene::Scene& scene = state.scene();
    while (points.positions.size() < k_side * k_side) {
        const scene::ObjectId o = random.below(static_cast<std::uint32_t>(scene.objects.size()));
        if (!(all || casters.casts(o)) || !state.object_visible(o)) continue;
        const scene::Mesh& mesh = scene.meshes[scene.objects[o].mesh];
        const auto& positions = scene.objects[o].deforming ? state.deformed(o).positions : mesh.positions;
        const auto& triangle = mesh.triangles[random.below(static_cast<std::uint32_t>(mesh.triangles.size()))];
        glm::vec3 corner[3];
        for (int i = 0; i < 3; ++i)
            corner[i] = glm::vec3(state.object_matrix(o) * glm::vec4(positions[triangle[i]], 1));
        float u = random.uniform(), v = random.uniform();
        if (u + v > 1) u = 1 - u, v = 1 - v;
        glm::vec3 normal = glm::cross(corner[1] - corner[0], corner[2] - corner[0]);
        if (glm::length(normal) < 1e-6f) continue;
        normal = glm::normalize(normal) * (random.below(2) ? 1.0f : -1.0f);
        points.positions.emplace_back(corner[0] + u * (corner[1] - corner[0]) + v * (corner[2] - corner[0]), 1);
        points.normals.emplace_back(normal, 0);
        points.objects.push_back(o + 1);
    }
    return points;
}

template <class T>
vk::Image image(const std::shared_ptr<vk::Device>& device, vk::Commands& commands, const char* name, VkFormat format,
                const std::vector<T>& values, std::vector<vk::Buffer>& staging)
{
    vk::Image image(
        device,
        {.name = name, .width = k_side, .height = k_side, .format = format, .usage = VK_IMAGE_USAGE_SAMPLED_BIT});
    staging.emplace_back(device, name, values.size() * sizeof(T));
    const vk::Buffer& buffer = staging.back();
    const vk::Upload upload = vk::upload_of(buffer, std::span<const T>(values));
    commands.upload(name, std::span(&upload, 1));
    VkBufferImageCopy whole{};
    whole.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
    whole.imageExtent = {k_side, k_side, 1};
    commands.pass(name)
        .reads(buffer, vk::Use::copy_source)
        .writes(image, vk::Use::copy_target)
        .copy([&](vk::Recorder& recorder) { recorder.copy(buffer, image, std::span(&whole, 1)); });
    return image;
}

// One view's tile as a buffer of the reference implementation.
light_views::SoftwareBuffer square(const std::vector<vk::Buffer>& depth, const std::vector<vk::Buffer>& item,
                                   const light_views::Tile& tile, int page_size)
{
    light_views::SoftwareBuffer buffer(tile.size);
    const auto page = static_cast<std::size_t>(tile.page);
    for (int y = 0; y < tile.size; ++y)
        for (int x = 0; x < tile.size; ++x) {
            const auto from = static_cast<std::size_t>(tile.y + y) * static_cast<unsigned>(page_size) +
                              static_cast<unsigned>(tile.x + x);
            buffer.depth[buffer.at(x, y)] = depth[page].as<float>()[from];
            buffer.item[buffer.at(x, y)] = item[page].as<std::uint32_t>()[from];
        }
    return buffer;
}

TEST_F(ShadowLookUpVulkan, EqualsTheCpuReference)
{
    constexpr int frames = 12;
    const test::LightScript script = test::make_light_script(3, frames);
    scene::SceneState state(script.scene, 0);
    light_views::LightViewsOptions view_options;
    view_options.atlas.view_size = 128;
    view_options.receivers = true;
    light_views::LightViews views(state, view_options);
    light_views::CasterGeometry casters(device_, state);
    light_views::GpuLightViews buffers(device_, views);
    GpuTextures textures(device_, views);
    GpuVisibility visibility_of(device_, views);
    vk::Commands commands(device_);
    const auto lights = static_cast<std::uint32_t>(script.scene->lights.size());
    const auto target = [&](const char* name) {
        return vk::Image(device_, {.name = name,
                                   .width = k_side,
                                   .height = k_side,
                                   .layers = lights,
                                   .format = VK_FORMAT_R8_UNORM,
                                   .usage = VK_IMAGE_USAGE_STORAGE_BIT,
                                   .array = true});
    };
    std::uint64_t compared = 0, different = 0, different_textures = 0, lit = 0, dark = 0, between = 0;
    for (int frame = 0; frame < frames; ++frame) {
        state.advance(script.time(frame));
        views.update(state);
        casters.update(commands, state);
        buffers.record(commands, views, casters);
        textures.record(commands, views, buffers, casters, state);
        LookupOptions options;
        options.filter = static_cast<float>(frame % 3);   // hard, one texel, two
        const Points points = points_of(state, views.casters(), static_cast<std::uint64_t>(frame));
        std::vector<vk::Buffer> staging;
        staging.reserve(3);
        const vk::Image positions = image(device_, commands, "points", VK_FORMAT_R32G32B32A32_SFLOAT, points.positions,
                                          staging),
                        normals =
                            image(device_, commands, "normals", VK_FORMAT_R32G32B32A32_SFLOAT, points.normals, staging),
                        objects = image(device_, commands, "objects", VK_FORMAT_R32_UINT, points.objects, staging);
        const vk::Image by_items = target("by items"), by_textures = target("by textures");
        const ImageInputs inputs{&positions, &normals, &objects};
        visibility_of.record(commands, views, buffers, nullptr, inputs, by_items, options);
        visibility_of.record(commands, views, buffers, &textures, inputs, by_textures, options);
        std::vector<vk::Buffer> depth, item, seen, seen_by_textures;
        for (std::uint32_t page = 0; page < buffers.depth().desc().layers; ++page) {
            depth.push_back(commands.read_back(buffers.depth(), page));
            item.push_back(commands.read_back(buffers.item(), page));
        }
        for (std::uint32_t l = 0; l < lights; ++l) {
            seen.push_back(commands.read_back(by_items, l));
            seen_by_textures.push_back(commands.read_back(by_textures, l));
        }
        commands.submit();

        std::vector<light_views::SoftwareBuffer> squares;
        for (const light_views::LightView& view : views.views())
            squares.push_back(square(depth, item, view.tile, views.atlas().page_size));
        for (std::uint32_t l = 0; l < lights; ++l) {
            const std::uint32_t first = views.first_view(l), end = views.atlas().first_tile[l + 1];
            for (std::size_t i = 0; i < points.positions.size(); ++i) {
                const glm::vec3 point(points.positions[i]), normal(points.normals[i]);
                float expected = 0;
                if (views.views()[first].shown) {
                    const auto* view = view_of(std::span(views.views()).subspan(first, end - first), point);
                    expected =
                        visibility(view->projection, squares[static_cast<std::size_t>(view - views.views().data())],
                                   point, normal, points.objects[i] - 1, options);
                }
                lit += expected == 1, dark += expected == 0, between += expected > 0 && expected < 1;
                ++compared;
                // One texel may differ where a border lies within rounding.
                constexpr float step = 1.0f / 255;
                different += std::abs(static_cast<float>(seen[l].as<std::uint8_t>()[i]) / 255 - expected) > step;
                different_textures += seen_by_textures[l].as<std::uint8_t>()[i] != seen[l].as<std::uint8_t>()[i];
            }
        }
    }
    EXPECT_GT(lit, compared / 20);
    EXPECT_GT(dark, compared / 20);
    EXPECT_GT(between, 100u);
    EXPECT_LT(different, compared / 1000) << compared;
    // The receivers' own textures differ from the items where objects have the same depth: the script's exact
    // duplicates.
    EXPECT_LT(different_textures, compared / 100) << compared;
}

// A receiver's texture as it was read back; empty if it has none.
ReceiverTexture texture_of(const GpuTextures& textures, const vk::Buffer& words, std::size_t view,
                           scene::ObjectId object, const light_views::Tile& tile)
{
    const shared::TexturePlace& place = textures.place(view, object);
    if (place.row_words == 0) return {};
    const int x = place.corner.x - tile.x, y = place.corner.y - tile.y;
    ReceiverTexture texture{{x, y, x + place.columns, y + place.rows}, {}};
    EXPECT_EQ(place.row_words, ReceiverTexture::row_words(texture.rect));
    const auto first = words.as<std::uint32_t>().begin() + place.first_word;
    texture.bits.assign(first, first + static_cast<std::ptrdiff_t>(place.row_words) * place.rows);
    return texture;
}

// How a texture differs from the items of its view.
struct TexelCounts {
    std::uint64_t white = 0, black = 0;
    std::uint64_t ties = 0;     // white, but the item is an equally near object with a higher number
    std::uint64_t faults = 0;   // any other difference
};
void compare_with_items(const ReceiverTexture& texture, const light_views::SoftwareBuffer& buffer,
                        scene::ObjectId object, TexelCounts& counts)
{
    for (int y = texture.rect.y0; y < texture.rect.y1; ++y)
        for (int x = texture.rect.x0; x < texture.rect.x1; ++x) {
            const std::uint32_t item = buffer.item[buffer.at(x, y)];
            const bool lit = texture.lit(x, y);
            ++(lit ? counts.white : counts.black);
            counts.ties += lit && item > object + 1;
            counts.faults += lit ? item < object + 1 : item == object + 1;
        }
}

// What the device decided, against the reference by the same texels.
struct Decisions {
    std::uint64_t compared = 0, different = 0, lit = 0, dark = 0, between = 0;
    std::uint64_t without_texture = 0;      // of objects that cast no shadow
    std::uint64_t results = 0, wrong = 0;   // by the reference: shared::LookupCounts
};
struct Texels {   // by view; the textures by object
    const std::vector<light_views::SoftwareBuffer>& buffers;
    const std::vector<std::vector<ReceiverTexture>>& textures;
};
// @param seen  the device's results for a light, by point
template <class Seen>
void compare_decisions(const light_views::LightViews& views, std::uint32_t light, const Points& points,
                       const Texels& texels, const LookupOptions& options, const Seen& seen, Decisions& found)
{
    const std::uint32_t first = views.first_view(light), end = views.atlas().first_tile[light + 1];
    for (std::size_t i = 0; i < points.positions.size(); ++i) {
        const glm::vec3 point(points.positions[i]), normal(points.normals[i]);
        const scene::ObjectId object = points.objects[i] - 1;
        float expected = 0;
        if (views.views()[first].shown) {
            const auto* at = view_of(std::span(views.views()).subspan(first, end - first), point);
            const light_views::ViewProjection& view = at->projection;
            const auto v = static_cast<std::size_t>(at - views.views().data());
            const float by_distance = visibility(view, texels.buffers[v], point, normal, object, options);
            const bool casts = views.casters().casts(object);
            expected =
                casts ? visibility_as_printed(view, texels.textures[v][object], point, normal, options) : by_distance;
            found.without_texture += !casts;
            if (glm::dot(normal, view.perspective ? view.origin - point : -view.forward) > 0)
                ++found.results, found.wrong += (expected >= 0.5f) != (by_distance >= 0.5f);
        }
        found.lit += expected == 1, found.dark += expected == 0, found.between += expected > 0 && expected < 1;
        ++found.compared;
        constexpr float step = 1.0f / 255;
        found.different += std::abs(static_cast<float>(seen[i]) / 255 - expected) > step;
    }
}

raster::ShadowOptions printed_options(int filter)
{
    raster::ShadowOptions options;
    options.method = ShadowTextures::coherent;
    options.look_up.filter = static_cast<float>(filter);
    options.look_up.as_printed = true;
    options.atlas.view_size = 128;
    return options;
}

// `--shadow-textures coherent --as-printed`, as the rasterised frame does it, over frames in which the textures are
// kept: the same texels, the same decisions, and the same counts as the CPU reference.
TEST_F(ShadowLookUpVulkan, AsPrintedEqualsTheCpuReference)
{
    constexpr int frames = 12;   // the exact duplicates meet in the later ones
    const test::LightScript script = test::make_light_script(5, frames);
    scene::SceneState state(script.scene, 0);
    const auto lights = static_cast<std::uint32_t>(script.scene->lights.size());
    vk::Commands commands(device_);
    const std::array<glm::vec4, 6> everywhere{glm::vec4(0, 0, 0, 1), glm::vec4(0, 0, 0, 1), glm::vec4(0, 0, 0, 1),
                                              glm::vec4(0, 0, 0, 1), glm::vec4(0, 0, 0, 1), glm::vec4(0, 0, 0, 1)};
    std::vector<std::unique_ptr<raster::ShadowVisibility>> shadows;   // by filter: hard, one texel, two
    for (int filter = 0; filter < 3; ++filter)
        shadows.push_back(std::make_unique<raster::ShadowVisibility>(device_, state, printed_options(filter)));
    TexelCounts texels;
    Decisions found;
    std::uint64_t kept = 0, device_results = 0, device_wrong = 0;
    for (int frame = 0; frame < frames; ++frame) {
        state.advance(script.time(frame));
        const Points points = points_of(state, shadows[0]->views().casters(), static_cast<std::uint64_t>(frame), true);
        for (const auto& shadow : shadows) {
            // Look up on the device.
            shadow->update(commands, state, everywhere);
            std::vector<vk::Buffer> staging;
            staging.reserve(3);
            std::vector<glm::uvec2> ids;
            for (const std::uint32_t object : points.objects) ids.emplace_back(object, 0);
            raster::GBuffer surfaces;
            surfaces.position =
                image(device_, commands, "points", VK_FORMAT_R32G32B32A32_SFLOAT, points.positions, staging);
            surfaces.geometric =
                image(device_, commands, "normals", VK_FORMAT_R32G32B32A32_SFLOAT, points.normals, staging);
            surfaces.ids = image(device_, commands, "objects", VK_FORMAT_R32G32_UINT, ids, staging);
            const vk::Image out(device_, {.name = "as printed",
                                          .width = k_side,
                                          .height = k_side,
                                          .layers = lights,
                                          .format = VK_FORMAT_R8_UNORM,
                                          .usage = VK_IMAGE_USAGE_STORAGE_BIT,
                                          .array = true});
            shadow->fill(commands, surfaces, 0, lights, out);
            shadow->end_frame(commands);
            const light_views::LightViews& views = shadow->views();
            const light_views::GpuLightViews& buffers = shadow->method().buffers();
            const GpuTextures* const textures = shadow->method().textures();
            ASSERT_NE(textures, nullptr);
            std::vector<vk::Buffer> depth, item, seen;
            for (std::uint32_t page = 0; page < buffers.depth().desc().layers; ++page) {
                depth.push_back(commands.read_back(buffers.depth(), page));
                item.push_back(commands.read_back(buffers.item(), page));
            }
            for (std::uint32_t l = 0; l < lights; ++l) seen.push_back(commands.read_back(out, l));
            const vk::Buffer words = commands.read_back(textures->textures());
            commands.submit();
            FrameCounters counters;
            shadow->count(counters);
            device_results += *counters.shadow.looked_up, device_wrong += *counters.shadow.looked_up_wrong;

            // Compare the texels with the items that the same views hold.
            std::vector<light_views::SoftwareBuffer> squares;
            std::vector<std::vector<ReceiverTexture>> of_view(views.views().size());
            for (std::size_t v = 0; v < views.views().size(); ++v) {
                const light_views::LightView& view = views.views()[v];
                squares.push_back(square(depth, item, view.tile, views.atlas().page_size));
                for (scene::ObjectId o = 0; o < script.scene->objects.size(); ++o) {
                    of_view[v].push_back(texture_of(*textures, words, v, o, view.tile));
                    if (view.shown) compare_with_items(of_view[v][o], squares[v], o, texels);
                }
            }
            if (frame > 0) {
                std::uint64_t made = 0;
                for (const auto& list : of_view)
                    for (const ReceiverTexture& texture : list) made += !texture.bits.empty();
                kept += made - std::min<std::uint64_t>(made, counters.shadow.textures);
            }

            LookupOptions options;
            options.filter = static_cast<float>(&shadow - shadows.data());
            for (std::uint32_t l = 0; l < lights; ++l)
                compare_decisions(views, l, points, {squares, of_view}, options, seen[l].as<std::uint8_t>(), found);
        }
    }
    EXPECT_EQ(texels.faults, 0u);
    EXPECT_GT(texels.white, 10000u);
    EXPECT_GT(texels.black, 10000u);
    EXPECT_GT(texels.ties, 0u);   // the script's exact duplicates
    EXPECT_GT(kept, 0u);
    EXPECT_GT(found.lit, found.compared / 20);
    EXPECT_GT(found.dark, found.compared / 20);
    EXPECT_GT(found.between, 100u);
    EXPECT_GT(found.without_texture, 100u);
    // One texel may differ where a border lies within rounding.
    EXPECT_LT(found.different, found.compared / 5000) << found.compared;
    EXPECT_GT(found.wrong, found.results / 100);
    EXPECT_NEAR(static_cast<double>(device_results), static_cast<double>(found.results),
                static_cast<double>(found.results) / 5000);
    EXPECT_NEAR(static_cast<double>(device_wrong), static_cast<double>(found.wrong),
                static_cast<double>(found.results) / 5000);
    RecordProperty("different", std::to_string(found.different) + " of " + std::to_string(found.compared));
    RecordProperty("wrong", std::to_string(device_wrong) + ", " + std::to_string(found.wrong) + " of " +
                                std::to_string(found.results) + ", " + std::to_string(device_results));
}

}   // namespace
}   // namespace gnomon::shadow_textures
#endif
