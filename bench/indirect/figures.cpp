// SPDX-License-Identifier: Apache-2.0
#include "bench/indirect/figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/check.h"
#include "bench/indirect/images.h"
#include "bench/report/image_figures.h"
#include "ray/ray_scene.h"

namespace gnomon::bench {

namespace {

using light_quadtree::LightNode;

constexpr int k_shown_side = 256;   // of an image; coarse levels are enlarged
constexpr double k_gamma = 2.2;     // of the images of flux
constexpr double k_bright = 0.98;   // quantile of flux that is shown white

std::uint8_t byte_of(double value)
{
    return static_cast<std::uint8_t>(std::lround(255 * std::clamp(value, 0.0, 1.0)));
}

// Paints one level of a view's pyramid; color(node, rgb) gives the colour of a node.
template <class Color>
Image8 level_image(const light_quadtree::LightMap& map, const light_quadtree::MapView& view, int level,
                   const Color& color)
{
    Image8 image(k_shown_side, k_shown_side, 3);
    for (int y = 0; y < k_shown_side; ++y)
        for (int x = 0; x < k_shown_side; ++x) {
            const int side = 1 << level;
            const std::size_t id = view.node(level, x * side / k_shown_side, y * side / k_shown_side);
            const glm::dvec3 rgb = color(map.node(id), id);
            for (int c = 0; c < 3; ++c)
                image.data[3 * (static_cast<std::size_t>(y) * k_shown_side + static_cast<std::size_t>(x)) +
                           static_cast<std::size_t>(c)] = byte_of(rgb[c]);
        }
    return image;
}

}   // namespace

LightMapFigures light_map_figures(const std::shared_ptr<const scene::Scene>& scene, int frame,
                                  const light_quadtree::LightMapOptions& options, Tasks& tasks)
{
    const scene::SceneState state(scene, scene->timeline.time_of(frame));
    const ray::RayScene rays(state);
    const light_quadtree::LightMap map(state, rays, options, tasks);
    LightMapFigures figures;
    if (map.views().empty() || !map.views().front().on) return figures;
    const light_quadtree::MapView& view = map.views().front();

    // Find the scale of flux, and the bounds of positions.
    std::vector<double> flux;
    Box3 box;
    float least = 1, most = 0;
    for (std::size_t id = view.node(view.levels, 0, 0); id < view.end(); ++id) {
        const LightNode& node = map.node(id);
        if (node.members == 0) continue;
        for (int c = 0; c < 3; ++c) flux.push_back(static_cast<double>(node.flux[c]));
        box.add(node.position);
        least = std::min(least, node.depth), most = std::max(most, node.depth);
    }
    if (flux.empty()) return figures;
    const auto at = flux.begin() + static_cast<std::ptrdiff_t>(k_bright * static_cast<double>(flux.size() - 1));
    std::nth_element(flux.begin(), at, flux.end());
    const double white = std::max(*at, 1e-30);
    const glm::dvec3 low(box.low), extent = glm::max(glm::dvec3(box.high) - low, glm::dvec3(1e-30));

    // Paint the four parts of the map.
    const auto add = [&](const char* name, const auto& color) {
        figures.map.push_back({name, level_image(map, view, view.levels, [&](const LightNode& node, std::size_t) {
                                   return node.members == 0 ? glm::dvec3(0) : color(node);
                               })});
    };
    add("reflected flux", [&](const LightNode& n) {
        glm::dvec3 rgb;
        for (int c = 0; c < 3; ++c) rgb[c] = std::pow(static_cast<double>(n.flux[c]) / white, 1 / k_gamma);
        return rgb;
    });
    add("position", [&](const LightNode& n) { return (glm::dvec3(n.position) - low) / extent; });
    add("normal", [](const LightNode& n) { return 0.5 * glm::dvec3(n.normal) + 0.5; });
    add("depth", [&](const LightNode& n) {
        return glm::dvec3(static_cast<double>(n.depth - least) / std::max(1e-6, static_cast<double>(most - least)));
    });

    // Paint the validity of each level: the flux of valid nodes, and black.
    for (int level = view.levels - 1; level >= 0; --level) {
        const double scale = white * std::pow(4, view.levels - level);
        std::size_t valid = 0;
        const std::size_t first = view.node(level, 0, 0), end = view.node(level + 1, 0, 0);
        for (std::size_t id = first; id < end; ++id) valid += map.node(id).members > 0 && map.valid(id);
        figures.validity.push_back({fmt::format("level {}: {} of {} valid", 10 - level, valid, end - first),
                                    level_image(map, view, level, [&](const LightNode& n, std::size_t id) {
                                        glm::dvec3 rgb(0);
                                        if (n.members == 0 || !map.valid(id)) return rgb;
                                        for (int c = 0; c < 3; ++c)
                                            rgb[c] = std::pow(static_cast<double>(n.flux[c]) / scale, 1 / k_gamma);
                                        return rgb;
                                    })});
    }
    return figures;
}

std::vector<NamedImage> light_figures(const IndirectStudy& study, const std::vector<glm::vec3>& irradiance)
{
    const std::vector<glm::vec3> none(irradiance.size(), glm::vec3(0));
    return {{"direct light", lit_image(study, none)},
            {"indirect light", lit_image(study, irradiance, false)},
            {"both", lit_image(study, irradiance)}};
}

}   // namespace gnomon::bench
