// SPDX-License-Identifier: Apache-2.0
#include "shadow_culling/certified/judge.h"

#include <algorithm>
#include <cstring>

#include "base/check.h"
#include "ray/origin.h"

namespace gnomon::shadow_culling {

namespace {

// Occluders between part and light are tried largest first. More tries rarely find one that closes the shaft.
constexpr std::size_t k_occluders_found = 12, k_occluders_tried = 3;

double area_of(const StaticTriangle& t)
{
    return glm::length(glm::cross(glm::dvec3(t.p[1]) - glm::dvec3(t.p[0]), glm::dvec3(t.p[2]) - glm::dvec3(t.p[0])));
}

}   // namespace

Judge::Judge(const scene::SceneState& state, const StaticTriangles& triangles, ShadowMemory& memory,
             const std::vector<char>& light_on, const CertifiedOptions& options)
    : state_(state), triangles_(triangles), memory_(memory), light_on_(light_on), options_(options)
{
}

void Judge::judge(RecordId record)
{
    const ShadowMemory::Evidence evidence = memory_.take_evidence(record);
    if (!evidence) return;
    record_ = record;
    level_ = memory_.level(record);
    triangle_ = record / 2;
    rim_ = memory_.rim(record);
    const StaticTriangle& t = triangles_[triangle_];
    for (int c = 0; c < 3; ++c) corner_[c] = glm::dvec3(t.p[c]);
    const glm::dvec3 cross = glm::cross(corner_[1] - corner_[0], corner_[2] - corner_[0]);
    const double length = glm::length(cross);
    normal_ = length > 0 ? cross / length : glm::dvec3(0);
    if (record & 1) normal_ = -normal_;
    lift_ = ray::origin_lift(t.p);

    for (int g = 0; g < memory_.groups(); ++g) {
        gather_evidence(evidence.get() + (static_cast<std::size_t>(g) << (2 * level_)));
        const int lights = std::min(k_lights_per_group, static_cast<int>(light_on_.size()) - g * k_lights_per_group);
        for (int l = 0; l < lights; ++l) {
            const int light = g * k_lights_per_group + l;
            if (light_on_[static_cast<std::size_t>(light)] && ((seen_[0] >> (2 * l)) & 3)) judge_part({}, 0, light);
        }
    }
}

// Combines the evidence of the finest parts up the pyramid.
void Judge::gather_evidence(const std::uint8_t* finest)
{
    seen_.assign(pyramid_size(level_), 0);
    std::memcpy(seen_.data() + pyramid_offset(level_), finest, std::size_t{1} << (2 * level_));
    for (std::uint32_t k = level_; k > 0; --k)
        for (std::uint32_t i = 0; i < 1u << (2 * k); ++i) {
            const std::uint8_t saw = seen_[pyramid_offset(k) + i];
            if (saw) seen_[pyramid_offset(k - 1) + micro_index(parent_of(micro_at(i, k)), k - 1)] |= saw;
        }
}

void Judge::judge_part(const MicroTriangle& part, std::uint32_t at_level, int light)
{
    const std::uint32_t in_pyramid = pyramid_offset(at_level) + micro_index(part, at_level);
    const int shift = 2 * (light % k_lights_per_group);
    const std::uint8_t saw = (seen_[in_pyramid] >> shift) & 3;
    if (saw == 0) return;
    std::uint8_t* const states = memory_.states(light / k_lights_per_group);
    const std::uint8_t byte = states[memory_.address(record_, part, at_level)];
    auto state = static_cast<ShadowState>((byte >> shift) & 3);
    if (state == ShadowState::none || state == ShadowState::full) return;

    if (state == ShadowState::unknown) {
        if (interruption_ && interruption_->requested()) allowed_ = 0;
        if (allowed_ == 0) return;
        state = saw == (k_saw_free | k_saw_occluded) ? ShadowState::partial
                                                     : certify(part, at_level, light, saw == k_saw_occluded);
        if (state != ShadowState::partial) {
            fill_down(part, at_level, light, state);
            return;
        }
        // If there is no memory for its quarters, the part stays unknown, and its rays are traced again.
        if (at_level < level_ && !memory_.open(record_, part, at_level)) return;
        states[memory_.address(record_, part, at_level)] |=
            static_cast<std::uint8_t>(static_cast<unsigned>(ShadowState::partial) << shift);
    }
    if (at_level == level_) return;
    MicroTriangle child[4];
    children_of(part, child);
    for (const MicroTriangle& c : child) judge_part(c, at_level + 1, light);
}

ShadowState Judge::certify(const MicroTriangle& part, std::uint32_t at_level, int light, bool saw_occluded)
{
    const scene::Light& source = state_.scene().lights[static_cast<std::size_t>(light)];
    const scene::LightState& at = state_.light(static_cast<scene::LightId>(light));
    visibility::LightPoint to;
    to.directional = source.type == scene::LightType::directional;
    to.place = to.directional ? glm::normalize(-glm::dvec3(at.direction)) : glm::dvec3(at.position);

    // No point needs a light behind the triangle's plane, and none is certified for a light near the plane. (All points
    // of a triangle agree whether they face a directional light.)
    const CertificateOptions& rules = options_.certificates;
    if (!to.directional && !(glm::dot(normal_, to.place - corner_[0]) > rules.graze_lifts * lift_))
        return ShadowState::partial;

    glm::dvec2 uv[3];
    corners_of(part, at_level, uv);
    for (glm::dvec2& corner : uv) corner = rim_.outer(corner);
    glm::dvec3 piece[3];
    for (int c = 0; c < 3; ++c)
        piece[c] = corner_[0] + uv[c].x * (corner_[1] - corner_[0]) + uv[c].y * (corner_[2] - corner_[0]);
    const visibility::Shaft shaft(piece, normal_, to, lift_, rules.shaft);

    ++counters_.certificates;
    --allowed_;
    bool holds = false;
    if (!saw_occluded) {
        holds = certify_none(triangles_, shaft, rules);
    } else if (shaft.valid()) {
        // Find the occluders of the part's centroid, and try the largest first.
        const glm::dvec3 origin = shaft.centroid() + lift_ * normal_;
        const double reach = to.directional ? 4.0 * static_cast<double>(triangles_.bounds().diagonal()) : 1.0;
        triangles_.along(origin, to.directional ? reach * to.place : to.place - origin, k_occluders_found, occluders_);
        std::sort(occluders_.begin(), occluders_.end(), [&](TriangleId a, TriangleId b) {
            const double area_a = area_of(triangles_[a]), area_b = area_of(triangles_[b]);
            return area_a != area_b ? area_a > area_b : a < b;
        });
        for (std::size_t i = 0; i < std::min(occluders_.size(), k_occluders_tried) && !holds; ++i)
            holds = certify_full(triangles_, shaft, occluders_[i], rules);
    }
    if (!holds) return ShadowState::partial;
    ++counters_.certified;
    return saw_occluded ? ShadowState::full : ShadowState::none;
}

// Copies a decided state to all finer levels that are stored, where look-ups read.
void Judge::fill_down(const MicroTriangle& part, std::uint32_t at_level, int light, ShadowState state)
{
    const int shift = 2 * (light % k_lights_per_group);
    std::uint8_t& byte = memory_.states(light / k_lights_per_group)[memory_.address(record_, part, at_level)];
    byte = static_cast<std::uint8_t>((byte & ~(3u << shift)) | (static_cast<unsigned>(state) << shift));
    if (!memory_.is_open(record_, part, at_level)) return;
    MicroTriangle child[4];
    children_of(part, child);
    for (const MicroTriangle& c : child) fill_down(c, at_level + 1, light, state);
}

}   // namespace gnomon::shadow_culling
