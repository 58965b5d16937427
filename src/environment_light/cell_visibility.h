// SPDX-License-Identifier: Apache-2.0
#pragma once
// Which cells of directions (direction_cells.h) points of a frame see, past static geometry and what moves.
//
// A cell is visible from a point if a ray in the cell's own direction leaves the scene. Most rays are not needed: what
// is proven of the point's part (cell_proofs.h) says what they would find, and what rays found at a point of a static
// surface is remembered (point_memory.h) as long as the view asks for the point. Dynamic objects are not part of
// either: rays go against them alone, to visible cells that the box of one may cover. Points on dynamic objects trace
// rays against everything.
//
// Cells whose mean direction lies below the surface are not visible. Where the own direction of a cell at the horizon
// lies below, its mean direction stands in.
//
// Where a point sees little of the sky, as through a window, a cell is a step that shows. The cells at the rim of what
// such a point sees are divided: it sees a share of them (PartialCell), by up to 64 rays in directions within the cell
// (part_directions.h), as many as the cell's light asks for beside that of all visible cells. Points in the dark look
// for windows that scouts missed, neighbours in other parts of cells. Between guides whose shares are alike, they are
// interpolated.
//
// Where points of a smooth surface lie close together, as in an image, most cells are visible from all of them, or from
// none. A point may therefore have guides around it: rays then go to those cells alone on which the guides do not
// agree, and to a few others as probes. A cell that a probe finds to be otherwise is traced from all points of the
// block. The same is done once more for what dynamic objects hide. Of a sun, rays go to its rim first (LeafGroup).
// Where a coarse answer will do, a few cells stand in for all.
//
// The answer to a point does not depend on what was proven or remembered, nor on the order of questions, but on its
// guides.

#include <memory>
#include <mutex>
#include <span>
#include <utility>
#include <vector>

#include "environment_light/cell_proofs.h"
#include "environment_light/part_directions.h"
#include "environment_light/point_memory.h"
#include "ray/ray_scene.h"
#include "visibility/dynamic_bounds.h"
#include "visibility/shadow_point.h"

namespace gnomon::environment_light {

struct VisibilityCounters {
    std::uint64_t points = 0;        // asked
    std::uint64_t free_points = 0;   // of these, without any ray or memory
    std::uint64_t remembered = 0;    // of these, by memory
    std::uint64_t rays = 0;          // against static objects, or everything
    std::uint64_t dynamic_rays = 0;
    void add(const VisibilityCounters& other);
};

/// What points see: a bit for each leaf, and a share of some.
struct SeenCells {
    std::size_t words = 0;   // of a point
    std::vector<std::uint64_t> masks;
    std::vector<PartialCell> partial;                                // of points, in any order
    std::vector<std::pair<std::uint32_t, std::uint32_t>> partials;   // by asked point: the first, and how many
    /// By leaf, rising.
    std::span<const PartialCell> partial_of(std::size_t asked) const
    {
        return {partial.data() + partials[asked].first, partials[asked].second};
    }
    std::span<const std::uint64_t> of(std::size_t asked) const { return {masks.data() + asked * words, words}; }
    std::span<std::uint64_t> of(std::size_t asked) { return {masks.data() + asked * words, words}; }
};

/// Points around another one on the same smooth surface, as indices in the list of asked points.
struct Guides {
    std::array<std::uint32_t, 4> corner{};   // some may be the same
    std::array<float, 4> weight{};           // of each, for interpolation; sum to 1
    bool guides = false;                     // whether the point guides others
    std::uint8_t pass = 0;                   // 0: none; its guides have a lower number
    std::uint32_t block = 0;    // points among the same guides have the same number, other passes other numbers
    std::uint32_t number = 0;   // of the point within the block
    bool coarse = false;        // without guides: rays go to stand-ins (DirectionCells::stand_ins()) alone;
    bool unless_dark = false;   // but not where these see little of the light above
    bool rough = false;         // coarse, with still fewer stand-ins; if one point is, all are
};

/// The static scene and the boxes of what moves; shared by several sets of cells.
class Surroundings {
 public:
    Surroundings(const scene::SceneState& state, const ray::RayScene& rays);
    /// Follows one advance() of the state, after the ray scene did.
    /// @return  whether static triangles changed: what was proven of them does not hold any more
    bool follow(const scene::SceneState& state, const ray::RayScene& rays);

    const ray::RayScene& rays() const { return *rays_; }
    const visibility::StaticTriangles& triangles() const { return *triangles_; }
    const std::vector<Box3>& dynamic_boxes() const { return boxes_; }
    std::size_t bytes() const { return triangles_->bytes(); }

 private:
    const ray::RayScene* rays_;
    std::unique_ptr<visibility::StaticTriangles> triangles_;
    std::unique_ptr<visibility::DynamicBounds> dynamic_;
    std::vector<Box3> boxes_;   // of visible dynamic objects
};

class CellVisibility {
 public:
    /// @param surroundings, cells  kept by reference
    CellVisibility(const Surroundings& surroundings, const DirectionCells& cells, const ProofOptions& options = {});

    /// Scratch memory of one thread, and what it counted.
    struct Scratch {
        VisibilityCounters counters;

     private:
        friend class CellVisibility;
        struct Target {
            std::uint32_t asked;
            std::uint16_t leaf;
        };
        // A cell of which a point asks what share it sees.
        struct Divided {
            std::uint32_t asked = 0, leaf = 0;
            int level = 0;                                   // of detail (cell_parts.cpp)
            std::uint64_t above = 0, traced = 0, seen = 0;   // parts; above the surface
            float share = -1;                                // if that is known otherwise
            bool done = false, remembered = true;            // false: rays did not find it
            bool thorough = false;     // begins with a ray for each sixteenth; of what moves: static parts count
            bool fine = false;         // has a ray for each part, unless sixteenths all see the sky
            std::uint64_t clear = 0;   // parts that dynamic objects leave
        };
        struct PartTarget {
            std::uint32_t divided, part;
        };
        struct Asked {
            const PartMasks* masks = nullptr;   // of a static point
            bool on_dynamic = false, is_static = false;
            bool fresh = false;   // rays found what was not remembered
        };
        ray::RayQueue queue;
        std::vector<Target> targets;   // by ray
        std::vector<std::uint8_t> occluded;
        std::vector<Asked> asked;
        // Masks of all asked points, one after the other.
        std::vector<std::uint64_t> above;               // cells above the surface
        std::vector<std::uint64_t> known, free;         // of these, proven, remembered or traced; of these, visible
        std::vector<std::uint64_t> wanted;              // to be decided next
        std::vector<std::uint64_t> between;             // to be interpolated between guides
        std::vector<std::uint64_t> following;           // wanted followers of scouts
        std::vector<std::uint64_t> agreed, contested;   // by guided point; by block
        std::vector<std::uint64_t> affected;            // cells that a dynamic object may cover
        // Of static points: visible cells that dynamic objects may hide; those of them of which shares are asked for;
        // cells that dynamic objects do not hide, as far as that is known; cells that they do.
        std::vector<std::uint64_t> touched, shared, clear_of, hidden_by;
        glm::vec3 above_normal{0};
        std::size_t above_at = 0;   // the last point with that normal
        SeenCells at_rest;          // what points with guides see past static objects; only where something moves
        std::vector<std::uint64_t> bits;
        std::vector<std::uint32_t> stack;
        // Shares of cells.
        std::vector<Divided> divided;           // of all points so far
        std::vector<PartTarget> part_targets;   // by ray of `part_queue`
        ray::RayQueue part_queue;
        std::vector<float> light, unit;        // by asked point: what it sees; what cells are compared with
        std::vector<KnownParts> known_parts;   // of all points
        std::vector<std::pair<std::uint32_t, std::uint32_t>> known_of;   // by asked point: the first, and how many
        std::vector<KnownParts> own_parts;
        std::vector<std::uint8_t> family_sees;   // bits: some leaf is seen, some is hidden
        std::vector<std::uint8_t> windows;       // by family: whether some point in the dark sees one of its leaves
        std::vector<std::uint32_t> dark;         // points in the dark
        // Parts of cells in which points in the dark see the sky, by point; and which parts such a point looks at.
        struct Glimpse {
            std::uint32_t asked, leaf, part;
        };
        std::vector<Glimpse> glimpses;
        std::vector<std::uint32_t> glance;     // by asked point; k_no_glance: it is not in the dark
        std::vector<Glimpse> glance_targets;   // by ray of `part_queue`
        bool small_windows = false;
        std::vector<std::uint32_t> union_leaves, order;
        std::vector<PartialCell> partial;
    };

    /// Finds what points see. Thread-safe for different scratch and memory.
    /// @param asked   indices of points; neighbours in the list should be near to each other
    /// @param guides  by asked point, or empty: cells that all guides of a point see, or none, are taken to be as they
    ///                are there, unless one of the probes of the block says otherwise
    /// @param memory  of static points; null: nothing is remembered
    /// @param moving  guides for what dynamic objects hide; they may be farther apart. Empty: `guides`
    /// @param first   the asked points before this one are those of the last call, with the same scratch, guides and
    ///                answers: only the others are answered, and these may have guides among all. What `seen` says of
    ///                the former is then without what moves.
    void find(Scratch& scratch, std::span<const visibility::ShadowPoint> points, std::span<const std::uint32_t> asked,
              std::span<const Guides> guides, PointMemory* memory, SeenCells& seen, std::size_t first = 0,
              std::span<const Guides> moving = {}) const;

    /// Takes over what is proven and remembered for other cells, of another image, where both have the same leaves.
    /// Call before the first question. What points remember of the others can be read until forget_other().
    /// @param other  kept by reference until then
    void take_over(const CellVisibility& other);
    void forget_other() { other_ = nullptr, leaf_of_other_.clear(); }

    const DirectionCells& cells() const { return cells_; }
    CellProofs& proofs() const { return *proofs_; }

 private:
    struct Query;
    glm::vec3 ray_direction(std::size_t leaf, const glm::vec3& normal) const;
    void find_above(const Query& query, std::size_t k) const;
    void look_up(const Query& query, PointMemory* memory) const;
    void read_other(const Query& query, std::size_t k, const PointMemory::Known& known) const;
    void decide_alone(const Query& query) const;
    void decide_guided(const Query& query, int pass) const;
    void decide(const Query& query, int pass) const;
    void decide_coarse(Query& query) const;
    void follow_stand_ins(const Query& query, std::size_t k) const;
    void follow_groups(const Query& query, std::size_t k) const;
    void follow_families(const Query& query, std::size_t k) const;
    void follow(const Query& query, std::size_t k, std::size_t first, std::size_t leaves, bool some_seen,
                bool some_hidden) const;
    void decide_roughly(const Query& query) const;
    void leave_stand_ins(const Query& query, std::size_t k) const;
    void follow_hidden(const Query& query, std::size_t k) const;
    void decide_wanted(const Query& query, int pass) const;
    void push_rays(const Query& query, std::span<const std::uint32_t> block) const;
    void flush(const Query& query, ray::Against against, bool sets, std::uint64_t& count) const;
    const std::uint64_t* probes_of(const Guides& guides) const;
    void remember(const Query& query, PointMemory& memory) const;
    // cell_dynamic.cpp
    void cover(Scratch& scratch, const glm::vec3& from, float from_radius, const Box3& box) const;
    void test_dynamic(const Query& query) const;
    void find_affected(const Query& query) const;
    void follow_guides(const Query& query, std::size_t k) const;
    void contest(const Query& query, std::size_t k) const;
    void decide_dynamic(const Query& query, int pass) const;
    void note_found(const Query& query, std::size_t k, std::span<const std::uint64_t> decided) const;
    // cell_parts.cpp
    void divide(const Query& query, int pass) const;
    void measure_light(const Query& query, std::size_t k) const;
    bool is_dark(const Query& query, std::size_t k) const;
    void look_for_windows(const Query& query) const;
    void glance_between(const Query& query) const;
    void divide_alone(const Query& query, std::size_t k) const;
    void divide_guided(const Query& query, std::size_t k) const;
    static float share_at(const Query& query, std::size_t k, std::size_t leaf);
    bool guides_are_alike(const Query& query, std::size_t k, std::span<const std::uint64_t> leaves) const;
    void look_at(const Query& query, std::size_t k, std::size_t leaf, int level, bool small_window) const;
    void trace_parts(const Query& query, std::size_t first) const;
    void push_parts(const Query& query, std::size_t first, int round, bool on_dynamic, ray::Against against,
                    std::uint64_t& count) const;
    void flush_parts(const Query& query, ray::Against against, std::uint64_t& count) const;
    void find_shared(const Query& query, std::size_t k) const;
    void divide_affected(const Query& query, std::size_t k) const;
    void take_dynamic_parts(const Query& query) const;
    float light_of(std::size_t leaf, const glm::vec3& normal) const;
    float light_of(std::span<const std::uint64_t> mask, const glm::vec3& normal) const;
    void add_partials(const Query& query, std::size_t first) const;
    const PartDirections& part_directions() const;

    const Surroundings& surroundings_;
    const DirectionCells& cells_;
    std::unique_ptr<CellProofs> proofs_;
    std::array<std::vector<float>, 3> mean_;   // by axis, padded to whole words
    std::vector<std::uint64_t> probes_;        // masks of the leaves that one kind of point probes, one after the other
    mutable std::once_flag parts_made_;
    mutable std::unique_ptr<PartDirections> parts_;   // made when the first point asks for a share
    std::vector<float> luminance_;                    // of the flux, by leaf
    float most_luminance_ = 0;
    // Masks of the leaves in which one kind of point in the dark looks for windows, one after the other.
    std::vector<std::uint64_t> in_windows_;
    std::vector<std::uint64_t> looked_into_;   // all of these
    std::uint32_t number_ = 0;                 // of these cells, in PointMemory
    const CellVisibility* other_ = nullptr;
    std::vector<std::int32_t> leaf_of_other_;   // by its leaf; -1: these cells have no such leaf
};

}   // namespace gnomon::environment_light
