// SPDX-License-Identifier: Apache-2.0
#include "trace/proven_visibility.h"

#include <algorithm>

namespace gnomon::trace {

namespace {

using area_light::AreaVisibility;

StateMark mark_of(area_light::PartState state)
{
    switch (state) {
        case area_light::PartState::unlit:
            return StateMark::away;
        case area_light::PartState::lit:
            return StateMark::none;
        case area_light::PartState::dark:
            return StateMark::full;
        case area_light::PartState::listed:
            return StateMark::penumbra;
        case area_light::PartState::open:
            break;
    }
    return StateMark::partial;
}

}   // namespace

class ProvenVisibility::Work final : public Worker {
 public:
    explicit Work(ProvenVisibility& owner) : owner_(owner), sampled_(owner.sampled_.make_worker()) {}

    void prepare(const PointBatch& batch) override { sampled_->prepare(batch); }

    void find_visible(const PointBatch& batch, std::uint32_t light, std::span<const std::uint32_t> points,
                      SizedVisible& result) override
    {
        const std::uint32_t planar = owner_.planar_[light];
        if (planar == k_sampled) return sampled_->find_visible(batch, light, points, result);
        owner_.visibility_->find(scratch_, batch.shadow_points, points, planar, answers_);
        result.reset(points.size());
        const area_light::CellPlaces& places = owner_.places_[planar];
        const bool light_moves = owner_.lights_->lights()[light].dynamic;
        for (std::size_t k = 0; k < points.size(); ++k) {
            const bool moves = light_moves || owner_.state_->is_dynamic(batch.shadow_points[points[k]].object);
            result.state[k] = moves ? StateMark::moving : mark_of(answers_.state[k]);
            if (answers_.answer[k] == AreaVisibility::Answer::lit) result.answer[k] = SizedVisible::Answer::lit;
            if (answers_.answer[k] != AreaVisibility::Answer::partial) continue;
            const std::size_t side = answers_.back[k] ? 1 : 0;
            const area_light::VisibleCells& cells = answers_.cells[answers_.at[k]];
            const area_light::LightCells& of = owner_.visibility_->cells(planar, answers_.back[k] != 0);
            std::uint8_t* seen = result.add_partial(k, places.of[side]);
            places.fill_seen(side, of, cells, seen);
            if (places.one_radiance) {
                const visibility::ShadowPoint& p = batch.shadow_points[points[k]];
                result.share[k] = of.share(p.origin, batch.normals[points[k]], p.normal, cells);
            }
        }
    }

    const area_light::VisibilityCounters& counters() const { return scratch_.counters; }
    std::unique_ptr<Worker>& sampled() { return sampled_; }

 private:
    ProvenVisibility& owner_;
    std::unique_ptr<Worker> sampled_;
    AreaVisibility::Scratch scratch_;
    AreaVisibility::Answers answers_;
};

void ProvenVisibility::begin_frame(const FrameContext& frame, const scene::SizedLights& lights)
{
    sampled_.begin_frame(frame, lights);
    state_ = &frame.state;
    const bool first = !visibility_;
    if (first) visibility_ = std::make_unique<AreaVisibility>(frame.state, frame.rays, options_);
    std::vector<area_light::AreaLight> planar;
    planar_.assign(lights.lights().size(), k_sampled);
    for (std::size_t l = 0; l < lights.lights().size(); ++l) {
        if (!lights.lights()[l].is_flat()) continue;
        planar_[l] = static_cast<std::uint32_t>(planar.size());
        planar.push_back(area_light::area_light_of(lights.lights()[l]));
    }
    visibility_->follow(frame.state, frame.rays, planar);
    if (!first && lights_ == &lights && version_ == lights.version()) return;

    // Make sample places of the cells.
    lights_ = &lights, version_ = lights.version();
    places_.clear();
    for (std::size_t l = 0; l < lights.lights().size(); ++l)
        if (planar_[l] != k_sampled) places_.emplace_back(*visibility_, planar_[l], lights.lights()[l]);
}

std::unique_ptr<SizedVisibility::Worker> ProvenVisibility::make_worker()
{
    return std::make_unique<Work>(*this);
}

FrameCounters::Shadow ProvenVisibility::end_frame(std::span<const std::unique_ptr<Worker>> workers, Tasks& tasks)
{
    counters_ = {};
    std::vector<std::unique_ptr<Worker>> sampled;
    for (const auto& worker : workers) {
        Work& work = static_cast<Work&>(*worker);
        counters_.add(work.counters());
        sampled.push_back(std::move(work.sampled()));
    }
    FrameCounters::Shadow sum = sampled_.end_frame(sampled, tasks);
    sum.rays += counters_.rays + counters_.dynamic_rays;
    sum.rays_dynamic_only += counters_.dynamic_rays;
    return sum;
}

area_light::AreaCounters ProvenVisibility::parts() const
{
    return visibility_ ? visibility_->parts() : area_light::AreaCounters{};
}

std::size_t ProvenVisibility::bytes() const
{
    std::size_t bytes = visibility_ ? visibility_->bytes() : 0;
    for (const area_light::CellPlaces& places : places_)
        for (const auto& of : places.of) bytes += of.size() * (sizeof(scene::SizedPlace) + sizeof(std::uint16_t));
    return bytes;
}

}   // namespace gnomon::trace
