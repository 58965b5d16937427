// SPDX-License-Identifier: Apache-2.0
#include "raster/visible_bounce.h"

#include <algorithm>

#include "base/check.h"
#include "irradiance_cache/vulkan/gpu_points.h"
#include "raster/barycentric.h"

namespace gnomon::raster {

namespace {

constexpr int k_tile = 32;   // pixels a side, lit as one batch

}   // namespace

VisibleBounce::VisibleBounce(const std::shared_ptr<vk::Device>& device, const scene::SceneState& state,
                             const ray::RayScene& rays, const irradiance_cache::CacheOptions& options, bool on_device,
                             Tasks& tasks)
    : device_(device),
      rays_(rays),
      tasks_(tasks),
      further_bounces_(options.light_tree.patches.bounces > 1),
      light_(state, rays, options, tasks),
      scratch_(static_cast<std::size_t>(tasks.threads()))
{
    if (!on_device) return;
    auto points = std::make_unique<irradiance_cache::GpuPoints>(device);
    on_device_ = points.get();
    light_.use_device(std::move(points));
}

void VisibleBounce::update(vk::Commands& commands, const gpu_scene::GpuScene& scene, const scene::SceneState& state)
{
    using ray::DeviceRays;
    if (on_device_ && on_device_->rays()) {
        on_device_->rays()->update(commands, scene, state);
    } else if (on_device_ && DeviceRays::supported(*device_)) {
        commands.submit();   // because it builds from the scene on the device
        on_device_->trace_with(std::make_unique<DeviceRays>(device_, scene, state), scene);
    }
    light_.update(state, rays_, tasks_);
    batches_.clear();
    for (std::size_t t = 0; t < scratch_.size(); ++t) batches_.push_back(light_.make_batch());
}

void VisibleBounce::fill(vk::Commands& commands, const GBuffer& surfaces, const scene::View& view,
                         const vk::Image& irradiance)
{
    const vk::Buffer positions = commands.read_back(surfaces.position), normals = commands.read_back(surfaces.normal),
                     geometric = commands.read_back(surfaces.geometric), diffuse = commands.read_back(surfaces.diffuse),
                     ids = commands.read_back(surfaces.ids);
    commands.submit();

    // Light the surfaces tile by tile, as the traced frame does.
    const int width = view.size.width, height = view.size.height;
    const auto pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    arrives_.assign(pixels, glm::vec4(0));
    const std::span<const glm::vec4> at = positions.as<glm::vec4>(), shading = normals.as<glm::vec4>(),
                                     faces = geometric.as<glm::vec4>(), colors = diffuse.as<glm::vec4>();
    const std::span<const glm::uvec2> id = ids.as<glm::uvec2>();
    const int columns = (width + k_tile - 1) / k_tile, rows = (height + k_tile - 1) / k_tile;
    const auto light_tile = [&](std::size_t tile, int w) {
        Scratch& own = scratch_[static_cast<std::size_t>(w)];
        own.points.clear(), own.pixels.clear();
        const int x0 = static_cast<int>(tile) % columns * k_tile, y0 = static_cast<int>(tile) / columns * k_tile;
        for (int y = y0; y < std::min(y0 + k_tile, height); ++y)
            for (int x = x0; x < std::min(x0 + k_tile, width); ++x) {
                const std::size_t i =
                    static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
                const bool unlit = static_cast<std::uint32_t>(colors[i].w) == GNOMON_MODEL_UNLIT;
                if (id[i].x == 0 || unlit || glm::vec3(colors[i]) == glm::vec3(0)) continue;
                irradiance_cache::IndirectPoint& point = own.points.emplace_back();
                point.position = glm::vec3(at[i]);
                point.geometric_normal = glm::vec3(faces[i]);
                point.normal = glm::vec3(shading[i]);
                point.object = id[i].x - 1;
                point.triangle = id[i].y;
                glm::vec3 corners[3];
                rays_.geometry(point.object).corners(point.triangle, corners);
                const glm::vec2 place = barycentric(corners, point.position);
                point.u = place.x, point.v = place.y;
                const float distance = glm::length(point.position - view.eye);
                point.width = view.pixel_width + distance * view.pixel_spread;
                point.to_viewer = view.orthographic ? -view.forward : (view.eye - point.position) / distance;
                own.pixels.push_back(static_cast<std::uint32_t>(i));
            }
        own.light.resize(own.points.size());
        if (!light_.shade(*batches_[static_cast<std::size_t>(w)], own.points, own.light.data())) return false;
        for (std::size_t k = 0; k < own.pixels.size(); ++k) arrives_[own.pixels[k]] = glm::vec4(own.light[k], 0);
        return true;
    };
    light_.for_each(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows), batches_, tasks_, light_tile);

    // Send the irradiance to the device.
    sent_.send(commands, arrives_, irradiance);
}

FrameCounters::Indirect VisibleBounce::end_frame()
{
    light_.end_frame(batches_);
    return {light_.counters().nodes, light_.counters().rays, on_device_ != nullptr, on_device_ && on_device_->traces()};
}

}   // namespace gnomon::raster
