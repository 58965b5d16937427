// SPDX-License-Identifier: Apache-2.0
#pragma once
// A conservative mask per light of the shadows of dynamic objects in the present frame, which answers most shadow
// queries without a ray.
//
// The projection of each dynamic object onto the light's plane has an outline: its silhouette edges seen from the
// light, and its borders. Where no outline passes, the number of the object's layers is constant (the argument of
// certify_full, inverted). So only outlines are drawn, widened by the rounding margin, and layers are counted along
// rows. Each texel stores, of the objects over it (MaskTexels, texels.h), the one that begins first, the one that
// begins next, and one that covers all of it. A point deeper than the covering object's end is in shadow. A point
// nearer than the first beginning is not shadowed by a dynamic object. A point on a dynamic object lies over itself; if
// the object does not rise above the plane of the point's triangle, the comparison starts with the next object.
//
// Points on dynamic objects also need the static scene. For each block, the least depth at which static geometry begins
// is kept while the light rests. Nothing static occludes a nearer point.
//
// The mask is drawn in blocks of texels about a pixel wide, where that costs less than the rays that it may save,
// estimated from the edges of the objects in the block and from the points of this frame and the last. It is kept while
// nothing moves. Neither the content of a block, nor whether it is drawn, nor the counters depend on threads.
//
// Cost per frame and queried light: a box per dynamic object, the outlines of those in queried blocks, and the blocks.

#include <atomic>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "shadow_culling/dynamic_mask/dynamic_shapes.h"
#include "shadow_culling/dynamic_mask/light_space.h"
#include "shadow_culling/dynamic_mask/texels.h"
#include "visibility/static_triangles.h"

namespace gnomon::shadow_culling {

using visibility::StaticTriangles;

struct MaskOptions {
    float texel_pixels = 2;       // width of a texel, in the pixels of the view
    std::uint32_t asked = 24;     // a block is considered for drawing if a batch has so many points in it
    double edges_per_ray = 3;     // a block is drawn if it has at most so many edges for every ray that it may save
    double margin = 8e-6;         // bound on the deviation of rays, as a fraction of the largest coordinate in play
    double min_facing = 1e-2;     // a triangle at a smaller sine to the light counts as edge-on and covers nothing
    double depth_margin = 4e-4;   // in comparisons of depths, as a fraction of the coordinates there
};

class DynamicMask {
 public:
    struct Unit;
    struct Print;
    struct Block;

    /// Whether dynamic objects lie between a point and a light; `not_drawn`: too few points were in the block.
    using Answer = MaskAnswer;

    /// @param triangles  the static geometry; kept by reference, so that later queries see its present content
    DynamicMask(const scene::SceneState& state, const ray::RayScene& rays, const StaticTriangles& triangles,
                const MaskOptions& options);
    ~DynamicMask();

    /// Follows one advance() of the state, after the ray scene did. (After a promotion, what is known of static objects
    /// remains true, because there are only fewer of them.)
    void begin_frame(const scene::SceneState& state, const ray::RayScene& rays, const CullingView& view);

    /// Queries about one light and their answers, by query. One per thread; reused.
    struct Asked {
        std::size_t count = 0;
        std::vector<std::uint32_t> point;   // index of the point
        std::vector<std::uint8_t> moving;   // 1: the point is on a dynamic object, so static geometry is tested as well
        std::vector<Answer> answer;         // never maybe_self
        std::vector<std::uint8_t> clear;    // of those with `moving`: 1 where certainly nothing static occludes; else 0

        /// Removes all queries and makes room for `room` of them.
        void clear_questions(std::size_t room)
        {
            count = 0;
            if (point.size() < room) point.resize(room), moving.resize(room);
        }

     private:
        friend class DynamicMask;
        Texels texels;
        struct Run {
            std::uint32_t first, block;   // query; index into `key`
        };
        std::vector<Run> runs;                   // of consecutive queries in one block
        std::vector<BlockKey> key;               // of blocks
        std::vector<std::uint32_t> asks, rays;   // by block: points, and the rays that they would need
        std::vector<Block*> drawn;
    };
    /// Thread-safe.
    void answer(std::uint32_t light, std::span<const ShadowPoint> points, Asked& asked);

    std::size_t bytes() const;

 private:
    struct LightMask;

    void add_unit(scene::ObjectId object);
    void measure(Unit& unit) const;
    LightMask& prepared(std::uint32_t light);
    void place_prints(LightMask& mask, std::uint32_t light);
    void forget_static_unless(LightMask& mask, const LightSpace& space, float coordinate) const;
    void fill_bins(LightMask& mask) const;
    Block* block_at(LightMask& mask, BlockKey key, std::uint32_t rays);
    void find_prints(const LightMask& mask, Block& block) const;
    void draw(LightMask& mask, Block& block);
    void find_outline(LightMask& mask, Print& print);
    float static_begins(LightMask& mask, Block& block) const;
    bool rises(const Print& print, const ShadowPoint& point) const;

    const scene::SceneState* state_;
    const ray::RayScene* rays_;
    MaskOptions options_;
    CullingView view_;
    const StaticTriangles& triangles_;
    std::uint32_t frame_ = 1;
    std::vector<std::unique_ptr<Unit>> units_;   // by SceneState::dynamic_index()
    std::vector<std::unique_ptr<LightMask>> lights_;
};

}   // namespace gnomon::shadow_culling
