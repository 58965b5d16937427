// SPDX-License-Identifier: Apache-2.0
#pragma once
// What points of a frame see of planar lights, from remembered shadows of the static scene and rays against what moves.
//
// A light that rests keeps the shadows of static triangles (area_shadows.h) for as long as it keeps its shape. A point
// in a lit part, or in a dark one, needs no ray; one in a listed part needs its list. Where the segments from a point
// to the light may meet a dynamic object, its triangles are listed, too; rays against dynamic objects alone decide
// where such an object has holes or very many triangles. Points on dynamic objects and in open parts trace rays against
// everything, and so do all points for a light that may move. Rays go to the middle of each cell of places
// (visible_cells.h).
//
// The answer to a point does not depend on what was remembered, nor on the order of questions. If what is remembered
// grows beyond AreaOptions::most_bytes, all of it is forgotten.

#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "area_light/area_shadows.h"
#include "area_light/holed_places.h"
#include "area_light/planar_pairs.h"
#include "area_light/visible_cells.h"
#include "ray/ray_scene.h"
#include "visibility/dynamic_triangles.h"
#include "visibility/shadow_point.h"

namespace gnomon::area_light {

/// A light of a frame.
struct AreaLight {
    FlatLight shape;
    bool two_sided = false;   // also emits at the back
    bool dynamic = false;     // may move: nothing is remembered
};

struct VisibilityCounters {
    std::uint64_t points[5] = {};   // by PartState, of static points; without those of lights that may move
    std::uint64_t rays = 0;         // against static objects
    std::uint64_t dynamic_rays = 0;
    std::uint64_t triangles = 0;           // of lists, tested for points
    std::uint64_t dynamic_triangles = 0;   // the same, of dynamic objects
    void add(const VisibilityCounters& other);
};

class AreaVisibility {
 public:
    AreaVisibility(const scene::SceneState& state, const ray::RayScene& rays, const AreaOptions& options = {});
    ~AreaVisibility();

    /// Follows one advance() of the state, after the ray scene did. All lights of this frame, in any order: what is
    /// remembered of a light that has the same shape as before is kept.
    void follow(const scene::SceneState& state, const ray::RayScene& rays, std::span<const AreaLight> lights);

    enum class Answer : std::uint8_t { dark, lit, partial };
    struct Answers {
        std::vector<Answer> answer;      // by asked point
        std::vector<std::uint32_t> at;   // by asked point that sees a part: index in `cells`
        std::vector<VisibleCells> cells;
        std::vector<PartState> state;   // by asked point: of its part; open where none is remembered
        std::vector<char> back;         // by asked point: it is behind the light; cells are those of the back
    };
    /// Scratch memory of one thread, and what it counted.
    struct Scratch {
        VisibilityCounters counters;

     private:
        friend class AreaVisibility;
        struct Holed {
            scene::ObjectId object;
            std::uint32_t triangle;
        };
        struct Target {
            std::uint32_t cells;
            std::uint16_t cell;
        };
        struct Listed {
            const std::vector<visibility::TriangleId>* list;   // of the part; null: it is lit
            std::uint32_t asked;
        };
        struct Blocker {
            Box3 box;
            const visibility::DynamicTriangles::Blocker* of;
        };
        struct Boxed {
            Box3 box;
            const visibility::StaticTriangle* triangle;
        };
        std::vector<Listed> listed;    // asked points of listed parts, and of lit ones that a dynamic object is near
        TriangleList list;             // the one that is looked through
        TriangleList holed;            // of it, those with holes
        std::vector<Holed> holed_at;   // by entry of `holed`
        std::vector<visibility::TriangleId> opaque_ids;
        std::vector<Boxed> dynamic;   // triangles near any point of the call
        TriangleList dynamic_list;    // and those near any point of a group
        std::vector<std::uint32_t> boxes;
        ray::RayQueue queue;
        std::vector<Target> targets;   // by ray
        std::vector<std::uint8_t> occluded;
        std::vector<Blocker> blockers;
        std::vector<std::uint32_t> all_rays, dynamic_rays;   // asked points
    };

    /// Finds what points see of a light. Thread-safe.
    /// @param asked  indices of points
    void find(Scratch& scratch, std::span<const visibility::ShadowPoint> points, std::span<const std::uint32_t> asked,
              std::size_t light, Answers& answers) const;
    /// The cells of a light's front, or of its back.
    const LightCells& cells(std::size_t light, bool back) const;

    /// Sums over the lights' remembered parts.
    AreaCounters parts() const;
    std::size_t bytes() const;

    /// What occludes, for clusters (cluster_visibility.h): as of the last follow().
    const visibility::StaticTriangles& triangles() const { return *triangles_; }
    /// Increases when the static triangles were made anew.
    std::uint64_t triangles_version() const { return triangles_version_; }
    const visibility::DynamicBounds& dynamic() const { return *dynamic_; }

 private:
    struct Side;
    struct Light;
    class Query;

    std::size_t bytes_of_parts() const;

    AreaOptions options_;
    const ray::RayScene* rays_;
    std::unique_ptr<visibility::StaticTriangles> triangles_;
    std::uint64_t triangles_version_ = 0;
    std::unique_ptr<PlanarPairs> pairs_;
    std::unique_ptr<visibility::DynamicBounds> dynamic_;
    visibility::DynamicTriangles dynamic_triangles_;
    const scene::SceneState* state_ = nullptr;
    std::vector<std::pair<visibility::TriangleId, scene::ObjectId>> first_of_object_;   // ascending; of static objects
    std::vector<std::unique_ptr<Light>> lights_;
    mutable std::mutex hole_maps_mutex_;
    mutable std::vector<std::unique_ptr<HoleMap>> hole_maps_;   // made when they are first asked for
};

}   // namespace gnomon::area_light
