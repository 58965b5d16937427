// SPDX-License-Identifier: Apache-2.0
#include "trace/checked_shadows.h"

#include <algorithm>

#include "scene/light_reach.h"

namespace gnomon::trace {

class CheckedShadows::Work final : public Worker {
 public:
    explicit Work(CheckedShadows& tester) : tester_(tester), tested_(tester.tested_.make_worker()) {}

    void note_primary_hits(const PrimaryRays& primary) override { tested_->note_primary_hits(primary); }
    void prepare(const PointBatch& batch) override
    {
        tested_->prepare(batch);
        if (!batch.primary || !batch.first_sample) return;
        for (std::size_t panel = 0; panel < tester_.map_.lights.size(); ++panel) mark_points(batch, panel);
    }
    void find_lit(const PointBatch& batch, scene::LightId light, std::vector<std::uint32_t>& lit) override
    {
        const std::size_t before = lit.size();
        tested_->find_lit(batch, light, lit);
        check(batch, light, std::span(lit).subspan(before));
    }
    PointState state_of(const PointBatch& batch, std::uint32_t point, scene::LightId light) const override
    {
        return tested_->state_of(batch, point, light);
    }
    std::unique_ptr<Worker> take_tested() { return std::move(tested_); }
    std::uint64_t wrong() const { return wrong_; }

 private:
    // Records the remembered state of every first hit.
    void mark_points(const PointBatch& batch, std::size_t panel)
    {
        StateMap& map = tester_.map_;
        const auto light = static_cast<scene::LightId>(map.lights[panel]);
        std::uint8_t* const cells = map.panel(panel);
        for (std::uint32_t p = 0; p < batch.points.size(); ++p) {
            const shading::SurfacePoint& s = batch.points[p].surface;
            const std::size_t pixel = batch.tile.index_in_image(batch.points[p].pixel, map.size.width);
            const PointState state = shown_state(batch, p, light);
            cells[pixel] = static_cast<std::uint8_t>(static_cast<unsigned>(state.mark) |
                                                     (state.untrusted ? StateCell::k_untrusted : 0u));
            const float facing = std::clamp(std::abs(glm::dot(s.normal, s.to_viewer)), 0.0f, 1.0f);
            map.shade[pixel] = static_cast<std::uint8_t>(facing * 255.0f + 0.5f);
        }
    }

    // The remembered state, where the light could reach the point.
    PointState shown_state(const PointBatch& batch, std::uint32_t p, scene::LightId id) const
    {
        const scene::Scene& scene = tester_.state_->scene();
        if (id >= scene.lights.size()) return {StateMark::away};   // lights with size: see CheckedSized
        const scene::Light& light = scene.lights[id];
        const scene::LightState& at = tester_.state_->light(id);
        const shadow_culling::ShadowPoint& here = batch.shadow_points[p];
        const glm::vec3 to_light = scene::LightReach(light, at).from(here.origin);
        if (!at.visible || !scene::LightReach::faces(to_light, here.normal) ||
            !scene::LightReach::faces(to_light, batch.normals[p]) ||
            scene::illuminate(light, at, batch.points[p].surface.position).irradiance == glm::vec3(0))
            return {StateMark::away};
        return tested_->state_of(batch, p, id);
    }

    // Traces every ray, and counts and marks the points where the tested answer differs.
    void check(const PointBatch& batch, scene::LightId light, std::span<const std::uint32_t> lit)
    {
        StateMap& map = tester_.map_;
        asked_.queue(*tester_.state_, batch, light);
        asked_.rays.purpose = ray::RayClass::check;
        const std::size_t count = asked_.rays.size();
        occluded_.resize(count + ray::k_packet_pad);
        tester_.rays_->occluded(asked_.rays, 0, count, occluded_.data());
        found_lit_.assign(batch.points.size(), 0);
        for (const std::uint32_t p : lit) found_lit_[p] = 1;

        const auto panel = std::find(map.lights.begin(), map.lights.end(), static_cast<int>(light));
        std::uint8_t* const cells =
            panel == map.lights.end() ? nullptr : map.panel(static_cast<std::size_t>(panel - map.lights.begin()));
        const std::uint8_t flag = batch.primary ? StateCell::k_wrong : StateCell::k_wrong_behind;
        for (std::size_t i = 0; i < count; ++i) {
            const std::uint32_t p = asked_.point[i];
            if (found_lit_[p] == !occluded_[i]) continue;
            ++wrong_;
            if (cells) cells[batch.tile.index_in_image(batch.points[p].pixel, map.size.width)] |= flag;
        }
    }

    CheckedShadows& tester_;
    std::unique_ptr<Worker> tested_;
    ShadowRays asked_;
    std::vector<std::uint8_t> occluded_;
    std::vector<std::uint8_t> found_lit_;   // by point
    std::uint64_t wrong_ = 0;
};

void CheckedShadows::begin_frame(const FrameContext& frame)
{
    state_ = &frame.state, rays_ = &frame.rays;
    tested_.begin_frame(frame);
    map_.start(frame.view.size);
}

std::unique_ptr<ShadowTester::Worker> CheckedShadows::make_worker()
{
    return std::make_unique<Work>(*this);
}

FrameCounters::Shadow CheckedShadows::end_frame(std::span<const std::unique_ptr<Worker>> workers, Tasks& tasks)
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
