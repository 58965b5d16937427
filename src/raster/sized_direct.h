// SPDX-License-Identifier: Apache-2.0
#pragma once
// Direct light of lights with size in the rasterised frame: in closed form, as in the traced one, times the visible
// share.
//
// The visible share is that of the traced frame for flat lights, if prove() was called (proven_shares.h). For
// clusters, and without, it is found from light views [Heckbert and Herf 1997]: some places on each light have depth
// buffers, which are kept up to date like those of other lights [Oh and Shin 2004]. The share is the sum of the visible
// places' weights over the sum of all places' weights. A look-up is filtered over a few texels, so that the edges of
// the places' shadows meet. The places are the same for every point and frame: there is no noise.
//
// Percentage-closer soft shadows, from one view in the middle of each light, are there for comparison.
//
// Cost: while surfaces, lights and casters rest, one addition per pixel. Otherwise, per pixel and light, the closed
// form and a look-up for each place; the views cost what changed in them. Memory: 16 bytes per texel of the views.

#include "raster/gbuffer.h"
#include "raster/proven_shares.h"
#include "scene/sized_light.h"
#include "shading/polygon_light.h"
#include "shadow_textures/vulkan/lookup_records.h"

namespace gnomon::raster {

struct SizedDirectOptions {
    enum class Method : std::uint8_t { views, percentage_closer, unshadowed };
    Method method = Method::views;
    // Places with a view: of a light at the most, of all lights together, and of a light at the least; powers of two.
    int places = 16, places_in_all = 256, least_places = 4;
    /// Filter and margins of a look-up, in texels.
    shadow_textures::LookupOptions look_up{.filter = 2};
    /// Of faces: half of view_size. A view of several places needs less detail than one of a point.
    light_views::AtlasOptions atlas{.view_size = 1024, .budget_texels = 1 << 25};
    /// Lobes are widened more than in the traced frame, because fewer places cannot resolve sharper ones.
    shading::PolygonLightOptions polygon{.least_roughness = 0.5f};
};

/// The inputs of one layer of surfaces.
struct SizedSurfaces {
    const GBuffer& surfaces;
    const vk::Image& share;   // weight in the image
    const vk::Buffer& frame;
    const scene::View& view;
};

class SizedDirect {
 public:
    /// @throws MissingError  too little device memory
    SizedDirect(const std::shared_ptr<vk::Device>& device, const scene::SceneState& state,
                const SizedDirectOptions& options = {});
    ~SizedDirect();

    /// Proves what is visible of flat lights, from the next update() on.
    /// @param rays  must follow the state before every update(); both outlive this
    void prove(const ray::RayScene& rays, Tasks& tasks) { proofs_ = std::make_unique<ProvenShares>(rays, tasks); }

    /// Follows one advance() of the state. Call once a frame, before add().
    void update(vk::Commands& commands, const scene::SceneState& state);
    /// Whether there is none now.
    bool empty() const { return lights_.empty(); }

    /// Adds the light that a layer of surfaces reflects. May submit.
    /// @param layers  add to the layer of direct light as well
    void add(vk::Commands& commands, const SizedSurfaces& layer, const vk::Image& color, const vk::Image& direct,
             bool layers);

    const scene::SizedLights& lights() const { return lights_; }
    /// Of the places; nullptr where there are no lights.
    const light_views::LightViews* views() const;
    /// Frames for which light was not computed anew, because nothing had changed.
    std::uint64_t kept() const { return kept_; }
    std::uint64_t draws() const;                                           // of the last update
    std::size_t bytes() const { return proofs_ ? proofs_->bytes() : 0; }   // of host memory that proofs hold

 private:
    struct Views;
    void find_places(const scene::SceneState& state);
    void send(vk::Commands& commands);
    void make_pipelines();
    void compute(vk::Commands& commands, const SizedSurfaces& layer);
    void compute_batch(vk::Commands& commands, const SizedSurfaces& layer, std::uint32_t first, std::uint32_t count);

    std::shared_ptr<vk::Device> device_;
    SizedDirectOptions options_;
    scene::SizedLights lights_;
    scene::SizedLights places_;   // the same lights, with the places that have views
    std::uint32_t sent_version_ = 0;
    // Of the places that have views:
    std::vector<scene::Light> kinds_;
    std::vector<scene::LightState> states_;
    std::vector<scene::LightId> moved_, moved_before_, started_;
    std::vector<std::uint32_t> first_place_;   // by light, with one more at the end
    std::unique_ptr<Views> views_;
    std::unique_ptr<ProvenShares> proofs_;
    vk::Pipeline compute_, sum_;
    vk::Buffer light_records_, faces_, place_records_, cells_, fits_, albedos_, view_places_, shares_;
    vk::Image image_;
    bool changed_ = true;   // lights or views, since image_ was made
    std::uint64_t kept_ = 0;
};

}   // namespace gnomon::raster
