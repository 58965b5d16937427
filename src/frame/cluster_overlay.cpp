// SPDX-License-Identifier: Apache-2.0
#include "frame/cluster_overlay.h"

#include <algorithm>
#include <optional>

#include "shading/surface.h"

namespace gnomon::frame {

namespace {

using light_quadtree::LightMap;

// A surface point belongs to a texel whose own point lies within this many texel widths.
constexpr float k_nearness = 2.5f;

struct Cluster {
    std::size_t node;
    int grid;   // log2 of the nodes a side of its level
};

// Descends from the start level, as the cut does.
std::optional<Cluster> cluster_at(const LightMap& map, const light_quadtree::CutLevels& levels,
                                  const glm::vec3& position)
{
    for (const LightMap::View& view : map.views()) {
        if (!view.on) continue;
        const glm::vec4 clip = view.projection.clip_from_world * glm::vec4(position, 1);
        if (!(clip.w > 0) || !(std::abs(clip.x) < clip.w) || !(std::abs(clip.y) < clip.w)) continue;
        const auto side = static_cast<float>(view.side());
        const int x = std::min(static_cast<int>((clip.x / clip.w * 0.5f + 0.5f) * side), view.side() - 1);
        const int y = std::min(static_cast<int>((clip.y / clip.w * 0.5f + 0.5f) * side), view.side() - 1);
        const light_quadtree::LightNode& texel = map.node(view.node(view.levels, x, y));
        if (texel.flux == glm::vec3(0)) continue;
        if (!(glm::length(texel.position - position) < k_nearness * std::sqrt(texel.area))) continue;
        const LightMap::Tree tree = map.tree_of(view, x, y);
        const int limit = std::min(light_quadtree::grid_of_paper_level(levels.limit), view.levels);
        for (int grid = light_quadtree::grid_of_paper_level(levels.start); grid <= limit; ++grid) {
            const int up = view.levels - grid;
            const std::size_t id = map.number(tree, view.node(grid, x >> up, y >> up));
            if (grid == limit || map.share(tree, view, grid, x >> up, y >> up) == light_quadtree::k_whole_share)
                return Cluster{id, grid};
        }
    }
    return {};
}

// Returns the saturated colour of a hue in [0, 1).
glm::vec3 hue_color(float hue)
{
    const auto channel = [&](float from) {
        const float h = hue + from;
        return std::clamp(std::abs((h - std::floor(h)) * 6 - 3) - 1, 0.0f, 1.0f);
    };
    return {channel(0), channel(2.0f / 3), channel(1.0f / 3)};
}

glm::vec3 color_of(const Cluster& cluster, int start)
{
    constexpr float k_golden = 0.61803399f;   // neighbours in number are far apart in hue
    const float turn = static_cast<float>(cluster.node % 65536) * k_golden;
    const glm::vec3 full = hue_color(turn - std::floor(turn));
    const float bright = std::max(0.4f, 1 - 0.2f * static_cast<float>(cluster.grid - start));
    return bright * (0.25f + 0.75f * full);
}

}   // namespace

Image8 paint_clusters(const scene::Scene& scene, const ray::RayScene& rays, const scene::View& view,
                      const light_quadtree::MapLight& light, Tasks& tasks)
{
    constexpr glm::vec3 k_unlit(0.25f), k_background(0.08f);
    constexpr float k_away = 0.35f;   // brightness of a surface seen edge on
    const light_quadtree::CutLevels& levels = light.options().levels;
    Image8 image(view.size.width, view.size.height, 3);
    tasks.for_each(static_cast<std::size_t>(view.size.height), [&](std::size_t row, int) {
        const int y = static_cast<int>(row);
        ray::RayQueue queue;
        queue.purpose = ray::RayClass::primary;
        for (int x = 0; x < view.size.width; ++x) {
            glm::vec3 origin, direction;
            float tnear, tfar;
            view.ray(static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f, origin, direction, tnear, tfar);
            queue.push(origin, tnear, direction, tfar);
        }
        ray::Hits hits;
        hits.resize(queue.size());
        rays.closest(queue, 0, queue.size(), hits, ray::Sides::front);
        for (std::size_t i = 0; i < queue.size(); ++i) {
            glm::vec3 color = k_background;
            if (hits.object[i] != scene::none) {
                shading::SurfacePoint s;
                shading::surface_at(scene, rays.geometry(hits.object[i]), hits.triangle[i], hits.u[i], hits.v[i],
                                    hits.t[i], queue.direction(i), {view.pixel_width, view.pixel_spread}, s);
                const auto cluster = cluster_at(light.map(), levels, s.position);
                color = cluster ? color_of(*cluster, light_quadtree::grid_of_paper_level(levels.start)) : k_unlit;
                color *= k_away + (1 - k_away) * std::abs(glm::dot(s.normal, s.to_viewer));
            }
            std::uint8_t* to = image.pixel(static_cast<int>(i), y);
            for (int c = 0; c < 3; ++c) to[c] = static_cast<std::uint8_t>(255 * color[c] + 0.5f);
        }
    });
    return image;
}

}   // namespace gnomon::frame
