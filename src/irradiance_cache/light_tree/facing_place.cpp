// SPDX-License-Identifier: Apache-2.0
#include "irradiance_cache/light_tree/facing_place.h"

#include <algorithm>
#include <cmath>

namespace gnomon::irradiance_cache {

namespace {

glm::vec3 normal_of(const LightTree& tree, NodeId node)
{
    const VirtualLightQuad& quad = tree.quad(node / 4);
    return {quad.nx[node % 4], quad.ny[node % 4], quad.nz[node % 4]};
}

// Approximately the most light that a node may bring if none of it is hidden, without the distance's square.
float most_light(const LightTree& tree, NodeId node, const FacingPoint& point)
{
    const VirtualLightQuad& quad = tree.quad(node / 4);
    const NodeId lane = node % 4;
    const glm::vec3 to = glm::vec3(quad.x[lane], quad.y[lane], quad.z[lane]) - point.origin;
    const float distance = glm::length(to);
    if (!(distance > 0)) return 0;
    const glm::vec3 normal = normal_of(tree, node);
    const float spread = std::sqrt(std::max(1 - glm::dot(normal, normal), 0.0f));
    const float source = spread - glm::dot(normal, to) / distance;
    const float receiver = (glm::dot(to, point.normal) + quad.radius[lane]) / distance;
    return quad.flux[lane] * std::max(source, 0.0f) * std::clamp(receiver, 0.0f, 1.0f);
}

}   // namespace

glm::vec3 facing_place(const LightTree& tree, NodeId node, const FacingPoint& point)
{
    constexpr float k_alike = 0.99f;   // squared length of a mean normal from which on all surfaces face alike
    const glm::vec3 sample = tree.samples().at(node);
    if (tree.children(node) == scene::none) return sample;
    if (const glm::vec3 mean = normal_of(tree, node); glm::dot(mean, mean) > k_alike) return sample;
    const auto faces = [&](NodeId leaf, const glm::vec3& place) {
        return glm::dot(normal_of(tree, leaf), point.origin - place) > 0;
    };
    if (faces(tree.samples().leaves[node], sample)) return sample;
    // Descend to the children that bring most light.
    NodeId leaf = node;
    while (tree.children(leaf) != scene::none) {
        const NodeId first = 4 * tree.children(leaf);
        float most = -1;
        for (NodeId child = first; child < first + 4; ++child) {
            if (!(tree.quad(first / 4).flux[child - first] > 0)) continue;
            const float light = most_light(tree, child, point);
            if (light > most) most = light, leaf = child;
        }
        if (most < 0) return sample;
    }
    const glm::vec3 place = tree.samples().at(leaf), to = place - point.origin;
    const bool above = glm::dot(to, point.normal) > 0 && glm::dot(to, point.horizon) > 0;
    return above && faces(leaf, place) ? place : sample;
}

}   // namespace gnomon::irradiance_cache
