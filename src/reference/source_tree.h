// SPDX-License-Identifier: Apache-2.0
#pragma once
// Chooses one of many sources of light for a surface point, for the path-traced reference [Conty Estevez and Kulla
// 2018, "Importance Sampling of Many Lights with Adaptive Tree Splitting"].
//
// A binary tree over the sources: a node stores their power, the bounds of their places and of the directions in which
// they emit. From the root, one of two children is chosen in proportion to what they may send to the point: power over
// squared distance, times the cosines at the point and at the node, each the greatest that the bounds allow. So only
// sources that send nothing have a chance of 0. The reference shares this tree with no other method.
//
// Cost: n log n to build; a choice and a chance evaluate two nodes for each level.

#include <span>
#include <vector>

#include "base/math.h"

namespace gnomon::reference {

/// A source of light: a triangle or a light.
struct Source {
    Box3 bounds;
    glm::vec3 axis{0, 0, 1};   // unit: the middle of the normals,
    float spread = 0;          // which are at most this far from it: an angle in radians; pi: all directions
    float reach = 0;           // it emits up to this angle from its normals, at most a right angle
    bool two_sided = false;    // and from their opposites
    bool steady = false;       // no falloff with distance
    float power = 0;           // irradiance that it brings to what faces it at a distance of 1
};

class SourceTree {
 public:
    explicit SourceTree(std::span<const Source> sources);
    bool empty() const { return nodes_.empty(); }

    struct Choice {
        std::uint32_t source = 0;
        float chance = 0;   // 0: no source reaches the point
    };
    /// @param normal  unit
    /// @param number  in [0, 1)
    Choice choose(const glm::vec3& position, const glm::vec3& normal, double number) const;
    /// The chance with which choose() returns a source.
    float chance(std::uint32_t source, const glm::vec3& position, const glm::vec3& normal) const;
    /// About the irradiance of all sources at a point, without occlusion.
    float importance(const glm::vec3& position, const glm::vec3& normal) const
    {
        return empty() ? 0 : importance(nodes_[0], position, normal);
    }

 private:
    static constexpr std::uint32_t k_none = ~0u;
    struct Node {
        glm::vec3 middle{0}, axis{0};
        float radius = 0;
        float cos_spread = 1, sin_spread = 0, cos_reach = 0;
        float power = 0, steady_power = 0;
        bool two_sided = false;
        std::uint32_t second = k_none;   // the first child follows its parent; of a leaf: k_none
        std::uint32_t parent = k_none, source = k_none;
    };
    std::uint32_t build(std::span<const Source> sources, std::span<std::uint32_t> order, std::uint32_t parent);
    static float importance(const Node& node, const glm::vec3& position, const glm::vec3& normal);

    std::vector<Node> nodes_;
    std::vector<std::uint32_t> leaf_;   // by source; k_none: without power
};

}   // namespace gnomon::reference
