// SPDX-License-Identifier: Apache-2.0
#pragma once
// Points of surfaces as an image shows them, for benches of indirect light: primary hits, and fixed points of surfaces
// that are found again in a later frame, or from elsewhere.

#include <vector>

#include "base/tasks.h"
#include "irradiance_cache/points/anchors.h"
#include "reference/reference.h"
#include "scene/view.h"
#include "trace/indirect_grid.h"

namespace gnomon::bench {

struct SeenPoint {
    irradiance_cache::IndirectPoint point;   // object is none where nothing was hit
    glm::vec2 place{0};                      // on the image, in pixels
    glm::vec3 diffuse{0};                    // share of light that it sends on evenly
    bool scatters = false;                   // a surface that reflects diffusely: bounced light matters there
};

// What scatters, tile by tile, as a traced frame hands it over.
struct SeenTile {
    std::vector<irradiance_cache::IndirectPoint> points;   // with their places in the tile
    std::vector<std::size_t> pixels;
};

struct SeenImage {
    Size size;
    scene::View view;
    std::vector<SeenPoint> points;   // by pixel, row by row
    std::vector<SeenTile> tiles;     // of k_seen_tile pixels a side
    trace::IndirectGrid grid;        // for methods that have sparse receivers; else empty
    std::size_t index(int x, int y) const
    {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(size.width) + static_cast<std::size_t>(x);
    }
};

inline constexpr int k_seen_tile = 32;

/// Primary hits through the centres of all pixels; at every `grid_step`-th pixel also as sparse receivers, if above 0.
void see_image(const scene::SceneState& state, const ray::RayScene& rays, const scene::View& view, int grid_step,
               Tasks& tasks, SeenImage& out);

/// A point that keeps its place on its object, and the side from which it was seen.
struct FixedPoint {
    scene::ObjectId object = scene::none;
    std::uint32_t triangle = 0;
    float u = 0, v = 0;
    bool front = true;       // by world winding
    std::uint64_t key = 0;   // chooses random numbers of references
};

/// Points of every `step`-th pixel in x and y that scatter, and their pixels.
struct PointGrid {
    std::vector<FixedPoint> points;
    std::vector<std::size_t> pixels;
};
PointGrid grid_of(const SeenImage& image, const ray::RayScene& rays, int step);

/// Where a fixed point is now, for a reference.
reference::IrradiancePoint place_of(const scene::Scene& scene, const ray::RayScene& rays, const FixedPoint& point);

/// Which of the points a view shows, and as what. Cost: a ray a point.
/// @param seen  out: indices of `points`, rising
std::vector<SeenPoint> find_again(const scene::Scene& scene, const ray::RayScene& rays, const scene::View& view,
                                  std::span<const FixedPoint> points, std::vector<std::size_t>& seen);

}   // namespace gnomon::bench
