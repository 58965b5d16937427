// SPDX-License-Identifier: Apache-2.0
#include "render/rasterizer.h"

#include "base/check.h"
#include "gnomon/error.h"
#ifdef GNOMON_VULKAN
#include "render/raster/raster_frame.h"
#include "render/raster/redrawn_overlay.h"
#include "render/raster/shadow_visibility.h"
#endif

namespace gnomon::render {

#ifdef GNOMON_VULKAN

namespace {

class VulkanRasterizer final : public Rasterizer {
 public:
    VulkanRasterizer(const scene::SceneState& state, const RasterSettings& settings)
        : device_(vk::Device::open()), frame_(device_, state)
    {
        options_.samples = settings.samples;
        options_.layers = settings.layers;
        if (settings.redrawn) options_.ids = &ids_;
        if (settings.shadows == ShadowTextures::off || state.scene().lights.empty()) return;
        ShadowOptions shadows;
        shadows.method = settings.shadows;
        shadows.look_up.filter = settings.shadow_filter;
        auto visibility = std::make_unique<ShadowVisibility>(device_, state, shadows);
        views_ = &visibility->views();
        frame_.set_visibility(std::move(visibility));
    }
    void update(const scene::SceneState& state) override { frame_.update(state); }
    FrameCounters render(const scene::SceneState& state, const View& view, FrameBuffers& out,
                         const Progress& progress) override
    {
        return frame_.render(state, view, options_, out, progress);
    }
    void paint_redrawn(double exposure, ImageF& color) const override
    {
        GNOMON_CHECK(views_ && options_.ids);
        render::paint_redrawn(ids_, redrawn_objects(*views_), exposure, color);
    }
    std::string device() const override { return device_->info().name; }

 private:
    std::shared_ptr<vk::Device> device_;
    RasterFrame frame_;
    RasterOptions options_;
    IdImage ids_;
    const light_views::LightViews* views_ = nullptr;   // of the frame's visibility
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

}   // namespace gnomon::render
