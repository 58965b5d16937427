// SPDX-License-Identifier: Apache-2.0
#pragma once
// Interface of the rasterised frame, without Vulkan types: it exists whether the program is built with Vulkan or not.

#include <memory>
#include <string>

#include "base/tasks.h"
#include "gnomon/renderer.h"
#include "irradiance_cache/irradiance_cache.h"
#include "light_quadtree/map_light.h"
#include "scene/view.h"
#include "shading/frame_buffers.h"

namespace gnomon::frame {

struct RasterSettings {
    int samples = 1;
    bool layers = false;
    bool backdrop_apart = false;   // as RasterOptions::backdrop_apart
    ShadowTextures shadows = ShadowTextures::items;
    bool as_printed = false;   // as RenderOptions::as_printed
    float shadow_filter = 1;   // texels; 0: hard
    bool redrawn = false;      // paint_redrawn() will be called
    /// While the time stays the same, paint_redrawn() shows what was drawn for its first frame. So the last of several
    /// images of one moment, each finer than the one before, still shows it.
    bool redrawn_stays = false;
    Indirect indirect = Indirect::off;
    light_quadtree::MapLightOptions map{};   // for Indirect::rsm and quadtree
    irradiance_cache::CacheOptions visible{};
    IndirectOn indirect_on = IndirectOn::automatic;
    // For Indirect::visible, and to prove what is visible of lights with size (else it is found from light views). The
    // ray scene must follow the state before every update(); both outlive the rasterizer.
    const ray::RayScene* rays = nullptr;
    Tasks* tasks = nullptr;
};

/// Whether a rasterizer of a scene proves what is visible of lights with size, for which it needs a ray scene.
bool raster_needs_rays(const scene::Scene& scene, ShadowTextures shadows);

class Rasterizer {
 public:
    virtual ~Rasterizer() = default;

    /// Follows one advance() of the state it was made from.
    virtual void update(const scene::SceneState& state) = 0;
    /// After an exception the rasterizer must not be used again.
    /// @throws MissingError      too little device memory, or the device was lost
    /// @throws InterruptedError  progress returned false
    virtual FrameCounters render(const scene::SceneState& state, const scene::View& view, shading::FrameBuffers& out,
                                 const Progress& progress) = 0;
    /// Paints Overlay::redrawn over the last frame's colour, which becomes the shown image, within 0 to 1.
    virtual void paint_redrawn(double exposure, ImageF& color) const = 0;
    virtual std::string device() const = 0;
    /// Bytes of host memory that the irradiance cache and proofs hold.
    virtual std::size_t remembered_bytes() const { return 0; }
};

/// @throws MissingError  built without Vulkan, no suitable device, or too little memory for the scene
std::unique_ptr<Rasterizer> make_rasterizer(const scene::SceneState& state, const RasterSettings& settings);

}   // namespace gnomon::frame
