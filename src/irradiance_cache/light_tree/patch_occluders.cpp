// SPDX-License-Identifier: Apache-2.0
#include "irradiance_cache/light_tree/patch_occluders.h"

#include <algorithm>
#include <cmath>

namespace gnomon::irradiance_cache {

std::optional<TriangleShadow> TriangleShadow::behind(const glm::vec3 (&corners)[3], const glm::vec3& from)
{
    // Planes are found in double precision, because they bound what a ray would have to find in single precision.
    const glm::dvec3 origin(from);
    glm::dvec3 p[3];
    for (int i = 0; i < 3; ++i) p[i] = glm::dvec3(corners[i]) - origin;
    glm::dvec3 normals[4];
    normals[3] = glm::cross(p[1] - p[0], p[2] - p[0]);
    double volume = glm::dot(normals[3], p[0]);
    const double sign = volume < 0 ? -1 : 1;
    volume *= sign;
    for (int i = 0; i < 3; ++i) normals[i] = glm::cross(p[i], p[(i + 1) % 3]);
    TriangleShadow shadow;
    for (int i = 0; i < 4; ++i) {
        const double length = glm::length(normals[i]);
        if (!(length > 0) || !std::isfinite(length)) return std::nullopt;
        const glm::vec3 n(sign / length * normals[i]);
        shadow.x_[i] = n.x, shadow.y_[i] = n.y, shadow.z_[i] = n.z;
        if (i == 3) shadow.distance_ = static_cast<float>(volume / length);
    }
    if (!(shadow.distance_ > 0)) return std::nullopt;
    // Rays round what is near the triangle to fractions of the coordinates, and end just before a light.
    constexpr float k_rounding = 2e-6f, k_margin = 2e-4f, k_most = 0.1f;
    float largest = 0;
    for (int axis = 0; axis < 3; ++axis) {
        largest = std::max(largest, std::abs(from[axis]));
        for (const glm::vec3& corner : corners) largest = std::max(largest, std::abs(corner[axis]));
    }
    shadow.margin_ = k_margin + k_rounding * largest / shadow.distance_;
    if (!(shadow.margin_ < k_most)) return std::nullopt;
    return shadow;
}

bool TriangleShadow::hides(const glm::vec3& centre, float radius) const
{
    const float needed = radius + margin_ * (glm::length(centre) + radius);
    bool inside = true;
    for (int i = 0; i < 4; ++i)
        inside &= x_[i] * centre.x + y_[i] * centre.y + z_[i] * centre.z >= needed + (i == 3 ? distance_ : 0.0f);
    return inside;
}

const TriangleShadow* PatchOccluders::OfOwner::find(std::size_t patch) const
{
    const Run& run = runs_[patch / k_run];
    if (run.places.empty()) return nullptr;
    const std::uint16_t place = run.places[patch % k_run];
    return place == 0 ? nullptr : &run.shadows[place - 1u];
}

void PatchOccluders::OfOwner::remember(std::size_t patch, const TriangleShadow& shadow)
{
    Run& run = runs_[patch / k_run];
    if (run.places.empty()) run.places.assign(k_run, 0);
    std::uint16_t& place = run.places[patch % k_run];
    if (place == 0) {
        run.shadows.push_back(shadow);
        place = static_cast<std::uint16_t>(run.shadows.size());
    } else {
        run.shadows[place - 1u] = shadow;
    }
}

PatchOccluders::OfOwner& PatchOccluders::of(std::uint32_t owner, std::size_t patches)
{
    OfOwner& found = owners_[owner];
    found.runs_.resize((patches + k_run - 1) / k_run);
    return found;
}

std::size_t PatchOccluders::bytes() const
{
    std::size_t bytes = 0;
    for (const auto& [owner, of] : owners_)
        for (const OfOwner::Run& run : of.runs_)
            bytes += run.places.size() * sizeof(std::uint16_t) + run.shadows.capacity() * sizeof(TriangleShadow);
    return bytes;
}

}   // namespace gnomon::irradiance_cache
