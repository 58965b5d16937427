// SPDX-License-Identifier: Apache-2.0
#pragma once
// Computes indirect irradiance at points of surfaces by path tracing, with an estimate of its error: the reference for
// the faster methods.
//
// Paths follow the light that diffuse surfaces reflect [Kajiya 1986, "The Rendering Equation"]. From a point, rays are
// distributed in proportion to the cosine. Where a ray meets a surface, one light is sampled by a shadow ray
// (next-event estimation), and the path continues for the given number of bounces. Nothing is cached, filtered or
// clamped: the estimate is unbiased, and the spread between batches of samples gives its error.
//
// The rules, here as for every kind of indirect light in this library:
//   - Surfaces reflect the fraction `diffuse`, equally in all directions, on both sides of a one-sided surface as well.
//   - Lobes of rough surfaces (Request::glossy) reflect emissive surfaces and the background, without a bounce.
//   - Mirrors and glass cast no light on other surfaces. A surface that does not block shadow rays does not block
//     indirect light; one that thins light blocks a path with the probability of what it does not let through.
//   - All lights of the scene take part, whatever their falloff. One of them is sampled at a time (light_choice.h), and
//     one place of an emissive surface (emitter_sampler.h).
//   - Irradiance is the integral of radiance times the cosine. The lights of AFF lack a factor of pi, and its radiance
//     is that of its images; so for every material: reflected radiance = diffuse / pi * irradiance.
// Directional lights are discs of an angular diameter, if one is given: a direction in it is drawn for each ray.
// With `surroundings`, the background lights the points too: the sky, and the environment image in place of the lights
// that approximate it (by both kinds of sampling, combined by the balance heuristic [Veach and Guibas 1995]). With
// `shining`, emissive surfaces emit light, whatever other lights there are, in place of the lights that approximate
// them (scene/defaults/emissive_lights.h), and are sampled in the same two ways. Otherwise lights alone do.
//
// Light that reaches a path's first surfaces over one bounce is found in a second way, too: a ray that leaves a light
// or an emissive surface ends where light arrives, and that place is connected with the path by a shadow ray [Veach and
// Guibas 1994, "Bidirectional Estimators for Light Transport"]; the balance heuristic weighs both. Lit places that few
// rays from elsewhere meet, such as the circle of a spot light or the gap above a luminous plate, are sampled by their
// light. Where surfaces thin light or let it through, there is the first way alone.
//
// All decisions of a path are points of scrambled low-discrepancy sequences (sample_pattern.h); paths of low throughput
// end at random from the second bounce on. The result is the same for any number of threads: a point's random numbers
// depend on the seed and its key alone. Cost: a sample is one ray and at most one shadow ray per bounce, in packets; a
// ray from a light, and a shadow ray for each connection.

#include <memory>
#include <span>
#include <vector>

#include "base/tasks.h"
#include "gnomon/types.h"
#include "ray/ray_scene.h"
#include "reference/emitter_sampler.h"
#include "reference/environment_sampler.h"
#include "reference/light_choice.h"
#include "reference/light_emission.h"
#include "reference/sample_pattern.h"
#include "shading/surface.h"

namespace gnomon::reference {

struct ReferenceOptions {
    int samples = 1024;   // paths a point, 1 or more
    int bounces = 1;      // diffuse bounces after the first surface that light meets, 0 or more
    std::uint64_t seed = 0;
    bool surroundings = false;   // also light from the background (see above)
    bool shining = false;
    bool shining_unbounced = true;   // with `shining`: emission also reaches the points themselves
    double sun_diameter = 0;         // angular, of directional lights, in radians; 0: points
};

/// A point whose irradiance is computed.
struct IrradiancePoint {
    glm::vec3 position{0};
    glm::vec3 geometric_normal{0};   // unit, on the side that is lit
    glm::vec3 normal{0};             // unit, shading; on that side too
    float offset = 0;                // how far along the geometric normal rays must start
    std::uint64_t key = 0;           // seed of its random numbers, with ReferenceOptions::seed
    // Of smooth meshes (shading::SurfacePoint::smooth_normal, shading::smooth_origin()). Normal 0: of no use.
    glm::vec3 smooth_normal{0}, smooth_origin{0};
};

/// The point of a triangle that a ray met at (1-u-v) p0 + u p1 + v p2, on the side towards `to_viewer`.
IrradiancePoint irradiance_point(const scene::Scene& scene, const ray::RayScene& rays, scene::ObjectId object,
                                 std::uint32_t triangle, float u, float v, const glm::vec3& to_viewer,
                                 std::uint64_t key);
/// @param smooth_origin  shading::smooth_origin()
IrradiancePoint irradiance_point(const shading::SurfacePoint& surface, const glm::vec3& smooth_origin,
                                 std::uint64_t key);

/// Irradiance at a point, without the direct light of the lights.
struct IrradianceEstimate {
    glm::vec3 indirect{0};         // after 1 to `bounces` bounces
    glm::vec3 surroundings{0};     // without a bounce: from the sky, the environment image and emissive surfaces
    glm::vec3 indirect_error{0};   // standard error of `indirect`; 0 with one sample
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

/// The data of a frame that all its paths read.
class ReferenceLight {
 public:
    ReferenceLight(const scene::SceneState& state, const ray::RayScene& rays, const ReferenceOptions& options);

    /// Whether the direct light of this light is to be added. Otherwise it is part of the surroundings.
    bool uses(const scene::Light& light) const
    {
        return !(options_.surroundings && light.of_environment) && !(options_.shining && light.of_surface);
    }
    const ReferenceOptions& options() const { return options_; }

 private:
    friend class ReferencePaths;
    const scene::SceneState& state_;
    const ray::RayScene& rays_;
    ReferenceOptions options_;
    std::vector<scene::LightId> lights_;   // that emit light
    std::unique_ptr<LightChoice> choice_;
    scene::Background background_;   // without the sun, which is a light
    bool background_shines_ = false;
    std::unique_ptr<EmitterSampler> emitters_;          // null: no surface shines
    bool transparent_ = false;                          // some materials do not block light
    std::unique_ptr<EnvironmentSampler> environment_;   // null: none to sample
    std::unique_ptr<LightEmission> emission_;           // null: paths are not connected with places that are lit
};

/// Traces paths in bulk. One object per thread; its memory is reused.
class ReferencePaths {
 public:
    explicit ReferencePaths(const ReferenceLight& light) : light_(light) {}

    struct Request {
        IrradiancePoint point;
        int samples = 1;
        /// If given, the point's surface (shading/glossy.h): `surroundings` is then the radiance that its lobe reflects
        /// to the viewer, of emissive surfaces and of the background whatever it is, and `indirect` is 0.
        const shading::SurfacePoint* glossy = nullptr;
    };
    /// @param out  one for each request
    void estimate(std::span<const Request> requests, IrradianceEstimate* out);
    const ReferenceCounters& counters() const { return counters_; }

 private:
    // A path and its last surface.
    struct Path {
        PathNumbers numbers;
        glm::vec3 position, origin;   // the surface point; the origin of rays from it
        glm::vec3 geometric_normal, normal;
        glm::vec3 smooth_normal, smooth_origin;   // of the smooth horizon, and of rays between it and the triangle's
        glm::vec3 weight;                         // throughput: irradiance at the path's start per irradiance here
        glm::vec3 direction;                      // of its next ray
        glm::vec3 indirect, surroundings;
        std::uint32_t passes = 0;                        // surfaces that thin light that it met
        float inverse_density = 0;                       // see from_light()
        bool aff = false;                                // the surface counts irradiance as AFF does
        const shading::SurfacePoint* glossy = nullptr;   // of a path that starts at a lobe, and ends with its first ray

        bool is_above(const glm::vec3& way) const { return glm::dot(way, smooth_normal) > 0; }
        const glm::vec3& origin_to(const glm::vec3& way) const
        {
            return glm::dot(way, geometric_normal) > 0 ? origin : smooth_origin;
        }
    };
    // A place that a ray from a light meets.
    struct LitPlace {
        EmittedRay ray;
        scene::ObjectId object = scene::none;
        std::uint32_t triangle = 0;
        float u = 0, v = 0;
        glm::vec3 position{0}, geometric_normal{0};   // on the side that is lit, above it by the rounding of rays
        float density = 0;   // per unit of area, that a ray from a light ends here, over that of its direction
    };
    class Sum;
    void push_first(const Request& request, int batch, std::uint32_t u, std::uint32_t v, int sample);
    void run_paths();
    void ask_environment(int bounce);
    void ask_emitters(int bounce);
    bool trace_on(int bounce);
    void pass_transparent();
    shading::SurfacePoint surface_of(std::size_t ray) const;
    const scene::Material& material_of(std::size_t ray) const;
    static void gain(Path& path, int bounce, const glm::vec3& irradiance);
    static float own_density(const Path& path, const glm::vec3& direction);
    static glm::vec3 response(const Path& path, const glm::vec3& direction);
    void ask_lights(int bounce);
    // Of the second way to light over one bounce (reference_connections.cpp).
    void find_lit_places();
    bool connects(int bounce) const;
    void connect(int bounce);
    glm::vec3 arriving(const LitPlace& place, const shading::SurfacePoint& s, float own, float& both);
    static float from_light(const Path& path, const glm::vec3& to_light, float density);
    void choose_directions(int bounce);
    void trace_shadows(bool to_surroundings);
    /// What surfaces along the rays let through, in passed_.
    void let_through(const ray::RayQueue& rays);

    const ReferenceLight& light_;
    ReferenceCounters counters_;
    SamplePattern pattern_;
    std::vector<Path> paths_;
    std::vector<LitPlace> lit_;   // by path
    ray::RayQueue rays_, shadow_rays_, passing_;
    std::vector<std::uint32_t> ray_path_, shadow_path_,
        standing_;   // by ray: its path; paths that still have a surface
    std::vector<glm::vec3> shadow_gain_;
    std::vector<EmitterPoint> emitter_points_;   // by ray
    LightChoice::Scratch choice_;
    ray::Hits hits_, next_hits_;
    std::vector<std::uint32_t> passing_ray_;
    std::vector<std::uint8_t> occluded_;
    std::vector<glm::vec3> passed_;   // by ray
};

}   // namespace gnomon::reference
