// SPDX-License-Identifier: Apache-2.0
#include "frame/raster_environment.h"

#ifdef GNOMON_VULKAN

#include <algorithm>

#include "gpu_scene/gpu_scene_shared.h"
#include "raster/shadow_point.h"

namespace gnomon::frame {

namespace {

constexpr int k_tile = 32;   // pixels a side, lit as one batch, as in traced frames

int tiles_across(int pixels)
{
    return (pixels + k_tile - 1) / k_tile;
}

std::size_t tiles_of(Size size)
{
    return static_cast<std::size_t>(tiles_across(size.width)) * static_cast<std::size_t>(tiles_across(size.height));
}

}   // namespace

void RasterEnvironment::begin_frame(const scene::SceneState& state, const scene::View& view)
{
    state_ = &state;
    technique_->begin_frame({state, rays_, view, tasks_}, tiles_of(view.size));
    workers_.clear();
    workers_.resize(static_cast<std::size_t>(tasks_.threads()));
}

bool RasterEnvironment::brings(scene::LightId light) const
{
    if (state_->scene().lights[light].of_environment) return has_image();
    return std::ranges::any_of(technique_->light().suns(), [&](const auto& sun) { return sun->light == light; });
}

std::span<const float> RasterEnvironment::visible(scene::LightId light) const
{
    return light < visible_.size() ? std::span<const float>(visible_[light]) : std::span<const float>();
}

// Makes the point of one pixel as the traced frame does.
void RasterEnvironment::add_point(const Surfaces& read, std::size_t pixel, const scene::View& view, Worker& own) const
{
    const glm::vec4 position = read.positions.as<glm::vec4>()[pixel], normal = read.normals.as<glm::vec4>()[pixel],
                    geometric = read.geometric.as<glm::vec4>()[pixel], diffuse = read.diffuse.as<glm::vec4>()[pixel],
                    specular = read.specular.as<glm::vec4>()[pixel];
    const shadow_culling::ShadowPoint at =
        raster::shadow_point_of(rays_, read.ids.as<glm::uvec2>()[pixel], glm::vec3(position), glm::vec3(geometric));
    trace::TilePoint& point = own.points.emplace_back();
    shading::SurfacePoint& s = point.surface;
    s.position = glm::vec3(position);
    s.geometric_normal = at.normal, s.normal = glm::vec3(normal);
    s.smooth_normal = glm::vec3(read.smooth.as<glm::vec4>()[pixel]);
    const float distance = glm::length(view.eye - s.position);
    s.to_viewer = view.orthographic ? -view.forward : (view.eye - s.position) / distance;
    s.offset = glm::dot(at.origin - s.position, at.normal);
    s.cone.width = view.pixel_width + distance * view.pixel_spread;
    s.diffuse = glm::vec3(diffuse), s.specular = glm::vec3(specular), s.coverage = geometric.w;
    const auto model = static_cast<std::uint32_t>(diffuse.w);
    s.model = model == GNOMON_MODEL_WHITTED ? scene::ShadingModel::whitted : scene::ShadingModel::metallic_roughness;
    if (model == GNOMON_MODEL_WHITTED)
        s.shine = normal.w;
    else
        s.roughness = std::max(normal.w, k_least_roughness);
    // Of what refracts, neither the reflected nor the refracted ray is shown.
    if (specular.w > 0) s.transmitted = glm::vec3(1), s.ior = specular.w;
    point.next = shading::continue_from(s);
    own.shadow_points.push_back(at);
    own.normals.push_back(s.normal);
}

void RasterEnvironment::light_tile(const Surfaces& read, std::size_t number, const scene::View& view, Worker& own)
{
    const Size size = view.size;
    trace::Tile tile;
    tile.side = k_tile;
    tile.x = static_cast<int>(number) % tiles_across(size.width) * k_tile;
    tile.y = static_cast<int>(number) / tiles_across(size.width) * k_tile;
    tile.width = std::min(k_tile, size.width - tile.x), tile.height = std::min(k_tile, size.height - tile.y);
    own.points.clear(), own.shadow_points.clear(), own.normals.clear();
    for (int y = 0; y < tile.height; ++y)
        for (int x = 0; x < tile.width; ++x) {
            const auto in_tile = static_cast<std::uint32_t>(y * k_tile + x);
            const std::size_t pixel = tile.index_in_image(in_tile, size.width);
            const bool unlit = static_cast<std::uint32_t>(read.diffuse.as<glm::vec4>()[pixel].w) == GNOMON_MODEL_UNLIT;
            if (read.ids.as<glm::uvec2>()[pixel].x == 0 || unlit) continue;
            add_point(read, pixel, view, own);
            own.points.back().pixel = in_tile;
        }
    if (own.points.empty()) return;
    const trace::PointBatch batch{own.points, own.shadow_points, own.normals, tile, true, true};
    const auto add = [&](const trace::TilePoint& point, const glm::vec3& radiance, const glm::vec3&) {
        radiance_[tile.index_in_image(point.pixel, size.width)] += glm::vec4(radiance, 0);
    };
    if (own.lighting.has_image()) own.lighting.light(batch, number, add);
    own.lighting.light_by_suns(
        batch, number, *state_,
        [&](const trace::TilePoint& point, const glm::vec3& radiance, scene::LightId light, float share) {
            add(point, radiance, glm::vec3(0));
            visible_[light][tile.index_in_image(point.pixel, size.width)] = share;
        });
}

void RasterEnvironment::fill(vk::Commands& commands, const raster::GBuffer& surfaces, const scene::View& view,
                             const vk::Image& radiance)
{
    // Read the surfaces back.
    const Surfaces read{commands.read_back(surfaces.position),  commands.read_back(surfaces.normal),
                        commands.read_back(surfaces.geometric), commands.read_back(surfaces.smooth),
                        commands.read_back(surfaces.diffuse),   commands.read_back(surfaces.specular),
                        commands.read_back(surfaces.ids)};
    commands.submit();

    // Light them tile by tile, as the traced frame does.
    const auto pixels = static_cast<std::size_t>(view.size.width) * static_cast<std::size_t>(view.size.height);
    radiance_.assign(pixels, glm::vec4(0));
    visible_.assign(state_->scene().lights.size(), {});
    for (const auto& sun : technique_->light().suns()) visible_[sun->light].assign(pixels, 0);
    tasks_.for_each(tiles_of(view.size), [&](std::size_t tile, int worker) {
        std::unique_ptr<Worker>& own = workers_[static_cast<std::size_t>(worker)];
        if (!own) own.reset(new Worker{trace::EnvironmentLighting(*technique_, rays_), {}, {}, {}});
        light_tile(read, tile, view, *own);
    });

    // Send their light to the device.
    sent_.send(commands, radiance_, radiance);
}

void RasterEnvironment::end_frame(FrameCounters& counters)
{
    environment_light::VisibilityCounters counted;
    for (const auto& worker : workers_)
        if (worker) counted.add(worker->lighting.counters());
    workers_.clear();
    technique_->set_counters(counted);
    counters.shadow.rays += counted.rays + counted.dynamic_rays;
    counters.shadow.rays_dynamic_only += counted.dynamic_rays;
}

}   // namespace gnomon::frame

#endif
