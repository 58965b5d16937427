// SPDX-License-Identifier: Apache-2.0
#pragma once
// The reference: indirect light by brute force, at given points of surfaces, with its own error.
//
// A path tracer for light that diffuse surfaces send on [Kajiya 1986, "The Rendering Equation"]: from a point, rays in
// proportion to the cosine; where one meets a surface, a lamp is asked for directly, by a shadow ray (next-event
// estimation), and the path goes on, as often as there are bounces. Nothing is remembered, nothing is filtered, nothing
// is clamped: the estimate is unbiased, and its spread between batches says how far off it is.
//
// What counts, here as for every kind of indirect light in this library:
//   - Surfaces reflect their `diffuse` share, evenly to all sides; both sides of a one-sided surface do.
//   - Mirrors and glass throw no light on other surfaces. What does not block a shadow ray does not block this light.
//   - Lights: all of the scene, whatever their falloff. Several are asked one at a time, chosen at random in proportion
//     to what each would add unshadowed.
//   - Irradiance is the integral of radiance times the cosine. AFF, whose lights lack a factor of pi, counts in
//   radiance
//     as its images show it; so for every material: radiance sent on = diffuse / pi * irradiance.
// With `surroundings`, what lies behind everything lights the points too: the sky and an image of the surroundings
// themselves, instead of the lights that stand for the image (by both kinds of sampling, weighted by the balance
// heuristic [Veach and Guibas 1995]). With `shining`, surfaces that shine by themselves do so too; else lights alone
// light, which scenes without any get in place of such surfaces (scene/defaults/emissive_lights.h).
//
// The same for any number of threads. A point's random numbers depend on the seed and its key alone.
// Cost: a sample is one ray and at most one shadow ray a bounce, in packets.

#include <memory>
#include <span>
#include <vector>

#include "base/random.h"
#include "base/tasks.h"
#include "gnomon/types.h"
#include "ray/ray_scene.h"
#include "reference/environment_sampler.h"
#include "reference/sample_pattern.h"
#include "shading/surface.h"

namespace gnomon::reference {

struct ReferenceOptions {
    int samples = 1024;   // paths a point, 1 or more
    int bounces = 1;      // diffuse bounces after the first surface that light meets, 0 or more
    std::uint64_t seed = 0;
    bool surroundings = false;   // also light that is no lamp's (see above)
    bool shining = false;
};

/// Where light is asked for.
struct IrradiancePoint {
    glm::vec3 position{0};
    glm::vec3 geometric_normal{0};   // unit, on the side that is lit
    glm::vec3 normal{0};             // unit, shading; on that side too
    float offset = 0;                // how far along the geometric normal rays must start
    std::uint64_t key = 0;           // chooses its random numbers: points with equal keys have the same
};

/// The point of a triangle that a ray met at (1-u-v) p0 + u p1 + v p2, on the side towards `to_viewer`.
IrradiancePoint irradiance_point(const scene::Scene& scene, const ray::RayScene& rays, scene::ObjectId object,
                                 std::uint32_t triangle, float u, float v, const glm::vec3& to_viewer,
                                 std::uint64_t key);
IrradiancePoint irradiance_point(const shading::SurfacePoint& surface, std::uint64_t key);

/// What a point gets, three channels each; not what lamps add without a bounce.
struct IrradianceEstimate {
    glm::vec3 indirect{0};         // after one to `bounces` bounces
    glm::vec3 surroundings{0};     // with none, from the sky, an image of the surroundings, shining surfaces
    glm::vec3 indirect_error{0};   // standard error of `indirect`; 0 with one sample, which cannot tell
    glm::vec3 error{0};            // of the sum
};

struct ReferenceCounters {
    std::uint64_t paths = 0;
    std::uint64_t rays = 0;   // of both kinds
};

/// Estimates indirect irradiance at many points, in parallel.
/// @param rays   follows `state`
/// @throws InterruptedError  progress returned false
std::vector<IrradianceEstimate> reference_irradiance(const scene::SceneState& state, const ray::RayScene& rays,
                                                     std::span<const IrradiancePoint> points,
                                                     const ReferenceOptions& options, Tasks& tasks,
                                                     ReferenceCounters* counters = nullptr,
                                                     const Progress& progress = {});

/// What all paths of a frame read.
class ReferenceLight {
 public:
    ReferenceLight(const scene::SceneState& state, const ray::RayScene& rays, const ReferenceOptions& options);

    /// Whether this light's own, unbounced light is the lamp's to give (and not the surroundings').
    bool uses(const scene::Light& light) const { return !(options_.surroundings && light.of_environment); }
    const ReferenceOptions& options() const { return options_; }

 private:
    friend class ReferencePaths;
    const scene::SceneState& state_;
    const ray::RayScene& rays_;
    ReferenceOptions options_;
    std::vector<scene::LightId> lights_;   // that shine
    scene::Background background_;         // without the sun, which is a light
    bool background_shines_ = false;
    bool surfaces_shine_ = false;
    bool transparent_ = false;                          // something does not block light
    std::unique_ptr<EnvironmentSampler> environment_;   // null: none to sample
};

/// Paths in bulk, with the memory they need. One a thread.
class ReferencePaths {
 public:
    explicit ReferencePaths(const ReferenceLight& light) : light_(light) {}

    struct Request {
        IrradiancePoint point;
        int samples = 1;
    };
    /// @param out  one for each request
    void estimate(std::span<const Request> requests, IrradianceEstimate* out);
    const ReferenceCounters& counters() const { return counters_; }

 private:
    // A path and the surface that it stands on.
    struct Path {
        Random random;
        glm::vec3 position, origin;   // of the surface; of rays from it
        glm::vec3 geometric_normal, normal;
        glm::vec3 weight;      // irradiance at the path's start for irradiance here
        glm::vec3 direction;   // of its next ray
        glm::vec3 indirect, surroundings;
        bool aff = false;   // the surface counts irradiance as AFF does
    };
    class Sum;
    void push_first(const Request& request, int batch, std::uint32_t u, std::uint32_t v, int sample);
    void run_paths();
    void ask_environment(int bounce);
    bool trace_on(int bounce);
    void pass_transparent();
    shading::SurfacePoint surface_of(std::size_t ray) const;
    void ask_lights();
    void choose_directions();
    void trace_shadows(bool to_surroundings);

    const ReferenceLight& light_;
    ReferenceCounters counters_;
    SamplePattern pattern_;
    std::vector<Path> paths_;
    ray::RayQueue rays_, shadow_rays_, passing_;
    std::vector<std::uint32_t> ray_path_, shadow_path_, standing_;   // whose ray; paths that still stand on a surface
    std::vector<glm::vec3> shadow_gain_;
    std::vector<float> light_chance_;
    ray::Hits hits_, next_hits_;
    std::vector<std::uint32_t> passing_ray_;
    std::vector<std::uint8_t> occluded_;
};

}   // namespace gnomon::reference
