// SPDX-License-Identifier: Apache-2.0
// The shadow look-up on the device equals its CPU reference for the same points and buffers.
#include "vk_helpers.h"

#ifdef GNOMON_VULKAN
#include "light_script.h"
#include "shadow_textures/vulkan/gpu_visibility.h"

namespace gnomon::shadow_textures {
namespace {

class ShadowLookUpVulkan : public test::VulkanTest {};

constexpr std::uint32_t k_side = 48;   // the side of the image of points

struct Points {
    std::vector<glm::vec4> positions, normals;
    std::vector<std::uint32_t> objects;   // + 1
};

// Random points on random triangles of all visible casters, seen from a random side.
Points points_of(const scene::SceneState& state, const light_views::Casters& casters, std::uint64_t seed)
{
    Points points;
    Random random(seed);
    const scene::Scene& scene = state.scene();
    while (points.positions.size() < k_side * k_side) {
        const scene::ObjectId o = random.below(static_cast<std::uint32_t>(scene.objects.size()));
        if (!casters.casts(o) || !state.object_visible(o)) continue;
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

}   // namespace
}   // namespace gnomon::shadow_textures
#endif
