// SPDX-License-Identifier: Apache-2.0
#include "trace/proven_visibility.h"

#include <algorithm>

#include "trace/place_rays.h"

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
    explicit Work(ProvenVisibility& owner) : owner_(owner), rays_(*owner.rays_) {}

    void find_visible(const PointBatch& batch, std::uint32_t light, std::span<const std::uint32_t> points,
                      SizedVisible& result) override
    {
        const std::uint32_t planar = owner_.planar_[light];
        if (planar == k_none) return find_of_cluster(batch, light, points, result);
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
    const PlaceRays& rays() const { return rays_; }

 private:
    // Answers for a cluster: by what is proven, and by rays elsewhere.
    void find_of_cluster(const PointBatch& batch, std::uint32_t light, std::span<const std::uint32_t> points,
                         SizedVisible& result)
    {
        using Answer = area_light::ClusterVisibility::Answer;
        result.reset(points.size());
        all_.clear(), dynamic_.clear();
        const std::uint32_t cluster = owner_.cluster_[light];
        const bool moves = cluster == k_none;
        if (!moves) owner_.clusters_.find(cluster_scratch_, batch.shadow_points, points, cluster);
        for (std::uint32_t k = 0; k < points.size(); ++k) {
            const Answer answer = moves ? Answer::unknown : cluster_scratch_.answer[k];
            const bool receiver_moves = owner_.state_->is_dynamic(batch.shadow_points[points[k]].object);
            result.state[k] = moves || receiver_moves ? StateMark::moving : mark_of(cluster_scratch_.state[k]);
            if (answer == Answer::lit) result.answer[k] = SizedVisible::Answer::lit;
            if (answer == Answer::lit_at_rest) dynamic_.push_back(k);
            if (answer == Answer::unknown) all_.push_back(k);
        }
        const scene::SizedLight& of = owner_.lights_->lights()[light];
        rays_.trace(batch, of, points, all_, ray::Against::everything, result);
        rays_.trace(batch, of, points, dynamic_, ray::Against::dynamic_only, result);
    }

    ProvenVisibility& owner_;
    PlaceRays rays_;
    AreaVisibility::Scratch scratch_;
    AreaVisibility::Answers answers_;
    area_light::ClusterVisibility::Scratch cluster_scratch_;
    std::vector<std::uint32_t> all_, dynamic_;   // asked points that rays decide
};

// Tells flat lights from clusters that rest, and from others.
void ProvenVisibility::sort_lights(const scene::SizedLights& lights)
{
    planar_lights_.clear();
    planar_.assign(lights.lights().size(), k_none);
    cluster_.assign(lights.lights().size(), k_none);
    std::uint32_t clusters = 0;
    for (std::size_t l = 0; l < lights.lights().size(); ++l) {
        const scene::SizedLight& light = lights.lights()[l];
        if (light.is_flat()) {
            planar_[l] = static_cast<std::uint32_t>(planar_lights_.size());
            planar_lights_.push_back(area_light::area_light_of(light));
        } else if (!light.dynamic) {
            cluster_[l] = clusters++;
        }
    }
}

void ProvenVisibility::begin_frame(const FrameContext& frame, const scene::SizedLights& lights)
{
    state_ = &frame.state, rays_ = &frame.rays;
    const bool first = !visibility_;
    if (first) visibility_ = std::make_unique<AreaVisibility>(frame.state, frame.rays, options_);
    const bool same_lights = !first && lights_ == &lights && version_ == lights.version();
    if (!same_lights) sort_lights(lights);
    visibility_->follow(frame.state, frame.rays, planar_lights_);
    if (same_lights) return clusters_.follow();
    std::vector<area_light::Cluster> clusters;
    for (std::size_t l = 0; l < lights.lights().size(); ++l)
        if (cluster_[l] != k_none) clusters.push_back(area_light::cluster_of(lights.lights()[l]));
    clusters_.set(*visibility_, std::move(clusters));

    // Make sample places of the cells.
    lights_ = &lights, version_ = lights.version();
    places_.clear();
    for (std::size_t l = 0; l < lights.lights().size(); ++l)
        if (planar_[l] != k_none) places_.emplace_back(*visibility_, planar_[l], lights.lights()[l]);
}

std::unique_ptr<SizedVisibility::Worker> ProvenVisibility::make_worker()
{
    return std::make_unique<Work>(*this);
}

FrameCounters::Shadow ProvenVisibility::end_frame(std::span<const std::unique_ptr<Worker>> workers, Tasks&)
{
    counters_ = {};
    FrameCounters::Shadow sum;
    for (const auto& worker : workers) {
        const Work& work = static_cast<const Work&>(*worker);
        counters_.add(work.counters());
        sum.rays += work.rays().traced();
        sum.rays_dynamic_only += work.rays().traced_dynamic_only();
    }
    sum.rays += counters_.rays + counters_.dynamic_rays;
    sum.rays_dynamic_only += counters_.dynamic_rays;
    return sum;
}

area_light::AreaCounters ProvenVisibility::parts() const
{
    area_light::AreaCounters sum = clusters_.parts();
    if (visibility_) sum.add(visibility_->parts());
    return sum;
}

std::size_t ProvenVisibility::bytes() const
{
    std::size_t bytes = clusters_.bytes() + (visibility_ ? visibility_->bytes() : 0);
    for (const area_light::CellPlaces& places : places_)
        for (const auto& of : places.of) bytes += of.size() * (sizeof(scene::SizedPlace) + sizeof(std::uint16_t));
    return bytes;
}

}   // namespace gnomon::trace
