// SPDX-License-Identifier: Apache-2.0
#pragma once
// What a host can ask about the last frame: what is seen at a pixel, and what changed.

#include <cstdint>
#include <vector>

#include "gnomon/ids.h"
#include "gnomon/math.h"
#include "gnomon/types.h"

namespace gnomon {

/// What the last frame shows at the centre of one pixel.
struct Pick {
    bool hit = false;   // false: nothing, and the rest is undefined
    InstanceId instance;
    MaterialId material;
    std::uint32_t triangle = 0;   // of the object's mesh, from 0
    Vec3 position;                // on the surface, in world space
    Vec3 normal;                  // shading normal in world space, unit, on the camera's side
    float depth = 0;              // metres along the camera's axis, as in the layer "depth"
};

/// What the last frame changed against the one before it; ids ascend.
struct FrameReport {
    /// The renderer began anew for this frame (FrameCounters::update), or the last one failed. Everything is new then:
    /// the lists of parts are empty, and `rectangles` holds the whole image.
    bool everything = true;
    std::vector<InstanceId> instances;   // moved, deformed, appeared, vanished or added; not removed, which have no id
    std::vector<LightId> lights;         // position, direction, visibility or values differ
    std::vector<MaterialId> materials;   // values differ
    /// Disjoint rectangles that contain all pixels whose linear colour differs from the last frame's, by any bit. Only
    /// with RenderOptions::report_changes, and empty for overlays. An automatic exposure may differ and so change how
    /// the other pixels are shown, too.
    std::vector<PixelRectangle> rectangles;
};

}   // namespace gnomon
