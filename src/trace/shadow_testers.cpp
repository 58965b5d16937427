// SPDX-License-Identifier: Apache-2.0
#include "trace/shadow_testers.h"

#include "ray/origin.h"
#include "scene/light_reach.h"
#include "shadow_culling/nah2009/paper_tracer.h"

namespace gnomon::trace {

void ShadowRays::queue(const scene::SceneState& state, const PointBatch& batch, scene::LightId id)
{
    const scene::LightReach light(state.scene().lights[id], state.light(id));
    const float end = light.directional() ? k_infinity : ray::k_shadow_ray_end;
    rays.clear();
    rays.purpose = ray::RayClass::shadow;
    rays.reserve(batch.points.size());
    point.clear();
    for (std::uint32_t p = 0; p < batch.points.size(); ++p) {
        const shadow_culling::ShadowPoint& here = batch.shadow_points[p];
        const glm::vec3 to_light = light.from(here.origin);
        if (!light.faces(to_light, here.normal) || !light.faces(to_light, batch.normals[p])) continue;
        if (light.dark_at(batch.points[p].surface.position)) continue;
        rays.push(here.origin, 0, to_light, end);
        point.push_back(p);
    }
}

class EveryShadowRay::Work final : public Worker {
 public:
    explicit Work(const EveryShadowRay& tester) : tester_(tester) {}

    void find_lit(const PointBatch& batch, scene::LightId light, std::vector<std::uint32_t>& lit) override
    {
        asked_.queue(*tester_.state_, batch, light);
        const std::size_t count = asked_.rays.size();
        if (count == 0) return;
        traced_ += count;
        occluded_.resize(count + ray::k_packet_pad);
        tester_.rays_->occluded(asked_.rays, 0, count, occluded_.data());
        if (tester_.log_) tester_.log_->entries.push_back({asked_.rays, true});
        for (std::size_t i = 0; i < count; ++i)
            if (!occluded_[i]) lit.push_back(asked_.point[i]);
    }
    PointState state_of(const PointBatch& batch, std::uint32_t point, scene::LightId) const override
    {
        const bool dynamic = tester_.state_->is_dynamic(batch.shadow_points[point].object);
        return {dynamic ? StateMark::moving : StateMark::unknown};
    }
    std::uint64_t traced() const { return traced_; }

 private:
    const EveryShadowRay& tester_;
    ShadowRays asked_;
    std::vector<std::uint8_t> occluded_;
    std::uint64_t traced_ = 0;
};

std::unique_ptr<ShadowTester::Worker> EveryShadowRay::make_worker()
{
    return std::make_unique<Work>(*this);
}

FrameCounters::Shadow EveryShadowRay::end_frame(std::span<const std::unique_ptr<Worker>> workers, Tasks&)
{
    FrameCounters::Shadow sum;
    for (const auto& worker : workers) sum.rays += static_cast<const Work&>(*worker).traced();
    return sum;
}

class CertifiedShadows::Work final : public Worker {
 public:
    explicit Work(const CertifiedShadows& tester) : tester_(tester), batch_(tester.culling_.make_batch()) {}

    void prepare(const PointBatch& batch) override { tester_.culling_.classify(*batch_, batch.shadow_points); }
    void find_lit(const PointBatch& batch, scene::LightId id, std::vector<std::uint32_t>& lit) override
    {
        const scene::LightReach light(tester_.state_->scene().lights[id], tester_.state_->light(id));
        occluded_.resize(batch.points.size() + ray::k_packet_pad);
        tester_.culling_.shadow(*batch_, static_cast<int>(id), occluded_.data());
        for (std::uint32_t p = 0; p < batch.points.size(); ++p) {
            if (occluded_[p]) continue;
            if (!light.faces(light.from(batch.shadow_points[p].origin), batch.normals[p])) continue;
            if (light.dark_at(batch.points[p].surface.position)) continue;
            lit.push_back(p);
        }
    }
    PointState state_of(const PointBatch& batch, std::uint32_t point, scene::LightId light) const override
    {
        if (tester_.state_->is_dynamic(batch.shadow_points[point].object)) return {StateMark::moving};
        switch (tester_.culling_.state_of(*batch_, point, static_cast<int>(light))) {
            case shadow_culling::ShadowState::none:
                return {StateMark::none};
            case shadow_culling::ShadowState::full:
                return {StateMark::full};
            case shadow_culling::ShadowState::partial:
                return {StateMark::partial};
            case shadow_culling::ShadowState::unknown:
                break;
        }
        return {StateMark::unknown};
    }
    std::unique_ptr<shadow_culling::CertifiedCulling::Batch> take_batch() { return std::move(batch_); }

 private:
    const CertifiedShadows& tester_;
    std::unique_ptr<shadow_culling::CertifiedCulling::Batch> batch_;
    std::vector<std::uint8_t> occluded_;
};

void CertifiedShadows::begin_frame(const FrameContext& frame)
{
    state_ = &frame.state;
    culling_.begin_frame(frame.state, frame.rays, {frame.view.eye, frame.view.pixel_spread, frame.view.pixel_width});
}

std::unique_ptr<ShadowTester::Worker> CertifiedShadows::make_worker()
{
    return std::make_unique<Work>(*this);
}

FrameCounters::Shadow CertifiedShadows::end_frame(std::span<const std::unique_ptr<Worker>> workers, Tasks& tasks)
{
    std::vector<std::unique_ptr<shadow_culling::CertifiedCulling::Batch>> batches;
    for (const auto& worker : workers) batches.push_back(static_cast<Work&>(*worker).take_batch());
    culling_.note_news(batches);
    if (!defer_certificates_) culling_.judge(tasks);
    const shadow_culling::CullingCounters& c = culling_.counters();
    FrameCounters::Shadow result;
    result.rays = c.skipped + c.dynamic_only + c.traced;
    result.rays_skipped = c.skipped;
    result.rays_dynamic_only = c.dynamic_only;
    return result;
}

class NahShadows::Work final : public Worker {
 public:
    explicit Work(NahShadows& tester) : tester_(tester) {}

    // DEVIATION(Nah 2009, 2.3): with several samples a pixel, the occlusion test sees the first of each; the paper has
    // one.
    void note_primary_hits(const PrimaryRays& primary) override
    {
        for (std::size_t i = 0; i < primary.rays.size(); ++i) {
            shadow_culling::PrimaryHit hit{shadow_culling::no_primitive, primary.rays.origin(i),
                                           primary.rays.direction(i)};
            if (primary.hits.object[i] != scene::none)
                hit.primitive = tester_.culling_.primitive(primary.hits.object[i], primary.hits.triangle[i],
                                                           primary.hits.u[i], primary.hits.v[i]);
            const std::size_t pixel = primary.tile.index_in_image(primary.paths[i].pixel, tester_.image_width_);
            tester_.primary_hits_[pixel] = hit;
            if (tester_.culling_.options().writes_at_once) tester_.see_pixel(pixel);
        }
    }
    void find_lit(const PointBatch& batch, scene::LightId light, std::vector<std::uint32_t>& lit) override
    {
        asked_.queue(*tester_.state_, batch, light);
        const std::size_t count = asked_.rays.size();
        origins_.resize(count);
        for (std::size_t i = 0; i < count; ++i) {
            const shadow_culling::ShadowPoint& here = batch.shadow_points[asked_.point[i]];
            origins_[i] = tester_.culling_.primitive(here.object, here.triangle, here.u, here.v);
        }
        occluded_.resize(count + ray::k_packet_pad);
        tracer_.answer(tester_.culling_, *tester_.rays_, static_cast<int>(light), asked_.rays, origins_,
                       occluded_.data());
        for (std::size_t i = 0; i < count; ++i)
            if (!occluded_[i]) lit.push_back(asked_.point[i]);
    }
    PointState state_of(const PointBatch& batch, std::uint32_t point, scene::LightId light) const override
    {
        const shadow_culling::PaperCulling& culling = tester_.culling_;
        const shadow_culling::ShadowPoint& here = batch.shadow_points[point];
        const shadow_culling::PrimitiveId origin = culling.primitive(here.object, here.triangle, here.u, here.v);
        if (culling.triangles().is_dynamic(origin)) return {StateMark::moving};
        const bool untrusted = culling.modes().occlusion(origin) != shadow_culling::OcclusionMode::fully_rendered;
        switch (culling.modes().shadow(origin, static_cast<int>(light))) {
            case shadow_culling::ShadowMode::non_shadow:
                return {StateMark::none, untrusted};
            case shadow_culling::ShadowMode::full_shadow:
                return {StateMark::full, untrusted};
            case shadow_culling::ShadowMode::partial_shadow:
                return {StateMark::partial, untrusted};
            case shadow_culling::ShadowMode::init:
                break;
        }
        return {StateMark::unknown, untrusted};
    }
    shadow_culling::PaperCulling::Notes take_notes() { return tracer_.take_notes(); }

 private:
    NahShadows& tester_;
    shadow_culling::PaperTracer tracer_;
    ShadowRays asked_;
    std::vector<shadow_culling::PrimitiveId> origins_;   // by ray
    std::vector<std::uint8_t> occluded_;
};

void NahShadows::begin_frame(const FrameContext& frame)
{
    state_ = &frame.state, rays_ = &frame.rays;
    culling_.begin_frame(frame.state, frame.rays);
    const Size size = frame.view.size;
    image_width_ = size.width;
    primary_hits_.assign(static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height), {});
}

void NahShadows::see_pixel(std::size_t pixel)
{
    const auto width = static_cast<std::size_t>(image_width_);
    const std::size_t x = pixel % width;
    const bool edge = x == 0 || x + 1 == width || pixel < width || pixel + width >= primary_hits_.size();
    const auto shown = [&](std::size_t at) { return primary_hits_[at].primitive; };
    culling_.see_pixel(primary_hits_[pixel], edge ? shadow_culling::no_primitive : shown(pixel - 1),
                       edge ? shadow_culling::no_primitive : shown(pixel - width), edge);
}

std::unique_ptr<ShadowTester::Worker> NahShadows::make_worker()
{
    return std::make_unique<Work>(*this);
}

FrameCounters::Shadow NahShadows::end_frame(std::span<const std::unique_ptr<Worker>> workers, Tasks&)
{
    std::vector<shadow_culling::PaperCulling::Notes> notes;
    for (const auto& worker : workers) notes.push_back(static_cast<Work&>(*worker).take_notes());
    if (!culling_.options().writes_at_once) culling_.see_image(primary_hits_, static_cast<std::size_t>(image_width_));
    culling_.end_frame(notes);
    FrameCounters::Shadow result;
    result.rays = culling_.counters().rays;
    result.rays_skipped = culling_.counters().skipped;
    result.rays_dynamic_only = culling_.counters().dynamic_only;
    return result;
}

}   // namespace gnomon::trace
