// SPDX-License-Identifier: Apache-2.0
#pragma once
// The rays of an evaluation: which nodes of its cut and which directions of the sky a new point sees past static
// geometry, and what dynamic objects change of a point's light in this frame.
//
// Both classes hold a thread's scratch memory. Points are added one after another, so that the rays of many are traced
// together.

#include <vector>

#include "irradiance_cache/cache_frame.h"
#include "irradiance_cache/light_tree/tested_nodes.h"
#include "irradiance_cache/near_field/near_of_points.h"
#include "irradiance_cache/points/cache_point.h"
#include "irradiance_cache/points/near_patches.h"

namespace gnomon::irradiance_cache {

class PointDevice;

/// Answers occlusion rays on the CPU, or on a device.
struct OcclusionTester {
    const ray::RayScene* rays = nullptr;
    PointDevice* device = nullptr;   // null: the CPU
    /// Sets occluded[i] for each ray of the queue; padded for packets.
    void test(const ray::RayQueue& queue, ray::Against against, std::vector<std::uint8_t>& occluded,
              CacheCounters& counters) const;
};

/// The static visibility of new points.
class StaticVisibility {
 public:
    StaticVisibility() { rays_.purpose = short_rays_.purpose = ray::RayClass::indirect; }
    void clear();
    std::size_t rays() const { return rays_.size() + near_.rays() + near_of_moving_.rays(); }
    /// Adds a point with its cut: the nodes, and what a unit of flux of each brings. Of a long cut, some are tested.
    void add(const CacheFrame& frame, CachePoint& point, std::span<const NodeId> cut, std::span<const float> weight);
    /// Traces a ray to each of them, and calls store(point, nodes) in order, where `nodes` are those that are visible.
    /// Then adds the static light that no node stands for.
    template <class Store>
    void trace_nodes(const CacheFrame& frame, const OcclusionTester& tester, CacheCounters& counters,
                     const Store& store);
    /// Traces rays to the sky, and adds the light of visible directions to the points' static light.
    /// Completes the points. @pre trace_nodes() was called
    /// @return  by how many the points' divided directions became more; may be negative
    std::ptrdiff_t trace_sky(const CacheFrame& frame, const OcclusionTester& tester, CacheCounters& counters);

 private:
    void thin_nodes(const CacheFrame& frame);

    struct Added {
        CachePoint* point;
        std::size_t first;         // of its rays
        std::size_t near;          // its number among points with near patches, or NearPatches::k_none
        CloseLight close{};        // lattice points
        std::size_t sky_ray = 0;   // its first one
        SkyMask sky_above{}, sky_seen{}, sky_edges{};   // directions above it; of these, seen; divided
    };
    bool is_surface_near(const CacheFrame& frame, const CachePoint& point);
    NearPatches& near_of(const CachePoint& point) { return point.owner == k_no_owner ? near_ : near_of_moving_; }
    void add_close_nodes(const CacheFrame& frame, Added& added) const;
    void add_beyond(const CacheFrame& frame, std::size_t nodes, Added& added) const;
    glm::vec3 facing_of_seen(const CacheFrame& frame, const CachePoint& point) const;
    void find_local();
    bool test_sky(const CacheFrame& frame, const OcclusionTester& tester, std::vector<glm::vec3>& passes,
                  CacheCounters& counters);
    void see_sky(const CacheFrame& frame, const OcclusionTester& tester, CacheCounters& counters);
    std::ptrdiff_t divide_sky(const CacheFrame& frame, const OcclusionTester& tester, CacheCounters& counters);
    static void add_sky(Added& added, const glm::vec3& light, const glm::vec3& direction);
    void add_node(const CacheFrame& frame, const CachePoint& point, NodeId node, float weight, const NearOptions* near);
    static constexpr float k_close = 1.0f;   // spacings
    std::vector<Added> added_;
    NearPatches near_, near_of_moving_{true};
    NearOfPoints near_field_, near_field_of_moving_;
    std::vector<CachePoint*> points_, moving_;   // moving: on dynamic objects, with static surfaces near by
    std::vector<NodeId> cut_;                    // of one point
    std::vector<float> cut_weights_;
    TestedNodes tested_;
    ray::RayQueue rays_, short_rays_;
    std::uint64_t short_cast_ = 0;   // rays of short_rays_ since clear()
    std::vector<NodeId> nodes_;      // by ray
    std::vector<float> weights_;     // by ray
    std::vector<SeenNode> seen_;     // of one point
    std::vector<std::uint8_t> occluded_;
    std::vector<glm::vec3> passes_, sky_passes_;   // by ray, where anything thins light
};

/// Corrections of static light by what dynamic objects change in this frame.
class PresentLight {
 public:
    PresentLight() { rays_.purpose = bounce_rays_.purpose = ray::RayClass::indirect; }
    void clear();
    /// Adds flux that arrives from a node unless a dynamic object occludes it.
    /// @param direction  to the node; its length is the node's weight
    void add_if_unoccluded(const CacheFrame& frame, CachePoint& point, NodeId node, const glm::vec3& flux,
                           const glm::vec3& direction);
    /// Takes away the light of visible sky directions that a dynamic object may hide, and adds it if it does not.
    void correct_sky(const CacheFrame& frame, CachePoint& point);
    /// Lets finish() add light that bounces off dynamic objects.
    void want_dynamic_lights(CachePoint& point) { lit_.push_back(&point); }
    /// Traces the rays, and adds what arrives; then light that bounces off dynamic objects. Where that is a small part
    /// of a point's light, no ray is cast.
    void finish(const CacheFrame& frame, const OcclusionTester& tester, CacheCounters& counters);

 private:
    struct Contribution {   // light that arrives if nothing is in between
        CachePoint* point;
        glm::vec3 flux, direction;
    };
    void add_dynamic_lights(const CacheFrame& frame, CachePoint& point);
    void add_arriving(const OcclusionTester& tester, const ray::RayQueue& rays,
                      const std::vector<Contribution>& contributions, ray::Against against, CacheCounters& counters);

    ray::RayQueue rays_, bounce_rays_;
    std::vector<Contribution> contributions_, bounces_;
    std::vector<std::uint8_t> occluded_;
    std::vector<glm::vec3> passes_;         // by ray, where anything thins light
    std::vector<SkyLight::Part> hidden_;    // the sky's light that a dynamic object may hide
    std::vector<const MovingBox*> boxes_;   // of those objects
    ray::RayQueue hidden_rays_;
    std::vector<CachePoint*> lit_;   // by dynamic objects
};

/// After all corrections: light of which only rounding errors are left becomes 0, because a dark point is treated
/// differently from one with a little light.
void end_corrections(CachePoint& point);

template <class Store>
void StaticVisibility::trace_nodes(const CacheFrame& frame, const OcclusionTester& tester, CacheCounters& counters,
                                   const Store& store)
{
    tester.test(rays_, ray::Against::static_only, occluded_, counters);
    if (frame.rays->thins_light()) thin_nodes(frame);
    near_.trace(frame), near_of_moving_.trace(frame);
    points_.clear();
    for (const Added& added : added_) points_.push_back(added.point);
    near_field_.find_static(frame, points_, counters);   // before any point is complete
    near_field_of_moving_.find_now(frame, moving_, counters);
    counters.rays += near_.rays() + near_of_moving_.rays() + short_cast_;
    RestOfLight rest;
    const bool patches = frame.lights.patch_light() != nullptr;   // without them, no light is local
    for (std::size_t a = 0; a < added_.size(); ++a) {
        const std::size_t last = a + 1 < added_.size() ? added_[a + 1].first : rays_.size();
        seen_.clear();
        for (std::size_t r = added_[a].first; r < last; ++r)
            if (!occluded_[r]) seen_.push_back(pack_seen(nodes_[r], weights_[r]));
        CachePoint& point = *added_[a].point;
        const bool near = added_[a].near != NearPatches::k_none, lattice = patches && is_lattice(point.key);
        if (lattice) add_close_nodes(frame, added_[a]);
        const float reach = lattice ? k_close * lattice_spacing(point.key) : 0;
        const std::size_t nodes = seen_.size();
        if (near) added_[a].close += near_of(point).find(frame, point, added_[a].near, seen_, rest, reach);
        if (lattice) add_beyond(frame, nodes, added_[a]);
        store(point, std::span<const SeenNode>(seen_));
        for (int colour = 0; near && colour < 3; ++colour) point.static_light[colour] += rest.light[colour];
        point.facing = patches ? facing_of_seen(frame, point) : glm::vec3(0);
        if (near) point.facing += rest.facing;
        counters.nodes += seen_.size();
    }
    counters.new_points += added_.size();
    near_field_.add_found(), near_field_of_moving_.add_found();
}

}   // namespace gnomon::irradiance_cache
