// SPDX-License-Identifier: Apache-2.0
#include "frame/rasterizer.h"

#include <algorithm>

#include "base/check.h"
#include "frame/raster_environment.h"
#include "gnomon/error.h"
#include "scene/emission.h"
#ifdef GNOMON_VULKAN
#include "raster/map_bounce.h"
#include "raster/raster_frame.h"
#include "raster/redrawn_overlay.h"
#include "raster/shadow_visibility.h"
#include "raster/thinned_shadows.h"
#include "raster/visible_bounce.h"
#endif

namespace gnomon::frame {

bool raster_has_image_apart(const scene::Scene& scene, const RenderOptions& options)
{
    return options.shadow_textures != ShadowTextures::off && scene.background.kind == scene::Background::Kind::image;
}

bool raster_has_suns_apart(const scene::Scene& scene, const RenderOptions& options)
{
    const auto is_sun = [](const scene::Light& light) {
        return light.type == scene::LightType::directional && !light.of_environment;
    };
    return options.shadow_textures != ShadowTextures::off && options.sun_size > 0 &&
           std::ranges::any_of(scene.lights, is_sun);
}

bool raster_needs_rays(const scene::Scene& scene, const RenderOptions& options)
{
    const ShadowTextures shadows = options.shadow_textures;
    if (raster_has_image_apart(scene, options) || raster_has_suns_apart(scene, options)) return true;
    const auto needs = [](const scene::Material& m) { return scene::may_emit(m) || scene::thins_light(m); };
    return shadows != ShadowTextures::off && std::ranges::any_of(scene.materials, needs);
}

#ifdef GNOMON_VULKAN

namespace {

class VulkanRasterizer final : public Rasterizer {
 public:
    VulkanRasterizer(const scene::SceneState& state, const RasterSettings& settings)
        : device_(vk::Device::open()), frame_(device_, state)
    {
        options_.samples = settings.samples;
        options_.layers = settings.layers;
        options_.backdrop_apart = settings.backdrop_apart;
        if (settings.redrawn) options_.ids = &ids_;
        redrawn_stays_ = settings.redrawn_stays;
        if (settings.indirect == Indirect::visible) {
            GNOMON_CHECK(settings.rays && settings.tasks);
            const bool software = device_->info().kind == "software";
            const bool on_device = settings.indirect_on == IndirectOn::vulkan ||
                                   (settings.indirect_on == IndirectOn::automatic && !software);
            auto bounce = std::make_unique<raster::VisibleBounce>(device_, state, *settings.rays, settings.visible,
                                                                  on_device, *settings.tasks);
            visible_ = &bounce->light();
            frame_.set_bounced(std::move(bounce));
        } else if (settings.indirect != Indirect::off) {
            light_quadtree::MapLightOptions map = settings.map;
            map.as_printed = settings.as_printed;
            frame_.set_bounced(std::make_unique<raster::MapBounce>(device_, state, map));
        }
        raster::SizedDirectOptions sized;
        if (settings.shadows == ShadowTextures::off) sized.method = raster::SizedDirectOptions::Method::unshadowed;
        auto direct = std::make_unique<raster::SizedDirect>(device_, state, sized);
        if (settings.rays && settings.tasks && settings.shadows != ShadowTextures::off)
            direct->prove(*settings.rays, *settings.tasks);
        sized_ = direct.get();
        frame_.set_sized(std::move(direct));
        if (settings.image_apart || settings.suns_apart) {
            GNOMON_CHECK(settings.rays && settings.tasks);
            auto surroundings = std::make_unique<RasterEnvironment>(*settings.rays, *settings.tasks);
            environment_ = surroundings.get();
            frame_.set_surroundings(std::move(surroundings));
        }
        if (settings.shadows == ShadowTextures::off || state.scene().lights.empty()) return;
        raster::ShadowOptions shadows;
        shadows.method = settings.shadows;
        shadows.look_up.filter = settings.shadow_filter;
        shadows.look_up.as_printed = settings.as_printed;
        shadows.image_apart = settings.image_apart, shadows.suns_apart = settings.suns_apart;
        auto visibility = std::make_unique<raster::ShadowVisibility>(device_, state, shadows);
        views_ = &visibility->views();
        if (settings.rays && settings.tasks && settings.rays->thins_light())
            frame_.set_visibility(std::make_unique<raster::ThinnedShadows>(device_, *settings.rays, *settings.tasks,
                                                                           std::move(visibility)));
        else
            frame_.set_visibility(std::move(visibility));
    }
    void update(const scene::SceneState& state) override { frame_.update(state); }
    void use_environment(trace::EnvironmentTechnique& technique) override
    {
        GNOMON_CHECK(environment_);
        environment_->use(technique);
    }
    FrameCounters render(const scene::SceneState& state, const scene::View& view, shading::FrameBuffers& out,
                         const Progress& progress, const RasterAdaptive* adaptive) override
    {
        options_.adaptive.reset();
        if (adaptive) options_.adaptive = {.filter = adaptive->filter, .exposure = adaptive->exposure, .refine = {}};
        const FrameCounters counters = frame_.render(state, view, options_, out, progress);
        if (options_.ids) note_redrawn(state);
        return counters;
    }
    void paint_redrawn(double exposure, ImageF& color) const override
    {
        GNOMON_CHECK(options_.ids);
        raster::paint_redrawn(ids_, redrawn_, exposure, color);
    }
    std::string device() const override { return device_->info().name; }
    std::size_t remembered_bytes() const override { return (visible_ ? visible_->bytes() : 0) + sized_->bytes(); }

 private:
    void note_redrawn(const scene::SceneState& state)
    {
        // The views of lights, and those of emissive clusters.
        std::vector<raster::Redrawn> now(state.scene().objects.size(), raster::Redrawn::kept);
        for (const light_views::LightViews* views : {views_, sized_->views()})
            if (views) raster::add_redrawn(*views, now);
        const bool nothing =
            std::all_of(now.begin(), now.end(), [](raster::Redrawn r) { return r == raster::Redrawn::kept; });
        if (redrawn_stays_ && nothing && state.time() == redrawn_time_ && redrawn_.size() == now.size()) return;
        redrawn_ = std::move(now);
        redrawn_time_ = state.time();
    }

    std::shared_ptr<vk::Device> device_;
    raster::RasterFrame frame_;
    raster::RasterOptions options_;
    raster::IdImage ids_;
    std::vector<raster::Redrawn> redrawn_;   // by object
    double redrawn_time_ = 0;
    bool redrawn_stays_ = false;
    const irradiance_cache::IrradianceCache* visible_ = nullptr;   // owned by the frame's bounced light
    const light_views::LightViews* views_ = nullptr;               // owned by the frame's visibility
    const raster::SizedDirect* sized_ = nullptr;                   // owned by the frame
    RasterEnvironment* environment_ = nullptr;                     // likewise; null: none is apart
};

}   // namespace

std::unique_ptr<Rasterizer> make_rasterizer(const scene::SceneState& state, const RasterSettings& settings)
{
    return std::make_unique<VulkanRasterizer>(state, settings);
}

#else

std::unique_ptr<Rasterizer> make_rasterizer(const scene::SceneState&, const RasterSettings&)
{
    throw MissingError("Vulkan: this program was built without it, and so without --renderer raster");
}

#endif

}   // namespace gnomon::frame
