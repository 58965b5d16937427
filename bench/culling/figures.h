// SPDX-License-Identifier: Apache-2.0
#pragma once
// Figures 5 and 6 of [Nah 2009] as images: the fault after a zoom-in, and the scenes that are measured.

#include "bench/report/page.h"
#include "gnomon/scene.h"
#include "gnomon/types.h"

namespace gnomon::bench {

/// Figure 5. A camera stands before a floor with thin posts whose shadows are smaller than a pixel, and moves in.
struct ZoomFigure {
    Image8 before;         // the published method: no shadow is seen, so none is remembered
    Image8 zoomed;         // the frame of the zoom, by what was remembered
    Image8 zoomed_right;   // the same frame with every ray traced
    Image8 after;          // the next frame: the modes that the zoom reset were learned again
    std::uint64_t wrong_zoomed = 0, wrong_after = 0;   // pixels that differ from tracing every ray
};
ZoomFigure zoom_figure(Size size);

/// Figure 6. One frame of a scene, in direct light.
Image8 scene_figure(const Scene& scene, double time, Size size);

}   // namespace gnomon::bench
