// SPDX-License-Identifier: Apache-2.0
#pragma once
// Indirect light from surfaces so near that the light tree cannot tell them apart, because one of its leaves is as wide
// as they are far away. In slits and corners that is most of the light.
//
// Short rays with a cosine distribution find those surfaces, and rays from there to the lights find how they are lit.
// All points use the same directions around their normal, so neighbouring points differ only by what they see. The near
// field fades out towards its radius; nodes of the light tree provide the rest (far_fraction()). Where leaves are
// narrow the radius is less: they can tell surfaces apart from nearer by, and a few rays may miss small bright
// surfaces.
//
// Cost: `rays` short rays per point, and one ray per light where they meet a lit surface. Only static surfaces are part
// of the near field. Dynamic objects occlude it, and are light sources of their own (DynamicVirtualLight).

#include <span>
#include <vector>

#include "irradiance_cache/light_tree/light_tree.h"
#include "irradiance_cache/near_field/near_reach.h"
#include "ray/ray_scene.h"
#include "ray/thin_hits.h"

namespace gnomon::irradiance_cache {

/// Fraction of the light from a surface that is not part of the near field: 0 within half the radius, 1 from it on.
inline float far_fraction(float distance, float radius)
{
    if (!(distance < radius)) return 1;
    const float t = std::max(0.0f, 2 * distance / radius - 1);
    return t * t * (3 - 2 * t);
}

struct NearOptions {
    float radius = 0;   // scene units, at most; 0: no near field
    int rays = 64;
    bool surface_lights = true;   // lights that approximate emissive surfaces take part (Light::of_surface)
    // Light that a place reflects is near up to so many widths of its light's leaf there. null: up to the radius.
    const LightTree* tree = nullptr;
    float widths = 0;

    /// The radius for a place where a leaf is so wide.
    float radius_at(float leaf_width) const { return tree ? std::min(radius, widths * leaf_width) : radius; }
};

/// Unit vectors around +z with a cosine distribution: a Fibonacci lattice on the unit disk, projected up. They are
/// along a Morton curve, so that rays in a packet stay together.
std::vector<glm::vec3> cosine_directions(int count);

struct NearAnswer {
    glm::vec3 light[3] = {};      // by colour, as CachePoint::light
    float nearest = k_infinity;   // distance to the nearest surface, scene units
    float form_factor = 0;        // of the surfaces in the near field, as far as it has not faded out
};

class NearLight {
 public:
    struct Scratch {
        ray::RayQueue rays, shadow_rays;
        std::vector<std::uint32_t> receiver_of;   // by short ray
        ray::Hits hits;
        std::vector<std::uint8_t> occluded;
        struct Lit {
            std::size_t receiver;
            glm::vec3 light, direction;
            std::size_t ray;   // that met the surface
        };
        std::vector<Lit> lit;
        // Where surfaces thin light: rays that go on behind them, and the part of light that passes, by ray.
        ray::RaysBehind behind;
        std::vector<std::uint32_t> on, next_on;
        // What dynamic objects may occlude: which lit surfaces, the ways of their light to them, and on to the points.
        std::vector<std::uint32_t> doubted;
        std::vector<LightWay> lights;
        std::vector<std::uint32_t> directions;
        ray::RayQueue to_lights, to_points;
        std::vector<std::uint8_t> occluded_on;
        std::vector<NearAnswer> without;
        std::vector<glm::vec3> passes, lit_passes;
        std::uint64_t cast = 0;   // counts up
    };
    explicit NearLight(const NearOptions& options = {});
    const NearOptions& options() const { return options_; }
    /// Of the short rays, about +z.
    std::span<const glm::vec3> directions() const { return directions_; }
    /// Computes the near field of some receivers. Thread-safe.
    /// @param against  the geometry that rays meet: static_only or everything
    /// @param reach    output: by receiver and direction, for find_change() of later frames; null if not wanted
    void gather(const scene::SceneState& state, const ray::RayScene& rays, const NearReceiver* receivers,
                std::size_t count, ray::Against against, Scratch& scratch, NearAnswer* answers,
                std::uint8_t* reach = nullptr) const;
    /// Computes what dynamic objects change of it: minus the light that they occlude. Thread-safe.
    /// Cost: the receivers' short rays, or those alone that a sphere is near enough to matter to, if the receivers have
    /// their reach; and rays to lights where a sphere is near enough to occlude.
    /// @param spheres  around dynamic objects
    void find_change(const scene::SceneState& state, const ray::RayScene& rays, const MovingSpheres& spheres,
                     const NearReceiver* receivers, std::size_t count, Scratch& scratch, NearAnswer* answers) const;

 private:
    struct Met;
    void queue_all(const NearReceiver* receivers, std::size_t count, Scratch& scratch) const;
    void queue_doubted(const scene::SceneState& state, const MovingSpheres& spheres, const NearReceiver* receivers,
                       std::size_t count, Scratch& scratch) const;
    void find_lit(const scene::SceneState& state, const ray::RayScene& rays, const NearReceiver* receivers,
                  std::size_t count, ray::Against against, Scratch& scratch, NearAnswer* answers) const;
    void note_reach(const NearReceiver* receivers, std::size_t count, const Scratch& scratch,
                    std::uint8_t* reach) const;
    bool takes_part(const scene::Light& light, const scene::LightState& at) const
    {
        return at.visible && !light.of_environment && (!light.of_surface || options_.surface_lights);
    }
    static void doubt(const MovingSpheres& spheres, Scratch& scratch);
    float light_surface(const scene::SceneState& state, const ray::RayScene& rays, const Met& met,
                        Scratch& scratch) const;
    void light_behind(const scene::SceneState& state, const ray::RayScene& rays, const NearReceiver* receivers,
                      ray::Against against, Scratch& scratch) const;

    NearOptions options_;
    std::vector<glm::vec3> directions_;
};

}   // namespace gnomon::irradiance_cache
