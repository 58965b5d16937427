// SPDX-License-Identifier: Apache-2.0
#pragma once
// Adaptive samples of the rasterised frame: clean edges without shading anything twice.
//
// 1. Each pixel is shaded at its centre.
// 2. The surfaces alone are drawn at 16 further places of all pixels (scene::refined_offset()).
// 3. In pixels in which something ends (shading/centre_samples.h), a further sample takes the light of the pixels
//    around it that show its surface, at its own reflectance; near ones count most. Where the background is seen, the
//    sample shows it.
// 4. A filter makes the pixels of all samples (image/pixel_filter.h).
//
// What no pixel around shows at its centre is not found: something thinner than a pixel has gaps. Where a scene has
// transparent surfaces, only the edges of opaque ones are clean, also those that are seen through glass.
//
// Memory on the host: CentreSample and the sums, 137 bytes a pixel without layers.

#include <optional>
#include <vector>

#include "gnomon/types.h"
#include "image/pixel_filter.h"
#include "scene/scene.h"
#include "scene/view.h"
#include "shading/centre_samples.h"
#include "shading/frame_buffers.h"

namespace gnomon::raster {

struct AdaptiveOptions {
    PixelFilter filter = PixelFilter::blackman_harris;
    std::optional<float> exposure;   // none: that of the image
    shading::RefineOptions refine;
};

/// The surfaces of one sample of each pixel, read back: four values a pixel, ids two (GBuffer).
struct DrawnSurfaces {
    std::span<const float> position, normal, diffuse, specular;
    std::span<const std::uint32_t> ids;
    std::span<const float> own;   // background and emitted light; w: how much is seen of what lies behind the scene
};

class EdgeSamples {
 public:
    /// @param out           of one sample a pixel; must outlive this, up to resolve()
    /// @param layers        its layers are averaged, too
    /// @param has_glass     surfaces before the opaque ones may be part of `out`
    /// @param alpha         it has alpha
    EdgeSamples(const scene::Scene& scene, const scene::View& view, const shading::FrameBuffers& out, bool layers,
                bool has_glass, bool alpha, const AdaptiveOptions& options);

    /// Takes the surfaces at the pixels' centres.
    void set_centres(const DrawnSurfaces& drawn);
    /// Takes those at scene::refined_offset(number), after the centres.
    void add(int number, const DrawnSurfaces& drawn);
    /// Writes the filtered image, after scene::k_refined_samples samples.
    void resolve(shading::FrameBuffers& out) const;
    /// Pixels with more than one sample.
    std::uint64_t refined() const { return refined_; }

 private:
    shading::CentreSample surface_at(const DrawnSurfaces& drawn, std::size_t pixel) const;
    void values_at(int x, int y, float* values) const;
    bool take_light(int x, int y, const glm::vec2& offset, const shading::CentreSample& own, float* values) const;
    void add_values(int x, int y, const image::SampleWeights& weights, float share, const float* values);

    const scene::Scene& scene_;
    const scene::View& view_;
    const shading::FrameBuffers& single_;
    bool has_glass_;
    AdaptiveOptions options_;
    std::vector<const ImageF*> layers_;                            // of `single_`: colour, then those below
    int alpha_ = -1, direct_ = -1, indirect_ = -1, albedo_ = -1;   // their first channels; -1: absent
    shading::CentreSamples centres_;
    std::vector<char> selected_;   // by pixel
    std::uint64_t refined_ = 0;
    image::SampleSums sums_;
};

}   // namespace gnomon::raster
