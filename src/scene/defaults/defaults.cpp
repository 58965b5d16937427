// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>

#include "base/check.h"
#include "scene/defaults/default_light.h"
#include "scene/defaults/default_view.h"
#include "scene/defaults/emissive_lights.h"
#include "scene/defaults/space_grid.h"
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

// The default light of a closed room: a square under the middle of the ceiling.
constexpr float k_room_light_irradiance = 3;   // on the floor below, like that of the sun outdoors
constexpr float k_room_light_size = 0.25f;     // of the room's shorter side
constexpr float k_room_light_drop = 0.02f;     // below the highest point, as a fraction of the height
constexpr int k_room_light_lights = 16;

constexpr float k_enough_lit = 0.25f;   // of all surfaces

void add_room_light(Scene& scene, const char* why)
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
    scene.warnings.push_back(fmt::format("{}: added a default light below the ceiling", why));
}

// How much of the surfaces the points that stand for emission shine on, by area: of the sides that surfaces show, or of
// both. Without them, nothing.
float share_lit_by_emission(const Scene& scene)
{
    const double start = scene.timeline.start;
    const std::vector<glm::dmat4> world = scene.world_matrices(start);
    std::vector<const Light*> emitters;
    for (const Light& light : scene.lights)
        if (light.of_surface) emitters.push_back(&light);
    if (emitters.empty()) return 0;
    const SpaceGrid grid(scene, start);
    if (grid.empty()) return 0;
    const auto shines_on = [&](const glm::vec3& point, const glm::vec3& normal) {
        const glm::vec3 from = point + 2.0f * grid.cell() * normal;
        return std::any_of(emitters.begin(), emitters.end(), [&](const Light* light) {
            const glm::vec3 at(world[light->node][3]), way = at - from;
            if (!(glm::dot(way, normal) > 0) || !(glm::dot(way, glm::vec3(world[light->node][2])) > 0)) return false;
            const float distance = glm::length(way);
            // Grid cells at both ends are filled by the surfaces themselves.
            return grid.cast(from, way / distance).distance > distance - 2 * grid.cell();
        });
    };
    // Ask at points that are spread by area.
    constexpr double k_points = 2048;
    double all = 0, next = 0;
    std::uint32_t lit = 0, asked = 0;
    for (const bool measures : {true, false}) {
        const double step = all / k_points;
        double sum = 0;
        for (const Object& object : scene.objects) {
            const Mesh& mesh = scene.meshes[object.mesh];
            const glm::mat4 m(world[object.node]);
            for (const MeshPart& part : mesh.parts)
                for (std::uint32_t t = part.first_triangle; t < part.first_triangle + part.triangle_count; ++t) {
                    glm::vec3 p[3];
                    for (int c = 0; c < 3; ++c) p[c] = transform_point(m, mesh.positions[mesh.triangles[t][c]]);
                    const glm::vec3 cross = glm::cross(p[1] - p[0], p[2] - p[0]);
                    const auto area = static_cast<double>(0.5f * glm::length(cross));
                    if (!(area > 0) || !std::isfinite(area)) continue;
                    sum += area;
                    if (measures) continue;
                    for (; next < sum; next += step) {
                        const glm::vec3 middle = (p[0] + p[1] + p[2]) / 3.0f, normal = glm::normalize(cross);
                        ++asked;
                        lit += shines_on(middle, normal) ||
                               (!scene.materials[part.material].one_sided() && shines_on(middle, -normal));
                    }
                }
        }
        if (measures && !((all = sum) > 0)) return 0;
    }
    return asked > 0 ? static_cast<float>(lit) / static_cast<float>(asked) : 0;
}

// Says so if nothing has any size in the first frame, as where everything grows out of points.
void warn_of_late_beginning(Scene& scene)
{
    constexpr int k_looks = 8;
    const double start = scene.timeline.start, length = scene.timeline.end - start;
    if (scene.objects.empty() || !(length > 0) || scene.bounds(start).diagonal() > 0) return;
    for (int look = 1; look < k_looks; ++look) {
        const double done = static_cast<double>(look) / (k_looks - 1);
        if (!(scene.bounds(start + length * done).diagonal() > 0)) continue;
        const double last = static_cast<double>(scene.timeline.frames) - 1;
        scene.warnings.push_back(fmt::format("frame 1 shows no surface, because none has any size there: frame {} does",
                                             1 + static_cast<int>(std::floor(last * done))));
        return;
    }
}

NodeId add_looking_node(Scene& scene, const char* name, const glm::dvec3& eye, const glm::dvec3& direction)
{
    const glm::dvec3 up = std::abs(direction.y) > 0.99 ? glm::dvec3(0, 0, -1) : glm::dvec3(0, 1, 0);
    const NodeId node = scene.add_node(name, none, glm::inverse(glm::lookAt(eye, eye + direction, up)));
    scene.child_begin.push_back(scene.child_begin.back());   // the node has no children; keeps the index complete
    return node;
}
}   // namespace

void add_sky_and_sun(Scene& scene, const Interior* court, const char* why)
{
    glm::dvec3 to_sun = k_to_sun;
    if (court) {
        scene.background.color = k_fill_of_court;
        const glm::dvec3 ahead(court->direction);
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
    scene.warnings.push_back(fmt::format("{}: added a default sky and sun", why));
}

void add_light_of_place(Scene& scene, const Interior& place, const char* why)
{
    if (place.covered)
        add_room_light(scene, why);
    else
        add_sky_and_sun(scene, &place, why);
}

void add_default_light(Scene& scene)
{
    GNOMON_CHECK(!scene.child_begin.empty());   // after finish()
    if (std::any_of(scene.lights.begin(), scene.lights.end(), [](const Light& l) { return !l.of_surface; })) return;
    // Emission is light enough, however dim, if it shines on enough of the scene; a glowing sign or a headlight does
    // not.
    const bool emits = !scene.lights.empty();
    if (emits && share_lit_by_emission(scene) >= k_enough_lit) return;
    const char* const why = emits ? "emissive surfaces light little of the scene" : "no light in the scene";
    if (const auto interior = find_interior(scene)) return add_light_of_place(scene, *interior, why);
    add_sky_and_sun(scene, nullptr, why);
}

void add_default_camera(Scene& scene)
{
    Survey unused;
    add_default_camera(scene, unused);
}

void add_default_camera(Scene& scene, Survey& found)
{
    if (!scene.cameras.empty()) return;
    GNOMON_CHECK(!scene.child_begin.empty());
    // The pointer does not own the scene.
    const SceneState state(std::shared_ptr<const Scene>(std::shared_ptr<const Scene>(), &scene), scene.timeline.start);
    DefaultView view = choose_view(state, {}, &found);
    view.camera.node = add_looking_node(scene, "default camera", view.eye, -view.axes[2]);
    scene.cameras.push_back(view.camera);
    const char* const how = !view.room         ? "that frames the scene"
                            : view.room->stage ? "before the scene"
                                               : "inside the scene";
    scene.warnings.push_back(fmt::format("no camera in the scene: added a default camera {}", how));
    warn_of_late_beginning(scene);
}

}   // namespace gnomon::scene
