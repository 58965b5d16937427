// SPDX-License-Identifier: Apache-2.0
// The 2D and 3D curves along which shapes are swept.

#include <algorithm>

#include "base/check.h"
#include "scene/builtin/shapes.h"

namespace gnomon::scene {

glm::vec2 right_of(const glm::vec2& direction)
{
    return glm::normalize(glm::vec2(direction.y, -direction.x));
}

Outline make_outline(std::span<const glm::vec2> points, bool closed, float crease)
{
    GNOMON_CHECK_LE(std::size_t{2}, points.size());
    Outline outline;
    const std::size_t count = closed ? points.size() : points.size() - 1;
    float along = 0;
    for (std::size_t i = 0; i < count; ++i) {
        const glm::vec2 a = points[i], b = points[(i + 1) % points.size()];
        const float length = glm::length(b - a);
        if (!(length > 0)) continue;
        const glm::vec2 normal = right_of(b - a);
        outline.segments.push_back({a, b, normal, normal, along, along + length});
        along += length;
    }
    // Smooth every corner that is not sharp.
    const float sharp = std::cos(crease);
    const std::size_t n = outline.segments.size();
    std::vector<glm::vec2> face(n);
    for (std::size_t i = 0; i < n; ++i) face[i] = outline.segments[i].normal_from;
    for (std::size_t i = 0; i < n; ++i) {
        if (!closed && i + 1 == n) break;
        const std::size_t next = (i + 1) % n;
        if (glm::dot(face[i], face[next]) <= sharp) continue;
        const glm::vec2 smooth = glm::normalize(face[i] + face[next]);
        outline.segments[i].normal_to = outline.segments[next].normal_from = smooth;
    }
    return outline;
}

std::vector<glm::vec2> arc(const glm::vec2& centre, float radius, float a, float b, int steps)
{
    std::vector<glm::vec2> points;
    for (int i = 0; i <= steps; ++i) {
        const float angle = a + (b - a) * static_cast<float>(i) / static_cast<float>(steps);
        points.push_back(centre + radius * glm::vec2(std::cos(angle), std::sin(angle)));
    }
    return points;
}

std::vector<glm::vec3> smooth_path(std::span<const glm::vec3> points, int steps)
{
    std::vector<glm::vec3> path;
    const std::size_t n = points.size();
    for (std::size_t i = 0; i + 1 < n; ++i) {
        const glm::vec3 p0 = points[i > 0 ? i - 1 : 0], p1 = points[i], p2 = points[i + 1];
        const glm::vec3 p3 = points[std::min(i + 2, n - 1)];
        for (int s = 0; s < steps; ++s) {
            const float t = static_cast<float>(s) / static_cast<float>(steps);
            path.push_back(0.5f * (2.0f * p1 + (p2 - p0) * t + (2.0f * p0 - 5.0f * p1 + 4.0f * p2 - p3) * (t * t) +
                                   (3.0f * p1 - p0 - 3.0f * p2 + p3) * (t * t * t)));
        }
    }
    path.push_back(points[n - 1]);
    return path;
}

}   // namespace gnomon::scene
