// SPDX-License-Identifier: Apache-2.0
#include "bench/indirect/device_frames.h"

#include "gnomon/error.h"

#ifdef GNOMON_VULKAN
#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "base/clocks.h"
#include "raster/map_bounce.h"
#include "raster/raster_frame.h"
#include "raster/shadow_visibility.h"

namespace gnomon::bench {

namespace {

light_quadtree::MapLightOptions map_options(const std::string& name, const IndirectSettings& settings)
{
    const IndirectMethodInfo info = find_indirect_method(name, settings);
    light_quadtree::MapLightOptions options;
    options.map.validity = {static_cast<float>(settings.depth_threshold), static_cast<float>(settings.normal_threshold),
                            static_cast<float>(info.settings.margin)};
    if (settings.full) options.grid = 0;
    if (name.starts_with("rsm")) {
        options.method = light_quadtree::MapMethod::rsm;
        options.rsm = {info.number, static_cast<float>(info.settings.radius)};
        return options;
    }
    options.levels.limit = info.number;
    options.as_printed = name.starts_with("printed");
    return options;
}

double median(std::vector<double> values)
{
    std::sort(values.begin(), values.end());
    return values[values.size() / 2];
}

// A rasterised frame with one method for indirect light.
class DeviceFrame {
 public:
    DeviceFrame(const std::shared_ptr<vk::Device>& device, const scene::SceneState& state,
                const light_quadtree::MapLightOptions& options)
        : frame_(device, state), software_(device->info().kind == "software")
    {
        auto bounce = std::make_unique<raster::MapBounce>(device, state, options);
        bounce_ = bounce.get();
        frame_.set_bounced(std::move(bounce));
        if (!state.scene().lights.empty())
            frame_.set_visibility(std::make_unique<raster::ShadowVisibility>(device, state));
    }

    /// Renders the state's frame once more. Returns milliseconds.
    double render(scene::SceneState& state, const scene::View& view, bool keep)
    {
        state.advance(state.time());
        if (!keep) {
            bounce_->forget();
            frame_.forget_surfaces();
        }
        const double begin = software_ ? cpu_ms() : wall_ms();
        frame_.update(state);
        counters_ = frame_.render(state, view, {}, buffers_);
        return (software_ ? cpu_ms() : wall_ms()) - begin;
    }
    const FrameCounters& counters() const { return counters_; }
    const std::vector<float>& image() const { return buffers_.color.data; }

 private:
    raster::RasterFrame frame_;
    raster::MapBounce* bounce_ = nullptr;   // owned by the frame
    bool software_;
    shading::FrameBuffers buffers_;
    FrameCounters counters_;
};

}   // namespace

DeviceFramesResult measure_device_frames(const std::shared_ptr<const scene::Scene>& scene,
                                         const DeviceFramesOptions& options, const Progress& progress)
{
    const auto device = vk::Device::open();
    DeviceFramesResult result;
    result.device = device->info().name;
    result.clock = device->info().kind == "software" ? "process CPU" : "wall";
    result.full = options.full;

    // List the methods, and quadtree:5 with the other thresholds.
    std::vector<std::pair<std::string, IndirectSettings>> list;
    IndirectSettings settings;
    settings.full = options.full;
    for (const std::string& method : options.methods) list.emplace_back(method, settings);
    for (const auto& [depth, normal] : options.thresholds) {
        settings.depth_threshold = depth, settings.normal_threshold = normal;
        list.emplace_back("quadtree:5", settings);
    }

    std::map<std::string, std::vector<float>> images;   // by limit level
    for (std::size_t i = 0; i < list.size(); ++i) {
        const auto& [method, of] = list[i];
        if (progress && !progress({method, static_cast<double>(i) / static_cast<double>(list.size())}))
            throw InterruptedError("interrupted");
        scene::SceneState state(scene, scene->timeline.time_of(options.frame));
        const scene::View view = scene::make_view(state, options.camera, options.size);
        DeviceFrame frame(device, state, map_options(method, of));
        DeviceFramesRow row;
        row.method = method;
        row.depth_threshold = of.depth_threshold, row.normal_threshold = of.normal_threshold;
        row.kept = row.made = true;
        frame.render(state, view, true);   // everything is made for the first time
        std::vector<double> kept, not_kept;
        const auto same = [&](bool all) {
            const FrameCounters& c = frame.counters();
            const bool grid = options.full || c.indirect.kept_receivers == all;
            return c.kept_surfaces == all && c.indirect.kept_map == all && grid;
        };
        for (int repeat = 0; repeat < options.repeats; ++repeat) {
            kept.push_back(frame.render(state, view, true));
            row.kept = row.kept && same(true);
        }
        for (int repeat = 0; repeat < options.repeats; ++repeat) {
            not_kept.push_back(frame.render(state, view, false));
            row.made = row.made && same(false);
        }
        row.ms_kept = median(kept), row.ms_not_kept = median(not_kept);
        row.lights = frame.counters().indirect.clusters;

        // Compare what is printed with the compacted cut.
        const std::string level = method.substr(method.find(':') + 1);
        if (method.starts_with("quadtree") && !images.contains(level)) images[level] = frame.image();
        if (method.starts_with("printed") && images.contains(level)) {
            const std::vector<float>&a = images[level], &b = frame.image();
            std::size_t different = 0;
            for (std::size_t k = 0; k < a.size(); ++k) different += a[k] != b[k];
            row.different_from_quadtree = static_cast<double>(different) / static_cast<double>(a.size());
        }
        result.rows.push_back(row);
    }
    return result;
}

}   // namespace gnomon::bench

#else

namespace gnomon::bench {

DeviceFramesResult measure_device_frames(const std::shared_ptr<const scene::Scene>&, const DeviceFramesOptions&,
                                         const Progress&)
{
    throw MissingError("this program was built without Vulkan, which frames on the device need");
}

}   // namespace gnomon::bench

#endif
