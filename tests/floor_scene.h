// SPDX-License-Identifier: Apache-2.0
#pragma once
// A floor of small squares that reaches to the horizon, for textures seen at grazing angles.

#include <algorithm>
#include <glm/gtc/matrix_transform.hpp>
#include <memory>

#include "api/scene_access.h"
#include "gnomon/gnomon.h"
#include "scene/scene.h"

namespace gnomon::test {

constexpr int k_squares_size = 64;

// Black and white squares of `u` by `v` texels.
inline scene::Texture squares(int u, int v)
{
    Image8 image(k_squares_size, k_squares_size, 3);
    for (int y = 0; y < k_squares_size; ++y)
        for (int x = 0; x < k_squares_size; ++x)
            std::fill_n(image.pixel(x, y), 3, (x / u + y / v) % 2 ? std::uint8_t{255} : std::uint8_t{0});
    return {"squares", image, true, {}};
}

// A floor of small squares that reaches to the horizon.
inline Scene floor_to_the_horizon()
{
    scene::Scene scene;
    scene.textures.push_back(squares(8, 8));
    scene::Material material;
    material.base_color_texture.texture = 0;
    material.base_color_texture.scale = {25, 25};
    material.base_color_texture.rotation = 0.3f;
    scene.materials.push_back(material);
    scene::Mesh mesh;
    mesh.positions = {{-50, 0, 50}, {50, 0, 50}, {50, 0, -50}, {-50, 0, -50}};
    mesh.texcoords[0] = {{0, 1}, {1, 1}, {1, 0}, {0, 0}};
    mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
    mesh.parts = {{0, 0, 2}};
    scene.meshes.push_back(mesh);
    scene.nodes[scene.add_node("floor", scene::none, glm::dmat4(1))].mesh = 0;
    scene::Camera camera;
    camera.node = scene.add_node("camera", scene::none, glm::translate(glm::dmat4(1), glm::dvec3(0, 1, 20)));
    scene.cameras.push_back(camera);
    scene.finish();
    return api::public_scene(std::make_shared<const scene::Scene>(std::move(scene)))
        .with_light_specs({"point 0 40 0 3000 3000 3000"});
}

}   // namespace gnomon::test
