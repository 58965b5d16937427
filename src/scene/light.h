// SPDX-License-Identifier: Apache-2.0
#pragma once
// Light sources and the background.

#include <memory>
#include <string>

#include "base/math.h"
#include "scene/ids.h"

namespace gnomon::scene {

class Environment;
struct LightTrack;

enum class LightType : std::uint8_t { point, spot, directional };
/// How irradiance falls off with distance: inverse square (candela), or constant (AFF: irradiance = colour * cos).
enum class Falloff : std::uint8_t { inverse_square, constant };
/// The angular profile inside the cone: glTF's squared ramp between the cosines of the two angles, the cosine from the
/// axis, or that cosine times the cubic smooth step between the cosines of the angles (Blender).
enum class SpotProfile : std::uint8_t { smooth, cosine, smooth_cosine };

/// A light, placed at its node's origin and directed along the node's -Z.
struct Light {
    std::string name;
    LightType type = LightType::point;
    glm::vec3 color{1};   // linear: candela (inverse square), lux (directional), or AFF's own
    Falloff falloff = Falloff::inverse_square;
    SpotProfile profile = SpotProfile::smooth;
    float inner_angle = 0;   // half-angles, radians
    float outer_angle = static_cast<float>(k_pi / 4);
    float range = 0;                             // metres beyond which the light has faded out; 0: unlimited
    std::shared_ptr<const LightTrack> track{};   // value_tracks.h; null: the values do not change by themselves
    NodeId node = none;
    bool of_environment = false;   // part of an environment map; only for diffuse reflection, because specular
                                   // reflection sees the map itself
    bool by_default = false;       // added by the library, not by the file
    bool of_surface = false;       // approximates an emissive surface of the scene; added by the library
};

/// Whether two lights reach the same points, with irradiance in the same proportions: everything that bears on it but
/// their colour and their nodes is the same, bit for bit.
bool same_reach(const Light& a, const Light& b);

/// A light at the current time.
struct LightState {
    glm::vec3 position{0};           // point and spot
    glm::vec3 direction{0, -1, 0};   // unit, the way the light travels; spot and directional
    bool visible = true;
    friend bool operator==(const LightState&, const LightState&) = default;
};

/// Upper limit of the irradiance of a light, per colour channel: 10^12 lux, ten million times the sun. With larger
/// values, products in the light maps (by area, by position, summed) could overflow.
inline constexpr float k_most_irradiance = 1e12f;

/// The light that arrives at a point, without occlusion.
struct LightSample {
    glm::vec3 to_light{0};     // unit
    float distance = 0;        // infinite for a directional light
    glm::vec3 irradiance{0};   // on a surface that faces the light; black outside its cone or range
};
LightSample illuminate(const Light& light, const LightState& state, const glm::vec3& point);

/// The radiance of rays that leave the scene, and its contribution as unshadowed light when indirect light is off.
struct Background {
    enum class Kind : std::uint8_t { color, sky, image };
    Kind kind = Kind::color;
    glm::vec3 color{0};   // of a sky: uniform ambient light for further bounces, where they are not computed
    // sky: a smooth gradient over elevation (up = +Y), with the sun's disc where a directional light comes from
    glm::vec3 zenith{0.18f, 0.32f, 0.62f};
    glm::vec3 horizon{0.62f, 0.70f, 0.80f};
    glm::vec3 ground{0.25f, 0.22f, 0.19f};
    glm::vec3 sun_direction{0};   // unit, towards the sun; zero: none
    glm::vec3 sun_radiance{0};
    std::shared_ptr<const Environment> environment;   // image

    glm::vec3 radiance(const glm::vec3& direction) const;
    /// Irradiance / pi on an unoccluded surface with this unit normal: the ambient light of the sky without the sun,
    /// which is a light of its own, or that of the environment map.
    glm::vec3 ambient(const glm::vec3& normal) const;
};

}   // namespace gnomon::scene
