// SPDX-License-Identifier: Apache-2.0
#pragma once
// The layers of a frame, which the traced and the rasterised frame fill.

#include "base/image.h"
#include "gnomon/frame_times.h"

namespace gnomon::shading {

/// Linear values averaged over samples; depth and normal are those of the first sample.
struct FrameBuffers {
    ImageF color;   // 3 channels
    /// 1: how much of the pixel shows surfaces of the scene, and shadows on the ground. Filled only if the background
    /// is not what the scene's surroundings are; `color` then lacks what is behind.
    ImageF alpha;
    ImageF depth;      // 1: along the view's forward axis; 0 where no surface was hit
    ImageF normal;     // 3: shading normal in world space
    ImageF albedo;     // 3
    ImageF direct;     // 3: direct light at primary hits; with a reference also from the background
    ImageF indirect;   // 3: indirect light there
    ImageF shadow;     // one channel per light: 1 lit, 0 in shadow or unlit, at primary hits
    // Filled by trace/centre_layers.h, each only if it is requested.
    ImageIds ids;    // 2: object + 1, material + 1; 0 where no surface was hit
    ImageF motion;   // 2: since the frame before, in pixels, right and down
    // Filled only with a reference, whether layers are requested or not; 3 channels each.
    ImageF variance;              // of color
    ImageF irradiance;            // indirect, at primary hits of surfaces that scatter light
    ImageF irradiance_variance;   // of `irradiance`
    FrameTimes times;             // of the frame; others fill the stages `scene` and `image`
};

}   // namespace gnomon::shading
