// SPDX-License-Identifier: Apache-2.0
#pragma once
// Indirect light from a light map, without occlusion: the published light quad-tree [Ki and Oh 2007], and the sampling
// of reflective shadow maps to which it is compared [Dachsbacher and Stamminger 2005].
//
// Sparse receivers [Ki and Oh 2007, 3.3]: light is gathered on a coarse grid of the image's points. A pixel
// interpolates from the surrounding grid points if their positions and normals agree with its own; every other pixel
// gathers by itself. Kept buffers: while neither scene, lights nor view change, the map, the cut and the grid's light
// are reused.
//
// Known flaws, as in the papers: bounced light is not occluded, so it leaks and is too bright; MapLightOptions::shadows
// mends that. Cost: the map's
// (light_map.h); then lights times receivers.

#include <memory>
#include <span>

#include "light_quadtree/cluster_shadows.h"
#include "light_quadtree/rsm.h"

namespace gnomon::light_quadtree {

enum class MapMethod : std::uint8_t {
    quadtree,
    rsm,
    brute
};   // brute: every texel is a light; the ground truth of both

struct MapLightOptions {
    MapMethod method = MapMethod::quadtree;
    LightMapOptions map;
    CutLevels levels;
    /// quadtree: every receiver goes through the tree by itself, level by level [3.2]: the same sums, to the bit.
    bool as_printed = false;
    bool shadows = false;   // quadtree, traced: clusters are occluded (cluster_shadows.h)
    RsmOptions rsm;
    int grid = 64;                 // sparse receivers along the image's longer side; 0: every pixel gathers
    float grid_normals = 0.9f;     // a grid point agrees if the cosine between the normals exceeds this
    float grid_off_plane = 0.1f;   // and its distance from the pixel's plane is below this fraction of the spacing
    int grid_neighbours = 3;       // number of the four that must agree
};

/// The point of a pixel at which light is computed.
struct MapReceiver {
    glm::vec3 position{0};
    glm::vec3 normal{0};    // unit, shading; zero: no surface
    float width = 0;        // of a pixel at the point, in scene units
    glm::ivec2 pixel{-1};   // negative: not a point of the image itself (seen in a mirror)
};

struct MapLightCounters {
    std::uint64_t lights = 0;         // clusters, or samples
    std::uint64_t gathered = 0;       // receivers
    std::uint64_t interpolated = 0;   // pixels
    bool kept_map = false;            // no texel of the map changed
    bool kept_grid = false;           // the grid's light was reused
    ShadowCounters shadow;
};

class MapLight {
 public:
    MapLight(const scene::SceneState& state, const ray::RayScene& rays, const MapLightOptions& options, Tasks& tasks);

    /// Makes everything anew in the next frame, as the paper does where something moves.
    void forget() { forgotten_ = true; }
    /// Call after the state advanced and the ray scene was updated. The ray scene is used until the next call.
    void begin_frame(const scene::SceneState& state, const ray::RayScene& rays, Tasks& tasks);

    /// Pixels between two receivers of the grid, for an image of that size; 0: no grid.
    int grid_step(int width, int height) const;
    /// With shadows: what static geometry does is also remembered for pixels of an image of that size, which the points
    /// of shade() name. Without it, for the grid alone. Call after begin_frame().
    void begin_image(int width, int height);
    /// Gathers at the grid's receivers, given row by row from pixel (0, 0) on, `columns` per row. Call after
    /// begin_frame().
    void set_grid(std::span<const MapReceiver> receivers, int columns, int step, Tasks& tasks);

    /// Scratch memory and counters of one thread.
    struct Batch {
        Receivers receivers;
        RsmPlaces places;
        std::vector<std::uint32_t> waiting;
        std::vector<PathModes::Row*> rows;
        ShadowScratch shadows;
        MapLightCounters counters;
    };
    /// Irradiance at points. Thread-safe if every thread uses its own batch, and the points of a pixel are in those of
    /// one thread.
    void shade(Batch& batch, std::span<const MapReceiver> points, glm::vec3* irradiance) const;
    /// Irradiance at receivers as a structure of arrays, all gathered without interpolation. begin, end: as for
    /// gather().
    void gather_all(Receivers& receivers, std::size_t begin, std::size_t end, Batch& batch) const;

    void end_frame(std::span<const std::unique_ptr<Batch>> batches);
    const MapLightCounters& counters() const { return counters_; }
    const LightMap& map() const { return map_; }
    const Clusters& clusters() const { return clusters_; }
    const MapLightOptions& options() const { return options_; }
    std::size_t bytes() const;

 private:
    bool interpolate(const MapReceiver& point, glm::vec3& irradiance) const;
    void gather_some(Receivers& receivers, std::size_t begin, std::size_t end, Batch& batch,
                     std::span<PathModes::Row* const> rows) const;
    void find_lights();
    PathModes::Row* row_of(const MapReceiver& point) const;

    MapLightOptions options_;
    LightMap map_;
    Clusters clusters_;
    std::uint32_t clusters_version_ = 0;   // of the map
    std::vector<MapReceiver> grid_;
    std::vector<glm::vec3> grid_light_;
    int grid_columns_ = 0, grid_step_ = 0;
    std::uint32_t grid_version_ = 0;   // of the map
    const ray::RayScene* rays_;
    // With shadows: paths of the grid's receivers and of pixels, and the boxes of dynamic objects.
    PathModes grid_modes_;
    mutable PathModes pixel_modes_;   // a pixel belongs to one thread
    int width_ = 0, height_ = 0;      // of the image; 0: pixels are not remembered
    std::unique_ptr<visibility::DynamicBounds> dynamic_;
    bool forgotten_ = false;
    MapLightCounters counters_;
};

}   // namespace gnomon::light_quadtree
