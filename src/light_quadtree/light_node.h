// SPDX-License-Identifier: Apache-2.0
#pragma once
// A node of a light map's pyramid [Ki and Oh 2007, 3.1]: a pixel light, or the combination of four nodes below.
//
// A node is a function of the four nodes below it, evaluated in a fixed order, so a tree that is updated upwards equals
// a new one. Means are over the texels that hit a surface. Mean normals are not normalised: where the normals below
// differ they are shorter than 1, which reduces the light that leaves along them accordingly.

#include <cmath>
#include <cstdint>

#include "base/math.h"

namespace gnomon::light_quadtree {

/// Twelve words without padding: compared bitwise, and loaded lane by lane.
struct LightNode {
    glm::vec3 position{0};       // mean
    glm::vec3 normal{0};         // mean
    float depth = 0;             // mean, as a fraction of the view's depth range
    float area = 0;              // of the surfaces, square units
    glm::vec3 flux{0};           // sum: radiant exitance times area
    std::uint32_t members = 0;   // texels that hit a surface
};
static_assert(sizeof(LightNode) == 48);

struct Validity {
    float depth_threshold = 0.05f;   // the depth of a child may differ from the mean by less than this
    float normal_threshold = 0.9f;   // the dot product of its normal with the mean must exceed this
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
    const float scale = 1 / static_cast<float>(node.members);
    node.position *= scale;
    node.normal *= scale;
    node.depth *= scale;
    return node;
}

/// Whether the four children are similar, so that their mean may represent them. Four empty children are
/// similar; four of which only some hit a surface are not.
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
