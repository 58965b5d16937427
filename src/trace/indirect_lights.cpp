// SPDX-License-Identifier: Apache-2.0
#include "trace/indirect_lights.h"

#include <algorithm>
#include <cmath>

#include "trace/indirect_grid.h"

namespace gnomon::trace {

namespace {

// Whether a surface reflects indirect light.
bool scatters(const shading::SurfacePoint& s)
{
    return s.model != scene::ShadingModel::unlit && s.diffuse != glm::vec3(0);
}

// What is left of a point's light so that the surfaces it comes from fill no more than what hides the environment.
// Interpolated between cache points, their form factor is more in places, and so is their light. Both shares are
// estimates. What they differ by anywhere is left alone: else the least of both would be too little, on average.
float kept_light(float form_factor, float hidden)
{
    constexpr float k_uncertain = 0.05f, k_certain = 0.15f;   // of `hidden`
    if (hidden >= 1) return 1;
    const float left = std::clamp((k_certain + 1 - form_factor / hidden) / (k_certain - k_uncertain), 0.0f, 1.0f);
    return std::min((1 + k_uncertain * left) * hidden / form_factor, 1.0f);
}

}   // namespace

class CachedIndirect::Work final : public Worker {
 public:
    explicit Work(const CachedIndirect& light) : light_(light), batch_(light.cache_.make_batch()) {}

    void gather(const PointBatch& batch, IndirectResult& result) override
    {
        ask(batch, result);
        form_factors_.resize(asked_.size());
        light_.cache_.shade(*batch_, asked_, result.irradiance.data(), form_factors_.data());
        for (std::size_t k = 0; k < asked_.size(); ++k)
            if (const float hidden = batch.points[result.point[k]].hidden; form_factors_[k] > hidden)
                result.irradiance[k] *= kept_light(form_factors_[k], hidden);
    }
    std::unique_ptr<Remembered> gather_and_remember(const PointBatch& batch, IndirectResult& result) override
    {
        const bool hidden = std::ranges::any_of(batch.points, [](const TilePoint& p) { return p.hidden < 1; });
        if (hidden) return Worker::gather_and_remember(batch, result);
        ask(batch, result);
        auto remembered = std::make_unique<RememberedPoints>();
        light_.cache_.shade_and_remember(*batch_, asked_, result.irradiance.data(), remembered->found);
        if (!remembered->found) return nullptr;
        remembered->point.assign(result.point.begin(), result.point.end());
        return remembered;
    }
    bool gather_again(Remembered& of, IndirectResult& result) override
    {
        RememberedPoints& remembered = static_cast<RememberedPoints&>(of);
        result.point.assign(remembered.point.begin(), remembered.point.end());
        result.irradiance.resize(result.point.size());
        return light_.cache_.shade_again(*batch_, *remembered.found, result.irradiance.data());
    }
    std::unique_ptr<irradiance_cache::IrradianceCache::Batch> take_batch() { return std::move(batch_); }

 private:
    struct RememberedPoints final : Remembered {
        std::vector<std::uint16_t> point;   // of the batch, which is a tile's
        std::unique_ptr<irradiance_cache::RememberedBatch> found;
        std::size_t bytes() const override
        {
            return sizeof(RememberedPoints) + point.capacity() * sizeof(std::uint16_t) + found->bytes();
        }
    };

    // Lists the points of a batch that receive indirect light.
    void ask(const PointBatch& batch, IndirectResult& result)
    {
        asked_.clear();
        result.point.clear();
        for (std::uint32_t p = 0; p < batch.points.size(); ++p) {
            const TilePoint& point = batch.points[p];
            const shading::SurfacePoint& s = point.surface;
            if (!scatters(s) || point.has_bounced) continue;
            const shadow_culling::ShadowPoint& here = batch.shadow_points[p];
            const float width = batch.primary ? s.cone.width : mirrored_width(point);
            asked_.push_back({s.position, s.geometric_normal, s.normal, here.object, here.triangle, here.u, here.v,
                              width, s.to_viewer});
            asked_.back().of_many = point.lobe.rays > 1 || point.parts > 1;
            if (batch.primary && !batch.scattered()) {
                const int pixel = static_cast<int>(point.pixel);
                asked_.back().x = static_cast<std::int16_t>(pixel % batch.tile.side);
                asked_.back().y = static_cast<std::int16_t>(pixel / batch.tile.side);
            }
            result.point.push_back(p);
        }
        result.irradiance.resize(asked_.size());
    }

    // The width that selects the cache points of what a mirror, glass or a lobe shows.
    float mirrored_width(const TilePoint& point) const
    {
        const Options& options = light_.options_;
        // Chrome and glass show everything small and from viewpoints of their own, so that its cache points would be
        // many and new in every frame. Where a curved mirror is small, though, they would be farther apart than the
        // walls around, and show nothing of how bounced light changes there.
        const float cone = point.surface.cone.width;
        const float reach = options.mirrored_reach * point.distance / light_.cache_.widest_spacing();
        const float least = point.lobe.rays > 0 ? options.lobe_least : options.mirrored_least;
        const float width = std::min(options.mirrored_spacing * cone, std::max(least * cone, reach));
        // A path of low throughput may be coarser. One that a lobe divided has the throughput of all of its parts.
        const float throughput = largest(point.throughput) * std::max(point.lobe.rays, 1.0f);
        return width / std::sqrt(std::min(throughput, 1.0f));
    }

    const CachedIndirect& light_;
    std::unique_ptr<irradiance_cache::IrradianceCache::Batch> batch_;
    std::vector<irradiance_cache::IndirectPoint> asked_;
    std::vector<float> form_factors_;
};

std::unique_ptr<IndirectLight::Worker> CachedIndirect::make_worker()
{
    return std::make_unique<Work>(*this);
}

FrameCounters::Indirect CachedIndirect::end_frame(std::span<const std::unique_ptr<Worker>> workers)
{
    std::vector<std::unique_ptr<irradiance_cache::IrradianceCache::Batch>> batches;
    for (const auto& worker : workers) batches.push_back(static_cast<Work&>(*worker).take_batch());
    cache_.end_frame(batches);
    return {cache_.counters().nodes, cache_.counters().rays};
}

class MapIndirect::Work final : public Worker {
 public:
    explicit Work(const MapIndirect& light) : light_(light), batch_(std::make_unique<light_quadtree::MapLight::Batch>())
    {
    }

    void gather(const PointBatch& batch, IndirectResult& result) override
    {
        receivers_.clear();
        result.point.clear();
        for (std::uint32_t p = 0; p < batch.points.size(); ++p) {
            const shading::SurfacePoint& s = batch.points[p].surface;
            if (!scatters(s) || batch.points[p].has_bounced) continue;
            light_quadtree::MapReceiver& receiver = receivers_.emplace_back();
            receiver.position = s.position;
            receiver.normal = s.normal;
            receiver.width = s.cone.width;
            if (batch.primary) receiver.pixel = batch.pixel_of_image(batch.points[p]);
            result.point.push_back(p);
        }
        result.irradiance.resize(receivers_.size());
        light_.light_.shade(*batch_, receivers_, result.irradiance.data());
    }
    std::unique_ptr<light_quadtree::MapLight::Batch> take_batch() { return std::move(batch_); }

 private:
    const MapIndirect& light_;
    std::unique_ptr<light_quadtree::MapLight::Batch> batch_;
    std::vector<light_quadtree::MapReceiver> receivers_;
};

void MapIndirect::begin_frame(const FrameContext& frame)
{
    light_.begin_frame(frame.state, frame.rays, frame.tasks);
    light_.begin_image(frame.view.size.width, frame.view.size.height);
    const int step = light_.grid_step(frame.view.size.width, frame.view.size.height);
    if (step == 0) return;
    const IndirectGrid grid = cast_indirect_grid(frame.state.scene(), frame.rays, frame.view, step, frame.tasks);
    light_.set_grid(grid.receivers, grid.columns, step, frame.tasks);
}

std::unique_ptr<IndirectLight::Worker> MapIndirect::make_worker()
{
    return std::make_unique<Work>(*this);
}

FrameCounters::Indirect MapIndirect::end_frame(std::span<const std::unique_ptr<Worker>> workers)
{
    std::vector<std::unique_ptr<light_quadtree::MapLight::Batch>> batches;
    for (const auto& worker : workers) batches.push_back(static_cast<Work&>(*worker).take_batch());
    light_.end_frame(batches);
    const light_quadtree::MapLightCounters& counters = light_.counters();
    return {.clusters = counters.lights,
            .rays = light_.map().work().cast + counters.shadow.cast(),
            .kept_map = counters.kept_map,
            .kept_receivers = counters.kept_grid};
}

}   // namespace gnomon::trace
