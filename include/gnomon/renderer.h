// SPDX-License-Identifier: Apache-2.0
#pragma once
// Renders frames of a scene.

#include <memory>
#include <optional>
#include <string>

#include "gnomon/frame.h"
#include "gnomon/scene.h"
#include "gnomon/types.h"

namespace gnomon {

/// Path-traced indirect light: slow, and right on average; how far off it is, is estimated. Everything else of the
/// image is as without it: the same rays through the same places of a pixel, so `samples` smooths edges here too.
struct ReferenceLightOptions {
    int spp = 1024;    // paths per pixel
    int bounces = 1;   // diffuse bounces; 1: direct light and one bounce
    std::uint64_t seed = 0;
};

/// What makes the image: rays on the processor, or the rasteriser on a Vulkan device, which shows mirrors without
/// their images and glass without refraction. Its bounced light runs on the device, too; for that of Indirect::visible,
/// which lights the surfaces that the device shows from remembered points, RenderOptions::indirect_on says who cuts,
/// traces and sums.
enum class RenderMethod { trace, raster };

/// Shadows of the rasterised frame. `coherent` draws again only what changed; `depth` and `per_caster` are the methods
/// it is measured against: the same image, at their cost.
enum class ShadowTextures { off, per_caster, depth, coherent };

/// gnomon/ranges.h has the ranges of numbers.
struct RenderOptions {
    Size size{};                    // 0 x 0: the file's own, else 1280 x 720
    std::string camera = "auto";    // a name, a number from 0, or auto: the first
    double turntable_seconds = 0;   // the camera circles the scene in that time instead; 0: not
    RenderMethod renderer = RenderMethod::trace;
    int max_depth = 10;                 // reflections and refractions in a row
    int samples = 1;                    // per pixel
    std::optional<double> exposure{};   // stops; none: automatic, from this frame alone
    ToneMap tonemap = ToneMap::neutral;
    ShadowCulling shadow_culling = ShadowCulling::certified;
    Indirect indirect = Indirect::visible;
    ShadowTextures shadow_textures = ShadowTextures::coherent;   // of the rasterised frame
    int shadow_filter = 1;   // width of the edges of its shadows, in texels of the light's view; 0: hard
    std::optional<ReferenceLightOptions> reference{};   // instead of `indirect`
    int rsm_samples = 256;                              // Indirect::rsm
    int indirect_level = 5;                             // Indirect::quadtree: where refinement ends; 6 (coarse), 5 or 4
    double depth_threshold = 0.05;   // Indirect::quadtree: parts that differ more are not one cluster; fraction of the
                                     // light view's depth range
    double normal_threshold = 0.9;   // Indirect::quadtree: nor those whose normals' cosine is not above this
    bool indirect_at_every_pixel =
        false;                  // Indirect::rsm, quadtree: else at 64 a side, interpolated where that is fair
    int indirect_memory = 16;   // Indirect::visible: MB of remembered points; changes time, not images
    IndirectOn indirect_on = IndirectOn::automatic;
    Accelerator accelerator = Accelerator::embree;
    int threads = 0;       // 0: all
    bool layers = false;   // also fill depth, normal, albedo, direct, indirect, shadow; more of a reference
    /// Instead of the scene's light; the image is then larger than `size`, see image_size, and has no other layers.
    Overlay overlay = Overlay::none;
    std::optional<int> overlay_light{};   // from 0; none: all lights, a panel each
};

/// Keeps what stands still from frame to frame. The image of a frame does not depend on the number of threads, nor on
/// the frames before it, except with ShadowCulling::paper, whose memory is its history, and with an overlay, which
/// shows the memory. Not thread-safe: one renderer a thread. One that was moved from can be assigned to or destroyed;
/// all else throws UsageError.
class Renderer {
 public:
    /// @throws UsageError for options out of range
    explicit Renderer(RenderOptions options = {});
    ~Renderer();
    Renderer(Renderer&&) noexcept;
    Renderer& operator=(Renderer&&) noexcept;

    /// @param frame  1 to scene.frame_count()
    /// @throws UsageError  for a frame or camera that does not exist
    /// @throws MissingError  RenderMethod::raster without a suitable Vulkan device or memory, or the device was lost
    Frame render(const Scene& scene, int frame, const Progress& progress = {});

    const RenderOptions& options() const;
    /// The Vulkan device of the last frame; empty without.
    std::string device() const;

 private:
    struct Impl;
    Impl& inside() const;
    std::unique_ptr<Impl> impl_;
};

/// The size a scene is rendered at when none is asked for.
Size default_size(const Scene& scene, const std::string& camera = "auto");

/// The size of the images that a renderer with these options makes.
/// @throws UsageError  no such camera or light; an overlay of a scene without lights, or too large
Size image_size(const Scene& scene, const RenderOptions& options);

}   // namespace gnomon
