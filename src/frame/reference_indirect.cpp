// SPDX-License-Identifier: Apache-2.0
#include "frame/reference_indirect.h"

#include <algorithm>

#include "shading/glossy.h"
#include "shading/layers.h"

namespace gnomon::frame {

namespace {

constexpr int k_least_paths = 2;   // of a point: fewer have no spread, and so no error

}   // namespace

class ReferenceIndirect::Work final : public Worker {
 public:
    explicit Work(const ReferenceIndirect& light) : light_(light), paths_(*light.light_) {}

    void begin_tile(const trace::Tile& tile) override
    {
        points_of_pixel_.assign(static_cast<std::size_t>(tile.side) * static_cast<std::size_t>(tile.side), 0);
    }
    void gather(const trace::PointBatch& batch, trace::IndirectResult& result) override
    {
        // Give each point random numbers of its own, by pixel and by how many points the pixel had so far.
        requests_.clear();
        result.point.clear();
        for (std::uint32_t p = 0; p < batch.points.size(); ++p) {
            const trace::TilePoint& point = batch.points[p];
            if (point.surface.diffuse * point.surface.coverage == glm::vec3(0)) continue;
            const std::uint64_t place = batch.tile.index_in_image(point.pixel, light_.image_width_);
            const std::uint64_t key = reference::mix(place, points_of_pixel_[point.pixel]++);
            requests_.push_back({irradiance_point(batch, p, key), samples_of(point.throughput)});
            result.point.push_back(p);
        }
        const std::size_t diffuse = requests_.size();
        result.lobe_point.clear();
        coats_.clear();
        for (const trace::TilePoint& point : batch.points)
            if (point.coat_glossy) coats_.push_back(shading::coat_surface(point.surface));
        auto coat = coats_.begin();
        for (std::uint32_t p = 0; p < batch.points.size(); ++p) {
            if (batch.points[p].glossy) request_lobe(batch, p, batch.points[p].surface, result);
            if (batch.points[p].coat_glossy) request_lobe(batch, p, *coat++, result);
        }
        estimates_.resize(requests_.size());
        paths_.estimate(requests_, estimates_.data());

        for (auto* list : {&result.irradiance, &result.surroundings, &result.irradiance_error, &result.error,
                           &result.lobe_radiance, &result.lobe_error})
            list->clear();
        for (std::size_t k = 0; k < estimates_.size(); ++k) {
            const reference::IrradianceEstimate& estimate = estimates_[k];
            if (k >= diffuse) {
                result.lobe_radiance.push_back(estimate.indirect + estimate.surroundings);
                result.lobe_error.push_back(estimate.error);
                continue;
            }
            result.irradiance.push_back(estimate.indirect);
            result.surroundings.push_back(estimate.surroundings);
            result.irradiance_error.push_back(estimate.indirect_error);
            result.error.push_back(estimate.error);
        }
    }
    std::uint64_t rays() const { return paths_.counters().rays; }

 private:
    void request_lobe(const trace::PointBatch& batch, std::uint32_t p, const shading::SurfacePoint& surface,
                      trace::IndirectResult& result)
    {
        const trace::TilePoint& point = batch.points[p];
        const std::uint64_t place = batch.tile.index_in_image(point.pixel, light_.image_width_);
        const std::uint64_t key = reference::mix(place, points_of_pixel_[point.pixel]++);
        const glm::vec3 share = shading::glossy_albedo(surface) * surface.coverage;
        requests_.push_back({irradiance_point(batch, p, key), samples_of(point.throughput * share), &surface});
        result.lobe_point.push_back(p);
    }
    reference::IrradiancePoint irradiance_point(const trace::PointBatch& batch, std::uint32_t p,
                                                std::uint64_t key) const
    {
        const shading::SurfacePoint& s = batch.points[p].surface;
        const visibility::ShadowPoint& at = batch.shadow_points[p];
        return reference::irradiance_point(
            s, shading::smooth_origin(light_.rays_->geometry(at.object), at.triangle, at.u, at.v, s), key);
    }
    // Gives a point seen in a mirror fewer paths, in proportion to its throughput, since it adds less to the noise.
    int samples_of(const glm::vec3& throughput) const
    {
        const int all = std::max(1, light_.options_.samples / light_.samples_per_pixel_);
        const float wanted = static_cast<float>(all) * std::max({throughput.x, throughput.y, throughput.z});
        if (wanted >= static_cast<float>(all)) return all;
        int samples = std::min(all, k_least_paths);
        while (static_cast<float>(samples) < wanted) samples *= 2;
        return std::min(samples, all);
    }

    const ReferenceIndirect& light_;
    reference::ReferencePaths paths_;
    std::vector<reference::ReferencePaths::Request> requests_;
    std::vector<reference::IrradianceEstimate> estimates_;
    std::vector<shading::SurfacePoint> coats_;     // of points with a glossy coat, in their order
    std::vector<std::uint32_t> points_of_pixel_;   // over all samples of the tile
};

void ReferenceIndirect::begin_frame(const trace::FrameContext& frame)
{
    light_.emplace(frame.state, frame.rays, options_);
    rays_ = &frame.rays;
    image_width_ = frame.view.size.width;
}

std::unique_ptr<trace::IndirectLight::Worker> ReferenceIndirect::make_worker()
{
    return std::make_unique<Work>(*this);
}

FrameCounters::Indirect ReferenceIndirect::end_frame(std::span<const std::unique_ptr<Worker>> workers)
{
    FrameCounters::Indirect sum;
    for (const auto& worker : workers) sum.rays += static_cast<const Work&>(*worker).rays();
    return sum;
}

}   // namespace gnomon::frame
