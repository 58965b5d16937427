// SPDX-License-Identifier: Apache-2.0
#pragma once
// Scenes whose lights are as bright as 32-bit floats allow.

#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <string>
#include <vector>

#include "api/scene_access.h"
#include "gnomon/gnomon.h"
#include "scene/scene.h"

namespace gnomon::test {

struct BrightScene {
    std::string name;
    Scene scene;
    float at_least;   // the brightest value exceeds this
};

// A triangle that stands on a floor and has a corner at the light itself.
inline Scene light_at_a_corner()
{
    scene::Scene scene;
    scene.materials.resize(1);
    scene.materials[0].double_sided = true;
    scene::Mesh mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {-2, 0, 2}, {2, 0, 2}, {0, 0, -2}};
    mesh.triangles = {{0, 1, 2}, {3, 4, 5}};
    mesh.parts = {{0, 0, 2}};
    scene.meshes.push_back(mesh);
    scene.nodes[scene.add_node("triangles", scene::none)].mesh = 0;
    scene::Camera camera;
    camera.node = scene.add_node("camera", scene::none, glm::translate(glm::dmat4(1), glm::dvec3(0.2, 0.6, 2.5)));
    scene.cameras.push_back(camera);
    scene.finish();
    return api::public_scene(std::make_shared<const scene::Scene>(std::move(scene)));
}

inline std::vector<BrightScene> bright_scenes(std::initializer_list<const char*> strengths)
{
    std::vector<BrightScene> scenes;
    for (const char* strength : strengths) {
        const std::string color = std::string(" ") + strength + " " + strength + " " + strength;
        const float at_least = std::string(strength) == "1" ? 0.01f : 1e6f;
        scenes.push_back({std::string("a corner, ") + strength,
                          light_at_a_corner().with_light_specs({"point 0 1 0" + color}), at_least});
        scenes.push_back({std::string("cornell, ") + strength,
                          load("builtin:cornell").with_light_specs({"spot 0.6 0.8 0.9 -1.1 -1 -1.1 40" + color}),
                          at_least});
    }
    return scenes;
}

inline std::size_t count_of_no_numbers(const Frame& image)
{
    std::size_t bad = 0;
    for (const Layer& layer : image.layers)
        for (const float value : layer.values()) bad += layer.name != "depth" && !std::isfinite(value);
    return bad;
}

inline float brightest_of(const Frame& image)
{
    const std::span<const float> data = image.layers.front().values();
    return *std::max_element(data.begin(), data.end());
}

}   // namespace gnomon::test
