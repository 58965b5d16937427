// SPDX-License-Identifier: Apache-2.0
#include "bench/lights/raster.h"

#include "gnomon/error.h"

#ifdef GNOMON_VULKAN
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "api/scene_access.h"
#include "base/clocks.h"
#include "gnomon/renderer.h"
#include "raster/raster_frame.h"
#include "scene/view.h"

namespace gnomon::bench {

namespace {

using Method = raster::SizedDirectOptions::Method;

constexpr double k_least_light = 0.01;          // of the mean: pixels with less are left out
constexpr float k_same_surface = 0.01f;         // of albedo and normal, by channel
constexpr float k_same_depth = 1e-3f;           // relative
constexpr double k_dark = 1e-3, k_leak = 0.1;   // visible fractions

double brightness(const std::vector<float>& rgb, std::size_t pixel)
{
    return static_cast<double>(rgb[3 * pixel]) + static_cast<double>(rgb[3 * pixel + 1]) +
           static_cast<double>(rgb[3 * pixel + 2]);
}

// A rasterised frame whose only lights are those with size.
class Frames {
 public:
    Frames(const std::shared_ptr<vk::Device>& device, const std::shared_ptr<const scene::Scene>& scene, double time,
           Method method, bool proves = false)
        : state_(scene, time), frame_(device, state_), software_(device->info().kind == "software")
    {
        raster::SizedDirectOptions options;
        options.method = method;
        auto sized = std::make_unique<raster::SizedDirect>(device, state_, options);
        if (proves) sized->prove(rays_.emplace(state_), tasks_);
        frame_.set_sized(std::move(sized));
    }
    double render(const scene::View& view)
    {
        const double begin = software_ ? cpu_ms() : wall_ms();
        if (rendered_) {
            state_.advance(state_.time());
            if (rays_) rays_->update(state_);
            frame_.update(state_);
        }
        rendered_ = true;
        frame_.render(state_, view, {.layers = true}, buffers_);
        return (software_ ? cpu_ms() : wall_ms()) - begin;
    }
    const scene::SceneState& state() const { return state_; }
    const shading::FrameBuffers& buffers() const { return buffers_; }

 private:
    scene::SceneState state_;
    Tasks tasks_{1};
    std::optional<ray::RayScene> rays_;
    raster::RasterFrame frame_;
    bool software_, rendered_ = false;
    shading::FrameBuffers buffers_;
};

Frame traced(const std::shared_ptr<const scene::Scene>& scene, int frame, Size size, scene::CameraId camera)
{
    RenderOptions options;
    options.size = size;
    options.camera = fmt::format("{}", camera);
    options.indirect = Indirect::off;
    options.max_depth = 0;
    options.layers = true;
    options.exposure = 0;
    return Renderer(options).render(api::public_scene(scene), frame);
}

const Layer& layer(const Frame& image, const std::string& name)
{
    const auto at =
        std::find_if(image.layers.begin(), image.layers.end(), [&](const Layer& l) { return l.name == name; });
    return *at;
}

}   // namespace

RasterLightsResult compare_raster_lights(const std::shared_ptr<const scene::Scene>& scene, int frame, Size size,
                                         scene::CameraId camera, bool others)
{
    RasterLightsResult result;
    std::shared_ptr<vk::Device> device;
    try {
        device = vk::Device::open();
    } catch (const MissingError&) {
        return result;
    }
    result.device = device->info().name;
    result.clock = device->info().kind == "software" ? "process CPU time" : "wall time";
    const Frame truth = traced(scene, frame, size, camera);
    const std::vector<float> light = layer(truth, "direct").copy(), depth = layer(truth, "depth").copy(),
                             albedo = layer(truth, "albedo").copy(), normal = layer(truth, "normal").copy();
    result.traced = ImageF(size.width, size.height, 3);
    result.traced.data = light;

    const double time = scene->timeline.time_of(frame);
    Frames unshadowed(device, scene, time, Method::unshadowed);
    const scene::View view = scene::make_view(unshadowed.state(), camera, size);
    unshadowed.render(view);
    const std::vector<float>& whole = unshadowed.buffers().direct.data;
    double mean = 0;
    for (std::size_t i = 0; i < depth.size(); ++i) mean += brightness(whole, i) / static_cast<double>(depth.size());
    std::vector<std::size_t> compared;
    const shading::FrameBuffers& seen_by_raster = unshadowed.buffers();
    const auto same_surface = [&](std::size_t i) {
        bool same = std::abs(depth[i] - seen_by_raster.depth.data[i]) <= k_same_depth * depth[i];
        for (std::size_t c = 3 * i; c < 3 * i + 3; ++c)
            same = same && std::abs(albedo[c] - seen_by_raster.albedo.data[c]) <= k_same_surface &&
                   std::abs(normal[c] - seen_by_raster.normal.data[c]) <= k_same_surface;
        return same;
    };
    for (std::size_t i = 0; i < depth.size(); ++i)
        if (brightness(whole, i) > k_least_light * mean && same_surface(i)) compared.push_back(i);
    result.pixels = static_cast<double>(compared.size());

    struct Way {
        const char* name;
        Method method;
        bool proves;
    };
    for (const auto& [name, method, proves] :
         {Way{"proven shares", Method::views, true}, Way{"light views from several places", Method::views, false},
          Way{"percentage-closer soft shadows", Method::percentage_closer, false}}) {
        if (!proves && !others) continue;
        RasterLightsRow row;
        row.method = name;
        Frames frames(device, scene, time, method, proves);
        // Another view, the view that is compared, and the same once more.
        scene::View aside = view;
        aside.eye += 1e-3f * aside.right;
        row.ms_first = frames.render(aside);
        row.ms_view = frames.render(view);
        row.ms_still = frames.render(view);
        row.direct = frames.buffers().direct;
        row.difference = ImageF(size.width, size.height, 1);
        const std::vector<float>& seen = frames.buffers().direct.data;
        for (const std::size_t i : compared) {
            const double here = brightness(light, i) / brightness(whole, i),
                         there = brightness(seen, i) / brightness(whole, i);
            row.rmse += (here - there) * (here - there);
            row.difference.data[i] = static_cast<float>(there - here);
            row.max_abs = std::max(row.max_abs, std::abs(here - there));
            if (here > k_dark) continue;
            ++row.darkest;
            row.leaks += there > k_leak;
        }
        row.rmse = std::sqrt(row.rmse / std::max(result.pixels, 1.0));
        result.rows.push_back(std::move(row));
    }
    return result;
}

}   // namespace gnomon::bench

#else

namespace gnomon::bench {

RasterLightsResult compare_raster_lights(const std::shared_ptr<const scene::Scene>&, int, Size, scene::CameraId, bool)
{
    return {};
}

}   // namespace gnomon::bench

#endif
