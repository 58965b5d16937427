// SPDX-License-Identifier: Apache-2.0
#pragma once
// Finds the surface points visible in an image, for bench indirect: the primary hits of all pixels, and points fixed to
// surfaces, which are found again in a later frame or from another view.

#include <vector>

#include "base/tasks.h"
#include "irradiance_cache/points/anchors.h"
#include "reference/reference.h"
#include "scene/view.h"
#include "trace/indirect_grid.h"

namespace gnomon::bench {

struct SeenPoint {
    irradiance_cache::IndirectPoint point;   // object is none where nothing was hit
    glm::vec2 place{0};                      // position in the image, in pixels
    glm::vec3 diffuse{0};                    // diffuse reflectance
    bool scatters = false;                   // whether the surface reflects diffusely, so that indirect light matters
};

// The diffuse points of a tile, as a traced frame passes them on.
struct SeenTile {
    std::vector<irradiance_cache::IndirectPoint> points;   // with their positions in the tile
    std::vector<std::size_t> pixels;
};

struct SeenImage {
    Size size;
    scene::View view;
    std::vector<SeenPoint> points;   // by pixel, row by row
    std::vector<SeenTile> tiles;     // of k_seen_tile x k_seen_tile pixels
    trace::IndirectGrid grid;        // for methods with sparse receivers; otherwise empty
    std::size_t index(int x, int y) const
    {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(size.width) + static_cast<std::size_t>(x);
    }
};

inline constexpr int k_seen_tile = 32;

/// Traces the primary rays through the centres of all pixels. If `grid_step` is above 0, every `grid_step`-th pixel
/// also gives a sparse receiver.
void see_image(const scene::SceneState& state, const ray::RayScene& rays, const scene::View& view, int grid_step,
               Tasks& tasks, SeenImage& out);

/// A point fixed to its object's surface, and the side from which it was seen.
struct FixedPoint {
    scene::ObjectId object = scene::none;
    std::uint32_t triangle = 0;
    float u = 0, v = 0;
    bool front = true;       // by the winding in world space
    std::uint64_t key = 0;   // selects the random numbers of references
};

/// The points of every `step`-th pixel in x and y that reflect diffusely, and their pixels.
struct PointGrid {
    std::vector<FixedPoint> points;
    std::vector<std::size_t> pixels;
};
PointGrid grid_of(const SeenImage& image, const ray::RayScene& rays, int step);

/// The current position of a fixed point, for a reference.
reference::IrradiancePoint place_of(const scene::Scene& scene, const ray::RayScene& rays, const FixedPoint& point);

/// Finds the points that are visible in a view. Cost: one ray per point.
/// @param seen  output: the indices of these points, ascending
std::vector<SeenPoint> find_again(const scene::Scene& scene, const ray::RayScene& rays, const scene::View& view,
                                  std::span<const FixedPoint> points, std::vector<std::size_t>& seen);

}   // namespace gnomon::bench
