// SPDX-License-Identifier: Apache-2.0
#pragma once
// The reference implementation of light views: draws them on the CPU, texel by texel, for tests. It defines the meaning
// of the plan's steps.
//
// Vertices are snapped to 1/256 texel and edges are evaluated in integers, so that a texel on a shared edge belongs to
// exactly one triangle. Depth depends on the triangle's plane only. So a triangle's result at a texel does not depend
// on the clipping rectangle, and redrawing a part gives the same bits as redrawing the whole. Cost: the texels of every
// triangle's bounding rectangle; too slow for interactive use.

#include "light_views/light_views.h"

namespace gnomon::light_views {

using Item = std::uint32_t;   // object + 1; 0: none

/// The two layers of a buffer, rows from y = 0.
struct SoftwareBuffer {
    explicit SoftwareBuffer(int size = 0);
    int size = 0;
    std::vector<float> depth;   // 0: nothing drawn
    std::vector<Item> item;

    std::size_t at(int x, int y) const
    {
        return static_cast<std::size_t>(y) * static_cast<unsigned>(size) + static_cast<unsigned>(x);
    }
    void empty(const Rect& rect);
    void copy(const SoftwareBuffer& from, const Rect& rect);
    friend bool operator==(const SoftwareBuffer&, const SoftwareBuffer&) = default;
};

/// Draws one object where it is nearer than the buffer's contents, or equally near.
/// @param clip     nothing is drawn outside
/// @param statics  optional: where its depth is equal, the higher of both items is written
void draw_object(SoftwareBuffer& buffer, const ViewProjection& view, const scene::SceneState& state,
                 scene::ObjectId object, const Rect& clip, const SoftwareBuffer* statics = nullptr);

/// The static and the rendering buffer of one view.
class SoftwareView {
 public:
    explicit SoftwareView(int size) : rendering_(size), statics_(size) {}
    void execute(const ViewPlan& plan, const ViewProjection& view, const scene::SceneState& state);

    const SoftwareBuffer& rendering() const { return rendering_; }
    const SoftwareBuffer& statics() const { return statics_; }

 private:
    SoftwareBuffer rendering_, statics_;
};

}   // namespace gnomon::light_views
