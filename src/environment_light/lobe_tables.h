// SPDX-License-Identifier: Apache-2.0
#pragma once
// Blurred images of an environment, as narrow lobes of rough surfaces see it.
//
// Seen along the normal, a lobe is round, and blurs the image as a table over directions has it. Seen at a slant, it is
// long: 32 directions are drawn from the normals that the viewer sees [Heitz 2018], and each has the mean of the image
// over its share of the lobe, a Gaussian around it from another table [Krivanek and Colbert 2008]. In between, both
// fade into each other: the directions' pattern turns with the view, which would show around where a surface faces the
// viewer.
//
// In a prototype, over 60 surroundings with bright bands, discs and boxes, 64 times as bright as the rest, the RMS
// error against the integral was .002 to .065 along the normal and .03 to .08 at 45 to 75 degrees from it, at
// roughnesses from .2 to .5. Round lobes alone had .18 to .40 at 60 degrees.
//
// Lobes narrower than the narrowest table have its tail, in proportion to the fourth power of roughness, and a core
// that is seen by 16 directions.
//
// Cost: 64 table look-ups (bilinear) at a slant, else two. Tables are made when they are first asked for: .4 to .9 s of
// processor time for a file with many roughnesses (AMD EPYC, AVX2).

#include <array>
#include <mutex>
#include <vector>

#include "base/direction_table.h"
#include "scene/environment.h"

namespace gnomon::environment_light {

class LobeTables {
 public:
    /// @param environment  kept by reference
    explicit LobeTables(const scene::Environment& environment);

    /// What microfacets reflect where they face the viewer, and at grazing angles [Schlick 1994].
    struct Reflectance {
        float f0 = 1, f90 = 1;
    };
    /// The mean radiance that a lobe sees, weighted by what it reflects. Thread-safe. All directions are unit.
    /// @param mirrored   the direction that a mirror shows
    /// @param roughness  perceptual
    glm::vec3 reflected(const glm::vec3& to_viewer, const glm::vec3& normal, const glm::vec3& mirrored, float roughness,
                        const Reflectance& reflectance);
    /// The same, viewed along the normal.
    glm::vec3 along_normal(const glm::vec3& mirrored, float roughness);
    std::size_t bytes() const;

 private:
    static constexpr std::size_t k_lobes = 12, k_spots = 9;
    // Radiance over the sphere in a pyramid of means.
    struct Level {
        int side = 0;   // squares
        std::vector<glm::vec3> flux;
        std::vector<glm::vec4> direction;   // unit mean direction; w: solid angle
    };
    // Made when it is first asked for.
    struct Table {
        std::once_flag made;
        DirectionTable values;
    };

    void make_levels();
    template <class Weight>
    glm::vec3 gather(const glm::vec3& around, float width, float reach, const Weight& weight) const;
    const DirectionTable& lobe(std::size_t number);
    const DirectionTable& spot(std::size_t number);
    glm::vec3 at_slant(const glm::vec3& to_viewer, const glm::vec3& normal, float alpha,
                       const Reflectance& reflectance);
    glm::vec3 narrow(const glm::vec3& to_viewer, const glm::vec3& normal, const glm::vec3& mirrored, float alpha);
    glm::vec3 spot_at(const glm::vec3& direction, float width);

    const scene::Environment& environment_;
    std::vector<Level> levels_;   // from the finest
    std::array<Table, k_lobes> lobes_;
    std::array<Table, k_spots> spots_;
};

}   // namespace gnomon::environment_light
