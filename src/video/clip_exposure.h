// SPDX-License-Identifier: Apache-2.0
#pragma once
// The exposure of a whole clip.
//
// An exposure that follows each frame makes a video brighter and darker where bright parts enter and leave the image.
// This one is computed once: from the pixels of small frames, spread evenly over the clip, as the exposure of a single
// image is from its own. It depends on the scene and the options alone, so each chunk and each range of frames computes
// the same.
//
// Cost: k_exposure_frames frames of at most k_exposure_side pixels a side, with one sample each.

#include "gnomon/renderer.h"
#include "gnomon/types.h"

namespace gnomon::video {

inline constexpr int k_exposure_frames = 8;   // or all of a shorter clip
inline constexpr int k_exposure_side = 128;   // pixels of the longer side

/// The frames that the exposure is computed from: each in the middle of its part of the clip.
std::vector<int> exposure_frames(int frame_count);

/// Stops. What the renderer remembers of the scene is used and stays; its options are the same afterwards.
/// @throws what Renderer::render throws
double clip_exposure(const Scene& scene, Renderer& renderer, const Progress& progress = {});

}   // namespace gnomon::video
