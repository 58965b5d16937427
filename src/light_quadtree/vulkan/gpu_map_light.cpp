// SPDX-License-Identifier: Apache-2.0
#include "light_quadtree/vulkan/gpu_map_light.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/check.h"
#include "gnomon/error.h"

namespace gnomon::light_quadtree {

namespace {

using shared::GatherPush;
using vk::Use;

constexpr std::uint32_t k_clusters_comp[] =
#include "light_quadtree/vulkan/gather_clusters.comp.inc"
    ;
constexpr std::uint32_t k_samples_comp[] =
#include "light_quadtree/vulkan/gather_samples.comp.inc"
    ;
constexpr std::uint32_t k_image_comp[] =
#include "light_quadtree/vulkan/map_image.comp.inc"
    ;
constexpr std::uint32_t k_printed_comp[] =
#include "light_quadtree/vulkan/gather_printed.comp.inc"
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
    : device_(device),
      options_(options),
      map_(device, state, options.map, options.levels, options.as_printed && options.method == MapMethod::quadtree)
{
    GNOMON_CHECK(options.method != MapMethod::brute);
    const bool samples = options.method == MapMethod::rsm;
    vk::ComputeDesc desc;
    desc.name = samples ? "bounced light by samples" : "bounced light by clusters";
    if (samples)
        desc.code = {"gather_samples.comp", k_samples_comp};
    else if (options.as_printed)
        desc.name = "bounced light as printed", desc.code = {"gather_printed.comp", k_printed_comp};
    else
        desc.code = {"gather_clusters.comp", k_clusters_comp};
    desc.blocks = {vk::shared_push<GatherPush>()};
    if (samples || options.as_printed) desc.blocks.push_back(vk::shared_block<shared::GpuMapView>("views"));
    pipeline_ = vk::Pipeline(device, desc);
    if (samples) {
        copy_pipeline_ = vk::Pipeline(device, vk::ComputeDesc{.name = "light map's texels to an image",
                                                              .code = {"map_image.comp", k_image_comp},
                                                              .blocks = {vk::shared_push<shared::MapImagePush>(),
                                                                         vk::shared_block<shared::GpuMapView>("views"),
                                                                         vk::shared_block<shared::GpuNode>("nodes")}});
        const auto rows = (static_cast<std::uint32_t>(options.rsm.samples) - 1) / GNOMON_SAMPLES_A_ROW + 1;
        pattern_ = vk::Buffer(device, "sampling pattern", sizeof(glm::vec4) * rows * GNOMON_SAMPLES_A_ROW);
        pattern_image_ = grid_image(device, "sampling pattern", {GNOMON_SAMPLES_A_ROW, rows});
        fit_texels();
    }
    for (vk::Image* image : {&grid_position_, &grid_normal_, &grid_light_, &none_})
        *image = grid_image(device, "no grid", {1, 1});
}

// Makes the image of the map's texels, unless it fits the map's views.
void GpuMapLight::fit_texels()
{
    const auto views = static_cast<std::uint32_t>(map_.views().size());
    const auto side = static_cast<std::uint32_t>(views == 0 ? 1 : map_.views().front().side());
    const glm::uvec2 size(3 * side, std::max(views, 1u) * side);
    if (texels_ && texels_.width() == size.x && texels_.height() == size.y) return;
    const std::uint32_t most = device_->limits().maxImageDimension2D;
    if (size.x > most || size.y > most)
        throw MissingError(fmt::format("Vulkan: light maps of {} x {} texels, and the device's images have {} at most",
                                       size.x, size.y, most));
    texels_ = grid_image(device_, "light map's texels", size);
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
    if (grid_step(surfaces.size) == 0) return;
    kept_grid_ = surfaces.kept && grid_version_ != 0 && grid_version_ == map_.version();
    if (kept_grid_) return;
    record(commands, surfaces, none_, true, false);
    grid_version_ = map_.version();
}

void GpuMapLight::forget()
{
    map_.forget();
    grid_version_ = 0;
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
    // Fill in the push constants.
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
    push.start = map_.start(), push.limit = map_.limit();
    const glm::uvec2 points = grid ? glm::uvec2(push.columns, push.rows)
                                   : glm::uvec2(surfaces.position->width(), surfaces.position->height());
    // Enlarge or shrink the images of the grid.
    if (grid && (grid_light_.width() != points.x || grid_light_.height() != points.y)) {
        grid_position_ = grid_image(device_, "receivers' positions", points);
        grid_normal_ = grid_image(device_, "receivers' normals", points);
        grid_light_ = grid_image(device_, "receivers' light", points);
    }

    // Upload the sampling pattern, and copy the map's texels.
    const bool samples = options_.method == MapMethod::rsm;
    if (samples) {
        push.samples = static_cast<std::uint32_t>(
            std::max(1, options_.rsm.samples / static_cast<int>(std::max(map_.views_on(), 1u))));
        send_pattern(commands, push.samples);
        copy_texels(commands);
    }

    // Record the gather: one pass, or as printed one for each level.
    const bool by_levels = options_.as_printed && !samples;
    for (push.level = push.start; push.level <= (by_levels ? push.limit : push.start); ++push.level)
        record_pass(commands, surfaces, irradiance, push, points);
}

void GpuMapLight::record_pass(vk::Commands& commands, const MapSurfaces& surfaces, const vk::Image& irradiance,
                              const GatherPush& push, const glm::uvec2& points)
{
    const bool samples = options_.method == MapMethod::rsm, by_levels = options_.as_printed && !samples;
    vk::Pass pass = commands.pass(push.fill_grid ? "bounced light of receivers" : "bounced light");
    std::vector<std::pair<const char*, const vk::Image*>> lights;
    if (samples)
        lights = {{"texels", &texels_}, {"pattern", &pattern_image_}};
    else if (by_levels)
        lights = {{"levels", &map_.level_image()}};
    else
        lights = {{"clusters", &map_.cluster_image()}};
    const bool by_views = samples || by_levels;
    const vk::Buffer& counted = by_views ? map_.view_buffer() : map_.counts();
    pass.reads(counted, Use::storage_read);
    for (const auto& [name, image] : lights) pass.reads(*image, Use::storage_read);
    pass.reads(*surfaces.position, Use::sampled).reads(*surfaces.normal, Use::sampled);
    pass.writes(grid_position_).writes(grid_normal_).writes(grid_light_).writes(irradiance);
    pass.compute([&](vk::Recorder& r) {
        r.bind(pipeline_);
        r.set(by_views ? "views" : "counts", counted);
        for (const auto& [name, image] : lights) r.set(name, *image);
        r.set("positions", *surfaces.position);
        r.set("normals", *surfaces.normal);
        r.set("grid_position", grid_position_);
        r.set("grid_normal", grid_normal_);
        r.set("grid_light", grid_light_);
        r.set("irradiance", irradiance);
        r.push(push);
        const glm::uvec2 together = samples ? glm::uvec2(GNOMON_SAMPLES_ACROSS, GNOMON_SAMPLES_DOWN)
                                            : glm::uvec2(GNOMON_CLUSTERS_ACROSS, GNOMON_CLUSTERS_DOWN);
        const glm::uvec2 groups = (points + together - 1u) / together;
        r.dispatch_over(groups.x, groups.y);
    });
}

// The pattern is kept while the number of samples does not change.
void GpuMapLight::send_pattern(vk::Commands& commands, std::uint32_t samples)
{
    if (pattern_samples_ == samples) return;
    pattern_samples_ = samples;
    const int side = map_.views().empty() ? 1 : map_.views().front().side();
    const RsmPattern pattern = make_rsm_pattern(static_cast<int>(samples), options_.rsm.radius, side);
    std::vector<glm::vec4> sent(pattern_.bytes() / sizeof(glm::vec4));
    for (std::size_t i = 0; i < pattern.x.size(); ++i) sent[i] = {pattern.x[i], pattern.y[i], pattern.weight[i], 0};
    const vk::Upload upload = vk::upload_of(pattern_, std::span<const glm::vec4>(sent));
    commands.upload("send sampling pattern", {&upload, 1});
    commands.pass("sampling pattern to texels")
        .reads(pattern_, Use::copy_source)
        .writes(pattern_image_, Use::copy_target)
        .copy([&](vk::Recorder& r) {
            VkBufferImageCopy all{};
            all.imageSubresource = {pattern_image_.aspect(), 0, 0, 1};
            all.imageExtent = {pattern_image_.width(), pattern_image_.height(), 1};
            r.copy(pattern_, pattern_image_, {&all, 1});
        });
}

// Copies what changed since the last copy; everything if there was another change in between.
void GpuMapLight::copy_texels(vk::Commands& commands)
{
    if (copied_ == map_.version()) return;
    const bool all = copied_ + 1 != map_.version() || copied_ == 0;
    copied_ = map_.version();
    fit_texels();
    glm::uvec2 size(0);
    for (const light_views::Rect& rect : map_.dirty())
        if (!rect.empty()) size = glm::max(size, glm::uvec2(rect.x1 - rect.x0, rect.y1 - rect.y0));
    if (all) size = glm::uvec2(map_.views().front().side());
    commands.pass("light map's texels to an image")
        .reads(map_.view_buffer(), Use::storage_read)
        .reads(map_.nodes(), Use::storage_read)
        .writes(texels_)
        .compute([&](vk::Recorder& r) {
            r.bind(copy_pipeline_);
            r.set("views", map_.view_buffer());
            r.set("nodes", map_.nodes());
            r.set("texels", texels_);
            r.push(shared::MapImagePush{all ? 1u : 0u});
            r.dispatch_over(size.x, size.y, static_cast<std::uint32_t>(map_.views().size()));
        });
}

std::size_t GpuMapLight::bytes() const
{
    return map_.bytes() + pattern_.bytes() + std::size_t{16} * texels_.width() * texels_.height() +
           std::size_t{48} * grid_light_.width() * grid_light_.height();
}

}   // namespace gnomon::light_quadtree
