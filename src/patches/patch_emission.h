// SPDX-License-Identifier: Apache-2.0
#pragma once
// Irradiance of patches from emissive surfaces (scene/sized_light.h), in closed form, and with shadows.
//
// A few points of each patch are lit, by the formula that also lights the pixels (shading/polygon_light.h), times the
// visible share of the light's sample places, and times what surfaces that thin light let through on the way to some of
// these places. What static geometry hides of a light is found once and kept for as long
// as the light stays as it is. Where a dynamic object may come between a patch and a light, rays against dynamic
// objects are added in frames in which any of them moves. So the irradiance is a function of the present state.
//
// Cost: a few rays for each point and light that face each other, once a light; per frame in which something moves, a
// box test for each patch and light, and rays for those that it concerns. Memory: 20 bytes for each such point.

#include <memory>
#include <vector>

#include "patches/surface_patches.h"
#include "scene/sized_light.h"
#include "visibility/dynamic_bounds.h"

namespace gnomon::patches {

struct EmissionOptions {
    int points = 4;               // of a patch, at most
    int points_and_lights = 16;   // their product: patches have fewer points if there are many lights
    scene::SizedLightOptions lights{.places = 32, .places_in_all = 1024, .least_places = 16};
    std::size_t first_places = 8;   // of a light: if they agree, so do all
};

class PatchEmission {
 public:
    PatchEmission(const SurfacePatches& patches, const EmissionOptions& options = {});
    ~PatchEmission();

    /// Follows one advance() of the state, after the ray scene did. The first call makes everything.
    /// @param lights  of this state, with EmissionOptions::lights
    /// @return  whether the lights, or what they bring without dynamic objects, changed
    bool update(const scene::SceneState& state, const ray::RayScene& rays, const scene::SizedLights& lights,
                Tasks& tasks);

    /// Finds everything again in the next update, because surfaces thin light in another way.
    void forget() { lights_.clear(), first_ = true; }

    /// By patch: without dynamic objects in the way, and now.
    std::span<const glm::vec3> static_irradiance() const { return static_; }
    std::span<const glm::vec3> irradiance() const { return now_; }
    std::size_t bytes() const;

 private:
    struct Point {
        glm::vec3 position{0}, normal{0};
    };
    // A point that a light would reach.
    struct Reached {
        std::uint32_t point = 0;     // of all patches' points
        std::uint32_t visible = 0;   // places, past static geometry
        glm::vec3 light{0};          // irradiance that arrives if all is visible
    };
    struct Light {
        scene::SizedLight shape;
        Box3 box;
        std::vector<Reached> reached;   // by point, ascending
    };
    class Shading;
    void choose_points(std::size_t lights);
    void light_points(Light& light, const ray::RayScene& rays, Tasks& tasks) const;
    void thin(const Light& light, const ray::RayScene& rays, std::size_t step, std::span<Reached> reached) const;
    static float weight_of(const scene::SizedPlace& place, const Point& point);
    void follow_blockers(const ray::RayScene& rays, Tasks& tasks);

    const SurfacePatches& patches_;
    EmissionOptions options_;
    std::uint32_t points_of_patch_ = 0;
    std::vector<Point> points_;
    std::vector<std::unique_ptr<Light>> lights_;
    std::uint32_t version_ = 0;   // of the lights
    bool first_ = true;
    std::unique_ptr<visibility::DynamicBounds> dynamic_;
    std::vector<glm::vec3> static_, now_;
};

}   // namespace gnomon::patches
