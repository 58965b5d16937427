// SPDX-License-Identifier: Apache-2.0
#pragma once
// Measures the visible fraction of lights with size in the rasterised frame against the traced one, and what a frame
// costs: with proven shares (raster/proven_shares.h), with light views from several places (raster/sized_direct.h), and
// with percentage-closer soft shadows. Times are those of one thread and the device.
//
// The visible fraction of a pixel is its direct light over its unshadowed direct light. Pixels whose unshadowed light
// is below a hundredth of the image's mean are left out, as are those in which both frames see different surfaces.

#include <memory>
#include <string>
#include <vector>

#include "base/image.h"
#include "gnomon/types.h"
#include "scene/scene.h"

namespace gnomon::bench {

struct RasterLightsRow {
    std::string method;
    double rmse = 0, max_abs = 0;   // of the visible fraction
    double darkest = 0;             // pixels that are dark in the traced frame
    double leaks = 0;               // those of them that see more than a tenth of the light
    double ms_first = 0;            // the first frame: all views are drawn
    double ms_view = 0;             // the camera moved: surfaces and light are computed anew
    double ms_still = 0;            // nothing changed
    ImageF direct;                  // linear
    ImageF difference;              // one channel: what the rasterised frame sees more than the traced one; else 0
};

struct RasterLightsResult {
    std::string device;   // empty: there is none, and nothing was measured
    std::string clock;    // what ms are
    double pixels = 0;
    ImageF traced;   // direct light, linear
    std::vector<RasterLightsRow> rows;
};

/// @param scene   its only lights are those with size
/// @param others  also measure the two other ways
RasterLightsResult compare_raster_lights(const std::shared_ptr<const scene::Scene>& scene, int frame, Size size,
                                         scene::CameraId camera, bool others = true);

}   // namespace gnomon::bench
