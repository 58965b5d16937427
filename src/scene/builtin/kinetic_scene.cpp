// SPDX-License-Identifier: Apache-2.0
// builtin:kinetic: a courtyard around a sundial, late on a summer's day, under a mobile that turns.

#include <glm/gtc/matrix_transform.hpp>

#include "scene/builtin/builtin.h"
#include "scene/builtin/kinetic.h"

namespace gnomon::scene {

namespace kinetic {

MeshId add_mesh(Scene& scene, MeshBuilder& builder, const char* name)
{
    scene.meshes.push_back(builder.finish(name));
    return static_cast<MeshId>(scene.meshes.size() - 1);
}

NodeId add_object(Scene& scene, MeshId mesh, const char* name, const glm::dmat4& local, NodeId parent)
{
    const NodeId node = scene.add_node(name, parent, local);
    scene.nodes[node].mesh = mesh;
    return node;
}

glm::dmat4 placed(const glm::dvec3& at, double turn, double scale)
{
    glm::dmat4 m = glm::translate(glm::dmat4(1), at);
    m = glm::rotate(m, turn, glm::dvec3(0, 1, 0));
    return glm::scale(m, glm::dvec3(scale));
}

}   // namespace kinetic

Scene make_kinetic()
{
    using namespace kinetic;
    Scene scene;
    scene.name = "builtin:kinetic";
    const Materials materials = add_materials(scene);

    // The sun stands low at the left, slightly behind the scene.
    const glm::dvec3 to_sun = glm::normalize(glm::dvec3(-0.74, 0.53, 0.38));
    Light sun;
    sun.name = "sun";
    sun.type = LightType::directional;
    sun.color = {6.2f, 4.5f, 2.7f};   // lux, scaled so that a sunlit wall is about 1
    sun.node = scene.add_node("sun", none, glm::inverse(glm::lookAt(glm::dvec3(0), -to_sun, glm::dvec3(0, 1, 0))));
    scene.lights.push_back(sun);

    scene.background.kind = Background::Kind::sky;
    scene.background.zenith = {0.05f, 0.22f, 0.70f};
    scene.background.horizon = {0.68f, 0.78f, 0.85f};
    scene.background.ground = {0.30f, 0.21f, 0.14f};
    scene.background.sun_direction = glm::vec3(to_sun);
    scene.background.sun_radiance = {60, 46, 28};

    add_landscape(scene, materials);
    add_courtyard(scene, materials);
    add_arcades(scene, materials);
    add_tower(scene, materials);
    add_sundial(scene, materials);
    add_ornaments(scene, materials);
    add_trees(scene, materials);
    add_climbers(scene, materials);
    add_mobile(scene, materials);
    add_camera(scene);

    scene.timeline = {0, k_end, k_frames, k_fps, false};
    scene.finish();
    return scene;
}

}   // namespace gnomon::scene
