// SPDX-License-Identifier: Apache-2.0
#pragma once
// The light that dynamic objects reflect of what has no light map: emissive surfaces, what lies beyond the scene, and
// light that has bounced off the patches of the static scene.
//
// Some places of the objects that move together stand for their surface: parts of equal size of large triangles, and
// places of small ones at equal steps of area. In a frame in which anything moves, each casts 8 rays, and up to four
// more to the brightest parts of an environment image; one that leaves the scene brings the light of the sky or of the
// image, one that ends on a patch what that patch reflects, and one that ends on a dynamic object what the nearest place
// there reflects, of lights without size as well; light bounces on between the places until a bounce brings less than a
// thousandth. Surfaces that thin light reflect by their alpha; no rays end on them. Emissive surfaces add their closed
// form where one ray past everything reaches them, at another of their places for each place. So few rays find little:
// what arrives at a place is taken to be the mean over it and the eight around it. Light that bounces from a dynamic
// object to a patch and back is found apart, by the same rays (again()).
//
// The result is a function of the present state. Cost: 8 rays and one for each light, for each place, of which there
// are 1,024 of all objects, up to twice as many where triangles are large, but at least 8 of those that move together,
// and one of each object. Of more than 1,024 objects that move together, 1,024 at most stand for all. Once for each mesh
// and number of places, the distance of each place to each other is measured.

#include <array>
#include <vector>

#include "base/tasks.h"
#include "patches/facing_places.h"
#include "patches/patch_rays.h"
#include "patches/surroundings.h"
#include "scene/sized_light.h"

namespace gnomon::patches {

class DynamicReflection {
 public:
    /// A part of an object's surface, and the light that it reflects.
    struct Reflector {
        scene::ObjectId object = scene::none;
        glm::vec3 position{0}, normal{0};
        glm::vec3 sample{0};   // just above the position
        glm::vec3 flux{0};     // radiant exitance times area
        float area = 0;
        std::uint32_t number = 0;   // among those of its object
        glm::vec3 side[2]{};        // of the triangle around the position that it is; 0: it is of no known shape
    };
    /// What lights the objects.
    struct Light {
        const SurfacePatches& patches;
        std::span<const glm::vec3> exitance;   // of the patches, radiant; empty: none
        const Surroundings& surroundings;
        const scene::SizedLights& emission;
        int further = 0;   // bounces from one dynamic object to another, at most
    };

    /// Finds what dynamic objects reflect now. Neither the result nor its order depends on the objects' numbers.
    /// @param groups  those that occlude light or thin it, by what moves together; some may be hidden
    std::vector<Reflector> gather(const scene::SceneState& state, const ray::RayScene& rays,
                                  std::span<const std::vector<scene::ObjectId>> groups, const Light& light,
                                  Tasks& tasks);
    /// The flux that the same objects reflect of further light of the patches.
    /// @param exitance  of the patches
    /// @param further   Light::further
    /// @return  by reflector of the last gather()
    std::vector<glm::vec3> again(std::span<const glm::vec3> exitance, int further) const;
    struct Measured {
        glm::mat4 matrix;
        scene::ObjectId object;
        double area;
    };
    /// An object that stands for others as well: `weight` times its own area.
    struct Chosen {
        scene::ObjectId object;
        std::size_t places;
        double weight;
    };
    /// Of more objects than places, chooses those on which equal steps of area end, in an order that does not depend on
    /// their numbers. Their areas, times their weights, are `all`.
    static std::vector<Chosen> choose_objects(std::vector<Measured> objects, double all);

    /// Drops what is kept of the objects' meshes. Call where meshes or materials may be others.
    void forget() { surfaces_.clear(); }

 private:
    static constexpr std::size_t k_neighbours = 8;
    struct Place {
        std::uint32_t triangle = 0;
        float u = 0, v = 0;
        float share = 0;   // of the triangle's area, that it stands for
        bool front = true;
        glm::vec2 sides[2]{};   // barycentric coordinates along two sides of the part that it is; 0: it is none
    };
    // What is kept of an object.
    struct Surface {
        const scene::Mesh* mesh = nullptr;
        double area = 0;            // at rest, of what occludes light or thins it
        bool closed = false;        // only its outside is lit: its front, or else
        bool inside_out = false;    // its back
        std::vector<double> sums;   // of these areas, by triangle
        std::size_t wanted = 0;     // places
        std::vector<Place> places;
        std::vector<std::array<std::uint32_t, k_neighbours>> neighbours;   // by place; a place's own number: none
    };
    Surface& surface_of(const scene::SceneState& state, const ray::RayScene& rays, scene::ObjectId object);
    static void choose_places(Surface& surface, std::size_t wanted);
    static void find_neighbours(Surface& surface);
    void add_places(const scene::SceneState& state, const ray::RayScene& rays, scene::ObjectId object,
                    const Surface& surface, float weight);
    void smoothen();
    struct Run;
    void light_by_patches(const scene::SceneState& state, const ray::RayScene& rays, const Light& light, Tasks& tasks);
    void light_run(const scene::SceneState& state, const ray::RayScene& rays, const Light& light, std::size_t first,
                   std::size_t end, Run& run);
    void light_by_spots(const ray::RayScene& rays, const Surroundings& surroundings);
    void light_by_emission(const ray::RayScene& rays, const Light& light);
    std::uint32_t nearest_place(scene::ObjectId object, const PatchRays::End& at) const;
    void light_by_points(const scene::SceneState& state, const ray::RayScene& rays);
    void bounce_between(std::vector<glm::vec3>& irradiance, std::span<const glm::vec3> of_points, int most) const;

    std::vector<Surface> surfaces_;   // by object
    std::vector<Reflector> reflectors_;
    std::vector<std::uint32_t> order_;                                  // of the last gather()'s result
    std::vector<glm::vec3> irradiance_, albedo_;                        // by reflector
    std::vector<std::array<std::uint32_t, k_neighbours>> neighbours_;   // likewise: others, or its own number
    std::vector<glm::vec3> reflected_;   // exitance by irradiance of lights without size, likewise
    std::vector<glm::vec3> of_points_;   // exitance by lights without size
    // A ray from one reflector to another, or to a patch.
    struct Link {
        std::uint32_t from, to;
        glm::vec3 weight;
    };
    std::vector<Link> links_, patch_links_;   // the second to patches
    // Some reflectors that follow one another: their rays, and the links that these find.
    struct Run {
        PatchRays rays;
        std::vector<Link> links, patch_links;
    };
    std::vector<Run> runs_;
    FacingPlaces sides_;                                     // of all reflectors
    std::vector<std::uint32_t> group_of_, first_of_group_;   // by object; the reflectors of each group, and the end
};

}   // namespace gnomon::patches
