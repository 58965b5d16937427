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
// Cost: a new point: its cut and one ray a node. A known point: a sum, again only if flux or dynamic objects changed. A
// pixel: the interpolation of four points.

#include <array>
#include <atomic>
#include <exception>
#include <memory>
#include <span>
#include <thread>

#include "base/tasks.h"
#include "irradiance_cache/light_tree/lattice_kernels.h"
#include "irradiance_cache/light_tree/triangle_clusters.h"
#include "irradiance_cache/near_field/near_hints.h"
#include "irradiance_cache/near_field/near_light.h"
#include "irradiance_cache/points/point_engine.h"
#include "irradiance_cache/points/sparse_pixels.h"
#include "irradiance_cache/points/surface_points.h"

namespace gnomon::irradiance_cache {

struct VisibleOptions {
    EmitterOptions emitters;
    // Spacing of anchors on the screen, in pixels: as wide as the first where neighbours can be interpolated, down to
    // the second where they lie behind corners.
    float widest = 24, narrowest = 12;
    float level_blend = 0.3f;     // share of a level of detail over which one fades into another
    float pixels_per_part = 6;    // of what moves
    float pixels_per_leaf = 16;   // of small triangles that no lattice fits: foliage, rods
    float pixels_per_own = 2;     // of parts that are about the pixel itself, where all else is dark
    CutOptions cut;
    // In place of cut.error and cut.estimate for points that move, since they are made anew every frame.
    float moving_error = 0.2f, moving_estimate = 0.05f;
    // Near light (near_light.h): from within so many leaves of the light map, where far points lie no further apart
    // than so many of its radii.
    float near_radius = 1, near_spacing = 4;
    float pixels_per_near = 2;           // spacing of its points,
    float pixels_per_near_cluster = 4;   // and of those that stand for smaller triangles
    int near_rays = 64;
    float unasked = 0.02f;   // share of a point's light: less than this comes from a dynamic object unshadowed
    // Bytes of remembered points, or twice what the last frame shows; the longest unseen go first.
    std::size_t memory = 16u << 20;
};

struct VisibleCounters {
    std::uint64_t rays = 0;           // static and dynamic
    std::uint64_t rays_dynamic = 0;   // of these, against dynamic objects alone
    std::uint64_t new_points = 0, summed_points = 0, moving_points = 0;
    std::uint64_t near_points = 0;   // new ones; not among new_points
    std::uint64_t nodes = 0;         // seen emitters of new points
    void add(const VisibleCounters& other);
};

class VisibleLight {
 public:
    VisibleLight(const scene::SceneState& state, const ray::RayScene& rays, const VisibleOptions& options,
                 Tasks& tasks);
    ~VisibleLight();

    /// From the next frame on, cuts and sums of points are the engine's; before the first frame. See shade().
    void set_engine(std::unique_ptr<PointEngine> engine);

    /// After the state advanced and the ray scene followed.
    void begin_frame(const scene::SceneState& state, const ray::RayScene& rays, Tasks& tasks);

    /// A thread's scratch.
    class Batch;
    std::unique_ptr<Batch> make_batch() const;
    /// Irradiance that arrives at points by one diffuse bounce, by point. From any thread.
    /// @return  always true without an engine. With one, false where remembered points wait for it, and there is no
    /// light yet: once all that is wanted was asked for so, light_waiting(), and ask again.
    bool shade(Batch& batch, std::span<const IndirectPoint> points, glm::vec3* irradiance);
    /// Has the engine bring all points that wait up to this frame.
    /// @param batches  one a thread of `tasks`
    void light_waiting(std::span<const std::unique_ptr<Batch>> batches, Tasks& tasks);

    /// Gathers the batches' counters; drops points if they take too much.
    void end_frame(std::span<const std::unique_ptr<Batch>> batches);

    /// For viewers, from the next frame on: once so many rays were cast in a frame no new point is asked about; what
    /// lacks is lit as brightly as the rest on average. 0: no limit, the only way to images that do not depend on
    /// history.
    void limit_rays(std::uint64_t a_frame) { most_rays_ = a_frame; }
    /// The last frame lacked points: the same frame once more would have more of them.
    bool lacks_points() const { return lacking_; }

    const VisibleCounters& counters() const { return counters_; }
    const EmitterTree& emitters() const { return emitters_; }
    std::size_t bytes() const;
    std::size_t points() const { return points_.size(); }

 private:
    // Points are interpolated to pixels whose plane is no further off than this share of the spacing.
    static constexpr float k_plane = 0.35f;

    // The parts of triangles that speak for a point, with their shares.
    struct PartAnchors {
        AnchorKey key[4];
        float share[4];
        int count = 0;
        void add(AnchorKey k, float s);
    };
    PartAnchors part_anchors(const IndirectPoint& point, float spacing, float leaf_spacing);
    PartAnchors far_parts(const IndirectPoint& point);
    PartAnchors own_parts(const IndirectPoint& point) const;
    void add_parts(PartAnchors& parts, const IndirectPoint& point, const glm::vec3& cross, float spacing) const;
    glm::vec3 around(Batch& batch, std::size_t wanted) const;
    float faded(float beyond) const;
    void find_cells(Batch& batch, std::span<const IndirectPoint> points);
    std::uint32_t cell_of(Batch& batch, const LatticeCell& cell, int level);
    void blend_level(Batch& batch, std::span<const IndirectPoint> points, glm::vec3* irradiance);
    void shade_parts(Batch& batch, std::span<const IndirectPoint> points, glm::vec3* irradiance);
    RememberedPoint* want(Batch& batch, AnchorKey key);
    void serve(Batch& batch);
    bool shade_points(Batch& batch, std::span<const IndirectPoint> points, glm::vec3* irradiance);
    void find_together();
    void forget_what_stood_still();
    void forget_seen(const RememberedPoint& point);
    void enclose_dynamic();
    void wait(Batch& batch);
    void light_some(std::span<RememberedPoint* const> points, std::span<const std::unique_ptr<Batch>> batches,
                    Tasks& tasks);
    void see_waiting(std::span<RememberedPoint* const> points, std::span<const std::unique_ptr<Batch>> batches,
                     Tasks& tasks);
    void push_ways(Batch& batch, const RememberedPoint& point, std::span<const NodeId> cut,
                   std::span<const float> weight) const;
    void ask(Batch& batch, const ray::RayQueue& rays, ray::Against against) const;
    CutOptions cut_options(const RememberedPoint& point) const;
    template <class Done>
    void await(const Done& done) const;
    bool out_of_rays() const { return most_rays_ > 0 && spent_rays_.load(std::memory_order_relaxed) >= most_rays_; }
    void put_off(Batch& batch);
    void place(Batch& batch);
    void open_ways(Batch& batch);
    float slope_of_end(const RememberedPoint& point, int way, scene::ObjectId object, std::uint32_t triangle) const;
    void place_part(RememberedPoint& point) const;
    void follow_radius(bool first);
    void forget_hints();
    void find_hints(Batch& batch, std::span<const IndirectPoint> points);
    void add_near_light(Batch& batch, std::span<const IndirectPoint> points, glm::vec3* irradiance);
    void serve_near(Batch& batch);
    void replace_hidden(Batch& batch, std::span<const IndirectPoint> points);
    void see_near(Batch& batch);
    bool near_at(float spacing) const { return spacing <= options_.near_spacing * near_.options().radius; }
    bool dynamic_may_touch(const RememberedPoint& point) const;
    void see(Batch& batch);
    void see_sky(Batch& batch);
    void shade_sky(Batch& batch, RememberedPoint& point);
    void sum(Batch& batch);
    static void end_sum(RememberedPoint& point);
    static void add_light(RememberedPoint& point, const glm::vec3& flux, const glm::vec3& direction);
    void bounce_off_dynamic(Batch& batch, RememberedPoint& point);
    struct Share {   // light that arrives if nothing stands between
        RememberedPoint* point;
        glm::vec3 flux, direction;
    };
    void add_what_arrives(Batch& batch, ray::RayQueue& rays, const std::vector<Share>& shares, ray::Against against);
    void fill_cells(Batch& batch) const;
    glm::vec3 at_part(const RememberedPoint& part, const glm::vec3& normal) const;

    VisibleOptions options_;
    const scene::SceneState* state_;
    const ray::RayScene* rays_;
    EmitterTree emitters_;
    std::unique_ptr<PointEngine> engine_;   // null: the threads that claim points do all themselves
    SurfacePoints points_;
    TriangleClusters clusters_;
    SkyLight sky_;
    NearLight near_;
    std::unique_ptr<NearHints> hints_;   // null: no near light
    float near_width_ = 0;               // of pixels: from here on it fades, from twice as wide on there is none
    light_views::Casters casters_;
    struct Together {   // what moves together
        std::uint32_t owner;
        std::vector<scene::ObjectId> objects;
    };
    std::vector<Together> together_;
    std::uint32_t promoted_ = 0;   // RayScene::promoted() then
    MovingSpheres dynamic_;
    std::vector<std::uint32_t> first_triangle_;   // by object, among all of the scene
    std::uint32_t frame_ = 0, dynamic_version_ = 1;
    std::uint64_t most_rays_ = 0;   // a frame; 0: no limit
    std::atomic<std::uint64_t> spent_rays_ = 0;
    std::atomic<bool> lacking_ = false;
    // A thread that fails, for want of memory, leaves points unfinished that others wait for: they fail as it did.
    std::atomic<bool> failing_ = false, failed_ = false;
    std::exception_ptr failure_;   // once failed_
    glm::vec3 average_{0};         // irradiance in the last frame, if rays are limited
    VisibleCounters counters_;
};

// Waits for what another thread does.
template <class Done>
void VisibleLight::await(const Done& done) const
{
    while (!done()) {
        if (failed_.load(std::memory_order_acquire)) std::rethrow_exception(failure_);
        std::this_thread::yield();
    }
}

class VisibleLight::Batch {
 public:
    Batch() { rays.purpose = bounce_rays.purpose = ray::RayClass::indirect; }
    VisibleCounters counters;
    glm::dvec3 light_sum{0};   // if rays are limited, of light_count pixels
    std::uint64_t light_count = 0;

 private:
    friend class VisibleLight;
    // Four lattice anchors around some pixels, side by side once they are ready.
    struct Cell {
        AnchorKey key[4];
        RememberedPoint* point[4];
        int level;
        std::size_t first, end;   // of `wanted`
        CellAnchors anchors;
    };
    struct Wanted {            // by one point: a cell, while levels of detail are gone through
        std::uint32_t point;   // which
        int level;
        std::uint32_t cell;
        float rest;         // share of its light that finer levels bring
        glm::vec3 around;   // what the level before says, such as it is; if this one has only begun to fade in
    };
    struct Part {
        std::uint32_t point;
        float rest;
        AnchorKey key;
        RememberedPoint* part;
        glm::vec3 around;   // what the lattice says, such as it is
    };
    struct Recent {
        AnchorKey key = 0;
        std::uint32_t frame = 0;
        RememberedPoint* point = nullptr;
    };
    struct Search {
        RememberedPoint* point;
        float from, best, found;
    };
    struct Fresh {
        RememberedPoint* point;
        std::size_t first;   // of its rays
    };
    struct Found {
        Wanted wanted;
        float x, y;   // place in its cell
    };
    static constexpr std::size_t k_least_slots = 64;
    std::vector<std::uint32_t> slots;   // cells by their keys: number + 1; open addressing, a power of two
    std::vector<Found> found;
    static constexpr unsigned k_recent_bits = 10;
    std::array<Recent, 1u << k_recent_bits> recent;
    SparsePixels pixels;
    std::vector<std::uint8_t> moving;   // by point
    std::vector<Wanted> wanted;
    std::vector<Cell> cells;
    LatticePoints lattice;   // of `wanted`
    LatticeLight light, around;
    std::vector<Part> parts, whole_parts;
    std::vector<float> near_share;   // by point: of its light, where near light comes by rays of its own
    std::vector<RememberedPoint*> claimed, awaited, put_off, summed;
    std::vector<RememberedPoint*> waiting;   // for the engine
    bool pending = false;                    // some of what these points want waits
    std::vector<Search> searching;
    std::vector<RememberedPoint*> placed;   // new lattice points
    std::vector<NodeId> cut, entries;
    std::vector<float> cut_weight, entry_weight;
    std::vector<ChangedNode> changed;
    std::vector<NodeId> stack;
    std::vector<Fresh> fresh;
    std::vector<Share> shares, bounces;
    ray::RayQueue rays, bounce_rays;

    ray::Hits hits;
    std::vector<std::uint8_t> occluded;
    struct NearPoint {
        std::uint32_t point;
        NearHints::Cell cell;
        bool known;   // that it is near others
    };
    std::vector<NearPoint> near_points;
    struct NearPart {
        std::uint32_t point;
        float share;
        AnchorKey key;
        RememberedPoint* part;
    };
    std::vector<NearPart> near_parts;
    std::vector<std::uint32_t> doubted;   // near parts that their pixel may not see
    std::vector<NearHints::Cell> awaited_cells;
    std::vector<NearHints::Asked> asked_cells;
    NearHints::Scratch hints;
    std::vector<RememberedPoint*> near_asked;
    std::vector<NearReceiver> near_receivers;
    std::vector<NearAnswer> near_answers;
    NearLight::Scratch near;
};

}   // namespace gnomon::irradiance_cache
