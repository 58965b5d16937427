// SPDX-License-Identifier: Apache-2.0
#pragma once
// Values of lights, materials and cameras as functions of time, as glTF's KHR_animation_pointer describes them.
//
// Each property has a track of its own, evaluated like the weights of morph targets; a property without one keeps its
// value. Results are limited to what the renderer can use, because a cubic spline may leave the range of its keys.
// SceneState applies the tracks that change between two times, and a value that a host handed over takes their place.
//
// Cost of apply(): a binary search per property with a track.

#include <memory>
#include <variant>
#include <vector>

#include "scene/scene.h"

namespace gnomon::scene {

/// One or more numbers; null: they do not change.
using NumbersTrack = std::shared_ptr<const WeightsTrack>;

/// Of a light. Its colour is the product of the two factors.
struct LightTrack {
    glm::vec3 rest_color{1};   // where there is no track; so for the next
    float rest_intensity = 1;
    float rest_inner_angle = 0;
    NumbersTrack color, intensity;   // 3 numbers, 1
    NumbersTrack range;              // metres; not for directional lights
    NumbersTrack inner_angle, outer_angle;

    void apply(double time, Light& light) const;
    /// The intervals of change of all properties together, ascending and disjoint.
    std::vector<Interval> changing() const;
};

struct MaterialLayers;

/// One more property of a material: a number, a colour, or where a texture lies.
struct MaterialPart {
    enum class Place : std::uint8_t { offset, scale, rotation };

    std::variant<float Material::*, float MaterialLayers::*, glm::vec3 MaterialLayers::*, TextureUse Material::*,
                 TextureUse MaterialLayers::*>
        member;
    Place place = Place::offset;   // of a texture
    float least = 0, most = 1;     // of the values
    NumbersTrack track;

    bool of_layers() const { return member.index() != 0 && member.index() != 3; }
    /// How many numbers its value has.
    int components() const;
};

/// Of a material. The emission is the product of the two factors.
struct MaterialTrack {
    glm::vec3 rest_emissive{0};   // where there is no track; so for the next
    float rest_strength = 1;
    NumbersTrack base_color;   // 4 numbers: colour and alpha; the alpha of AlphaMode::mask stays as it is
    NumbersTrack metallic, roughness;
    NumbersTrack emissive, strength;   // 3 numbers, 1
    std::vector<MaterialPart> parts;   // those of layers only for materials that have some
    bool alpha_changes = false;        // the surface is not always as opaque as its material says

    void apply(double time, Material& material) const;
    std::vector<Interval> changing() const;
};

/// Of a camera.
struct CameraTrack {
    NumbersTrack vertical_fov;   // radians; perspective
    NumbersTrack half_height;    // of an orthographic view
    NumbersTrack near, far;      // metres

    void apply(double time, Camera& camera) const;
    std::vector<Interval> changing() const;
};

/// The widest field of view of a camera of a file: a little less than pi.
inline constexpr double k_widest_fov = 3.1;

}   // namespace gnomon::scene
