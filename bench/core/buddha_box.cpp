// SPDX-License-Identifier: Apache-2.0
#include "bench/core/buddha_box.h"

#include "gnomon/scene_builder.h"
#include "io/load.h"
#include "scene/scene.h"

namespace gnomon::bench {

namespace {

constexpr float k_height = 1.3f, k_floor = -1, k_back = -0.2f;   // of the model in the box from -1 to 1
constexpr Vec3 k_clay{0.72f, 0.65f, 0.5f};

}   // namespace

Scene make_buddha_box(const std::string& file)
{
    // Read the model, and find its place.
    const scene::Scene model = io::load_scene(file);
    Box3 bounds;
    for (const scene::Mesh& mesh : model.meshes) bounds.add(mesh.bounds());
    const glm::vec3 centre = bounds.centre(), size = bounds.size();
    const float scale = size.y > 0 ? k_height / size.y : 1;

    // Replace the blocks of the box.
    const Scene box = load("builtin:cornell");
    SceneBuilder builder(box);
    for (const char* block : {"tall block", "short block"}) builder.remove(box.find_node(block));
    const MaterialId clay = builder.material({.base_color = k_clay, .metallic = 0, .roughness = 1});
    for (const scene::Mesh& mesh : model.meshes) {
        std::vector<Vec3> positions, normals;
        std::vector<std::uint32_t> indices;
        for (const glm::vec3& p : mesh.positions)
            positions.push_back(
                {scale * (p.x - centre.x), scale * (p.y - bounds.low.y) + k_floor, scale * (p.z - centre.z) + k_back});
        for (const glm::vec3& n : mesh.normals) normals.push_back({n.x, n.y, n.z});
        for (const auto& triangle : mesh.triangles)
            for (int corner = 0; corner < 3; ++corner) indices.push_back(triangle[corner]);
        if (indices.empty()) continue;
        builder.instance(builder.mesh({.positions = positions, .indices = indices, .normals = normals}), clay);
    }
    return builder.finish();
}

}   // namespace gnomon::bench
