// SPDX-License-Identifier: Apache-2.0
#pragma once
// Surface points seen by a camera, for which indirect light is computed.

#include <functional>
#include <vector>

#include "irradiance_cache/points/anchors.h"
#include "scene/view.h"
#include "world.h"

namespace gnomon::test {

/// One point per pixel of a square image, with flat shading.
/// @param pixels  out, if given: the pixel of each point
/// @param wanted  whether to keep points of an object; if not given, all are kept
inline std::vector<irradiance_cache::IndirectPoint> seen_points(const World& world, int side,
                                                                std::vector<std::size_t>* pixels = nullptr,
                                                                const std::function<bool(scene::ObjectId)>& wanted = {})
{
    const scene::View view = scene::make_view(world.state, 0, {side, side});
    ray::RayQueue queue;
    for (int y = 0; y < side; ++y)
        for (int x = 0; x < side; ++x) {
            glm::vec3 origin, direction;
            float tnear, tfar;
            view.ray(static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f, origin, direction, tnear, tfar);
            queue.push(origin, tnear, direction, tfar);
        }
    ray::Hits hits;
    hits.resize(queue.size());
    world.rays.closest(queue, 0, queue.size(), hits, ray::Sides::front);
    std::vector<irradiance_cache::IndirectPoint> points;
    for (std::size_t i = 0; i < queue.size(); ++i) {
        if (hits.object[i] == scene::none || (wanted && !wanted(hits.object[i]))) continue;
        glm::vec3 p[3];
        world.rays.geometry(hits.object[i]).corners(hits.triangle[i], p);
        glm::vec3 normal = glm::normalize(glm::cross(p[1] - p[0], p[2] - p[0]));
        if (glm::dot(normal, queue.direction(i)) > 0) normal = -normal;
        const float u = hits.u[i], v = hits.v[i];
        const glm::vec3 at = (1 - u - v) * p[0] + u * p[1] + v * p[2];
        points.push_back({at, normal, normal, hits.object[i], hits.triangle[i], u, v,
                          view.pixel_width + glm::length(at - view.eye) * view.pixel_spread,
                          -glm::normalize(queue.direction(i))});
        if (pixels) pixels->push_back(i);
    }
    return points;
}

}   // namespace gnomon::test
