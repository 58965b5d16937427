// SPDX-License-Identifier: Apache-2.0
#include "light_quadtree/vulkan/gpu_map_light.h"

#include <algorithm>

#include "base/check.h"

namespace gnomon::light_quadtree {

namespace {

using shared::GatherPush;
using shared::GpuSample;
using vk::Use;

constexpr std::uint32_t k_clusters_comp[] =
#include "light_quadtree/vulkan/gather_clusters.comp.inc"
    ;
constexpr std::uint32_t k_samples_comp[] =
#include "light_quadtree/vulkan/gather_samples.comp.inc"
    ;
constexpr VkFormat k_wide_format = VK_FORMAT_R32G32B32A32_SFLOAT;

vk::Image grid_image(const std::shared_ptr<vk::Device>& device, const char* name, glm::uvec2 size)
{
    return vk::Image(device, {.name = name,
                              .width = size.x,
                              .height = size.y,
                              .format = k_wide_format,
                              .usage = VK_IMAGE_USAGE_STORAGE_BIT});
}

}   // namespace

GpuMapLight::GpuMapLight(const std::shared_ptr<vk::Device>& device, const scene::SceneState& state,
                         const MapLightOptions& options)
    : device_(device), options_(options), map_(device, state, options.map, options.levels)
{
    GNOMON_CHECK(options.method != MapMethod::brute);
    const bool samples = options.method == MapMethod::rsm;
    vk::ComputeDesc desc;
    desc.name = samples ? "bounced light by samples" : "bounced light by clusters";
    if (samples)
        desc.code = {"gather_samples.comp", k_samples_comp};
    else
        desc.code = {"gather_clusters.comp", k_clusters_comp};
    desc.blocks = {{"", sizeof(GatherPush), {{"total", offsetof(GatherPush, total)}}}};
    if (samples) desc.blocks.push_back({"nodes", sizeof(shared::GpuNode), {}});
    pipeline_ = vk::Pipeline(device, desc);
    pattern_ =
        vk::Buffer(device, "sampling pattern", static_cast<std::size_t>(options.rsm.samples) * sizeof(GpuSample));
    for (vk::Image* image : {&grid_position_, &grid_normal_, &grid_light_, &none_})
        *image = grid_image(device, "no grid", {1, 1});
}

int GpuMapLight::grid_step(Size size) const
{
    return options_.grid == 0 ? 0 : (std::max(size.width, size.height) + options_.grid - 1) / options_.grid;
}

std::uint64_t GpuMapLight::lights(const vk::Buffer& count) const
{
    return options_.method == MapMethod::rsm ? static_cast<std::uint64_t>(options_.rsm.samples)
                                             : count.as<std::uint32_t>()[map_.count_at()];
}

void GpuMapLight::record_grid(vk::Commands& commands, const MapSurfaces& surfaces)
{
    if (grid_step(surfaces.size) > 0) record(commands, surfaces, none_, true, false);
}

void GpuMapLight::record_light(vk::Commands& commands, const MapSurfaces& surfaces, const vk::Image& irradiance)
{
    record(commands, surfaces, irradiance, false, false);
}

void GpuMapLight::record_listed(vk::Commands& commands, const MapSurfaces& points, const vk::Image& irradiance)
{
    record(commands, points, irradiance, false, true);
}

void GpuMapLight::record(vk::Commands& commands, const MapSurfaces& surfaces, const vk::Image& irradiance, bool grid,
                         bool listed)
{
    const int step = grid_step(surfaces.size);
    GatherPush push{};
    push.eye = surfaces.eye;
    push.pixel_width = surfaces.pixel_width, push.pixel_spread = surfaces.pixel_spread;
    push.width = static_cast<std::uint32_t>(surfaces.size.width);
    push.height = static_cast<std::uint32_t>(surfaces.size.height);
    push.step = static_cast<std::uint32_t>(step);
    if (step > 0) {
        push.columns = (push.width - 1) / push.step + 2;
        push.rows = (push.height - 1) / push.step + 2;
    }
    push.fill_grid = grid ? 1 : 0;
    push.listed = listed ? 1 : 0;
    push.grid_normals = options_.grid_normals;
    push.grid_off_plane = options_.grid_off_plane;
    push.grid_neighbours = static_cast<std::uint32_t>(options_.grid_neighbours);
    push.views = static_cast<std::uint32_t>(map_.views().size());
    push.total = map_.count_at();
    const glm::uvec2 points = grid ? glm::uvec2(push.columns, push.rows)
                                   : glm::uvec2(surfaces.position->width(), surfaces.position->height());
    if (grid && (grid_light_.width() != points.x || grid_light_.height() != points.y)) {
        grid_position_ = grid_image(device_, "receivers' positions", points);
        grid_normal_ = grid_image(device_, "receivers' normals", points);
        grid_light_ = grid_image(device_, "receivers' light", points);
    }

    const bool samples = options_.method == MapMethod::rsm;
    if (samples) {
        push.samples = static_cast<std::uint32_t>(
            std::max(1, options_.rsm.samples / static_cast<int>(std::max(map_.views_on(), 1u))));
        const int side = map_.views().empty() ? 1 : map_.views().front().side();
        const RsmPattern pattern = make_rsm_pattern(static_cast<int>(push.samples), options_.rsm.radius, side);
        std::vector<GpuSample> sent;
        for (std::size_t i = 0; i < pattern.x.size(); ++i)
            sent.push_back({pattern.x[i], pattern.y[i], pattern.weight[i]});
        const vk::Upload upload = vk::upload_of(pattern_, std::span<const GpuSample>(sent));
        commands.upload("send sampling pattern", {&upload, 1});
    }

    vk::Pass pass = commands.pass(grid ? "bounced light of receivers" : "bounced light");
    std::vector<std::pair<const char*, const vk::Buffer*>> lights;
    if (samples)
        lights = {{"views", &map_.view_buffer()}, {"nodes", &map_.nodes()}, {"pattern", &pattern_}};
    else
        lights = {{"counts", &map_.counts()}};
    if (!samples) pass.reads(map_.cluster_image(), Use::storage_read);
    for (const auto& [name, buffer] : lights) pass.reads(*buffer, Use::storage_read);
    pass.reads(*surfaces.position, Use::sampled).reads(*surfaces.normal, Use::sampled);
    pass.writes(grid_position_).writes(grid_normal_).writes(grid_light_).writes(irradiance);
    pass.compute([&](vk::Recorder& r) {
        r.bind(pipeline_);
        for (const auto& [name, buffer] : lights) r.set(name, *buffer);
        if (!samples) r.set("clusters", map_.cluster_image());
        r.set("positions", *surfaces.position);
        r.set("normals", *surfaces.normal);
        r.set("grid_position", grid_position_);
        r.set("grid_normal", grid_normal_);
        r.set("grid_light", grid_light_);
        r.set("irradiance", irradiance);
        r.push(push);
        const glm::uvec2 together = samples ? glm::uvec2(1) : glm::uvec2(GNOMON_CLUSTERS_ACROSS, GNOMON_CLUSTERS_DOWN);
        const glm::uvec2 groups = (points + together - 1u) / together;
        r.dispatch_over(groups.x, groups.y);
    });
}

std::size_t GpuMapLight::bytes() const
{
    return map_.bytes() + pattern_.bytes() + std::size_t{48} * grid_light_.width() * grid_light_.height();
}

}   // namespace gnomon::light_quadtree
