// SPDX-License-Identifier: Apache-2.0
#pragma once
// The G-buffer of the rasterised frame, and the interfaces through which shadows and indirect light enter it.

#include <span>

#include "gnomon/types.h"
#include "gpu_scene/gpu_scene.h"
#include "scene/state.h"
#include "scene/view.h"
#include "vk/commands.h"

namespace gnomon::raster {

/// One layer of surfaces, of the image's size. Images are sampled (texelFetch) or read as storage images; the format
/// is four 32-bit floats except for the ids.
struct GBuffer {
    vk::Image position;    // xyz: in the world; w: depth along the view's forward axis, 0 where there is no surface
    vk::Image normal;      // xyz: shading normal, unit, on the viewer's side; w: roughness, or Phong's exponent
    vk::Image geometric;   // xyz: geometric normal, likewise; w: coverage
    vk::Image smooth;     // xyz: normal of the smooth horizon (ray/smooth_surface.h), likewise; w: height of the smooth
                          // surface above the triangle, along it
    vk::Image diffuse;    // xyz: reflectance; w: shading model (GNOMON_MODEL_...)
    vk::Image specular;   // xyz: mirror reflectance at normal incidence
    vk::Image ids;        // two 32-bit: object + 1 (0: nothing), triangle in the object's mesh
    bool kept = false;    // the surfaces are those of the last frame
};

/// Shadows. Called once for every batch of lights and every layer of surfaces (transparent surfaces come first, nearest
/// first; in later layers, a pixel that needs no more surfaces has no object).
class LightVisibility {
 public:
    virtual ~LightVisibility() = default;

    /// Follows one advance() of the state; called once a frame, before any fill.
    /// @param planes  of the view, pointing inwards: no surface outside of them will be filled
    virtual void update(vk::Commands& commands, const scene::SceneState& state,
                        std::span<const glm::vec4, 6> planes) = 0;

    /// Records the passes that fill layers 0 ... count - 1 of an array image (8-bit, one channel) with the visibility
    /// of lights first ... first + count - 1 at `surfaces`: 1 is lit, 0 in shadow, between at filtered edges. Surfaces
    /// that face away from a light may have any value. The image may be a colour target or a storage image, and its
    /// former content is not used.
    virtual void fill(vk::Commands& commands, const GBuffer& surfaces, std::uint32_t first, std::uint32_t count,
                      const vk::Image& visibility) = 0;

    /// After the last fill of a frame, before its last submit: records what count() reads.
    virtual void end_frame(vk::Commands&) {}
    /// After that submit: adds the frame's draws, and other counts.
    virtual void count(FrameCounters&) const {}
};

/// Light that arrives by one bounce. Called once for every layer of surfaces.
class BouncedLight {
 public:
    virtual ~BouncedLight() = default;

    /// Called once a frame, before any fill and before the view's draws are culled.
    virtual void update(vk::Commands& commands, const gpu_scene::GpuScene& scene, const scene::SceneState& state) = 0;

    /// Fills an image (four 32-bit floats; xyz: irradiance) at all surfaces of a layer that scatter light. May submit.
    virtual void fill(vk::Commands& commands, const GBuffer& surfaces, const scene::View& view,
                      const vk::Image& irradiance) = 0;

    /// The irradiance has light of more than one bounce, so that nothing must stand in for it.
    virtual bool has_further_bounces() const { return false; }

    /// After the last fill of a frame.
    virtual FrameCounters::Indirect end_frame() = 0;
};

/// Direct light that the host finds: of environment images, and of directional lights that have a size. Called once for
/// every layer of surfaces.
class SurroundingLight {
 public:
    virtual ~SurroundingLight() = default;

    /// Called once a frame, before any fill.
    virtual void begin_frame(const scene::SceneState& state, const scene::View& view) = 0;
    /// Whether it brings a light of the scene, or what that light approximates: nothing else must add it.
    virtual bool brings(scene::LightId light) const = 0;
    /// Whether it lights by an environment image.
    virtual bool has_image() const = 0;
    /// The irradiance by the image of a surface with this unit normal that sees everything above it.
    /// @pre has_image()
    virtual glm::vec3 open_irradiance(const glm::vec3& normal) const = 0;

    /// Fills an image (four 32-bit floats; xyz: radiance towards the viewer, coverage included) at all surfaces of a
    /// layer. May submit.
    virtual void fill(vk::Commands& commands, const GBuffer& surfaces, const scene::View& view,
                      const vk::Image& radiance) = 0;
    /// By pixel of the last layer that was filled: the visible share of a directional light with a size. Empty for
    /// others.
    virtual std::span<const float> visible(scene::LightId light) const = 0;

    /// After the last fill of a frame: adds its rays.
    virtual void end_frame(FrameCounters& counters) = 0;
};

}   // namespace gnomon::raster
