// SPDX-License-Identifier: Apache-2.0
#pragma once
// Renders one frame by rasterisation, with deferred shading:
//
//   cull -> ids of opaque surfaces -> per layer: ids of transparent surfaces -> surfaces -> (shadows) -> lights
//                                                                                -> (indirect light)
//
// Lights are points, spots and suns (LightVisibility says which reach a surface), lights with size (SizedDirect), and
// environment images and suns with a size (SurroundingLight).
//
// Only ids (draw and triangle) are drawn. A compute pass then makes each pixel's surface from its triangle, by the
// formulas and with the ray cone of the traced frame. So both frames see the same surface, texel and normal, and differ
// only where a ray and the rasteriser disagree about an edge.
//
// Transparent surfaces are peeled, nearest first, RasterOptions::transparent_layers of them, and composed front to
// back. Compared with the traced frame, reflection and refraction are left out, as at max depth 0; but surfaces behind
// a transparent one are seen, straight through it.
//
// While neither scene nor view change, the G-buffer is kept, and frames begin with the lights. That needs one sample
// per pixel and no transparent surfaces, of which a frame makes one layer after the other in the same images.
//
// CPU cost of a frame: the objects that moved, and a constant number of passes; there is no loop over static objects. A
// frame depends on the scene, the view and the options alone.

#include "base/image.h"
#include "gnomon/types.h"
#include "raster/edge_samples.h"
#include "raster/gbuffer.h"
#include "raster/raster_shared.h"
#include "raster/sized_direct.h"
#include "shading/frame_buffers.h"

namespace gnomon::raster {

/// Object + 1 (0: nothing) and triangle of each pixel's nearest surface, as in GBuffer::ids.
using IdImage = Image<std::uint32_t>;

struct RasterOptions {
    int samples = 1;                 // per pixel
    bool layers = false;             // fill all of shading::FrameBuffers, not `color` alone
    int transparent_layers = 4;      // transparent surfaces in a row; light from behind them is lost
    std::uint32_t light_batch = 8;   // lights whose shadows are held at once
    /// Leave what lies behind the scene out of `color`, and fill `alpha`, as trace::TracedOptions::backdrop_apart says.
    bool backdrop_apart = false;
    IdImage* ids = nullptr;   // optional: filled by the first sample
    /// Samples where something ends (edge_samples.h), beside one of each pixel.
    std::optional<AdaptiveOptions> adaptive = {};
};

class RasterFrame {
 public:
    /// Opens a device and uploads the scene.
    /// @throws MissingError  no suitable device, or too little memory
    explicit RasterFrame(const scene::SceneState& state);
    RasterFrame(const std::shared_ptr<vk::Device>& device, const scene::SceneState& state);

    /// Shadows from the next frame on; null: none.
    void set_visibility(std::unique_ptr<LightVisibility> visibility) { visibility_ = std::move(visibility); }
    /// Direct light of lights with size from the next frame on; the lights that approximate surfaces are then left out.
    void set_sized(std::unique_ptr<SizedDirect> sized) { sized_ = std::move(sized); }
    /// Light of surroundings from the next frame on, instead of the directional lights that approximate an environment
    /// image; null: those light.
    void set_surroundings(std::unique_ptr<SurroundingLight> light) { surroundings_ = std::move(light); }
    /// Indirect light from the next frame on; null: ambient light stands in for it.
    void set_bounced(std::unique_ptr<BouncedLight> bounced) { bounced_ = std::move(bounced); }

    /// Follows one advance() of the state it was made from; takes effect in the next render(). Call once an advance.
    void update(const scene::SceneState& state);

    /// @throws MissingError      the device has too little memory, or was lost
    /// @throws InterruptedError  progress returned false
    FrameCounters render(const scene::SceneState& state, const scene::View& view, const RasterOptions& options,
                         shading::FrameBuffers& out, const Progress& progress = {});

    const gpu_scene::GpuScene& scene() const { return scene_; }
    const vk::Device& device() const { return *device_; }
    /// Makes the next frame's G-buffer anew.
    void forget_surfaces() { kept_key_.clear(); }
    /// Of the last frame's passes.
    const std::vector<vk::PassTiming>& timings() const { return commands_.timings(); }

 private:
    // The images that one sample has read back; empty where the options do not need them.
    struct Drawn {
        vk::Buffer counts, ids, diffuse, specular, normal, position, color, direct, indirect, lit;
    };
    void make_pipelines();
    void fit(Size size, const RasterOptions& options, std::size_t lights);
    void begin_frame(const scene::SceneState& state, const scene::View& view, const RasterOptions& options);
    bool find_kept(const scene::View& view, const RasterOptions& options, const shared::RasterFrame& constants);
    Drawn draw_sample(const scene::View& view, const RasterOptions& options, int sample);
    void refine_edges(const scene::View& view, const RasterOptions& options, shading::FrameBuffers& out,
                      FrameCounters& counters);
    void store_sample(const Drawn& drawn, const RasterOptions& options, int sample, shading::FrameBuffers& out);
    void draw_ids(const shared::DrawPush& push);
    void peel(const shared::DrawPush& push, const vk::Image& last_depth, const vk::Image& depth);
    void draw_groups(vk::Recorder& r, scene::SurfaceClass surface) const;
    void resolve(const shared::ResolvePush& push);
    void light(const RasterOptions& options, const scene::View& view, bool layers);
    void light_by(std::uint32_t first, std::uint32_t end, const RasterOptions& options, bool layers);
    void light_by_surroundings(const scene::View& view, const RasterOptions& options, bool layers);
    void bounce(const scene::View& view, bool layers);
    void clear(const vk::Image& image, float value);
    void copy(const vk::Image& from, const vk::Image& to);
    bool keeps_surfaces(const RasterOptions& options) const;

    std::shared_ptr<vk::Device> device_;
    std::shared_ptr<const scene::Scene> described_;
    gpu_scene::GpuScene scene_;
    vk::Commands commands_;
    std::unique_ptr<LightVisibility> visibility_;
    std::unique_ptr<BouncedLight> bounced_;
    std::unique_ptr<SizedDirect> sized_;
    std::unique_ptr<SurroundingLight> surroundings_;
    vk::Pipeline opaque_, masked_, peel_, resolve_, shade_, surrounding_, bounce_;
    vk::Buffer frame_, environment_, lit_;

    Size size_{};
    GBuffer surfaces_;
    vk::Image opaque_ids_, peeled_ids_, opaque_depth_, peel_depth_[2];
    vk::Image color_, direct_, indirect_, irradiance_, through_, share_, lights_visible_;
    vk::Image surrounding_light_;       // radiance of the surfaces of a layer
    ImageF surrounding_visible_;        // of the frame, by pixel and light; empty: no light has a visible share
    vk::Image own_;                     // background and emitted light of the surfaces that are kept
    std::vector<std::byte> kept_key_;   // what surfaces_ and own_ were made for, the scene apart; empty: nothing
    bool scene_changed_ = true;         // since they were made
    float unlimited_far_ = 0;           // where an orthographic view without a far plane ends
};

}   // namespace gnomon::raster
