// SPDX-License-Identifier: Apache-2.0
#pragma once
// The layers of a frame, as the traced and the rasterised frame fill them.

#include "base/image.h"
#include "gnomon/frame_times.h"

namespace gnomon::shading {

/// Linear, averaged over samples; depth and normal are the first sample's.
struct FrameBuffers {
    ImageF color;      // 3
    ImageF depth;      // 1: along the view's forward axis; 0 where nothing was hit
    ImageF normal;     // 3: shading normal in world space
    ImageF albedo;     // 3
    ImageF direct;     // 3: what lights add at primary hits; with a reference also the surroundings
    ImageF indirect;   // 3: what bounced light adds there
    ImageF shadow;     // one channel a light: 1 lit, 0 in shadow or unlit, at primary hits
    // With a reference alone, layers or not, 3 each.
    ImageF variance;              // of color
    ImageF irradiance;            // by bounces, at primary hits of surfaces that scatter light
    ImageF irradiance_variance;   // of that
    FrameTimes times;             // of the frame; stages `scene` and `image` are not its own
};

}   // namespace gnomon::shading
