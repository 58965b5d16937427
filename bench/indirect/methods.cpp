// SPDX-License-Identifier: Apache-2.0
#include "bench/indirect/methods.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

#include "bench/indirect/vulkan.h"
#include "gnomon/error.h"
#include "irradiance_cache/irradiance_cache.h"
#include "light_quadtree/map_light.h"

namespace gnomon::bench {

namespace {

constexpr double k_widest = 2;   // radius at which a disk covers the light map from any centre

// The irradiance cache, which takes visibility into account. Points are passed tile by tile, as in the traced frame.
class VisibleMethod final : public IndirectMethod {
 public:
    VisibleMethod(const IndirectSettings& settings, const scene::SceneState& state, const ray::RayScene& rays,
                  Tasks& tasks)
        : visible_(state, rays, options_of(settings), tasks), light_(static_cast<std::size_t>(tasks.threads()))
    {
    }

    void begin_frame(const scene::SceneState& state, const ray::RayScene& rays, Tasks& tasks) override
    {
        visible_.update(state, rays, tasks);
        batches_.clear();
        for (std::size_t t = 0; t < light_.size(); ++t) batches_.push_back(visible_.make_batch());
    }

    void light(const SeenImage& image, Tasks& tasks, glm::vec3* irradiance) override
    {
        tasks.for_each(image.tiles.size(), [&](std::size_t t, int worker) {
            const SeenTile& tile = image.tiles[t];
            const auto w = static_cast<std::size_t>(worker);
            std::vector<glm::vec3>& own = light_[w];
            own.resize(tile.points.size());
            visible_.shade(*batches_[w], tile.points, own.data());
            for (std::size_t i = 0; i < own.size(); ++i) irradiance[tile.pixels[i]] = own[i];
        });
    }

    void sample(std::span<const SeenPoint> points, glm::vec3* irradiance) override
    {
        std::vector<irradiance_cache::IndirectPoint> wanted;
        for (const SeenPoint& point : points) wanted.push_back(point.point);
        visible_.shade(*batches_[0], wanted, irradiance);
    }

    IndirectWork end_frame() override
    {
        visible_.end_frame(batches_);
        const irradiance_cache::CacheCounters& c = visible_.counters();
        return {c.nodes, c.rays, visible_.light_tree().dirty_leaves(), visible_.light_tree().dirty_nodes(),
                visible_.bytes()};
    }

 private:
    static irradiance_cache::CacheOptions options_of(const IndirectSettings& settings)
    {
        irradiance_cache::CacheOptions options = irradiance_cache::options_for_bounces(settings.bounces, true);
        options.memory = settings.memory;
        return options;
    }
    irradiance_cache::IrradianceCache visible_;
    std::vector<std::unique_ptr<irradiance_cache::IrradianceCache::Batch>> batches_;
    std::vector<std::vector<glm::vec3>> light_;   // by thread
};

// Light maps without visibility: the quad-tree as published, and the sampling with which the paper compares it.
class MapMethod final : public IndirectMethod {
 public:
    MapMethod(const light_quadtree::MapLightOptions& options, const scene::SceneState& state, const ray::RayScene& rays,
              Tasks& tasks)
        : map_(state, rays, options, tasks), scratch_(static_cast<std::size_t>(tasks.threads()))
    {
        for (std::size_t t = 0; t < scratch_.size(); ++t)
            batches_.push_back(std::make_unique<light_quadtree::MapLight::Batch>());
    }

    int grid_step(Size size) const override { return map_.grid_step(size.width, size.height); }

    bool forget() override
    {
        if (map_.options().shadows) return false;   // not of the paper
        map_.forget();
        return true;
    }

    void begin_frame(const scene::SceneState& state, const ray::RayScene& rays, Tasks& tasks) override
    {
        map_.begin_frame(state, rays, tasks);
    }

    void light(const SeenImage& image, Tasks& tasks, glm::vec3* irradiance) override
    {
        map_.begin_image(image.size.width, image.size.height);
        if (const int step = grid_step(image.size); step > 0)
            map_.set_grid(image.grid.receivers, image.grid.columns, step, tasks);
        tasks.for_each(image.tiles.size(), [&](std::size_t t, int worker) {
            const std::vector<std::size_t>& pixels = image.tiles[t].pixels;
            const auto w = static_cast<std::size_t>(worker);
            Scratch& own = scratch_[w];
            own.points.clear();
            for (const std::size_t pixel : pixels) own.points.push_back(receiver_of(image.points[pixel]));
            own.light.resize(pixels.size());
            map_.shade(*batches_[w], own.points, own.light.data());
            for (std::size_t i = 0; i < pixels.size(); ++i) irradiance[pixels[i]] = own.light[i];
        });
    }

    void sample(std::span<const SeenPoint> points, glm::vec3* irradiance) override
    {
        std::vector<light_quadtree::MapReceiver> wanted;
        for (const SeenPoint& point : points) wanted.push_back(receiver_of(point));
        map_.shade(*batches_[0], wanted, irradiance);
    }

    IndirectWork end_frame() override
    {
        map_.end_frame(batches_);
        const light_quadtree::LightMap::Work& work = map_.map().work();
        const light_quadtree::ShadowCounters& shadow = map_.counters().shadow;
        return {map_.counters().lights, work.cast + shadow.cast(), work.dirty_texels, work.dirty_nodes, map_.bytes(),
                shadow.left_out};
    }

 private:
    static light_quadtree::MapReceiver receiver_of(const SeenPoint& seen)
    {
        return {seen.point.position, seen.point.normal, seen.point.width, glm::ivec2(glm::floor(seen.place))};
    }

    struct Scratch {
        std::vector<light_quadtree::MapReceiver> points;
        std::vector<glm::vec3> light;
    };
    light_quadtree::MapLight map_;
    std::vector<std::unique_ptr<light_quadtree::MapLight::Batch>> batches_;
    std::vector<Scratch> scratch_;
};

light_quadtree::MapLightOptions map_options(const IndirectMethodInfo& info, light_quadtree::MapMethod method)
{
    light_quadtree::MapLightOptions options;
    options.method = method;
    options.map.validity = {static_cast<float>(info.settings.depth_threshold),
                            static_cast<float>(info.settings.normal_threshold),
                            static_cast<float>(info.settings.margin)};
    if (info.settings.full) options.grid = 0;
    return options;
}

std::unique_ptr<IndirectMethod> make_map_method(const IndirectMethodInfo& info,
                                                const light_quadtree::MapLightOptions& options,
                                                const scene::SceneState& state, const ray::RayScene& rays, Tasks& tasks)
{
    if (info.vulkan) return make_vulkan_map_method(options, state, rays, tasks);
    return std::make_unique<MapMethod>(options, state, rays, tasks);
}

enum class Gathered : std::uint8_t { as_published, as_printed, with_shadows };

template <Gathered gathered, bool separate_trees = false>
std::unique_ptr<IndirectMethod> make_quadtree(const IndirectMethodInfo& info, const scene::SceneState& state,
                                              const ray::RayScene& rays, Tasks& tasks)
{
    light_quadtree::MapLightOptions options = map_options(info, light_quadtree::MapMethod::quadtree);
    options.levels.limit = info.number;
    options.as_printed = gathered == Gathered::as_printed;
    options.shadows = gathered == Gathered::with_shadows;
    options.map.separate_trees = separate_trees;
    return make_map_method(info, options, state, rays, tasks);
}

// The table of methods. A method with a number is named NAME:NUMBER; a second number may follow.
struct Row {
    const char* name;
    const char* form;                   // what follows the name
    const char* title;                  // format string for the number, and for the second one
    int least, most;                    // range of the number; 0, 0 if there is none
    double IndirectSettings::*second;   // what the second number sets; null if there is none
    double highest;                     // of the second number
    bool visible, walks, on_device;
    decltype(IndirectMethodInfo::make) make;
};
constexpr Row k_methods[] = {
    {"visible", "", "cached visibility", 0, 0, nullptr, 0, true, true, false,
     [](const IndirectMethodInfo& info, const scene::SceneState& state, const ray::RayScene& rays,
        Tasks& tasks) -> std::unique_ptr<IndirectMethod> {
         return std::make_unique<VisibleMethod>(info.settings, state, rays, tasks);
     }},
    {"quadtree", ":LEVEL[:MARGIN]", "quad-tree, limit level {}, margin of validity {}", 1, 7, &IndirectSettings::margin,
     1, false, true, true, make_quadtree<Gathered::as_published>},
    {"separate", ":LEVEL[:MARGIN]",
     "separate quad-trees of static and dynamic objects, limit level {}, margin of "
     "validity {}",
     1, 7, &IndirectSettings::margin, 1, false, true, false, make_quadtree<Gathered::as_published, true>},
    {"printed", ":LEVEL", "quad-tree as printed, one pass a level, limit level {}", 1, 7, nullptr, 0, false, false,
     true, make_quadtree<Gathered::as_printed>},
    {"shadowed", ":LEVEL[:MARGIN]", "quad-tree with shadows of clusters, limit level {}, margin of validity {}", 1, 7,
     &IndirectSettings::margin, 1, true, true, false, make_quadtree<Gathered::with_shadows>},
    {"separate-shadowed", ":LEVEL[:MARGIN]",
     "separate quad-trees with shadows of clusters, limit level {}, margin of "
     "validity {}",
     1, 7, &IndirectSettings::margin, 1, true, true, false, make_quadtree<Gathered::with_shadows, true>},
    {"rsm", ":SAMPLES[:RADIUS]", "sampling, {} samples within {} of the map's side", 1, 65536,
     &IndirectSettings::radius, k_widest, false, false, true,
     [](const IndirectMethodInfo& info, const scene::SceneState& state, const ray::RayScene& rays,
        Tasks& tasks) -> std::unique_ptr<IndirectMethod> {
         light_quadtree::MapLightOptions options = map_options(info, light_quadtree::MapMethod::rsm);
         options.rsm = {info.number, static_cast<float>(info.settings.radius)};
         return make_map_method(info, options, state, rays, tasks);
     }},
};

}   // namespace

IndirectMethodInfo find_indirect_method(const std::string& name, const IndirectSettings& settings)
{
    // Find the name in the table, then parse the numbers that follow it.
    const std::size_t colon = name.find(':');
    std::string known;
    for (const Row& row : k_methods) {
        const bool numbered = row.most > 0;
        known += fmt::format("{}{}{}", known.empty() ? "" : ", ", row.name, row.form);
        if (name.substr(0, colon) != row.name || numbered != (colon != std::string::npos)) continue;
        IndirectMethodInfo info{name,        "",       settings, row.make, 0, settings.vulkan && row.on_device,
                                row.visible, row.walks};
        if (numbered) {
            const char* const end = name.data() + name.size();
            std::from_chars_result at = std::from_chars(name.data() + colon + 1, end, info.number);
            const bool right = at.ec == std::errc() && info.number >= row.least && info.number <= row.most;
            if (right && row.second && at.ptr != end && *at.ptr == ':') {
                double& second = info.settings.*row.second;
                at = std::from_chars(at.ptr + 1, end, second);
                if (at.ec != std::errc() || at.ptr != end || !(second > 0 && second <= row.highest))
                    throw UsageError(fmt::format("method '{}': the {} must be above 0 and at most {}", name,
                                                 row.second == &IndirectSettings::radius ? "radius" : "margin",
                                                 row.highest));
            }
            if (!right || at.ptr != end)
                throw UsageError(fmt::format("method '{}': the number must be {} to {}", name, row.least, row.most));
        }
        info.title = fmt::format(fmt::runtime(row.title), info.number, row.second ? info.settings.*row.second : 0.0);
        return info;
    }
    throw UsageError(fmt::format("no method '{}': expected {}", name, known));
}

std::vector<glm::vec3> brute_irradiance(const scene::SceneState& state, const ray::RayScene& rays,
                                        std::span<const SeenPoint> points, Tasks& tasks)
{
    light_quadtree::MapLightOptions options;
    options.method = light_quadtree::MapMethod::brute;
    options.grid = 0;
    const light_quadtree::MapLight map(state, rays, options, tasks);
    std::vector<glm::vec3> light(points.size());
    constexpr std::size_t k_together = 4 * light_quadtree::k_receiver_step;
    tasks.for_each((points.size() + k_together - 1) / k_together, [&](std::size_t part, int) {
        const std::size_t begin = part * k_together, end = std::min(points.size(), begin + k_together);
        std::vector<light_quadtree::MapReceiver> wanted;
        for (std::size_t i = begin; i < end; ++i)
            wanted.push_back({points[i].point.position, points[i].point.normal, points[i].point.width});
        light_quadtree::MapLight::Batch batch;
        map.shade(batch, wanted, light.data() + begin);
    });
    return light;
}

}   // namespace gnomon::bench
