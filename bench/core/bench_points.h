// SPDX-License-Identifier: Apache-2.0
#pragma once
// The shading points of one tile, for benches that measure shadow passes by themselves: primary hits, and with a depth
// above 0 the hits of the reflected and refracted rays that the traced frame would trace from there.
//
// The rays are the traced frame's to the bit (a test holds them to its log); their order is not. Primary hits come
// first. Costs what the frame without its lights costs; never part of a measured time.

#include <cstdint>
#include <vector>

#include "scene/view.h"
#include "shading/shading.h"
#include "shadow_culling/certified/certified_culling.h"

namespace gnomon::bench {

/// A primary hit, for who looks on.
struct SeenPixel {
    int x = 0, y = 0;
    scene::ObjectId object = scene::none;
    std::uint32_t triangle = 0;
    glm::vec3 origin{0}, direction{0};   // of its ray
};

struct BenchPoints {
    std::vector<shadow_culling::ShadowPoint> points;   // primary hits, then those of reflected and refracted rays
    std::size_t primary = 0;                           // so many of them
    std::vector<SeenPixel> pixels;                     // of the primary ones
    std::vector<glm::vec3> diffuse;                    // reflectance, of the primary ones
    std::uint64_t reflected_rays = 0, refracted_rays = 0;
};

/// One a thread, reused from tile to tile.
class PointTracer {
 public:
    static constexpr int k_tile = 32;   // pixels a side

    /// Replaces `out` by the points of the tile with its top left corner at (x0, y0).
    /// @param max_depth  reflections and refractions in a row
    /// @param rays_log   optional: every ray traced is added
    void trace(const scene::SceneState& state, const ray::RayScene& rays, const scene::View& view, int x0, int y0,
               int max_depth, BenchPoints& out, ray::RayQueue* rays_log = nullptr);

 private:
    struct Path {
        glm::vec3 share;
        shading::RayCone cone;
    };
    struct Continued {
        shading::SurfacePoint surface;
        glm::vec3 share;
    };
    void queue_primary(const scene::View& view, int x0, int y0);
    void follow(const scene::SceneState& state, const ray::RayScene& rays, bool primary, BenchPoints& out);
    void queue_continuations();

    ray::RayQueue queue_;
    std::vector<Path> paths_;   // by ray of the queue
    std::vector<std::pair<int, int>> pixels_;
    ray::Hits hits_;
    std::vector<Continued> shaded_;
    std::uint64_t reflected_ = 0, refracted_ = 0;   // rays in the queue
};

}   // namespace gnomon::bench
