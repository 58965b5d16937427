// SPDX-License-Identifier: Apache-2.0
#pragma once
// The data that a tile hands to the techniques of the traced frame: the points of one queue, side by side.
//
// A technique is called once for a whole batch (shadows: once per light and batch), so that its virtual calls cost
// nothing per point or ray, and so that its rays stay in full packets.

#include <algorithm>
#include <cstdint>
#include <functional>
#include <span>

#include "base/tasks.h"
#include "scene/view.h"
#include "shading/shading.h"
#include "shadow_culling/certified/shadow_point.h"

namespace gnomon::trace {

inline float largest(const glm::vec3& v)
{
    return std::max({v.x, v.y, v.z});
}

/// What a technique needs to know of a frame; all of it outlives the frame.
struct FrameContext {
    const scene::SceneState& state;
    const ray::RayScene& rays;   // follows the state
    const scene::View& view;
    Tasks& tasks;
};

/// A square of pixels, cut off at the image's borders. Its pixels are numbered row by row, `side` to a row.
struct Tile {
    int x = 0, y = 0, width = 0, height = 0;
    int side = 0;

    glm::ivec2 pixel_of_image(std::uint32_t pixel) const
    {
        return {x + static_cast<int>(pixel) % side, y + static_cast<int>(pixel) / side};
    }
    /// Place in an image of that width, row by row.
    std::size_t index_in_image(std::uint32_t pixel, int image_width) const
    {
        const glm::ivec2 at = pixel_of_image(pixel);
        return static_cast<std::size_t>(at.y) * static_cast<std::size_t>(image_width) + static_cast<std::size_t>(at.x);
    }
};

/// The tiles of an image are numbered row by row.
/// @param columns  tiles in a row
/// @param side     power of two
inline Tile tile_at(std::size_t index, int columns, int side, Size size)
{
    Tile tile;
    tile.side = side;
    tile.x = static_cast<int>(index) % columns * side;
    tile.y = static_cast<int>(index) / columns * side;
    tile.width = std::min(side, size.width - tile.x);
    tile.height = std::min(side, size.height - tile.y);
    return tile;
}

/// What a path knows of the lobe (shading/lobe_rays.h) that it left, if any.
struct LobePath {
    std::uint32_t light = 0;    // which sum its light is added to, from 1 on; 0: that of its pixel
    std::uint32_t number = 0;   // of the ray that left the first lobe
    float rays = 0;             // into how many the path was divided; 0: it was not
};

/// What a ray shows at its end.
struct PathEnd {
    bool no_light = false;   // emission and background are counted already, by a lobe
    float emission = 1;      // the share of emission that is not counted already, by a highlight
    float background = 1;    // likewise, of the background
    glm::vec3 open{0};       // radiance that takes the place of the rest of the background: the mean over a lobe
};

/// The path that a ray in a queue continues.
struct Path {
    std::uint32_t pixel;    // of the tile; or the number of a sample (PointBatch::pixels)
    glm::vec3 throughput;   // of the path so far: the weight of what the ray brings in the pixel's colour
    shading::RayCone cone;
    PathEnd end = {};
    LobePath lobe = {};
    float parts = 1;           // paths into which a rough surface split it
    bool straight = false;     // it came from the camera without being reflected or refracted
    std::uint8_t splits = 0;   // how often it took the dimmer of two rays: path_splits.h
};

/// A point to shade.
struct TilePoint {
    shading::SurfacePoint surface;
    shading::Continuation next;
    std::uint32_t pixel;   // as of its path
    glm::vec3 throughput;
    float distance = 0;            // from where its ray started
    float parts = 1;               // as of its path
    bool straight = false;         // see Path
    std::uint8_t splits = 0;       // likewise
    bool behind = false;           // its light counts as what lies behind the scene: TracedOptions::backdrop_apart
    bool glossy = false;           // its lobe's share of emission and background: see IndirectLight::reflects_lobes()
    bool coat_glossy = false;      // likewise, of its coat's lobe
    bool has_bounced = false;      // its bounced light is known
    bool has_irradiance = false;   // and it is what the surface reflects of `irradiance`
    glm::vec3 irradiance{0};
    float image_by_lobe = 0;   // what its lobe shows of the environment image, of what it would show by itself
    float hidden = 1;          // at most this share of its hemisphere, by cosine, is filled by surfaces
    glm::vec3 open{0};         // mean radiance that rays of its lobe show of the image where they meet nothing
    PathEnd end;               // of the path that it ends
    LobePath lobe;             // likewise
};

/// The points of one queue. The spans hold until the batch is shaded.
struct PointBatch {
    std::span<const TilePoint> points;
    std::span<const shadow_culling::ShadowPoint> shadow_points;   // by point; an unlit surface has normal 0
    std::span<const glm::vec3> normals;                           // by point: shading normals
    Tile tile;
    bool primary = false;        // first hits, not seen in mirrors or through glass
    bool first_sample = false;   // of the pixels
    /// Empty, or the pixels, of the tile, of further samples of some pixels: TilePoint::pixel then numbers the samples.
    std::span<const std::uint32_t> pixels = {};
    float most_share = 1;   // of its pixel, that the light of a point makes

    bool scattered() const { return !pixels.empty(); }
    /// At most this share of its pixel is a point's light.
    float share_of(const TilePoint& point) const { return most_share * largest(point.throughput); }
    glm::ivec2 pixel_of_image(const TilePoint& point) const
    {
        return tile.pixel_of_image(scattered() ? pixels[point.pixel] : point.pixel);
    }
};

/// Takes radiance that a point reflects towards the viewer, throughput left out, and the part of it that comes from its
/// lobes; the rest is proportional to its diffuse reflectance, but for sheen.
using AddReflected = std::function<void(const TilePoint&, const glm::vec3& radiance, const glm::vec3& by_lobe)>;

/// The first hits of a tile, by ray.
struct PrimaryRays {
    const ray::RayQueue& rays;
    const ray::Hits& hits;
    std::span<const Path> paths;
    Tile tile;
};

}   // namespace gnomon::trace
