// SPDX-License-Identifier: Apache-2.0
#include "irradiance_cache/points/near_patches.h"

#include <algorithm>

#include "irradiance_cache/near_field/near_light.h"

namespace gnomon::irradiance_cache {

namespace {

constexpr float k_least_cosine = 0.1f;    // as of nodes: bounds light at grazing angles for other normals
constexpr float k_clear_cosine = 0.25f;   // of a node's place, from which on it can stand for its patch

}   // namespace

NearPatches::NearPatches() : directions_(cosine_directions(static_cast<int>(k_rays))) {}

void NearPatches::clear()
{
    rays_.clear();
}

std::size_t NearPatches::add(const CachePoint& point)
{
    const std::size_t first = rays_.size();
    glm::vec3 t, b;
    make_basis(point.normal, t, b);
    for (const glm::vec3& d : directions_) rays_.push(point.origin(), d.x * t + d.y * b + d.z * point.normal);
    return first;
}

void NearPatches::trace(const CacheFrame& frame)
{
    if (rays_.size() == 0) return;
    rays_.trace(frame.state->scene(), *frame.rays);
    passes_.resize(frame.rays->thins_light() ? rays_.size() : 0);
    if (!passes_.empty()) rays_.find_passing(*frame.rays, passes_.data());
}

void NearPatches::find(const CacheFrame& frame, const CachePoint& point, std::size_t first,
                       std::vector<SeenNode>& seen, glm::vec3 (&rest)[3])
{
    const LightTree& tree = frame.lights;
    const patches::SurfacePatches& patches = tree.patch_light()->patches();
    const glm::vec3 origin = point.origin();
    // Sum the rays by patch, in the order in which patches are met first.
    met_.clear();
    for (std::size_t r = first; r < first + k_rays; ++r) {
        const glm::vec3 direction = rays_.direction(r);
        if (rays_.leaves(r) || !(glm::dot(direction, point.horizon) > 0)) continue;
        const patches::PatchId patch = rays_.patch(patches, *frame.rays, r);
        if (patch == patches::k_no_patch || !is_wide(tree, origin, tree.node_of(patch))) continue;
        auto met = std::ranges::find(met_, patch, &Met::patch);
        if (met == met_.end()) met = met_.insert(met_.end(), {patch, 0, glm::vec3(0)});
        const float share = (passes_.empty() ? 1 : luminance(passes_[r])) / static_cast<float>(k_rays);
        met->share += share;
        met->direction += direction * (share / std::max(glm::dot(direction, point.normal), k_least_cosine));
    }
    std::fill(rest, rest + 3, glm::vec3(0));
    for (const Met& met : met_) {
        const NodeId node = tree.node_of(met.patch);
        const glm::vec3 flux = tree.static_flux().at(node);
        if (flux == glm::vec3(0) || !(met.share > 0)) continue;
        const float inverse_area = 1 / patches.patches()[met.patch].area;
        const glm::vec3 to = tree.samples().at(node) - origin;
        const float cosine = glm::dot(to, point.normal) / glm::length(to);
        if (cosine > k_clear_cosine && glm::dot(to, point.horizon) > 0) {
            seen.push_back(pack_seen(node, met.share * inverse_area / cosine));
            continue;
        }
        for (int colour = 0; colour < 3; ++colour) rest[colour] += (flux[colour] * inverse_area) * met.direction;
    }
}

}   // namespace gnomon::irradiance_cache
