// SPDX-License-Identifier: Apache-2.0
#pragma once
// Adaptive samples of the traced frame.
//
// 1. Each pixel has a sample at its centre, all of whose light is computed.
// 2. Pixels in which something ends (shading/centre_samples.h) get 4 more samples. A pixel whose samples then differ by
//    more than a bound gets 12 more. The positions are the same in all pixels (scene::refined_offset()).
// 3. Where a further sample finds a surface that no pixel around has at its centre, such as a thin wire, step 2 goes on
//    with the pixels around that have one sample yet, for some rounds.
// 4. A pixel of one sample that shows a texture which changes from pixel to pixel has further samples without rays: the
//    texture at other places of the triangle's plane, in light that is taken from the pixels around.
// 5. A filter makes the pixels of all samples (image/pixel_filter.h).
//
// A further sample costs a camera ray and its surface. Where the pixels around it that show the same surface agree in
// their light, it takes its light from them, at its own reflectance; so edges of objects need no shadow rays and no
// indirect light. Elsewhere, at edges of shadows and in highlights, the light of the first 4 is computed as that of any
// other, but for bounced light that agrees between the nearest pixels that show the surface or, in mirror images and
// where none shows it, between the nearest places that earlier samples met (bounced_places.h). The last 12 say how much
// of the pixel each surface covers, and take their light from the samples near them; where all show one surface, they
// do so if the nearest agree.
//
// Each step reads what the step before made of the whole image, so that the image depends neither on the order of tiles
// nor on threads. Memory: CentreSamples, and SampleSums, 92 and 23 bytes a pixel without layers.

#include <array>
#include <vector>

#include "base/tasks.h"
#include "image/pixel_filter.h"
#include "scene/view.h"
#include "shading/centre_samples.h"
#include "shading/frame_buffers.h"
#include "trace/point_batch.h"

namespace gnomon::trace {

class LobeImage;
struct TracedOptions;

/// What a frame's further samples are made from, and where they go.
struct Refinement {
    const shading::CentreSamples& centres;
    const shading::FrameBuffers& single;   // of one sample a pixel
    std::vector<const ImageF*> layers;     // its layers that are averaged over samples
    const LobeImage* lobes;                // filtered; null: no surface has any
    shading::RefineOptions options;
    std::array<image::SampleWeights, scene::k_refined_samples + 1> weights;   // of the centre, and by further sample
    image::SampleWeights lone;                                                // of a pixel's only sample
    image::SampleSums& sums;
};

/// How far the pixels of an image are refined.
class RefinedPixels {
 public:
    static constexpr int k_rounds = 4;   // of step 2

    explicit RefinedPixels(Size size) : state_(size.width, size.height, 1) {}
    /// Selects the pixels of the first round.
    void select(const Refinement& refinement, Tasks& tasks);
    /// Selects those of the next round.
    /// @return false: there are none
    bool select_next(Tasks& tasks);
    /// Takes note of a selected pixel's samples. Tasks may do so at once for different pixels.
    /// @param found  a surface that no pixel around it has at its centre
    void set_refined(const glm::ivec2& at, bool found) { *state_.pixel(at.x, at.y) = found ? k_found : k_refined; }

    /// A pixel that is made otherwise: it takes no part.
    void leave_out(int x, int y) { *state_.pixel(x, y) = k_left_out; }

    /// Whether it has pixels for the next round.
    bool any_selected(const Tile& tile) const;
    bool selected(int x, int y) const { return *state_.pixel(x, y) == k_selected; }
    /// It has one sample, or is selected for a round that was not made.
    bool single(int x, int y) const { return *state_.pixel(x, y) <= k_selected; }

 private:
    // A pixel that found a surface becomes a refined one when it has selected its neighbours.
    static constexpr std::uint8_t k_single = 0, k_selected = 1, k_found = 2, k_refined = 3, k_left_out = 4;
    Image8 state_;
};

/// The layers of a frame that are averaged over the samples of a pixel.
std::vector<ImageF*> averaged_layers(shading::FrameBuffers& buffers, const TracedOptions& options);
std::vector<const ImageF*> averaged_layers(const shading::FrameBuffers& buffers, const TracedOptions& options);

/// One of the samples beyond the first of a pixel.
struct FurtherSample {
    std::uint32_t pixel;     // of the tile
    std::uint32_t number;    // scene::refined_offset()
    std::uint32_t refined;   // number of the pixel among the refined ones of the tile
};

}   // namespace gnomon::trace
