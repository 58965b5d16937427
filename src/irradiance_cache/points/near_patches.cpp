// SPDX-License-Identifier: Apache-2.0
#include "irradiance_cache/points/near_patches.h"

#include <algorithm>

#include "irradiance_cache/near_field/near_light.h"

namespace gnomon::irradiance_cache {

namespace {

constexpr float k_least_cosine = 0.1f;   // as of nodes: bounds light at grazing angles for other normals
constexpr float k_tiny = 1e-30f;
constexpr float k_clear_cosine = 0.25f;   // of a node's place, from which on it can stand for its patch

}   // namespace

NearPatches::NearPatches(bool moving) : moving_(moving), directions_(cosine_directions(static_cast<int>(k_rays))) {}

void NearPatches::clear()
{
    rays_.clear(), nodes_.clear(), ends_.clear();
}

std::size_t NearPatches::divide(const LightTree& tree, const CachePoint& point, std::vector<NodeId>& nodes,
                                std::vector<float>& weights, float& nearest)
{
    const glm::vec3 origin = point.origin();
    const std::size_t first = nodes_.size();
    float all = 0, near = 0, reach = 0;
    nearest = k_infinity;
    std::size_t left = 0;
    for (std::size_t k = 0; k < nodes.size(); ++k) {
        const NodeId node = nodes[k];
        const VirtualLightQuad& quad = tree.quad(node / 4);
        const std::size_t lane = node % 4;
        const float light = weights[k] * quad.flux[lane];
        all += light;
        if (node < tree.first_patch() || tree.children(node) != scene::none) continue;
        const float distance = glm::length(glm::vec3(quad.x[lane], quad.y[lane], quad.z[lane]) - origin);
        if (!(quad.radius[lane] > k_width * distance)) continue;
        nodes_.push_back(node);
        near += light;
        nearest = std::min(nearest, distance - quad.radius[lane]);
        reach = std::max(reach, distance + quad.radius[lane]);
    }
    add_missed(tree, origin, nodes, near, all, reach);
    if (!(near > k_least * all)) {
        nodes_.resize(first);
        return k_none;
    }
    // Near patches are in the order of the cut.
    for (std::size_t k = 0, n = first; k < nodes.size(); ++k) {
        if (n < nodes_.size() && nodes_[n] == nodes[k]) {
            ++n;
            continue;
        }
        nodes[left] = nodes[k], weights[left++] = weights[k];
    }
    nodes.resize(left), weights.resize(left);
    std::sort(nodes_.begin() + static_cast<std::ptrdiff_t>(first), nodes_.end());
    ends_.push_back(nodes_.size());
    glm::vec3 t, b;
    make_basis(point.normal, t, b);
    for (const glm::vec3& d : directions_) rays_.push(origin, d.x * t + d.y * b + d.z * point.normal, reach);
    return ends_.size() - 1;
}

// Adds near patches that the cut leaves out because their middle is no higher than the point: the point's own, above
// all, whose surface may be uneven.
void NearPatches::add_missed(const LightTree& tree, const glm::vec3& origin, std::span<const NodeId> cut, float& near,
                             float& all, float& reach)
{
    // Part of an uneven patch's exitance that its own light is assumed to be, by the spread of its normals.
    constexpr float k_own_light = 0.5f;
    held_.resize(tree.size());
    for (const NodeId node : cut) held_.mark(node);
    find_uneven(tree, origin, held_, uneven_, stack_);
    for (const NodeId node : cut) held_.unmark(node);
    for (const NodeId node : uneven_) {
        const VirtualLightQuad& quad = tree.quad(node / 4);
        const std::size_t lane = node % 4;
        const float distance = glm::length(glm::vec3(quad.x[lane], quad.y[lane], quad.z[lane]) - origin);
        const glm::vec3 normal(quad.nx[lane], quad.ny[lane], quad.nz[lane]);
        const float spread = 1 - glm::dot(normal, normal);
        const float light = k_own_light * spread * quad.flux[lane] / std::max(quad.area[lane], k_tiny);
        nodes_.push_back(node);
        near += light, all += light;
        reach = std::max(reach, distance + quad.radius[lane]);
    }
}

void NearPatches::trace(const CacheFrame& frame)
{
    if (rays_.size() == 0) return;
    const ray::Against against = moving_ ? ray::Against::everything : ray::Against::static_only;
    rays_.trace(frame.state->scene(), *frame.rays, against);
    passes_.resize(frame.rays->thins_light() ? rays_.size() : 0);
    if (!passes_.empty()) rays_.find_passing(*frame.rays, passes_.data(), against);
}

CloseLight NearPatches::find(const CacheFrame& frame, const CachePoint& point, std::size_t number,
                             std::vector<SeenNode>& seen, RestOfLight& rest, float reach)
{
    const LightTree& tree = frame.lights;
    const patches::SurfacePatches& patches = tree.patch_light()->patches();
    const glm::vec3 origin = point.origin();
    const std::span<const NodeId> all(nodes_);
    const std::size_t from = number == 0 ? 0 : ends_[number - 1];
    const std::span<const NodeId> near = all.subspan(from, ends_[number] - from);
    // Sum the rays by patch, in the order in which patches are met first.
    met_.clear();
    for (std::size_t r = number * k_rays; r < (number + 1) * k_rays; ++r) {
        const glm::vec3 direction = rays_.direction(r);
        if (rays_.leaves(r) || !(glm::dot(direction, point.horizon) > 0)) continue;
        const patches::PatchId patch = rays_.patch(patches, *frame.rays, r);
        if (patch == patches::k_no_patch) continue;
        // The middle of a patch that a dynamic object stands on may lie behind a side of the object: no cut holds it.
        const NodeId of_patch = tree.node_of(patch);
        const auto is_behind = [&] {
            const VirtualLightQuad& quad = tree.quad(of_patch / 4);
            const std::size_t lane = of_patch % 4;
            return !(glm::dot(glm::vec3(quad.x[lane], quad.y[lane], quad.z[lane]) - origin, point.horizon) > 0);
        };
        if (!std::ranges::binary_search(near, of_patch) && !(moving_ && is_behind())) continue;
        auto met = std::ranges::find(met_, patch, &Met::patch);
        if (met == met_.end()) met = met_.insert(met_.end(), {patch, 0, 0, glm::vec3(0)});
        const float share = (passes_.empty() ? 1 : luminance(passes_[r])) / static_cast<float>(k_rays);
        met->share += share;
        if (rays_.distance(r) < reach) met->close += share;
        met->direction += direction * (share / std::max(glm::dot(direction, point.normal), k_least_cosine));
    }
    rest = {};
    CloseLight close;
    for (const Met& met : met_) {
        const NodeId node = tree.node_of(met.patch);
        const glm::vec3 flux =
            moving_ ? tree.flux().at(node) / tree.patch_light()->open_part(met.patch) : tree.static_flux().at(node);
        if (flux == glm::vec3(0) || !(met.share > 0)) continue;
        const float inverse_area = 1 / patches.patches()[met.patch].area;
        const float exitance = inverse_area * luminance(flux);
        const float farther = (met.share - met.close) * exitance;
        close += {met.close * exitance, met.close, farther, 0, met.close > 0 ? farther : 0};
        const glm::vec3 to = tree.samples().at(node) - origin;
        const float cosine = glm::dot(to, point.normal) / glm::length(to);
        if (!moving_ && cosine > k_clear_cosine && glm::dot(to, point.horizon) > 0) {
            seen.push_back(pack_seen(node, met.share * inverse_area / cosine));
            continue;
        }
        rest.facing += met.direction;
        for (int colour = 0; colour < 3; ++colour) rest.light[colour] += (flux[colour] * inverse_area) * met.direction;
    }
    return close;
}

}   // namespace gnomon::irradiance_cache
