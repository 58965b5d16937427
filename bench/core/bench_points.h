// SPDX-License-Identifier: Apache-2.0
#pragma once
// Finds the shading points of one tile, for benches that measure the shadow pass alone: the primary hits and, up to a
// given depth, the hits of the reflected and refracted rays that the traced frame would trace from them.
//
// The rays equal those of the traced frame to the bit, in another order (a test compares them with the frame's log).
// Primary hits come first. Cost: that of a traced frame without its lights; it is never part of a measured time.

#include <cstdint>
#include <vector>

#include "scene/view.h"
#include "shading/shading.h"
#include "shadow_culling/certified/certified_culling.h"
#include "trace/path_splits.h"

namespace gnomon::bench {

/// The primary hit of a pixel.
struct SeenPixel {
    int x = 0, y = 0;
    scene::ObjectId object = scene::none;
    std::uint32_t triangle = 0;
    float u = 0, v = 0;
    glm::vec3 origin{0}, direction{0};   // of its ray
};

struct BenchPoints {
    std::vector<shadow_culling::ShadowPoint> points;   // primary hits, then those of reflected and refracted rays
    std::vector<std::uint32_t> pixel;                  // by point: whose path reaches it, in the image's order
    std::size_t primary = 0;                           // number of primary hits
    std::vector<SeenPixel> pixels;                     // by primary hit
    std::vector<glm::vec3> diffuse;                    // diffuse reflectance, by primary hit
    std::uint64_t reflected_rays = 0, refracted_rays = 0;
};

/// Use one per thread; it is reused from tile to tile.
class PointTracer {
 public:
    static constexpr int k_tile = 32;   // width and height in pixels

    /// Replaces `out` by the points of the tile with its top left corner at (x0, y0).
    /// @param max_depth  largest number of reflections and refractions in a path
    /// @param rays_log   optional; receives every ray traced
    void trace(const scene::SceneState& state, const ray::RayScene& rays, const scene::View& view, int x0, int y0,
               int max_depth, BenchPoints& out, ray::RayQueue* rays_log = nullptr);

 private:
    struct Path {
        glm::vec3 throughput;
        shading::RayCone cone;
        std::uint32_t pixel;
        std::uint8_t splits = 0;
    };
    struct Continued {
        shading::SurfacePoint surface;
        glm::vec3 throughput;
        std::uint32_t pixel;
        std::uint8_t splits = 0;
        trace::PathSplits next;   // of the rays that continue from it
    };
    void queue_primary(const scene::View& view, int x0, int y0);
    void follow(const scene::SceneState& state, const ray::RayScene& rays, bool primary, BenchPoints& out);
    void queue_continuations();

    ray::RayQueue queue_;
    std::vector<Path> paths_;   // by ray of the queue
    std::vector<std::pair<int, int>> pixels_;
    ray::Hits hits_;
    std::vector<Continued> shaded_;
    std::uint64_t reflected_ = 0, refracted_ = 0;   // numbers of such rays in the queue
};

}   // namespace gnomon::bench
