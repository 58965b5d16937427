// SPDX-License-Identifier: Apache-2.0
// The handles at a picked object, and where cameras show what is picked.
#ifdef GNOMON_VIEWER
#include "viewer/gizmo.h"

#include <gtest/gtest.h>

#include "gnomon/gnomon.h"

namespace gnomon::viewer {
namespace {

Camera camera_at(const Vec3& eye, const Vec3& target)
{
    Camera camera;
    camera.transform = Transform::look_at(eye, target);
    return camera;
}

glm::vec3 applied(const Transform& transform, const glm::vec3& p)
{
    glm::dmat4 matrix;
    for (int i = 0; i < 16; ++i) matrix[i / 4][i % 4] = transform.m[static_cast<std::size_t>(i)];
    return glm::vec3(matrix * glm::dvec4(glm::dvec3(p), 1));
}

// What a pixel shows lies where the projection says, for each kind of camera.
TEST(Projection, AgreesWithWhatIsPicked)
{
    const Scene scene = load("builtin:cornell");
    std::vector<Camera> cameras(4, camera_at({0.4, 1.2, 3.5}, {0, 1, 0}));
    cameras[1].shift_x = 0.1, cameras[1].shift_y = -0.15;
    cameras[2].orthographic_height = 2;
    cameras[3].intrinsics = Intrinsics{.fx = 60, .fy = 70, .cx = 30, .cy = 20, .size = {64, 48}};
    Renderer renderer({.threads = 1});
    for (std::size_t c = 0; c < cameras.size(); ++c) {
        RenderOptions options;
        options.size = {64, 48};
        options.samples = 1;
        options.indirect = Indirect::off;
        renderer.set_options(options);
        FrameInput input;
        input.camera = cameras[c];
        renderer.render(scene, input);
        const Projection projection(renderer.camera(), {64, 48});
        int seen = 0;
        for (const glm::ivec2 pixel :
             {glm::ivec2(20, 20), glm::ivec2(40, 12), glm::ivec2(33, 40), glm::ivec2(50, 30)}) {
            const Pick pick = renderer.pick(pixel.x, pixel.y);
            if (!pick.hit) continue;
            ++seen;
            const glm::vec3 point(pick.position.x, pick.position.y, pick.position.z);
            const auto place = projection.place_of(point);
            ASSERT_TRUE(place);
            EXPECT_NEAR(place->x * 64, static_cast<float>(pixel.x) + 0.5f, 0.02f) << c;
            EXPECT_NEAR(place->y * 48, static_cast<float>(pixel.y) + 0.5f, 0.02f) << c;
            const Projection::Line sight = projection.line_at(*place);
            const glm::vec3 off = point - sight.origin;
            EXPECT_LT(glm::length(off - glm::dot(off, sight.direction) * sight.direction), 1e-3f) << c;
        }
        EXPECT_GE(seen, 2) << c;
    }
}

constexpr glm::vec2 k_corner(20, 10), k_size(800, 600), k_middle(420, 310);

TEST(Gizmo, ArrowsMoveTheObjectWithTheMouse)
{
    const Gizmo gizmo(camera_at({0, 0, 5}, {0, 0, 0}), glm::vec3(0), k_corner, k_size);
    EXPECT_EQ(gizmo.at(k_middle), Gizmo::Handle::scale);
    EXPECT_EQ(gizmo.at(k_middle + glm::vec2(50, 1)), Gizmo::Handle::move_x);
    EXPECT_EQ(gizmo.at(k_middle + glm::vec2(1, -50)), Gizmo::Handle::move_y);   // up
    EXPECT_EQ(gizmo.at(k_middle + glm::vec2(200, 90)), Gizmo::Handle::none);
    const glm::vec2 from = k_middle + glm::vec2(50, 0), to = from + glm::vec2(120, 30);
    const Gizmo::Change change = gizmo.drag(Gizmo::Handle::move_x, from, to);
    const float metre = 600 / (2 * 5 * std::tan(0.4f));   // in pixels
    EXPECT_NEAR(change.move.x, 120 / metre, 0.005f);
    EXPECT_EQ(change.move.y, 0);
    EXPECT_EQ(gizmo.drag(Gizmo::Handle::move_z, from, to).move, glm::vec3(0)) << "an axis that is seen from its end";
    EXPECT_NEAR(gizmo.drag(Gizmo::Handle::scale, k_middle, k_middle + glm::vec2(100, 0)).factor, 2, 1e-5f);
}

TEST(Gizmo, RingsTurnTheObjectWithTheMouse)
{
    const Gizmo gizmo(camera_at({0, 5, 5}, {0, 0, 0}), glm::vec3(0), k_corner, k_size);
    EXPECT_FALSE(gizmo.line(Gizmo::Handle::turn_y).empty());
    EXPECT_EQ(gizmo.at(gizmo.line(Gizmo::Handle::turn_y)[10]), Gizmo::Handle::turn_y);
    // Follow a point of the ring by a quarter turn: from +Z, which is nearest, to +X, at the right.
    const Projection projection(camera_at({0, 5, 5}, {0, 0, 0}), k_size);
    const glm::vec2 from = k_corner + *projection.place_of({0, 0, 0.7f}) * k_size;
    const glm::vec2 to = k_corner + *projection.place_of({0.7f, 0, 0}) * k_size;
    EXPECT_NEAR(gizmo.drag(Gizmo::Handle::turn_y, from, to).angle, k_pi / 2, 1e-3);
    // A ring that is seen from its edge would hide an arrow.
    const Gizmo level(camera_at({0, 0, 5}, {0, 0, 0}), glm::vec3(0), k_corner, k_size);
    EXPECT_TRUE(level.line(Gizmo::Handle::turn_y).empty());
    EXPECT_EQ(level.line(Gizmo::Handle::turn_z).size(), 49u);
}

// A change in the world is that change below parents that turn and scale.
TEST(Gizmo, ChangesAreInTheWorldBelowAnyParent)
{
    const Transform parent =
        Transform::translation(1, 2, 3) * Transform::rotation({1, 1, 0}, 0.7) * Transform::scaling(2, 2, 2);
    Picked picked;
    picked.transform = Transform::translation(0.5, 0, 0) * Transform::rotation({0, 0, 1}, 0.3);
    picked.world = parent * picked.transform;
    picked.pivot = {0.2f, 0.1f, 0};
    const glm::vec3 pivot = pivot_of(picked), point(0.4f, -0.3f, 0.8f);
    UserOverride before{NodeId{}, picked.transform};
    before.pivot = applied(picked.transform, picked.pivot);
    EXPECT_EQ(before.transform(), picked.transform);

    Gizmo::Change change;
    change.move = {0, 0.5f, 0}, change.axis = {0, 1, 0}, change.angle = 0.6f, change.factor = 1.5f;
    const UserOverride after = changed(before, change, parent_of(picked));
    const glm::vec3 found = applied(parent * after.transform(), point);
    const glm::vec3 off = 1.5f * (applied(picked.world, point) - pivot);
    const glm::vec3 turned = glm::vec3(glm::mat4_cast(glm::angleAxis(0.6f, glm::vec3(0, 1, 0))) * glm::vec4(off, 1));
    EXPECT_LT(glm::length(found - (pivot + turned + change.move)), 1e-4f);
}

}   // namespace
}   // namespace gnomon::viewer
#endif
