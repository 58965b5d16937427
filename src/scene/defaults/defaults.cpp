// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <glm/gtc/matrix_transform.hpp>

#include "base/check.h"
#include "scene/defaults/emissive_lights.h"
#include "scene/defaults/framing.h"
#include "scene/defaults/interior.h"
#include "scene/emission.h"
#include "scene/scene.h"

namespace gnomon::scene {

namespace {
// A late-morning sun from the left front and a clear sky, in lux and nits scaled so that a white wall is about 1. The
// ground is grey, as bright as a reflectance of 0.3 would be under both. The haze between them is wide, because objects
// that float in the air have no horizon.
constexpr glm::vec3 k_sun_color{4.4f, 4.15f, 3.75f};
constexpr glm::dvec3 k_to_sun{-0.6, 0.75, 0.4};
constexpr glm::vec3 k_zenith{0.16f, 0.28f, 0.55f}, k_horizon{0.50f, 0.57f, 0.65f}, k_ground{0.20f, 0.195f, 0.19f};
// The sun of a courtyard: steep from behind the view, so that it reaches the ground. Along the view, up, to the
// left.
constexpr glm::dvec3 k_to_sun_of_court{-0.55, 1.0, 0.12};
// Irradiance by several bounces of sky and sun light in the courtyard's arcades.
constexpr glm::vec3 k_fill_of_court{0.06f, 0.058f, 0.055f};

// From the right, a little above: the angle of product photographs.
constexpr glm::dvec3 k_to_camera{0.55, 0.36, 1.0};
constexpr double k_fov = 0.7;
constexpr double k_near = 5e-5;   // of the diagonal

// The default light of a closed room: a square under the middle of the ceiling.
constexpr float k_room_light_irradiance = 3;   // on the floor below, like that of the sun outdoors
constexpr float k_room_light_size = 0.25f;     // of the room's shorter side
constexpr float k_room_light_drop = 0.02f;     // below the highest point, as a fraction of the height
constexpr int k_room_light_lights = 16;

void add_room_light(Scene& scene)
{
    const Box3 box = scene.bounds(scene.timeline.start);
    const glm::vec3 size = box.size();
    const float half = 0.5f * k_room_light_size * std::min(size.x, size.z);
    glm::vec3 middle = box.centre();
    middle.y = box.high.y - k_room_light_drop * size.y;
    EmitterPatch patch;
    const glm::vec3 u(half, 0, 0), v(0, 0, half);
    patch.triangles = {middle - u - v, middle + u - v, middle + u + v, middle - u - v, middle + u + v, middle - u + v};
    patch.normal = {0, -1, 0};
    patch.area = 4 * half * half;
    // Irradiance below a small square light: radiance times area over the height squared.
    patch.radiance = glm::vec3(1.0f, 0.95f, 0.85f) * (k_room_light_irradiance * size.y * size.y / patch.area);
    Light like;
    like.name = "default light";
    like.by_default = true;
    add_patch_lights(scene, patch, k_room_light_lights, 1, 0, like);
    scene.finish();
    add_room_fill(scene, patch.radiance * (static_cast<float>(k_pi) * patch.area));
    scene.warnings.emplace_back("no light in the scene: added a default light below the ceiling");
}

NodeId add_looking_node(Scene& scene, const char* name, const glm::dvec3& eye, const glm::dvec3& direction)
{
    const glm::dvec3 up = std::abs(direction.y) > 0.99 ? glm::dvec3(0, 0, -1) : glm::dvec3(0, 1, 0);
    const NodeId node = scene.add_node(name, none, glm::inverse(glm::lookAt(eye, eye + direction, up)));
    scene.child_begin.push_back(scene.child_begin.back());   // the node has no children; keeps the index complete
    return node;
}
}   // namespace

void add_default_light(Scene& scene)
{
    if (!scene.lights.empty() || emits_light(scene)) return;
    GNOMON_CHECK(!scene.child_begin.empty());   // after finish()
    // Light a closed room from its ceiling; no sun reaches it.
    const auto interior = find_interior(scene);
    if (interior && interior->covered) return add_room_light(scene);
    glm::dvec3 to_sun = k_to_sun;
    if (interior) {
        scene.background.color = k_fill_of_court;
        const glm::dvec3 ahead(interior->direction);
        to_sun = k_to_sun_of_court.x * ahead + k_to_sun_of_court.y * glm::dvec3(0, 1, 0) +
                 k_to_sun_of_court.z * glm::cross(glm::dvec3(0, 1, 0), ahead);
    }
    to_sun = glm::normalize(to_sun);
    Light sun;
    sun.name = "default sun";
    sun.type = LightType::directional;
    sun.color = k_sun_color;
    sun.by_default = true;
    sun.node = add_looking_node(scene, "default sun", glm::dvec3(0), -to_sun);
    scene.lights.push_back(sun);
    scene.background.kind = Background::Kind::sky;
    scene.background.zenith = k_zenith, scene.background.horizon = k_horizon, scene.background.ground = k_ground;
    scene.background.sun_direction = glm::vec3(to_sun);
    scene.warnings.emplace_back("no light in the scene: added a default sky and sun");
}

void add_default_camera(Scene& scene)
{
    if (!scene.cameras.empty()) return;
    GNOMON_CHECK(!scene.child_begin.empty());
    if (const auto interior = find_interior(scene)) {
        Camera camera;
        camera.name = "default camera";
        camera.vertical_fov = interior->vertical_fov;
        camera.near = static_cast<double>(scene.bounds(scene.timeline.start).diagonal()) * k_near;
        camera.node =
            add_looking_node(scene, "default camera", glm::dvec3(interior->eye), glm::dvec3(interior->direction));
        scene.cameras.push_back(camera);
        scene.warnings.emplace_back("no camera in the scene: added a default camera inside the scene");
        return;
    }
    FramingOptions options;
    options.back = glm::normalize(k_to_camera);
    options.vertical_fov = k_fov;
    const Framed framed = frame_clip(scene, options);
    Camera camera;
    camera.name = "default camera";
    camera.vertical_fov = k_fov;
    camera.near = framed.size * k_near;
    camera.node = add_looking_node(scene, "default camera", framed.eye, -options.back);
    scene.cameras.push_back(camera);
    scene.warnings.emplace_back("no camera in the scene: added a default camera that frames the scene");
}

}   // namespace gnomon::scene
