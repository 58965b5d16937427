// SPDX-License-Identifier: Apache-2.0
#pragma once
// Lights and what lies behind everything.

#include <memory>
#include <string>

#include "base/math.h"
#include "scene/ids.h"

namespace gnomon::scene {

class Environment;

enum class LightType : std::uint8_t { point, spot, directional };
/// How irradiance falls with distance: with its square (candela), or not at all (AFF: irradiance = colour * cos).
enum class Falloff : std::uint8_t { inverse_square, constant };
/// Inside the cone: glTF's smooth step between the two angles, or the cosine from the axis.
enum class SpotProfile : std::uint8_t { smooth, cosine };

/// A light shines from its node's origin along the node's -Z.
struct Light {
    std::string name;
    LightType type = LightType::point;
    glm::vec3 color{1};   // linear: candela (inverse square), lux (directional), or AFF's own
    Falloff falloff = Falloff::inverse_square;
    SpotProfile profile = SpotProfile::smooth;
    float inner_angle = 0;   // half-angles, radians
    float outer_angle = static_cast<float>(k_pi / 4);
    float range = 0;   // metres beyond which nothing is lit (smoothly); 0: unlimited
    NodeId node = none;
    bool of_environment = false;   // stands for a part of the surroundings: lights diffusely alone, since mirrors show
                                   // the surroundings themselves
    bool by_default = false;       // not the file's own
};

/// A light where it is now.
struct LightState {
    glm::vec3 position{0};           // point and spot
    glm::vec3 direction{0, -1, 0};   // unit, the way the light travels; spot and directional
    bool visible = true;
    friend bool operator==(const LightState&, const LightState&) = default;
};

/// No light brings more to a surface, by colour: a million million lux, ten million times the sun. Beyond, what light
/// maps make of it (times areas, summed, times places) would not be numbers for long.
inline constexpr float k_most_irradiance = 1e12f;

/// What a light does at a point, without anything between.
struct LightSample {
    glm::vec3 to_light{0};     // unit
    float distance = 0;        // infinite for a directional light
    glm::vec3 irradiance{0};   // on a surface that faces the light; black outside its cone or range
};
LightSample illuminate(const Light& light, const LightState& state, const glm::vec3& point);

/// Seen where a ray leaves the scene, and what it adds as unshadowed light with indirect light off.
struct Background {
    enum class Kind : std::uint8_t { color, sky, image };
    Kind kind = Kind::color;
    glm::vec3 color{0};   // of a sky: an even light on all surfaces, for the bounces that nobody follows
    // sky: a smooth gradient over elevation (up = +Y), with the sun's disc where a directional light comes from
    glm::vec3 zenith{0.18f, 0.32f, 0.62f};
    glm::vec3 horizon{0.62f, 0.70f, 0.80f};
    glm::vec3 ground{0.25f, 0.22f, 0.19f};
    glm::vec3 sun_direction{0};   // unit, towards the sun; zero: none
    glm::vec3 sun_radiance{0};
    std::shared_ptr<const Environment> environment;   // image

    glm::vec3 radiance(const glm::vec3& direction) const;
    /// Irradiance / pi on an unoccluded surface with this unit normal: the sky's ambient light (the sun's is the
    /// light's), or the image's, blurred.
    glm::vec3 ambient(const glm::vec3& normal) const;
};

}   // namespace gnomon::scene
