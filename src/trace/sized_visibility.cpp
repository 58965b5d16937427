// SPDX-License-Identifier: Apache-2.0
#include "trace/sized_visibility.h"

#include <algorithm>

#include "ray/origin.h"

namespace gnomon::trace {

namespace {

constexpr std::size_t k_rays_at_once = 1 << 14;

}   // namespace

class SampledVisibility::Work final : public Worker {
 public:
    explicit Work(const SampledVisibility& owner) : owner_(owner) { queue_.purpose = ray::RayClass::shadow; }

    void find_visible(const PointBatch& batch, std::uint32_t light_index, std::span<const std::uint32_t> points,
                      SizedVisible& result) override
    {
        const scene::SizedLight& light = owner_.lights_->lights()[light_index];
        result.reset(points.size());
        queue_.clear(), targets_.clear();
        for (std::uint32_t asked = 0; asked < points.size(); ++asked) {
            result.add_partial(asked, light.places);
            const shadow_culling::ShadowPoint& here = batch.shadow_points[points[asked]];
            const glm::vec3& normal = batch.normals[points[asked]];
            for (std::uint32_t i = 0; i < light.places.size(); ++i) {
                // Skip places that do not face the point, or that it does not face: they have no weight.
                const scene::SizedPlace& place = light.places[i];
                const scene::SizedFace& face = light.faces[place.face];
                const glm::vec3 to_place = place.position - here.origin;
                if (!(glm::dot(to_place, here.normal) > 0) || !(glm::dot(to_place, normal) > 0)) continue;
                if (!face.two_sided && !(glm::dot(to_place, face.normal) < 0)) continue;
                queue_.push(here.origin, 0, to_place, ray::k_shadow_ray_end);
                targets_.emplace_back(asked, i);
            }
            if (queue_.size() >= k_rays_at_once) trace(result);
        }
        trace(result);
        for (std::size_t asked = 0; asked < points.size(); ++asked)
            if (std::ranges::all_of(result.seen_by(asked), [](std::uint8_t seen) { return seen == 0; }))
                result.answer[asked] = SizedVisible::Answer::dark;
    }
    std::uint64_t traced() const { return traced_; }

 private:
    void trace(SizedVisible& result)
    {
        const std::size_t count = queue_.size();
        if (count == 0) return;
        traced_ += count;
        occluded_.resize(count + ray::k_packet_pad);
        owner_.rays_->occluded(queue_, 0, count, occluded_.data());
        for (std::size_t r = 0; r < count; ++r) {
            if (occluded_[r]) continue;
            const auto [asked, place] = targets_[r];
            result.seen[result.first[asked] + place] = SizedVisible::k_whole;
        }
        queue_.clear(), targets_.clear();
    }

    const SampledVisibility& owner_;
    ray::RayQueue queue_;
    std::vector<std::pair<std::uint32_t, std::uint32_t>> targets_;   // by ray: asked point, place
    std::vector<std::uint8_t> occluded_;
    std::uint64_t traced_ = 0;
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
