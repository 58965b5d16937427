// SPDX-License-Identifier: Apache-2.0
#include "app/indirect_methods.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

#include "gnomon/error.h"
#include "light_quadtree/visible_light.h"

namespace gnomon::app {

namespace {

// Remembered visibility: points are handed over tile by tile, as the traced frame does.
class VisibleMethod final : public IndirectMethod {
 public:
    VisibleMethod(const scene::SceneState& state, const ray::RayScene& rays, Tasks& tasks)
        : visible_(state, rays, {}, tasks), scratch_(static_cast<std::size_t>(tasks.threads()))
    {
    }

    void begin_frame(const scene::SceneState& state, const ray::RayScene& rays, Tasks& tasks) override
    {
        visible_.begin_frame(state, rays, tasks);
        batches_.clear();
        for (std::size_t t = 0; t < scratch_.size(); ++t) batches_.push_back(visible_.make_batch());
    }

    void light(const SeenPicture& picture, Tasks& tasks, glm::vec3* irradiance) override
    {
        const int columns = (picture.size.width + k_tile - 1) / k_tile;
        const int rows = (picture.size.height + k_tile - 1) / k_tile;
        tasks.for_each(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows), [&](std::size_t t, int w) {
            Scratch& own = scratch_[static_cast<std::size_t>(w)];
            own.points.clear(), own.pixels.clear();
            const int x0 = static_cast<int>(t) % columns * k_tile, y0 = static_cast<int>(t) / columns * k_tile;
            for (int y = y0; y < std::min(y0 + k_tile, picture.size.height); ++y)
                for (int x = x0; x < std::min(x0 + k_tile, picture.size.width); ++x) {
                    const std::size_t pixel = picture.index(x, y);
                    if (!picture.points[pixel].scatters) continue;
                    own.points.push_back(picture.points[pixel].point);
                    own.pixels.push_back(pixel);
                }
            own.light.resize(own.points.size());
            visible_.shade(*batches_[static_cast<std::size_t>(w)], own.points, own.light.data());
            for (std::size_t i = 0; i < own.pixels.size(); ++i) irradiance[own.pixels[i]] = own.light[i];
        });
    }

    void sample(std::span<const SeenPoint> points, glm::vec3* irradiance) override
    {
        std::vector<light_quadtree::IndirectPoint> wanted;
        for (const SeenPoint& point : points) wanted.push_back(point.point);
        visible_.shade(*batches_[0], wanted, irradiance);
    }

    IndirectWork end_frame() override
    {
        visible_.end_frame(batches_);
        const light_quadtree::VisibleCounters& c = visible_.counters();
        return {c.nodes, c.rays, visible_.emitters().dirty_leaves(), visible_.emitters().dirty_nodes(),
                visible_.bytes()};
    }

 private:
    static constexpr int k_tile = 32;
    struct Scratch {
        std::vector<light_quadtree::IndirectPoint> points;
        std::vector<std::size_t> pixels;
        std::vector<glm::vec3> light;
    };
    light_quadtree::VisibleLight visible_;
    std::vector<std::unique_ptr<light_quadtree::VisibleLight::Batch>> batches_;
    std::vector<Scratch> scratch_;
};

// The table. A method with a number is asked for as NAME:NUMBER.
struct Row {
    const char* name;
    const char* title;   // {} is the number
    int least, most;     // number; 0, 0: none
    decltype(IndirectMethodInfo::make) make;
};
constexpr Row k_methods[] = {
    {"visible", "remembered visibility", 0, 0,
     [](const IndirectMethodInfo&, const scene::SceneState& state, const ray::RayScene& rays, Tasks& tasks)
         -> std::unique_ptr<IndirectMethod> { return std::make_unique<VisibleMethod>(state, rays, tasks); }},
};

}   // namespace

IndirectMethodInfo find_indirect_method(const std::string& name)
{
    const std::size_t colon = name.find(':');
    std::string known;
    for (const Row& row : k_methods) {
        const bool numbered = row.most > 0;
        known += fmt::format("{}{}{}", known.empty() ? "" : ", ", row.name, numbered ? ":N" : "");
        if (name.substr(0, colon) != row.name || numbered != (colon != std::string::npos)) continue;
        int number = 0;
        if (numbered) {
            const char* const end = name.data() + name.size();
            const auto [stop, error] = std::from_chars(name.data() + colon + 1, end, number);
            if (error != std::errc() || stop != end || number < row.least || number > row.most)
                throw UsageError(fmt::format("method '{}': its number is {} to {}", name, row.least, row.most));
        }
        return {name, fmt::format(fmt::runtime(row.title), number), row.make, number};
    }
    throw UsageError(fmt::format("no method '{}' to measure: expected {}", name, known));
}

}   // namespace gnomon::app
