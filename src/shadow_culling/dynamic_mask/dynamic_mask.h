// SPDX-License-Identifier: Apache-2.0
#pragma once
// What the dynamic objects can shadow this frame, seen from a light: an image of them on the light's plane that answers
// most points without a ray.
//
// Each object that moves is a surface whose projection has an outline: the edges where it folds over as seen from the
// light, and those it ends at. Where no outline passes, the number of its layers is the same all over [the argument of
// certify_full, turned round]; so only outlines are drawn, widened by the margin of rounding, and layers are counted
// along the rows. A texel then knows, of everything over it (MaskTexels, texels.h), which object begins first and which
// next, and one that covers all of it. A point deeper than that one ends is in shadow; one nearer than all that begins
// over it is free of dynamic objects. A point on a dynamic object is over itself: where its triangle sees all of its
// object below its plane, it counts from the next one on.
//
// For points on dynamic objects the static scene is asked, too: of every block the least depth at which anything static
// begins is kept while the light stands still. A nearer point is clear of it.
//
// Drawn in blocks of texels about a pixel wide, where that is cheaper than the rays it may spare: by the edges of
// the dynamic objects there, and by who asks now and asked in the frame before. Kept while nothing moves. What a block
// holds, and whether it is asked, does not depend on threads, nor do counts.
//
// Cost a frame: for each light asked, a box for every dynamic object, the outlines of those in the blocks asked, and
// the blocks.

#include <atomic>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "shadow_culling/certified/static_triangles.h"
#include "shadow_culling/dynamic_mask/dynamic_shapes.h"
#include "shadow_culling/dynamic_mask/light_space.h"
#include "shadow_culling/dynamic_mask/texels.h"

namespace gnomon::shadow_culling {

struct MaskOptions {
    float texel_pixels = 2;     // width of a texel, in the pixels of the view
    std::uint32_t asked = 24;   // points of a batch that make a block worth a look
    double edges_per_ray =
        3;                  // of the dynamic objects in a block, for every ray it may spare, up to which it is drawn
    double margin = 8e-6;   // rays stray less than this, as a fraction of the largest coordinate in play
    double min_facing = 1e-2;     // sine under which a triangle counts as edge-on: it covers nothing
    double depth_margin = 4e-4;   // between a point and what it is compared to, as a fraction of the coordinates there
};

class DynamicMask {
 public:
    struct Unit;
    struct Print;
    struct Block;

    /// What moves, on the way from a point to a light; `not_drawn`: too few points asked there.
    using Answer = MaskAnswer;

    /// @param triangles  what stands still; kept by reference, and asked as it is then
    DynamicMask(const scene::SceneState& state, const ray::RayScene& rays, const StaticTriangles& triangles,
                const MaskOptions& options);
    ~DynamicMask();

    /// Follows one advance() of the state, after the ray scene did. (After a promotion, what is known of static objects
    /// remains true, because there are only fewer of them.)
    void begin_frame(const scene::SceneState& state, const ray::RayScene& rays, const CullingView& view);

    /// Questions about one light, and their answers, by question. A thread's own; reused.
    struct Asked {
        std::size_t count = 0;
        std::vector<std::uint32_t> point;   // asked for
        std::vector<std::uint8_t> moving;   // 1: the point is on something that moves, and asks for the static part too
        std::vector<Answer> answer;         // never maybe_self
        std::vector<std::uint8_t> clear;    // of those: 1 where certainly nothing static is in the way; else 0

        /// No questions, and room for some.
        void clear_questions(std::size_t room)
        {
            count = 0;
            if (point.size() < room) point.resize(room), moving.resize(room);
        }

     private:
        friend class DynamicMask;
        Texels texels;
        struct Run {
            std::uint32_t first, block;   // question; into `key`
        };
        std::vector<Run> runs;                   // of questions about one block
        std::vector<BlockKey> key;               // of blocks
        std::vector<std::uint32_t> asks, rays;   // by block: points, and the rays they would take
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
