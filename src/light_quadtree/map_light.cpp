// SPDX-License-Identifier: Apache-2.0
#include "light_quadtree/map_light.h"

#include <algorithm>
#include <cstring>

#include "base/check.h"
#include "base/interruption.h"

namespace gnomon::light_quadtree {

MapLight::MapLight(const scene::SceneState& state, const ray::RayScene& rays, const MapLightOptions& options,
                   Tasks& tasks)
    : options_(options), map_(state, rays, options.map, tasks), rays_(&rays)
{
    if (options_.shadows) dynamic_ = std::make_unique<visibility::DynamicBounds>(state, rays);
    find_lights();
}

void MapLight::begin_frame(const scene::SceneState& state, const ray::RayScene& rays, Tasks& tasks)
{
    rays_ = &rays;
    const std::uint32_t before = map_.version();
    if (forgotten_) {
        map_.remake(state, rays, tasks);
        grid_modes_.forget(), pixel_modes_.forget();
        forgotten_ = false;
    } else {
        map_.update(state, rays, tasks);
    }
    if (dynamic_) dynamic_->update(state, rays);
    // Static geometry changed: what it does to paths is not known any longer.
    if (const scene::FrameChanges& changes = state.changes(); !changes.promoted.empty() ||
                                                              !changes.materials_changed.empty() ||
                                                              !changes.added.empty() || !changes.removed.empty())
        grid_modes_.forget(), pixel_modes_.forget();
    grid_modes_.begin_frame(), pixel_modes_.begin_frame();
    find_lights();
    counters_.kept_map = map_.version() == before;
    // With shadows, what moves occludes without changing the map.
    if (options_.shadows && state.changes().anything()) grid_version_ = 0;
}

void MapLight::find_lights()
{
    counters_ = {};
    if (options_.method == MapMethod::rsm) {
        counters_.lights = static_cast<std::uint64_t>(options_.rsm.samples);
        return;
    }
    if (clusters_version_ != map_.version()) {
        if (options_.method == MapMethod::quadtree)
            find_clusters(map_, options_.levels, clusters_);
        else
            all_texels(map_, clusters_);
        clusters_version_ = map_.version();
        if (options_.shadows) grid_modes_.follow(clusters_), pixel_modes_.follow(clusters_);
    }
    counters_.lights = clusters_.size();
}

int MapLight::grid_step(int width, int height) const
{
    return options_.grid == 0 ? 0 : (std::max(width, height) + options_.grid - 1) / options_.grid;
}

void MapLight::gather_all(Receivers& receivers, std::size_t begin, std::size_t end, Batch& batch) const
{
    gather_some(receivers, begin, end, batch, {});
}

void MapLight::gather_some(Receivers& receivers, std::size_t begin, std::size_t end, Batch& batch,
                           std::span<PathModes::Row* const> rows) const
{
    const bool quadtree = options_.method == MapMethod::quadtree;
    if (options_.method == MapMethod::rsm) {
        sample_map(map_, options_.rsm, receivers, begin, end, batch.places);
    } else if (quadtree && options_.shadows) {
        gather_with_shadows(clusters_, receivers, begin, end, *rays_, {rows, dynamic_.get()}, batch.shadows);
    } else if (quadtree && options_.as_printed) {
        for (std::size_t i = begin; i < end; ++i) {
            const glm::vec3 light =
                gather_as_printed(map_, options_.levels, {receivers.x[i], receivers.y[i], receivers.z[i]},
                                  {receivers.nx[i], receivers.ny[i], receivers.nz[i]});
            receivers.r[i] = light.x, receivers.g[i] = light.y, receivers.b[i] = light.z;
        }
    } else {
        gather(clusters_, receivers, begin, end);
    }
}

void MapLight::set_grid(std::span<const MapReceiver> points, int columns, int step, Tasks& tasks)
{
    GNOMON_CHECK(columns > 0 && step > 0 && points.size() % static_cast<std::size_t>(columns) == 0);
    const auto same = [](const MapReceiver& a, const MapReceiver& b) {
        return a.position == b.position && a.normal == b.normal && a.width == b.width;
    };
    counters_.kept_grid = grid_version_ == map_.version() && grid_columns_ == columns && grid_step_ == step &&
                          std::equal(points.begin(), points.end(), grid_.begin(), grid_.end(), same);
    if (counters_.kept_grid) return;
    grid_.assign(points.begin(), points.end());
    grid_columns_ = columns, grid_step_ = step, grid_version_ = map_.version();
    Receivers receivers;
    receivers.resize(grid_.size());
    for (std::size_t i = 0; i < grid_.size(); ++i) receivers.set(i, grid_[i].position, grid_[i].normal);
    constexpr std::size_t k_part = 8 * k_receiver_step;
    const std::size_t padded = receivers.x.size(), parts = (padded + k_part - 1) / k_part;
    if (options_.shadows) grid_modes_.resize(grid_.size());
    std::vector<Batch> batches(parts);
    tasks.for_each(parts, [&](std::size_t part, int) {
        const std::size_t begin = part * k_part, end = std::min(padded, begin + k_part);
        Batch& batch = batches[part];
        if (options_.shadows) {
            batch.rows.assign(end - begin, nullptr);
            for (std::size_t i = begin; i < std::min(end, grid_.size()); ++i)
                batch.rows[i - begin] = grid_modes_.of(i, grid_[i].position, grid_[i].normal);
        }
        gather_some(receivers, begin, end, batch, batch.rows);
    });
    for (const Batch& batch : batches) counters_.shadow += batch.shadows.counters;
    grid_light_.resize(grid_.size());
    for (std::size_t i = 0; i < grid_.size(); ++i) grid_light_[i] = receivers.irradiance(i);
    counters_.gathered += grid_.size();
}

void MapLight::begin_image(int width, int height)
{
    if (!options_.shadows || (width == width_ && height == height_)) return;
    width_ = width, height_ = height;
    pixel_modes_.forget();
    pixel_modes_.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
}

// What is remembered of a point's paths; null if it is not a pixel's own, or not the first of several in its pixel.
PathModes::Row* MapLight::row_of(const MapReceiver& point) const
{
    if (point.pixel.x < 0 || point.pixel.y < 0 || point.pixel.x >= width_ || point.pixel.y >= height_) return nullptr;
    return pixel_modes_.of(static_cast<std::size_t>(point.pixel.y) * static_cast<std::size_t>(width_) +
                               static_cast<std::size_t>(point.pixel.x),
                           point.position, point.normal);
}

// Interpolates from the four surrounding receivers of the grid if enough of them lie on the pixel's surface.
bool MapLight::interpolate(const MapReceiver& point, glm::vec3& irradiance) const
{
    const int column = point.pixel.x / grid_step_, row = point.pixel.y / grid_step_;
    const auto fx = static_cast<float>(point.pixel.x % grid_step_) / static_cast<float>(grid_step_),
               fy = static_cast<float>(point.pixel.y % grid_step_) / static_cast<float>(grid_step_);
    const float most_off = options_.grid_off_plane * static_cast<float>(grid_step_) * point.width;
    glm::vec3 sum(0);
    float weights = 0;
    int agree = 0;
    for (int corner = 0; corner < 4; ++corner) {
        const int dx = corner % 2, dy = corner / 2;
        const std::size_t at = static_cast<std::size_t>(row + dy) * static_cast<std::size_t>(grid_columns_) +
                               static_cast<std::size_t>(column + dx);
        const MapReceiver& other = grid_[at];
        if (!(glm::dot(other.normal, point.normal) > options_.grid_normals)) continue;
        if (!(std::abs(glm::dot(other.position - point.position, point.normal)) < most_off)) continue;
        ++agree;
        const float weight = (dx ? fx : 1 - fx) * (dy ? fy : 1 - fy);
        sum += weight * grid_light_[at];
        weights += weight;
    }
    if (agree < options_.grid_neighbours || !(weights > 0)) return false;
    irradiance = sum / weights;
    return true;
}

void MapLight::shade(Batch& batch, std::span<const MapReceiver> points, glm::vec3* irradiance) const
{
    batch.waiting.clear();
    for (std::uint32_t i = 0; i < points.size(); ++i) {
        if (options_.grid > 0 && points[i].pixel.x >= 0 && interpolate(points[i], irradiance[i])) {
            ++batch.counters.interpolated;
            continue;
        }
        batch.waiting.push_back(i);
    }
    Receivers& receivers = batch.receivers;
    receivers.resize(batch.waiting.size());
    for (std::size_t k = 0; k < batch.waiting.size(); ++k)
        receivers.set(k, points[batch.waiting[k]].position, points[batch.waiting[k]].normal);
    if (options_.shadows) {
        batch.rows.assign(receivers.x.size(), nullptr);
        for (std::size_t k = 0; k < batch.waiting.size(); ++k) batch.rows[k] = row_of(points[batch.waiting[k]]);
    }
    constexpr std::size_t k_part = 8 * k_receiver_step;   // between interruption points
    for (std::size_t begin = 0; begin < receivers.x.size(); begin += k_part) {
        interruption_point();
        const std::size_t end = std::min(begin + k_part, receivers.x.size());
        gather_some(
            receivers, begin, end, batch,
            options_.shadows ? std::span(batch.rows).subspan(begin, end - begin) : std::span<PathModes::Row*>());
    }
    for (std::size_t k = 0; k < batch.waiting.size(); ++k) irradiance[batch.waiting[k]] = receivers.irradiance(k);
    batch.counters.gathered += batch.waiting.size();
}

void MapLight::end_frame(std::span<const std::unique_ptr<Batch>> batches)
{
    for (const auto& batch : batches) {
        counters_.gathered += batch->counters.gathered;
        counters_.interpolated += batch->counters.interpolated;
        counters_.shadow += batch->shadows.counters;
        batch->counters = {};
        batch->shadows.counters = {};
    }
}

std::size_t MapLight::bytes() const
{
    return map_.bytes() + clusters_.size() * (10 * sizeof(float) + sizeof(std::size_t) + 1) +
           grid_.size() * (sizeof(MapReceiver) + sizeof(glm::vec3)) + grid_modes_.bytes() + pixel_modes_.bytes();
}

}   // namespace gnomon::light_quadtree
