// SPDX-License-Identifier: Apache-2.0
#pragma once
// A node of a light map's pyramid [Ki and Oh 2007, 3.1]: a pixel light, or the combination of four nodes below.
//
// A node is a function of the four nodes below it, evaluated in a fixed order, so a tree that is updated upwards equals
// a new one. Means are over the texels that hit a surface. Mean normals are not normalised: where the normals below
// differ they are shorter than 1, which reduces the light that leaves along them accordingly.

#include <algorithm>
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
    /// Fraction of the thresholds around them within which a node is valid in part. It then shares the light with its
    /// children, so that light does not change abruptly when something moves. 0: valid or not, as published.
    float margin = 0;
};

/// A node's share of the light of its part of the map, in steps of 1 / k_whole_share; its children have the rest.
using Share = std::uint8_t;
inline constexpr Share k_whole_share = 255;

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

/// The share of a node: whole where it is valid, none where it is not, and between them within the margin of the
/// thresholds, where it falls in proportion to the larger of the two differences.
inline Share share_of(const LightNode (&four)[4], const LightNode& mean, const Validity& validity)
{
    if (!(validity.margin > 0)) return is_valid(four, mean, validity) ? k_whole_share : Share{0};
    constexpr float k_least = 1e-20f;   // a threshold of 0
    if (mean.members == 0) return k_whole_share;
    float most = 0;   // difference, relative to its threshold
    for (const LightNode& child : four) {
        if (child.members == 0) return 0;
        most = std::max(most, std::abs(child.depth - mean.depth) / std::max(validity.depth_threshold, k_least));
        most = std::max(most,
                        (1 - glm::dot(child.normal, mean.normal)) / std::max(1 - validity.normal_threshold, k_least));
    }
    const float share = std::min(1.0f, std::max(0.0f, (1 + validity.margin - most) / (2 * validity.margin)));
    return static_cast<Share>(share * static_cast<float>(k_whole_share) + 0.5f);
}

/// The part of a node's light that is left to its children.
inline float left_by(Share share)
{
    return static_cast<float>(k_whole_share - share) / static_cast<float>(k_whole_share);
}
inline float taken_by(Share share)
{
    return static_cast<float>(share) / static_cast<float>(k_whole_share);
}

}   // namespace gnomon::light_quadtree
