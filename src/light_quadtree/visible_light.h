// SPDX-License-Identifier: Apache-2.0
#pragma once
// Indirect light with shadows, without noise and without history.
//
// Every surface point keeps its own cut through the emitters' tree (emitters.h): coarse where little light comes from
// afar, fine where it matters, and of it only the nodes that it sees past everything static. While light and static
// geometry stand still that never changes; a frame sums present flux over what is seen, and asks what moves, and that
// alone, whether it stands between. Points are anchored canonically (anchors.h), so the same frame has the same bytes
// whatever came before, for any number of threads.
//
// Extends [Ki and Oh 2007]: their cut is one for all receivers and knows no visibility.
// Cost: a new point: its cut and one ray a node. A known point: a sum, again only if flux or movers changed. A pixel:
// the interpolation of four points.

#include <array>
#include <memory>
#include <span>

#include "base/tasks.h"
#include "light_quadtree/surface_points.h"
#include "light_quadtree/triangle_clusters.h"

namespace gnomon::light_quadtree {

struct VisibleOptions {
    EmitterOptions emitters;
    float pixels_per_point = 8;   // spacing of anchors on the screen: between half of this and this
    CutOptions cut;
    float level_blend = 0.3f;         // share of a level of detail over which it fades into the next
    std::size_t memory = 64u << 20;   // bytes of remembered points; those not in the last frame go first
};

struct VisibleCounters {
    std::uint64_t rays = 0;           // static and dynamic
    std::uint64_t rays_dynamic = 0;   // of these, against movers alone
    std::uint64_t new_points = 0, summed_points = 0, moving_points = 0;
    std::uint64_t nodes = 0;   // seen emitters of new points
    void add(const VisibleCounters& other);
};

class VisibleLight {
 public:
    VisibleLight(const scene::SceneState& state, const ray::RayScene& rays, const VisibleOptions& options,
                 Tasks& tasks);
    ~VisibleLight();

    /// After the state advanced and the ray scene followed.
    void begin_frame(const scene::SceneState& state, const ray::RayScene& rays, Tasks& tasks);

    /// A thread's scratch.
    class Batch;
    std::unique_ptr<Batch> make_batch() const;
    /// Irradiance that arrives at points by one diffuse bounce, by point. From any thread.
    void shade(Batch& batch, std::span<const IndirectPoint> points, glm::vec3* irradiance);

    /// Gathers the batches' counters; drops points if they take too much.
    void end_frame(std::span<const std::unique_ptr<Batch>> batches);

    const VisibleCounters& counters() const { return counters_; }
    const EmitterTree& emitters() const { return emitters_; }
    std::size_t bytes() const { return emitters_.bytes() + points_.bytes() + clusters_.bytes(); }
    std::size_t points() const { return points_.size(); }

 private:
    AnchorKey part_anchor(const IndirectPoint& point);
    void find_anchors(Batch& batch, std::span<const IndirectPoint> points);
    RememberedPoint* want(Batch& batch, AnchorKey key);
    void serve(Batch& batch);
    void place(Batch& batch);
    void open_ways(Batch& batch);
    void place_part(RememberedPoint& point) const;
    void see(Batch& batch);
    void sum(Batch& batch);
    void fill_cells(Batch& batch) const;
    glm::vec3 interpolate(const Batch& batch, const IndirectPoint& point, std::size_t index, bool strict,
                          float& weight) const;
    glm::vec3 at_part(const RememberedPoint& part, const glm::vec3& normal) const;

    VisibleOptions options_;
    const scene::SceneState* state_;
    const ray::RayScene* rays_;
    EmitterTree emitters_;
    SurfacePoints points_;
    TriangleClusters clusters_;
    light_views::Casters casters_;
    std::vector<scene::ObjectId> dynamics_;
    std::vector<Sphere> movers_;
    std::vector<std::uint32_t> first_triangle_;   // by object, among all of the scene
    std::uint32_t frame_ = 0, movers_version_ = 1;
    VisibleCounters counters_;
};

class VisibleLight::Batch {
 public:
    Batch() { rays.purpose = ray::RayClass::indirect; }
    VisibleCounters counters;

 private:
    friend class VisibleLight;
    // Four lattice anchors around some pixels, side by side once they are ready.
    struct Cell {
        RememberedPoint* point[4];
        float x[4], y[4], z[4], nx[4], ny[4], nz[4];
        float low_b[4], high_b[4], low_c[4], high_c[4];   // places that are open to the anchor
        float light[9][4];                                // by colour and axis
        int axis;
    };
    struct Wanted {   // by one pixel: a cell on one level of detail or two
        std::uint32_t cell[2] = {0, 0};
        float fx[2] = {0, 0}, fy[2] = {0, 0};
        float share[2] = {0, 0};   // 0: no such cell
    };
    struct Recent {
        AnchorKey key = 0;
        std::uint32_t frame = 0;
        RememberedPoint* point = nullptr;
    };
    struct Search {
        RememberedPoint* point;
        float from, best;
    };
    struct Fresh {
        RememberedPoint* point;
        std::size_t first;   // of its rays
    };
    struct Share {
        RememberedPoint* point;
        glm::vec3 flux, direction;
    };
    static constexpr unsigned k_recent_bits = 10;
    std::array<Recent, 1u << k_recent_bits> recent;
    std::vector<Wanted> wanted;
    std::vector<Cell> cells;
    std::vector<RememberedPoint*> parts;   // by left pixel
    std::vector<std::uint32_t> left;
    std::vector<RememberedPoint*> claimed, awaited;
    std::vector<Search> searching;
    std::vector<RememberedPoint*> placed;   // new lattice points
    std::vector<NodeId> cut, entries;
    std::vector<float> cut_weight, entry_weight;
    std::vector<std::uint32_t> through;
    std::vector<NodeId> stack;
    std::vector<Fresh> fresh;
    std::vector<Share> shares;
    ray::RayQueue rays;
    ray::Hits hits;
    std::vector<std::uint8_t> blocked;
};

}   // namespace gnomon::light_quadtree
