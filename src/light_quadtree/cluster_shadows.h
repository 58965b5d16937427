// SPDX-License-Identifier: Apache-2.0
#pragma once
// The sum over clusters with shadows: each cluster is a light, occluded by a ray from the receiver to its mean
// position. The published method ignores visibility [Ki and Oh 2007, 7], which its error against a reference consists
// of.
//
// Clusters stay where they are while the light and what it shines on rest; those of static objects stay whatever moves
// if they have a tree of their own (LightMapOptions::separate_trees). What static geometry does to the path from a
// receiver to a cluster is remembered while both stay, as shadow culling remembers it for a light [Nah et al. 2009,
// 2.3]: NON_SHADOW, after which only dynamic objects are tested, or FULL_SHADOW, after which nothing is. Both are
// proven, because neither end of the path has moved by a bit. Against dynamic objects, only rays whose paths meet the
// box of one are cast. So once a path is known, a ray is cast for it only where something moves.
//
// Known flaw: a cluster is visible as a whole or not at all, so the edges of its shadow are hard. Cost: at most a ray
// per receiver and cluster that face each other; two bits per remembered pair.

#include <span>
#include <unordered_map>

#include "light_quadtree/gather.h"
#include "ray/ray_scene.h"
#include "visibility/dynamic_bounds.h"

namespace gnomon::light_quadtree {

/// Pairs of a receiver and a cluster that face each other, and the rays that their visibility took.
struct ShadowCounters {
    std::uint64_t pairs = 0;
    std::uint64_t rays = 0;           // of paths of which nothing was known: against static geometry, or everything
    std::uint64_t rays_dynamic = 0;   // of paths that static geometry leaves free, against dynamic objects alone
    std::uint64_t left_out = 0;       // pairs without a ray
    std::uint64_t cast() const { return rays + rays_dynamic; }
    ShadowCounters& operator+=(const ShadowCounters& more);
};

enum class PathMode : std::uint8_t { unknown, non_shadow, full_shadow };

/// The modes of the paths from a set of receivers, by number, to the clusters of a cut.
class PathModes {
 public:
    /// The modes of one receiver's paths, two bits each.
    class Row {
     public:
        bool is_of(const glm::vec3& position, const glm::vec3& normal) const
        {
            return position_ == position && normal_ == normal;
        }
        PathMode get(std::size_t cluster) const
        {
            return static_cast<PathMode>(modes_[cluster / 4] >> (cluster % 4 * 2) & 3u);
        }
        void set(std::size_t cluster, PathMode mode)
        {
            const auto shift = static_cast<unsigned>(cluster % 4 * 2);
            modes_[cluster / 4] = static_cast<std::uint8_t>((modes_[cluster / 4] & ~(3u << shift)) |
                                                            static_cast<unsigned>(mode) << shift);
        }

     private:
        friend class PathModes;
        glm::vec3 position_{0}, normal_{0};
        std::uint32_t version_ = 0;   // of the cut; 0: nothing is known
        std::uint64_t asked_ = 0;     // frame in which it was last asked for
        std::vector<std::uint8_t> modes_;
    };

    /// Call before the first of() of a frame.
    void begin_frame() { ++frame_; }
    /// Follows the cut. Clusters that are in it again and have not moved keep their modes.
    void follow(const Clusters& clusters);
    /// Changes the number of receivers; the first ones keep their modes.
    void resize(std::size_t receivers) { rows_.resize(receivers); }
    std::size_t size() const { return rows_.size(); }
    /// Forgets all modes, for instance because static geometry changed.
    void forget();
    /// A receiver's modes in the present cut; unknown, unless it has not moved. Null if it was asked for in this frame
    /// for another place, which then is the one that is remembered. Different receivers may be asked for at the same
    /// time. Cost: once per cut, a step per cluster.
    Row* of(std::size_t receiver, const glm::vec3& position, const glm::vec3& normal);
    std::size_t bytes() const;

 private:
    struct End {
        std::size_t place;   // in the cut
        glm::vec3 position;
        float disk;
    };
    std::vector<Row> rows_;
    std::uint64_t frame_ = 1;
    std::uint32_t version_ = 0;                   // of the cut
    std::vector<std::uint32_t> before_;           // by cluster: its place in the last cut; scene::none if it is new
    std::unordered_map<std::size_t, End> ends_;   // by node of the tree
};

/// What helps to leave out rays. Without all of it, a ray against everything is cast for every pair.
struct ShadowKnowledge {
    std::span<PathModes::Row* const> rows;                // by receiver of the range; null: nothing is remembered of it
    const visibility::DynamicBounds* dynamic = nullptr;   // null: any ray may meet a dynamic object
};

struct ShadowScratch {
    ray::RayQueue queue;
    std::vector<std::uint32_t> receiver;   // by ray
    std::vector<std::uint8_t> occluded;
    std::vector<Box3> boxes;
    ShadowCounters counters;
};

/// Whether a receiver sees a cluster that it faces: the reference of a single pair, and false if they face away.
bool cluster_visible(const Clusters& clusters, std::size_t cluster, const glm::vec3& position, const glm::vec3& normal,
                     const ray::RayScene& rays);

/// As gather(), with shadows.
void gather_with_shadows(const Clusters& clusters, Receivers& receivers, std::size_t begin, std::size_t end,
                         const ray::RayScene& rays, const ShadowKnowledge& known, ShadowScratch& scratch);

}   // namespace gnomon::light_quadtree
