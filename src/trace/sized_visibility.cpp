// SPDX-License-Identifier: Apache-2.0
#include "trace/sized_visibility.h"

#include <numeric>

#include "trace/place_rays.h"

namespace gnomon::trace {

class SampledVisibility::Work final : public Worker {
 public:
    explicit Work(const SampledVisibility& owner) : owner_(owner), rays_(*owner.rays_) {}

    void find_visible(const PointBatch& batch, std::uint32_t light, std::span<const std::uint32_t> points,
                      SizedVisible& result) override
    {
        result.reset(points.size());
        all_.resize(points.size());
        std::iota(all_.begin(), all_.end(), 0u);
        rays_.trace(batch, owner_.lights_->lights()[light], points, all_, ray::Against::everything, result);
    }
    std::uint64_t traced() const { return rays_.traced(); }

 private:
    const SampledVisibility& owner_;
    PlaceRays rays_;
    std::vector<std::uint32_t> all_;
};

void SampledVisibility::begin_frame(const FrameContext& frame, const scene::SizedLights& lights)
{
    lights_ = &lights;
    rays_ = &frame.rays;
}

std::unique_ptr<SizedVisibility::Worker> SampledVisibility::make_worker()
{
    return std::make_unique<Work>(*this);
}

FrameCounters::Shadow SampledVisibility::end_frame(std::span<const std::unique_ptr<Worker>> workers, Tasks&)
{
    FrameCounters::Shadow sum;
    for (const auto& worker : workers) sum.rays += static_cast<const Work&>(*worker).traced();
    return sum;
}

}   // namespace gnomon::trace
