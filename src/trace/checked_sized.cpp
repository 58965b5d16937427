// SPDX-License-Identifier: Apache-2.0
#include "trace/checked_sized.h"

#include <algorithm>
#include <cmath>

#include "ray/origin.h"

namespace gnomon::trace {

StateMark joined(StateMark a, StateMark b)
{
    if (a == b || b == StateMark::away) return a;
    if (a == StateMark::away) return b;
    for (const StateMark traced : {StateMark::moving, StateMark::unknown, StateMark::partial})
        if (a == traced || b == traced) return traced;
    return StateMark::penumbra;
}

class CheckedSized::Work final : public Worker {
 public:
    explicit Work(CheckedSized& owner)
        : owner_(owner), tested_(owner.tested_.make_worker()), rays_(owner.rays_.make_worker())
    {
    }

    void prepare(const PointBatch& batch) override
    {
        tested_->prepare(batch);
        rays_->prepare(batch);
    }
    void find_visible(const PointBatch& batch, std::uint32_t light, std::span<const std::uint32_t> points,
                      SizedVisible& result) override
    {
        tested_->find_visible(batch, light, points, result);
        const int panel = owner_.panel_of_[light];
        std::uint8_t* const cells = panel < 0 ? nullptr : owner_.map_.panel(static_cast<std::size_t>(panel));
        const auto cell_of = [&](std::uint32_t p) -> std::uint8_t& {
            return cells[batch.tile.index_in_image(batch.points[p].pixel, owner_.map_.size.width)];
        };
        if (cells && batch.primary && batch.first_sample)
            for (std::size_t k = 0; k < points.size(); ++k) {
                std::uint8_t& cell = cell_of(points[k]);
                const StateMark mark = joined(StateCell::of(cell).mark, result.state[k]);
                cell = static_cast<std::uint8_t>((cell & ~StateCell::k_mark) | static_cast<unsigned>(mark));
            }

        // Trace rays where it is proven that all or nothing is visible.
        asked_.clear(), lit_.clear();
        for (std::size_t k = 0; k < points.size(); ++k) {
            const bool lit = result.state[k] == StateMark::none && result.answer[k] == SizedVisible::Answer::lit;
            if (!lit && result.state[k] != StateMark::full) continue;
            asked_.push_back(points[k]), lit_.push_back(lit);
        }
        if (asked_.empty()) return;
        rays_->find_visible(batch, light, asked_, traced_);
        for (std::size_t k = 0; k < asked_.size(); ++k) {
            if (lit_[k] ? sees_all(batch, light, k) : traced_.answer[k] == SizedVisible::Answer::dark) continue;
            ++wrong_;
            if (cells) cell_of(asked_[k]) |= batch.primary ? StateCell::k_wrong : StateCell::k_wrong_behind;
        }
    }

    // Whether the rays of an asked point reach every place that faces it. Places that it sees so nearly edge-on that in
    // single precision the end of the ray may lie behind their face are not asked.
    bool sees_all(const PointBatch& batch, std::uint32_t index, std::size_t k) const
    {
        const scene::SizedLight& light = owner_.lights_->lights()[index];
        const std::span<const std::uint8_t> seen = traced_.seen_by(k);
        const glm::vec3 &origin = batch.shadow_points[asked_[k]].origin,
                        &horizon = batch.shadow_points[asked_[k]].normal, &normal = batch.normals[asked_[k]];
        for (std::size_t i = 0; i < light.places.size(); ++i) {
            const glm::vec3 to_place = light.places[i].position - origin;
            const scene::SizedFace& face = light.faces[light.places[i].face];
            const bool faces = glm::dot(to_place, horizon) > 0 && glm::dot(to_place, normal) > 0 &&
                               (face.two_sided || glm::dot(to_place, face.normal) < 0);
            const glm::vec3 reach = glm::max(glm::abs(origin), glm::abs(light.places[i].position));
            constexpr float k_rounding = 4e-7f;
            const float before_face = (1 - ray::k_shadow_ray_end) * std::abs(glm::dot(to_place, face.normal));
            const bool edge_on = before_face < k_rounding * std::max({reach.x, reach.y, reach.z});
            if (faces && !edge_on && seen[i] == 0) return false;
        }
        return true;
    }

    std::unique_ptr<Worker> take_tested() { return std::move(tested_); }
    std::uint64_t wrong() const { return wrong_; }

 private:
    CheckedSized& owner_;
    std::unique_ptr<Worker> tested_, rays_;
    std::vector<std::uint32_t> asked_;
    std::vector<char> lit_;   // by asked point: proven lit, else proven dark
    SizedVisible traced_;
    std::uint64_t wrong_ = 0;
};

void CheckedSized::begin_frame(const FrameContext& frame, const scene::SizedLights& lights)
{
    tested_.begin_frame(frame, lights);
    rays_.begin_frame(frame, lights);
    lights_ = &lights;
}

std::unique_ptr<SizedVisibility::Worker> CheckedSized::make_worker()
{
    return std::make_unique<Work>(*this);
}

FrameCounters::Shadow CheckedSized::end_frame(std::span<const std::unique_ptr<Worker>> workers, Tasks& tasks)
{
    std::uint64_t wrong = 0;
    std::vector<std::unique_ptr<Worker>> tested;
    for (const auto& worker : workers) {
        Work& work = static_cast<Work&>(*worker);
        wrong += work.wrong();
        tested.push_back(work.take_tested());
    }
    FrameCounters::Shadow result = tested_.end_frame(tested, tasks);
    result.rays_wrong = wrong;
    return result;
}

}   // namespace gnomon::trace
