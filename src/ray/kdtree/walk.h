// SPDX-License-Identifier: Apache-2.0
#pragma once
// Traverses one tree from the near end of a ray to its far end. Distances to planes are rounded outwards, so that no
// leaf that the ray touches is missed.

#include <algorithm>
#include <array>
#include <utility>

#include "ray/kdtree/part.h"

namespace gnomon::ray {

// Covers three roundings (difference, reciprocal, product) with room to spare.
inline constexpr float k_plane_slack = 8 * 0x1p-24f;
// The distance of a grazing hit is less exact than that of a plane: only hits nearer by this fraction end the
// traversal.
inline constexpr float k_hit_slack = 1e-5f;

struct KdRay {
    glm::vec3 origin, direction, inverse;   // inverse: 0 where the ray does not leave its plane of that axis
    float tnear, tfar;

    KdRay(const glm::vec3& from, float near_distance, const glm::vec3& along, float far_distance)
        : origin(from), direction(along), tnear(near_distance), tfar(far_distance)
    {
        for (int axis = 0; axis < 3; ++axis) {
            const float r = 1 / along[axis];
            inverse[axis] = std::isfinite(r) ? r : 0;
        }
    }
};

inline float rounded_down(float t)
{
    return t - k_plane_slack * std::abs(t);
}
inline float rounded_up(float t)
{
    return t + k_plane_slack * std::abs(t);
}

/// Clips the interval [low, high] of a ray to a box. @return whether it is not empty
inline bool cut(const KdRay& ray, const Box3& box, float& low, float& high)
{
    for (int axis = 0; axis < 3; ++axis) {
        if (ray.inverse[axis] == 0) {
            if (ray.origin[axis] < box.low[axis] || ray.origin[axis] > box.high[axis]) return false;
            continue;
        }
        float a = (box.low[axis] - ray.origin[axis]) * ray.inverse[axis];
        float b = (box.high[axis] - ray.origin[axis]) * ray.inverse[axis];
        if (a > b) std::swap(a, b);
        low = std::max(low, rounded_down(a));   // a NaN (infinite t) changes nothing
        high = std::min(high, rounded_up(b));
    }
    return low <= high;
}

/// Calls leaf(node) for the leaves that a ray touches, nearest first, until it returns true.
/// @param limit  end of the traversal; the leaf function may reduce it
/// @param only   0, or bits of KdPart::holds: traversal stops at nodes without all of them [Nah 2009, 2.4]
/// @return whether a leaf function returned true
template <class Leaf>
bool walk(const KdPart& part, const KdRay& ray, const float& limit, KdCounts& counts, std::uint8_t only, Leaf&& leaf)
{
    struct Later {
        std::uint32_t node;
        float low, high;
    };
    std::array<Later, k_deepest + 1> stack;
    int waiting = 0;
    if (part.nodes.empty()) return false;
    float low = rounded_down(ray.tnear), high = rounded_up(limit);
    if (!cut(ray, part.box, low, high)) {
        ++counts.nodes;
        return false;
    }
    std::uint32_t at = 0;
    for (;;) {
        const KdNode& node = part.nodes[at];
        ++counts.nodes;
        const bool entered = only == 0 || (part.holds[at] & only) == only;
        if (entered && node.axis != KdNode::k_leaf) {
            const float origin = ray.origin[static_cast<int>(node.axis)];
            const float inverse = ray.inverse[static_cast<int>(node.axis)];
            const float distance = node.split - origin;
            const bool from_below = distance > 0 || (distance == 0 && inverse > 0);
            const std::uint32_t near = from_below ? node.first : node.first + 1;
            const std::uint32_t far = from_below ? node.first + 1 : node.first;
            if (inverse == 0) {   // parallel: every triangle that the ray touches is, enlarged, on either side
                at = near;
                continue;
            }
            const float t = distance * inverse;
            const float t_low = rounded_down(t), t_high = rounded_up(t);
            if (t_high < 0 || t_low > high) {
                at = near;
            } else if (t_high < low) {
                at = far;
            } else {
                stack[static_cast<std::size_t>(waiting++)] = {far, std::max(low, t_low), high};
                high = std::min(high, t_high);
                at = near;
            }
            continue;
        }
        if (entered && leaf(node)) return true;
        do {
            if (waiting == 0) return false;
            const Later& next = stack[static_cast<std::size_t>(--waiting)];
            at = next.node, low = next.low, high = next.high;
        } while (low > limit);
    }
}

}   // namespace gnomon::ray
