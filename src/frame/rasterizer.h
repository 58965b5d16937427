// SPDX-License-Identifier: Apache-2.0
#pragma once
// Interface of the rasterised frame, without Vulkan types: it exists whether the program is built with Vulkan or not.

#include <memory>
#include <optional>
#include <string>

#include "base/tasks.h"
#include "gnomon/renderer.h"
#include "irradiance_cache/irradiance_cache.h"
#include "light_quadtree/map_light.h"
#include "scene/view.h"
#include "shading/frame_buffers.h"
#include "trace/environment_lighting.h"

namespace gnomon::frame {

struct RasterSettings {
    int samples = 1;
    bool layers = false;
    ShadowTextures shadows = ShadowTextures::items;
    bool as_printed = false;       // as RenderOptions::as_printed
    float shadow_filter = 1;       // texels; 0: hard
    bool backdrop_apart = false;   // fill FrameBuffers::alpha: see trace::TracedOptions
    bool redrawn = false;          // paint_redrawn() will be called
    /// While the time stays the same, paint_redrawn() shows what was drawn for its first frame. So the last of several
    /// images of one moment, each finer than the one before, still shows it.
    bool redrawn_stays = false;
    Indirect indirect = Indirect::off;
    light_quadtree::MapLightOptions map{};   // for Indirect::rsm and quadtree
    irradiance_cache::CacheOptions visible{};
    IndirectOn indirect_on = IndirectOn::automatic;
    /// Environment images, and suns with a size, light as in traced frames: use_environment() will be called.
    bool image_apart = false, suns_apart = false;
    // For Indirect::visible, for environments, and to prove what is visible of lights with size (else it is found from
    // light views). The ray scene must follow the state before every update(); both outlive the rasterizer.
    const ray::RayScene* rays = nullptr;
    Tasks* tasks = nullptr;
};

/// Whether rasterised frames of a scene find the light of its environment image as traced frames do: unless they have
/// no shadows.
bool raster_has_image_apart(const scene::Scene& scene, const RenderOptions& options);
/// The same of its directional lights, which then have a size.
bool raster_has_suns_apart(const scene::Scene& scene, const RenderOptions& options);
/// Whether a rasterizer of a scene needs a ray scene: it lights by its surroundings, proves what is visible of lights
/// with size, or finds what surfaces that thin light let through.
bool raster_needs_rays(const scene::Scene& scene, const RenderOptions& options);

/// Adaptive samples (raster/edge_samples.h).
struct RasterAdaptive {
    PixelFilter filter = PixelFilter::blackman_harris;
    std::optional<float> exposure;   // none: that of the image
};

class Rasterizer {
 public:
    virtual ~Rasterizer() = default;

    /// Follows one advance() of the state it was made from.
    virtual void update(const scene::SceneState& state) = 0;
    /// Before every render(), with RasterSettings::image_apart or suns_apart.
    /// @param technique  must outlive that frame
    virtual void use_environment(trace::EnvironmentTechnique& technique) = 0;
    /// After an exception the rasterizer must not be used again.
    /// @throws MissingError      too little device memory, or the device was lost
    /// @throws InterruptedError  progress returned false
    /// @param adaptive  optional: samples where something ends, beside one of each pixel
    virtual FrameCounters render(const scene::SceneState& state, const scene::View& view, shading::FrameBuffers& out,
                                 const Progress& progress, const RasterAdaptive* adaptive = nullptr) = 0;
    /// Paints Overlay::redrawn over the last frame's colour, which becomes the shown image, within 0 to 1.
    virtual void paint_redrawn(double exposure, ImageF& color) const = 0;
    virtual std::string device() const = 0;
    /// Bytes of host memory that the irradiance cache and proofs hold.
    virtual std::size_t remembered_bytes() const { return 0; }
};

/// @throws MissingError  built without Vulkan, no suitable device, or too little memory for the scene
std::unique_ptr<Rasterizer> make_rasterizer(const scene::SceneState& state, const RasterSettings& settings);

}   // namespace gnomon::frame
