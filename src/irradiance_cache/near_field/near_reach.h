// SPDX-License-Identifier: Apache-2.0
#pragma once
// How far a receiver's short rays go to surfaces that are lit: what the near field of static geometry remembers for
// frames in which dynamic objects move.
//
// In such a frame, few of these surfaces have a dynamic object between them and the receiver, or between them and a
// light. Which ones may have is known without a ray from a byte for each direction. So only their rays are cast again,
// and the answer is the same to the bit.

#include <cstdint>
#include <span>
#include <vector>

#include "irradiance_cache/light_tree/moving_spheres.h"
#include "scene/light.h"

namespace gnomon::irradiance_cache {

struct NearReceiver {
    glm::vec3 origin{0}, normal{0}, horizon{0};
    /// By direction, what NearLight::gather() found past static geometry; empty if it was not kept.
    std::span<const std::uint8_t> reach = {};
};

/// A distance as a byte: in steps of a 253rd of the radius, rounded up.
class ReachSteps {
 public:
    static constexpr std::uint8_t k_nothing_lit = 0;
    static constexpr std::uint8_t k_inexact = 255;   // a step would not tell where the lit surface is
    explicit ReachSteps(float radius) : step_(radius / 253) {}
    float step() const { return step_; }
    /// @param point      where the short ray starts
    /// @param direction  of the ray, unit
    /// @param t          its length, at most the radius
    /// @param surface    where the rays from there to the lights start
    std::uint8_t encode(const glm::vec3& point, const glm::vec3& direction, float t, const glm::vec3& surface) const;
    /// From the surface's distance to two steps more.
    float decode(std::uint8_t reach) const { return static_cast<float>(reach) * step_; }

 private:
    float step_;
};

/// The farthest distance at which a surface is lit, with all that it may be wrong by; 0 where none is.
float farthest_reach(std::span<const std::uint8_t> reach, float radius);

/// Where the light of a light comes from.
struct LightWay {
    bool endless;   // from a direction, or else from a position
    glm::vec3 at;
};

/// Finds which short rays of a receiver lead to lit surfaces whose light a dynamic object may occlude.
class NearDoubts {
 public:
    NearDoubts(float radius, std::span<const glm::vec3> directions);
    /// @param axes     tangent, bitangent and normal: what a direction's coordinates refer to
    /// @param lights   all that may light a surface
    /// @param doubted  output: the numbers of such directions, in ascending order; all with k_inexact are among them
    void find(const NearReceiver& receiver, const glm::mat3& axes, std::span<const LightWay> lights,
              const MovingSpheres& spheres, std::vector<std::uint32_t>& doubted);

 private:
    ReachSteps steps_;
    std::span<const glm::vec3> directions_;
    std::vector<MovingSpheres::Object> met_;
    // The lit surfaces of a receiver: their directions, where they are relative to it, and whether one is doubted.
    std::vector<std::uint32_t> number_;
    std::vector<float> x_, y_, z_;
    std::vector<std::int32_t> doubt_, near_;   // near_: a sphere meets its way
};

/// Whether a sphere or a box, grown by `radius`, meets the near field around the way from a point to a light.
bool meets_near_field(const Sphere& sphere, const glm::vec3& point, const LightWay& light, float radius);
bool meets_near_field(const MovingBox& box, const glm::vec3& point, const LightWay& light, float radius);

/// The way to a light, from wherever.
LightWay way_to(const scene::Light& light, const scene::LightState& at);

}   // namespace gnomon::irradiance_cache
