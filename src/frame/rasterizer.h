// SPDX-License-Identifier: Apache-2.0
#pragma once
// The rasterised frame as the renderer sees it: without a Vulkan type, and there whether Vulkan is built in or not.

#include <memory>
#include <string>

#include "base/tasks.h"
#include "gnomon/renderer.h"
#include "irradiance_cache/irradiance_cache.h"
#include "light_quadtree/map_light.h"
#include "trace/traced_frame.h"

namespace gnomon::frame {

struct RasterSettings {
    int samples = 1;
    bool layers = false;
    ShadowTextures shadows = ShadowTextures::coherent;
    float shadow_filter = 1;   // texels; 0: hard
    bool redrawn = false;      // paint_redrawn() will be called
    /// While the time stays, paint_redrawn() shows what was drawn for it: who looks at one moment in several images,
    /// finer each time, sees it in the last, too.
    bool redrawn_stays = false;
    Indirect indirect = Indirect::off;
    light_quadtree::MapLightOptions map{};   // of Indirect::rsm, quadtree
    irradiance_cache::CacheOptions visible{};
    IndirectOn indirect_on = IndirectOn::automatic;
    // Of Indirect::visible: follows the state before every update() and render(); both outlive the rasterizer.
    const ray::RayScene* rays = nullptr;
    Tasks* tasks = nullptr;
};

class Rasterizer {
 public:
    virtual ~Rasterizer() = default;

    /// Follows one advance() of the state it was made from.
    virtual void update(const scene::SceneState& state) = 0;
    /// @throws MissingError      too little device memory, or the device was lost; this rasterizer is then of no more
    /// use
    /// @throws InterruptedError  progress returned false; likewise
    virtual FrameCounters render(const scene::SceneState& state, const scene::View& view, shading::FrameBuffers& out,
                                 const Progress& progress) = 0;
    /// Overlay::redrawn, over the last frame's colour; its light becomes what is shown, within 0 to 1.
    virtual void paint_redrawn(double exposure, ImageF& color) const = 0;
    virtual std::string device() const = 0;
    /// Held in the host's memory from frame to frame, of bounced light.
    virtual std::size_t remembered_bytes() const { return 0; }
};

/// @throws MissingError  built without Vulkan, no suitable device, or too little memory for the scene
std::unique_ptr<Rasterizer> make_rasterizer(const scene::SceneState& state, const RasterSettings& settings);

}   // namespace gnomon::frame
