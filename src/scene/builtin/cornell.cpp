// SPDX-License-Identifier: Apache-2.0
// builtin:cornell. The constants in this file define the scene completely.

#include <array>
#include <glm/gtc/matrix_transform.hpp>

#include "scene/builtin/builtin.h"
#include "scene/builtin/shapes.h"

namespace gnomon::scene {

namespace {

constexpr float k_wall = 0.1f;   // thickness
constexpr int k_frames = 40;
constexpr double k_fps = 24;

const glm::dvec3 k_ball_start{-0.35, 0.1, 0.35};
const glm::dvec3 k_ball_step{0.02, -0.01, 0};   // a frame
constexpr float k_ball_radius = 0.12f;

// Moves the ball linearly: in frame i it is at start + i * step.
class BallTrack final : public TransformTrack {
 public:
    glm::dmat4 evaluate(double time) const override
    {
        constexpr double same_frame = 1e-9;
        double frame = 1 + time * k_fps;
        if (std::abs(frame - std::round(frame)) < same_frame) frame = std::round(frame);
        frame = std::min(std::max(frame, 1.0), static_cast<double>(k_frames));
        return glm::translate(glm::dmat4(1), k_ball_start + frame * k_ball_step);
    }
    std::vector<Interval> changing() const override { return {{0, (k_frames - 1) / k_fps}}; }
};

MaterialId add_rough(Scene& scene, const char* name, const glm::vec3& color)
{
    Material material;
    material.name = name;
    material.base_color = color;
    material.roughness = 1;
    scene.materials.push_back(material);
    return static_cast<MaterialId>(scene.materials.size() - 1);
}

NodeId add_mesh_node(Scene& scene, MeshBuilder& builder, const char* name, const glm::dmat4& local = glm::dmat4(1))
{
    scene.meshes.push_back(builder.finish(name));
    const NodeId node = scene.add_node(name, none, local);
    scene.nodes[node].mesh = static_cast<MeshId>(scene.meshes.size() - 1);
    return node;
}

}   // namespace

Scene make_cornell()
{
    Scene scene;
    scene.name = "builtin:cornell";
    const MaterialId white = add_rough(scene, "white", glm::vec3(0.75f));
    const MaterialId red = add_rough(scene, "red", {0.75f, 0.1f, 0.1f});
    const MaterialId green = add_rough(scene, "green", {0.1f, 0.75f, 0.1f});
    const MaterialId blue = add_rough(scene, "blue", {0.3f, 0.3f, 0.8f});

    // Walls around the box from -1 to 1, open towards the camera.
    struct Wall {
        const char* name;
        MaterialId material;
        glm::vec3 low, high;
    };
    constexpr float outer = 1 + k_wall;
    const std::array<Wall, 5> walls{{{"floor", white, {-outer, -outer, -outer}, {outer, -1, 1}},
                                     {"ceiling", white, {-outer, 1, -outer}, {outer, outer, 1}},
                                     {"back", white, {-1, -1, -outer}, {1, 1, -1}},
                                     {"left", red, {-outer, -1, -outer}, {-1, 1, 1}},
                                     {"right", green, {1, -1, -outer}, {outer, 1, 1}}}};
    MeshBuilder builder;
    for (const Wall& wall : walls) {
        builder.use(wall.material);
        builder.box(wall.low, wall.high, 0);
        add_mesh_node(scene, builder, wall.name);
    }

    // Two blocks, turned about +Y.
    const auto add_block = [&](const char* name, const glm::vec3& size, const glm::dvec3& centre, double turn) {
        builder.use(white);
        builder.box(-0.5f * size, 0.5f * size, 0);
        const glm::dmat4 place = glm::translate(glm::dmat4(1), centre);
        add_mesh_node(scene, builder, name, glm::rotate(place, turn, glm::dvec3(0, 1, 0)));
    };
    add_block("tall block", {0.55f, 1.2f, 0.55f}, {-0.35, -0.4, -0.35}, 0.35);
    add_block("short block", {0.55f, 0.55f, 0.55f}, {0.38, -0.725, 0.3}, -0.3);

    builder.use(blue);
    builder.sphere(glm::vec3(0), k_ball_radius, 64, 31);
    const NodeId ball = add_mesh_node(scene, builder, "ball");
    scene.nodes[ball].transform = std::make_shared<BallTrack>();

    Light spot;
    spot.name = "spot";
    spot.type = LightType::spot;
    spot.color = glm::vec3(8);   // candela
    spot.profile = SpotProfile::cosine;
    spot.inner_angle = 0;
    spot.outer_angle = 0.7f;
    const glm::dvec3 light_position(0.6, 0.8, 0.9), direction(-1.1, -1, -1.1);
    spot.node = scene.add_node(
        "spot", none, glm::inverse(glm::lookAt(light_position, light_position + direction, glm::dvec3(0, 1, 0))));
    scene.lights.push_back(spot);

    Camera camera;
    camera.name = "front";
    camera.vertical_fov = 2 * 0.31;
    camera.node = scene.add_node("camera", none, glm::translate(glm::dmat4(1), glm::dvec3(0, 0, 3.6)));
    scene.cameras.push_back(camera);

    scene.timeline = {0, (k_frames - 1) / k_fps, k_frames, k_fps, false};
    scene.finish();
    return scene;
}

}   // namespace gnomon::scene
