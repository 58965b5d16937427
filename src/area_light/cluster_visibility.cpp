// SPDX-License-Identifier: Apache-2.0
#include "area_light/cluster_visibility.h"

#include <algorithm>
#include <utility>

namespace gnomon::area_light {

namespace {

bool same(const Cluster& a, const Cluster& b)
{
    return a.two_sided == b.two_sided &&
           std::ranges::equal(a.faces, b.faces, [](const auto& x, const auto& y) { return same_bits(x, y); });
}

}   // namespace

Cluster cluster_of(const scene::SizedLight& light)
{
    Cluster cluster;
    for (const scene::SizedFace& face : light.faces) {
        cluster.faces.push_back({face.corner, face.corners, face.normal});
        cluster.two_sided = cluster.two_sided || face.two_sided;
    }
    return cluster;
}

void ClusterVisibility::set(const AreaVisibility& occluders, std::vector<Cluster> clusters)
{
    if (occluders_ != &occluders || version_ != occluders.triangles_version()) known_.clear();
    occluders_ = &occluders, version_ = occluders.triangles_version();
    std::vector<Known> before = std::exchange(known_, {});
    for (Cluster& cluster : clusters) {
        const auto at =
            std::ranges::find_if(before, [&](const Known& old) { return old.shadows && same(old.cluster, cluster); });
        Known& known = known_.emplace_back(std::move(cluster));
        known.shadows = at != before.end()
                            ? std::move(at->shadows)
                            : std::make_unique<ClusterShadows>(occluders.triangles(), known.cluster, options_);
    }
}

void ClusterVisibility::follow()
{
    // Keep what is known, unless it has become too much.
    if (known_.empty() || (version_ == occluders_->triangles_version() && bytes() <= options_.most_bytes)) return;
    version_ = occluders_->triangles_version();
    for (Known& known : known_)
        known.shadows = std::make_unique<ClusterShadows>(occluders_->triangles(), known.cluster, options_);
}

void ClusterVisibility::find(Scratch& scratch, std::span<const visibility::ShadowPoint> points,
                             std::span<const std::uint32_t> asked, std::size_t cluster) const
{
    ClusterShadows& shadows = *known_[cluster].shadows;
    const visibility::StaticTriangles& triangles = occluders_->triangles();
    scratch.answer.assign(asked.size(), Answer::unknown);
    scratch.state.assign(asked.size(), PartState::open);
    scratch.last = {};

    // Find the dynamic objects that may lie between any of the points and the cluster.
    Box3 box;
    for (const std::uint32_t p : asked) box.add(points[p].origin);
    scratch.boxes.clear();
    if (!box.empty()) occluders_->dynamic().select(box, shadows.box(), scratch.boxes);
    const auto meets_dynamic = [&](const visibility::ShadowPoint& p) {
        return std::ranges::any_of(scratch.boxes, [&](std::uint32_t index) {
            return visibility::may_shadow(occluders_->dynamic().box(index), Box3{p.origin, p.origin}, shadows.box());
        });
    };

    for (std::size_t k = 0; k < asked.size(); ++k) {
        const visibility::ShadowPoint& p = points[asked[k]];
        const visibility::TriangleId first =
            p.object == scene::none ? visibility::no_triangle : triangles.first_of(p.object);
        if (first == visibility::no_triangle) continue;
        const PartState state = shadows.part_at(first + p.triangle, p.front, p.u, p.v, scratch.last).state;
        ++scratch.points[static_cast<std::size_t>(state)];
        scratch.state[k] = state;
        if (state == PartState::unlit || state == PartState::dark)
            scratch.answer[k] = Answer::dark;
        else if (state == PartState::lit)
            scratch.answer[k] = meets_dynamic(p) ? Answer::lit_at_rest : Answer::lit;
    }
}

AreaCounters ClusterVisibility::parts() const
{
    AreaCounters sum;
    for (const Known& known : known_) sum.add(known.shadows->counters());
    return sum;
}

std::size_t ClusterVisibility::bytes() const
{
    std::size_t bytes = 0;
    for (const Known& known : known_)
        bytes += sizeof known + known.shadows->bytes() + known.cluster.faces.size() * sizeof(LightPolygon);
    return bytes;
}

}   // namespace gnomon::area_light
