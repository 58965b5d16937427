// SPDX-License-Identifier: Apache-2.0
#include "bench/lights/squares.h"

#include <algorithm>

namespace gnomon::bench {

namespace {

// Where a light without falloff (AFF) is as strong as its square, as a fraction of the scene's
// diagonal.
constexpr float k_alike = 0.25f;

void add_square(scene::Scene& scene, const glm::vec3& centre, const glm::vec3& direction, float side,
                const glm::vec3& radiance)
{
    scene::Material material;
    material.base_color = glm::vec3(0);
    material.emissive = radiance;
    scene.materials.push_back(material);
    const std::array<glm::vec3, 4> corners = square_corners(centre, direction, side);
    scene::Mesh mesh;
    mesh.positions.assign(corners.begin(), corners.end());
    mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
    mesh.parts = {{static_cast<scene::MaterialId>(scene.materials.size() - 1), 0, 2}};
    scene.meshes.push_back(mesh);
    const scene::NodeId node = scene.add_node("square", scene::none);
    scene.nodes[node].mesh = static_cast<scene::MeshId>(scene.meshes.size() - 1);
}

std::shared_ptr<const scene::Scene> finished(scene::Scene& scene)
{
    scene.lights.clear();
    scene.finish();
    return std::make_shared<const scene::Scene>(std::move(scene));
}

}   // namespace

std::array<glm::vec3, 4> square_corners(const glm::vec3& centre, const glm::vec3& direction, float side)
{
    glm::vec3 u, v;
    make_basis(direction, u, v);
    const glm::vec3 a = 0.5f * side * u, b = 0.5f * side * v;
    std::array<glm::vec3, 4> corners{centre - a - b, centre + a - b, centre + a + b, centre - a + b};
    if (glm::dot(glm::cross(a, b), direction) < 0) std::swap(corners[1], corners[3]);
    return corners;
}

bool becomes_square(const scene::Light& light)
{
    return light.type != scene::LightType::directional && !light.of_surface && !light.of_environment;
}

std::shared_ptr<const scene::Scene> with_squares(const scene::SceneState& state, float side, int only)
{
    scene::Scene scene = state.scene();
    const float alike = k_alike * scene.bounds(state.time()).diagonal();
    int number = 0;
    for (scene::LightId l = 0; l < state.scene().lights.size(); ++l) {
        const scene::Light& light = state.scene().lights[l];
        if (!becomes_square(light)) continue;
        if (only >= 0 && number++ != only) continue;
        const float square = light.falloff == scene::Falloff::constant ? alike * alike : 1.0f;
        add_square(scene, state.light(l).position, state.light(l).direction, side,
                   light.color * (square / (side * side)));
    }
    return finished(scene);
}

std::shared_ptr<const scene::Scene> with_square(const scene::SceneState& state, const glm::vec3& centre,
                                                const glm::vec3& direction, float side, float radiance)
{
    scene::Scene scene = state.scene();
    add_square(scene, centre, direction, side, glm::vec3(radiance));
    return finished(scene);
}

}   // namespace gnomon::bench
