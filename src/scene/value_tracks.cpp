// SPDX-License-Identifier: Apache-2.0
#include "scene/value_tracks.h"

#include <algorithm>
#include <array>
#include <limits>

#include "base/check.h"
#include "scene/keyframe_track.h"
#include "scene/material_layers.h"

namespace gnomon::scene {

namespace {

constexpr float k_most = std::numeric_limits<float>::max();

// The value of a track of n numbers, each within a range. An infinite value becomes the end of its range, and one that
// is not a number the lower one.
template <std::size_t n>
std::array<float, n> numbers_at(const WeightsTrack& track, double time, float least, float most)
{
    std::vector<float> values;
    track.evaluate(time, values);
    GNOMON_CHECK_EQ(values.size(), n);
    std::array<float, n> result;
    for (std::size_t i = 0; i < n; ++i) result[i] = values[i] > least ? std::min(values[i], most) : least;
    return result;
}

float number_at(const NumbersTrack& track, double time, float least, float most)
{
    return numbers_at<1>(*track, time, least, most)[0];
}

glm::vec3 color_at(const NumbersTrack& track, double time)
{
    const auto [r, g, b] = numbers_at<3>(*track, time, 0, k_most);
    return {r, g, b};
}

std::vector<Interval> changing_of(const std::vector<const NumbersTrack*>& tracks)
{
    std::vector<Interval> intervals;
    for (const NumbersTrack* track : tracks) {
        if (!*track) continue;
        const std::vector<Interval> more = (*track)->changing();
        intervals.insert(intervals.end(), more.begin(), more.end());
    }
    return join_intervals(std::move(intervals));
}

// The product of a colour and a factor, finite.
glm::vec3 scaled(const glm::vec3& color, float factor)
{
    return glm::min(color * factor, glm::vec3(k_most));
}

// Sets the properties whose types are simple; layers are those of the material, or null.
void set_part(const MaterialPart& part, double time, Material& material, MaterialLayers* layers)
{
    std::vector<float> values;
    part.track->evaluate(time, values);
    GNOMON_CHECK_EQ(values.size(), static_cast<std::size_t>(part.components()));
    for (float& value : values) value = value > part.least ? std::min(value, part.most) : part.least;
    const auto place = [&](TextureUse& use) {
        if (part.place == MaterialPart::Place::offset) use.offset = {values[0], values[1]};
        if (part.place == MaterialPart::Place::scale) use.scale = {values[0], values[1]};
        if (part.place == MaterialPart::Place::rotation) use.rotation = values[0];
    };
    if (const auto* const number = std::get_if<float Material::*>(&part.member)) material.*(*number) = values[0];
    if (const auto* const texture = std::get_if<TextureUse Material::*>(&part.member)) place(material.*(*texture));
    if (!layers) return;
    if (const auto* const number = std::get_if<float MaterialLayers::*>(&part.member)) layers->*(*number) = values[0];
    if (const auto* const color = std::get_if<glm::vec3 MaterialLayers::*>(&part.member))
        layers->*(*color) = {values[0], values[1], values[2]};
    if (const auto* const texture = std::get_if<TextureUse MaterialLayers::*>(&part.member)) place(layers->*(*texture));
}

}   // namespace

int MaterialPart::components() const
{
    constexpr int k_counts[] = {1, 1, 3, 2, 2};
    const bool is_texture = member.index() >= 3;
    return is_texture && place == Place::rotation ? 1 : k_counts[member.index()];
}

void LightTrack::apply(double time, Light& light) const
{
    if (color || intensity)
        light.color = scaled(color ? color_at(color, time) : rest_color,
                             intensity ? number_at(intensity, time, 0, k_most) : rest_intensity);
    // A range of 0 would be unlimited.
    constexpr float k_least_range = 1e-6f;
    if (range) light.range = number_at(range, time, k_least_range, k_most);
    constexpr float k_widest = static_cast<float>(k_pi / 2);
    if (outer_angle) light.outer_angle = number_at(outer_angle, time, 0, k_widest);
    if (inner_angle || outer_angle)
        light.inner_angle =
            std::min(inner_angle ? number_at(inner_angle, time, 0, k_widest) : rest_inner_angle, light.outer_angle);
}

std::vector<Interval> LightTrack::changing() const
{
    return changing_of({&color, &intensity, &range, &inner_angle, &outer_angle});
}

void MaterialTrack::apply(double time, Material& material) const
{
    if (base_color) {
        const auto [r, g, b, alpha] = numbers_at<4>(*base_color, time, 0, 1);
        material.base_color = {r, g, b};
        if (material.alpha_mode != AlphaMode::mask) material.alpha = alpha;
    }
    if (metallic) material.metallic = number_at(metallic, time, 0, 1);
    if (roughness) material.roughness = number_at(roughness, time, 0, 1);
    if (emissive || strength)
        material.emissive = scaled(emissive ? color_at(emissive, time) : rest_emissive,
                                   strength ? number_at(strength, time, 0, k_most) : rest_strength);
    // Layers are shared between materials, so change a copy.
    std::shared_ptr<MaterialLayers> layers;
    for (const MaterialPart& part : parts) {
        if (part.of_layers() && !layers && material.layers) layers = std::make_shared<MaterialLayers>(*material.layers);
        set_part(part, time, material, layers.get());
    }
    if (layers) material.layers = std::move(layers);
}

std::vector<Interval> MaterialTrack::changing() const
{
    std::vector<const NumbersTrack*> tracks{&base_color, &metallic, &roughness, &emissive, &strength};
    for (const MaterialPart& part : parts) tracks.push_back(&part.track);
    return changing_of(tracks);
}

void CameraTrack::apply(double time, Camera& camera) const
{
    constexpr float k_narrowest = 1e-4f;   // radians, and metres
    if (vertical_fov)
        camera.vertical_fov = number_at(vertical_fov, time, k_narrowest, static_cast<float>(k_widest_fov));
    if (half_height) camera.orthographic_height = 2.0 * number_at(half_height, time, k_narrowest, k_most);
    if (near) camera.near = number_at(near, time, k_narrowest, k_most);
    constexpr double k_deeper = 1.0001;   // the far plane is behind the near one
    if (far) camera.far = std::max<double>(number_at(far, time, k_narrowest, k_most), k_deeper * camera.near);
}

std::vector<Interval> CameraTrack::changing() const
{
    return changing_of({&vertical_fov, &half_height, &near, &far});
}

}   // namespace gnomon::scene
