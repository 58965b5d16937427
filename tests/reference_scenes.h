// SPDX-License-Identifier: Apache-2.0
#pragma once
// Scenes and points whose irradiance is known, for tests of the path-traced reference.
#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "reference/reference.h"
#include "scene_helpers.h"

namespace gnomon::test {

using reference::IrradianceEstimate;
using reference::IrradiancePoint;
using reference::ReferenceOptions;

struct ReferenceWorld {
    explicit ReferenceWorld(std::shared_ptr<const scene::Scene> s, int frame = 1)
        : scene(std::move(s)), state(scene, scene->timeline.time_of(frame)), rays(state)
    {
    }
    std::vector<IrradianceEstimate> irradiance(const std::vector<IrradiancePoint>& points,
                                               const ReferenceOptions& options, int threads = 2) const
    {
        Tasks tasks(threads);
        return reference::reference_irradiance(state, rays, points, options, tasks);
    }
    std::shared_ptr<const scene::Scene> scene;
    scene::SceneState state;
    ray::RayScene rays;
};

inline IrradiancePoint point_at(const glm::vec3& position, const glm::vec3& normal, std::uint64_t key = 1)
{
    IrradiancePoint point;
    point.position = position, point.geometric_normal = point.normal = normal, point.key = key;
    return point;
}

// A rectangle in y = 0 around the origin, with half its side lengths in `half`.
inline scene::Mesh rectangle(const glm::vec2& half)
{
    scene::Mesh mesh;
    mesh.positions = {{-half.x, 0, -half.y}, {-half.x, 0, half.y}, {half.x, 0, half.y}, {half.x, 0, -half.y}};
    mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
    mesh.parts = {{0, 0, 2}};
    return mesh;
}

// The inside of a cube of half-width 1; every wall has material 0.
inline scene::Scene closed_room()
{
    scene::Scene scene;
    scene.materials.resize(1);
    scene.materials[0].double_sided = true;
    scene.meshes.push_back(rectangle({1, 1}));
    const auto wall = [&](double angle, const glm::dvec3& axis) {
        add_object(scene, 0, scene::none,
                   glm::translate(glm::rotate(glm::dmat4(1), angle, axis), glm::dvec3(0, -1, 0)));
    };
    wall(0, {1, 0, 0}), wall(k_pi, {1, 0, 0});
    wall(k_pi / 2, {1, 0, 0}), wall(-k_pi / 2, {1, 0, 0});
    wall(k_pi / 2, {0, 0, 1}), wall(-k_pi / 2, {0, 0, 1});
    return scene;
}

// Irradiance at the origin, on a surface that faces +Y, by a convex polygon of radiance 1 that lies above the horizon
// [Lambert 1760; Arvo 1994].
inline double lambert(const std::vector<glm::dvec3>& polygon)
{
    double sum = 0;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        const glm::dvec3 a = glm::normalize(polygon[i]), b = glm::normalize(polygon[(i + 1) % polygon.size()]);
        const glm::dvec3 axis = glm::cross(a, b);
        const double sine = glm::length(axis);
        if (sine > 0) sum += std::atan2(sine, glm::dot(a, b)) * axis.y / sine;
    }
    return std::abs(sum) / 2;
}

// A square emitter of half-width .5 at some height, parallel to the floor y = 0, from x = `from` on.
inline double under_emitter(const glm::dvec2& place, double height, double from = -0.5)
{
    from = std::clamp(from, -0.5, 0.5);
    if (!(from < 0.5)) return 0;
    return lambert({{from - place.x, height, -0.5 - place.y},
                    {0.5 - place.x, height, -0.5 - place.y},
                    {0.5 - place.x, height, 0.5 - place.y},
                    {from - place.x, height, 0.5 - place.y}});
}

// The emitter as a scene: material 0 is black, and material 1 emits.
inline scene::Scene emitter_scene(double height, bool double_sided)
{
    scene::Scene scene;
    scene.materials.resize(2);
    scene.materials[0].base_color = glm::vec3(0);
    scene.materials[0].double_sided = true;
    scene.materials[1].emissive = {2, 1, 0.5f};
    scene.materials[1].base_color = glm::vec3(0);
    scene.materials[1].double_sided = double_sided;
    scene.meshes.push_back(rectangle({0.5f, 0.5f}));
    scene.meshes.edit(0).parts[0].material = 1;
    // The rectangle faces up: turn it to the floor.
    add_object(scene, 0, scene::none,
               glm::rotate(glm::translate(glm::dmat4(1), glm::dvec3(0, height, 0)), k_pi, glm::dvec3(1, 0, 0)));
    return scene;
}

}   // namespace gnomon::test
