// SPDX-License-Identifier: Apache-2.0
#pragma once
// The light of patches that are so near to a cache point that one place and a kernel cannot represent them: the foot of
// a wall is lit by patches of that wall that are wider than they are far away.
//
// A patch is near if its radius exceeds half of its distance. It then takes no part in the point's cut. Rays with a
// cosine distribution around the point's normal, the same for all points of a plane, find how much of the hemisphere
// near patches cover and what hides them. A patch becomes a node of the point as before, with a weight that rays
// found, so that light that dynamic objects occlude is corrected in the same way. Where the node's place lies too near
// the horizon for that, the light is added as it arrives.
//
// Cost: k_rays closest hits for a new point that has a near patch. Points on dynamic objects have none.

#include <vector>

#include "irradiance_cache/cache_frame.h"
#include "irradiance_cache/points/cache_point.h"
#include "patches/patch_rays.h"

namespace gnomon::irradiance_cache {

/// Holds a thread's scratch memory.
class NearPatches {
 public:
    static constexpr std::size_t k_rays = 64;   // of a point

    NearPatches();
    void clear();
    std::size_t rays() const { return rays_.size(); }

    /// Takes the near patches out of one node of a point's cut.
    /// @param keep  called with the nodes that are left, instead of this one
    /// @return      whether there is any near patch
    template <class Keep>
    bool take(const LightTree& tree, const glm::vec3& origin, NodeId node, float weight, const Keep& keep);
    /// Queues the rays of a point. @return  the number of the first
    std::size_t add(const CachePoint& point);

    /// Traces all rays.
    void trace(const CacheFrame& frame);
    /// Finds the light of a point's near patches.
    /// @param first  that add() returned
    /// @param seen   appended to: nodes with their weights
    /// @param rest   out: the static light that no node stands for, by colour, as in CachePoint
    void find(const CacheFrame& frame, const CachePoint& point, std::size_t first, std::vector<SeenNode>& seen,
              glm::vec3 (&rest)[3]);

 private:
    static constexpr float k_width = 0.5f;   // radius over distance from which on a patch is near
    struct Met {
        patches::PatchId patch;
        float share;           // of the rays
        glm::vec3 direction;   // sum over rays, each as long as its share over its cosine
    };
    static bool is_wide(const LightTree& tree, const glm::vec3& origin, NodeId node)
    {
        const VirtualLightQuad& quad = tree.quad(node / 4);
        const std::size_t k = node % 4;
        const glm::vec3 to = glm::vec3(quad.x[k], quad.y[k], quad.z[k]) - origin;
        return quad.radius[k] * quad.radius[k] > k_width * k_width * glm::dot(to, to);
    }

    std::vector<glm::vec3> directions_;
    patches::PatchRays rays_;
    std::vector<glm::vec3> passes_;   // by ray, where anything thins light
    std::vector<NodeId> stack_;
    std::vector<Met> met_;
};

template <class Keep>
bool NearPatches::take(const LightTree& tree, const glm::vec3& origin, NodeId node, float weight, const Keep& keep)
{
    // A node that is not wide has no wide part. Parts of one that is have its weight: it brings little light, or the
    // cut would have refined it.
    bool any = false;
    stack_.assign(1, node);
    while (!stack_.empty()) {
        const NodeId part = stack_.back();
        stack_.pop_back();
        if (!(tree.quad(part / 4).flux[part % 4] > 0)) continue;
        if (!is_wide(tree, origin, part)) {
            keep(part, weight);
            continue;
        }
        const NodeId below = tree.children(part);
        if (below == scene::none)
            any = true;
        else
            for (NodeId k = 4; k-- > 0;) stack_.push_back(4 * below + k);
    }
    return any;
}

}   // namespace gnomon::irradiance_cache
