// SPDX-License-Identifier: Apache-2.0
#pragma once
// The light of patches that are so near to a cache point that one place and a kernel cannot represent them: the foot of
// a wall is lit by patches of that wall that are wider than they are far away.
//
// A patch of a point's cut is near if its radius exceeds half of its distance. It then takes no part in the cut. Rays
// with a cosine distribution around the point's normal, the same for all points of a plane, find how much of the
// hemisphere near patches cover and what hides them. A patch becomes a node of the point as before, with a weight that
// rays found, so that light that dynamic objects occlude is corrected in the same way. Where the node's place lies too
// near the horizon for that, the light is added as it arrives.
//
// Points on dynamic objects are evaluated again whenever anything moves. Their near patches are seen past dynamic
// objects too, with their present light, and no node stands for them: the place of a patch that the object covers in
// part may lie under it.
//
// Cost: k_rays closest hits for a new point that has a near patch.

#include <vector>

#include "irradiance_cache/cache_frame.h"
#include "irradiance_cache/points/cache_point.h"
#include "patches/patch_rays.h"

namespace gnomon::irradiance_cache {

/// How much of a point's light comes from surfaces close to it.
struct CloseLight {
    float irradiance = 0;    // luminance, from less far than some distance
    float form_factor = 0;   // of the surfaces that it comes from
    float farther = 0;       // luminance of all other irradiance
    float sky = 0;           // of this, the sky's
    float beyond = 0;        // of this, what comes from surfaces that are as bright as those that are close

    CloseLight& operator+=(const CloseLight& other)
    {
        irradiance += other.irradiance, form_factor += other.form_factor;
        farther += other.farther, sky += other.sky, beyond += other.beyond;
        return *this;
    }
};

/// Light that no node stands for; see CachePoint.
struct RestOfLight {
    glm::vec3 light[3] = {};   // by colour
    glm::vec3 facing{0};
};

/// Holds a thread's scratch memory.
class NearPatches {
 public:
    static constexpr std::size_t k_rays = 64;   // of a point
    static constexpr std::size_t k_none = ~std::size_t{0};

    /// @param moving  for points on dynamic objects
    explicit NearPatches(bool moving = false);
    void clear();
    std::size_t rays() const { return rays_.size(); }

    /// Takes near patches out of a point's cut, and queues the point's rays.
    /// @param nodes, weights  of the cut, as cut_tree() returns them; out: those that are left
    /// @return  the number of the point; k_none if near patches bring next to nothing, and the cut stays
    /// @param nearest  out: how far the nearest of them is, at least; infinite if there is none
    std::size_t divide(const LightTree& tree, const CachePoint& point, std::vector<NodeId>& nodes,
                       std::vector<float>& weights, float& nearest);

    /// Traces all rays.
    void trace(const CacheFrame& frame);
    /// Finds the light of a point's near patches.
    /// @param number  that divide() returned
    /// @param seen   appended to: nodes with their weights
    /// @param rest   out: the static light that no node stands for, and what gives it
    /// @param reach  scene units
    /// @return  how much of the light comes from less far than `reach`
    CloseLight find(const CacheFrame& frame, const CachePoint& point, std::size_t number, std::vector<SeenNode>& seen,
                    RestOfLight& rest, float reach);

 private:
    void add_missed(const LightTree& tree, const glm::vec3& origin, std::span<const NodeId> cut, float& near,
                    float& all, float& reach);

    static constexpr float k_width =
        1 / PatchLight::k_uneven_reach;       // radius over distance from which on a patch is near
    static constexpr float k_least = 0.03f;   // fraction of a point's light, visibility ignored, that they must bring
    struct Met {
        patches::PatchId patch;
        float share;           // of the rays
        float close;           // of the rays: those that end within `reach`
        glm::vec3 direction;   // sum over rays, each as long as its share over its cosine
    };
    bool moving_;
    std::vector<glm::vec3> directions_;
    patches::PatchRays rays_;
    std::vector<glm::vec3> passes_;   // by ray, where anything thins light
    std::vector<NodeId> nodes_;       // near patches of all points
    std::vector<std::size_t> ends_;   // by point: where its near patches end
    std::vector<Met> met_;
    MarkedNodes held_;                     // of one point: nodes of its cut over patches
    std::vector<NodeId> uneven_, stack_;   // likewise
};

}   // namespace gnomon::irradiance_cache
