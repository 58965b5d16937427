// SPDX-License-Identifier: Apache-2.0
#pragma once
// Adaptive samples of the traced frame.
//
// 1. Each pixel has a sample at its centre, all of whose light is computed.
// 2. Pixels in which something ends (shading/centre_samples.h) get 4 more samples, and those whose samples then differ
//    by more than a bound get 16. The positions are the same in all pixels (scene::refined_offset()).
// 3. A filter makes the pixels of all samples (image/pixel_filter.h).
//
// A further sample costs a camera ray and its surface. Where the pixels around it that show the same surface agree in
// their light, it takes its light from them, at its own reflectance; so edges of objects need no shadow rays and no
// indirect light. Elsewhere, at edges of shadows and in highlights, its light is computed as that of any other.
//
// Each step reads what the step before made of the whole image, so that the image depends neither on the order of tiles
// nor on threads. Memory: CentreSamples, and SampleSums, 84 and 23 bytes a pixel without layers.

#include <array>
#include <vector>

#include "image/pixel_filter.h"
#include "scene/view.h"
#include "shading/centre_samples.h"
#include "shading/frame_buffers.h"

namespace gnomon::trace {

class LobeImage;
struct TracedOptions;

/// What a frame's further samples are made from, and where they go.
struct Refinement {
    const shading::CentreSamples& centres;
    const shading::FrameBuffers& single;   // of one sample a pixel
    const LobeImage* lobes;                // filtered; null: no surface has any
    shading::RefineOptions options;
    std::array<image::SampleWeights, scene::k_refined_samples + 1> weights;   // of the centre, and by further sample
    image::SampleSums& sums;
};

/// The layers of a frame that are averaged over the samples of a pixel.
std::vector<ImageF*> averaged_layers(shading::FrameBuffers& buffers, const TracedOptions& options);
std::vector<const ImageF*> averaged_layers(const shading::FrameBuffers& buffers, const TracedOptions& options);

/// One of the samples beyond the first of a pixel.
struct FurtherSample {
    std::uint32_t pixel;    // of the tile
    std::uint32_t number;   // scene::refined_offset()
};

}   // namespace gnomon::trace
