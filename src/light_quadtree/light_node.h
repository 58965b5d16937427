// SPDX-License-Identifier: Apache-2.0
#pragma once
// A node of a light map's pyramid [Ki and Oh 2007, 3.1]: a pixel light, or what four nodes below have in common.
//
// A node is a function of the four below it, in one fixed order; so a tree repaired upward equals a tree made anew.
// Means are over the texels that hit something. Mean normals are not normalised: where the normals below differ they
// are shorter than 1, and the light that leaves along them is less by as much.

#include <cmath>
#include <cstdint>

#include "base/math.h"

namespace gnomon::light_quadtree {

/// Twelve words without padding: compared in bits, and read lane by lane.
struct LightNode {
    glm::vec3 position{0};       // mean
    glm::vec3 normal{0};         // mean
    float depth = 0;             // mean, as a fraction of the view's depth range
    float area = 0;              // of the surfaces, square units
    glm::vec3 flux{0};           // sum: radiant exitance times area
    std::uint32_t members = 0;   // texels that hit something
};
static_assert(sizeof(LightNode) == 48);

struct Validity {
    float depth_threshold = 0.05f;   // a child's depth may differ from the mean by less than this
    float normal_threshold = 0.9f;   // its normal's dot product with the mean one must be above this
};

inline LightNode mean_of(const LightNode (&four)[4])
{
    LightNode node;
    for (const LightNode& child : four) {
        const auto members = static_cast<float>(child.members);
        node.position += members * child.position;
        node.normal += members * child.normal;
        node.depth += members * child.depth;
        node.area += child.area;
        node.flux += child.flux;
        node.members += child.members;
    }
    if (node.members == 0) return node;
    const float share = 1 / static_cast<float>(node.members);
    node.position *= share;
    node.normal *= share;
    node.depth *= share;
    return node;
}

/// Whether the four are alike, so that their mean may stand for them. Nothing at all is like nothing; where only some
/// of the four hit something they are not alike.
inline bool is_valid(const LightNode (&four)[4], const LightNode& mean, const Validity& validity)
{
    if (mean.members == 0) return true;
    for (const LightNode& child : four) {
        if (child.members == 0) return false;
        if (!(std::abs(child.depth - mean.depth) < validity.depth_threshold)) return false;
        if (!(glm::dot(child.normal, mean.normal) > validity.normal_threshold)) return false;
    }
    return true;
}

}   // namespace gnomon::light_quadtree
