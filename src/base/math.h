// SPDX-License-Identifier: Apache-2.0
#pragma once
// GLM with one configuration, and a few helpers that it lacks. Column vectors: world = M_outer ... M_inner p.

#ifndef GLM_FORCE_XYZW_ONLY
#define GLM_FORCE_XYZW_ONLY
#endif
#ifndef GLM_FORCE_DEPTH_ZERO_TO_ONE
#define GLM_FORCE_DEPTH_ZERO_TO_ONE
#endif
#ifndef GLM_ENABLE_EXPERIMENTAL
#define GLM_ENABLE_EXPERIMENTAL
#endif
#include <cmath>
#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>
#include <limits>
#include <numbers>

namespace gnomon {

inline constexpr float k_infinity = std::numeric_limits<float>::infinity();
inline constexpr double k_pi = std::numbers::pi;

/// An axis-aligned box; empty until something is added.
struct Box3 {
    glm::vec3 low{k_infinity};
    glm::vec3 high{-k_infinity};

    bool empty() const { return !(low.x <= high.x && low.y <= high.y && low.z <= high.z); }
    void add(const glm::vec3& p) { low = glm::min(low, p), high = glm::max(high, p); }
    void add(const Box3& b) { low = glm::min(low, b.low), high = glm::max(high, b.high); }
    glm::vec3 centre() const { return 0.5f * low + 0.5f * high; }
    glm::vec3 size() const { return empty() ? glm::vec3(0) : high - low; }
    float diagonal() const { return glm::length(size()); }
};

inline bool is_finite(const glm::vec3& v)
{
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

/// Relative luminance of linear Rec. 709 colour.
inline float luminance(const glm::vec3& c)
{
    return 0.2126f * c.x + 0.7152f * c.y + 0.0722f * c.z;
}
inline double luminance(const glm::dvec3& c)
{
    return 0.2126 * c.x + 0.7152 * c.y + 0.0722 * c.z;
}

/// Transforms a point, without the division by w (all our matrices are affine).
inline glm::vec3 transform_point(const glm::mat4& m, const glm::vec3& p)
{
    return glm::vec3(m * glm::vec4(p, 1));
}
inline glm::dvec3 transform_point(const glm::dmat4& m, const glm::dvec3& p)
{
    return glm::dvec3(m * glm::dvec4(p, 1));
}

/// Two unit vectors perpendicular to the unit vector n and to each other (Duff et al. 2017).
inline void make_basis(const glm::vec3& n, glm::vec3& s, glm::vec3& t)
{
    const float sign = std::copysign(1.0f, n.z);
    const float a = -1.0f / (sign + n.z);
    const float b = n.x * n.y * a;
    s = {1.0f + sign * n.x * n.x * a, sign * b, -sign * n.x};
    t = {b, sign + n.y * n.y * a, -n.y};
}

}   // namespace gnomon
