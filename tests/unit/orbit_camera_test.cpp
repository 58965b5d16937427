// SPDX-License-Identifier: Apache-2.0
#ifdef GNOMON_VIEWER
#include "viewer/orbit_camera.h"

#include <gtest/gtest.h>

#include "gnomon/scene.h"
#include "viewer/projection.h"

namespace gnomon::viewer {
namespace {

constexpr Size k_size{64, 48};

Camera some_camera()
{
    const Scene scene = load("builtin:cornell");
    return scene.camera(scene.cameras().front());
}

glm::vec3 axis_of(const Camera& camera, std::size_t column)
{
    const auto& m = camera.transform.m;
    return glm::vec3(glm::dvec3(m[4 * column], m[4 * column + 1], m[4 * column + 2]));
}
glm::vec3 right_of(const Camera& camera)
{
    return axis_of(camera, 0);
}
glm::vec3 up_of(const Camera& camera)
{
    return axis_of(camera, 1);
}

void expect_near(const glm::vec3& a, const glm::vec3& b, float room)
{
    for (int axis = 0; axis < 3; ++axis) EXPECT_NEAR(a[axis], b[axis], room) << "axis " << axis;
}

TEST(OrbitCamera, StartsAtTheSceneCamera)
{
    const Camera given = some_camera();
    OrbitCamera orbit;
    orbit.follow(given, k_size, 2);
    const Camera own = orbit.camera();
    for (std::size_t i = 0; i < 16; ++i) EXPECT_NEAR(own.transform.m[i], given.transform.m[i], 1e-5) << "element " << i;
    Camera expected = given;
    expected.transform = own.transform;
    EXPECT_EQ(own, expected) << "the projection is kept";
}

TEST(OrbitCamera, OrbitsItsPivotAndStaysUpright)
{
    OrbitCamera orbit;
    orbit.follow(some_camera(), k_size, 2);
    const glm::vec3 pivot = orbit.pivot();
    for (int i = 0; i < 20; ++i) {
        orbit.orbit(0.3f, 0.2f);
        const Camera camera = orbit.camera();
        EXPECT_NEAR(glm::length(eye_of(camera) - pivot), 2, 1e-4f);
        expect_near(eye_of(camera) + 2.0f * forward_of(camera), pivot, 1e-4f);
        EXPECT_GT(up_of(camera).y, 0) << "the camera stays upright";
        EXPECT_NEAR(glm::length(glm::cross(right_of(camera), up_of(camera)) + forward_of(camera)), 0, 1e-5f);
    }
    orbit.zoom(0.5f);
    EXPECT_NEAR(glm::length(eye_of(orbit.camera()) - pivot), 1, 1e-4f);
}

TEST(OrbitCamera, LooksAndFliesFromTheEye)
{
    OrbitCamera orbit;
    orbit.follow(some_camera(), k_size, 2);
    const Camera before = orbit.camera();
    orbit.look(0.4f, 0.1f);
    const Camera after = orbit.camera();
    expect_near(eye_of(after), eye_of(before), 1e-4f);
    EXPECT_GT(glm::dot(forward_of(after), right_of(before)), 0) << "to the right";
    EXPECT_GT(forward_of(after).y, forward_of(before).y);
    orbit.fly(1, 0, 0);
    expect_near(eye_of(orbit.camera()), eye_of(after) + forward_of(after), 1e-4f);
    const glm::vec3 target(0.3f, 0.2f, -0.1f);
    orbit.aim(target);
    const Camera aimed = orbit.camera();
    expect_near(eye_of(aimed) + orbit.distance() * forward_of(aimed), target, 1e-4f);
}

// The same camera as field of view, intrinsics and matrix: half the height of the view, which the pointer crosses, is
// the same fraction of the distance.
TEST(OrbitCamera, PansByTheSameFractionOfTheViewAtAnyDistance)
{
    Camera by_angle = some_camera();
    by_angle.vertical_fov = 2 * std::atan(0.5);
    Camera by_pixels = by_angle, by_matrix = by_angle;
    by_pixels.intrinsics = Intrinsics{48, 48, 32, 24, {}};   // of 64 x 48 pixels
    by_matrix.matrix = Transform{};
    by_matrix.matrix->m = {1.5, 0, 0, 0, 0, 2, 0, 0, 0, 0, -1, -1, 0, 0, -0.02, 0};
    for (const Camera& given : {by_angle, by_pixels, by_matrix})
        for (const float distance : {0.5f, 5.0f}) {
            OrbitCamera orbit;
            orbit.follow(given, k_size, distance);
            const glm::vec3 before = orbit.pivot();
            orbit.pan(0.5f, 0);   // half the height to the right: the scene follows the pointer, the eye moves left
            const glm::vec3 went = orbit.pivot() - before;
            EXPECT_LT(glm::dot(went, right_of(orbit.camera())), 0);
            EXPECT_NEAR(glm::length(went), 0.5f * distance, 1e-4f * distance);
        }
    OrbitCamera orbit;
    orbit.follow(by_pixels, k_size, 1);
    EXPECT_EQ(orbit.camera().intrinsics->size, k_size) << "they belong to the size that was followed";
}

TEST(OrbitCamera, ZoomsAnOrthographicCameraByItsHeight)
{
    Camera by_height = some_camera();
    by_height.orthographic_height = 3;
    Camera by_matrix = some_camera();
    by_matrix.matrix = Transform{};
    by_matrix.matrix->m[5] = 2.0 / 3;
    for (const Camera& given : {by_height, by_matrix}) {
        OrbitCamera orbit;
        orbit.follow(given, k_size, 4);
        EXPECT_NEAR(orbit.camera().orthographic_height.value(), 3, 1e-5);
        orbit.zoom(0.5f);
        EXPECT_NEAR(orbit.camera().orthographic_height.value(), 1.5, 1e-5);
        EXPECT_FALSE(orbit.camera().matrix);
    }
}

TEST(OrbitCamera, LooksAtThePivotFromEachSide)
{
    OrbitCamera orbit;
    orbit.follow(some_camera(), k_size, 3);
    const glm::vec3 pivot = orbit.pivot();
    for (const auto& [side, towards] : {std::pair{OrbitCamera::Side::front, glm::vec3(0, 0, -1)},
                                        std::pair{OrbitCamera::Side::right, glm::vec3(-1, 0, 0)},
                                        std::pair{OrbitCamera::Side::top, glm::vec3(0, -1, 0)},
                                        std::pair{OrbitCamera::Side::corner, glm::normalize(glm::vec3(-1))}}) {
        orbit.look_from(side);
        EXPECT_GT(glm::dot(forward_of(orbit.camera()), towards), 0.999f);
        EXPECT_LT(glm::length(eye_of(orbit.camera()) + 3.0f * forward_of(orbit.camera()) - pivot), 1e-4f);
    }
}

// Whether an orbit camera shows all corners of a box, and how near they come to the edge of the view: 1 touches it.
float reach_of(const OrbitCamera& orbit, const Box3& box, Size size)
{
    const Projection projection(orbit.camera(), glm::vec2(size.width, size.height));
    float most = 0;
    for (int corner = 0; corner < 8; ++corner) {
        const auto place =
            projection.place_of(glm::vec3(corner & 1 ? box.high.x : box.low.x, corner & 2 ? box.high.y : box.low.y,
                                          corner & 4 ? box.high.z : box.low.z));
        if (!place) return k_infinity;
        for (int axis = 0; axis < 2; ++axis) most = std::max(most, std::abs(2 * (*place)[axis] - 1));
    }
    return most;
}

// Long, tall and deep boxes fill the view from every side, whatever projects them, and nothing of them is cut off.
TEST(OrbitCamera, FitsABoxFromEachSide)
{
    Camera by_angle = some_camera();
    Camera shifted = by_angle, by_height = by_angle, by_pixels = by_angle;
    shifted.shift_x = 0.1f, shifted.shift_y = -0.1f;
    by_height.orthographic_height = 0.01;
    by_pixels.intrinsics = Intrinsics{48, 40, 30, 20, {64, 48}};
    const Box3 boxes[] = {{glm::vec3(-40, 0, 1), glm::vec3(-2, 1, 2)},
                          {glm::vec3(0, 0, 0), glm::vec3(1, 90, 1)},
                          {glm::vec3(3, 0, -70), glm::vec3(4, 2, 5)}};
    for (const Camera& given : {by_angle, shifted, by_height, by_pixels})
        for (const Size size : {Size{64, 48}, Size{30, 90}})
            for (const Box3& box : boxes)
                for (const auto side : {OrbitCamera::Side::front, OrbitCamera::Side::right, OrbitCamera::Side::top,
                                        OrbitCamera::Side::corner}) {
                    OrbitCamera orbit;
                    orbit.follow(given, size, 3);
                    orbit.look_from(side);
                    orbit.fit(box, size);
                    EXPECT_LT(reach_of(orbit, box, size), 1);
                    EXPECT_GT(reach_of(orbit, box, size), 0.85f);
                    EXPECT_EQ(orbit.pivot(), box.centre());
                }
    OrbitCamera orbit;
    orbit.follow(by_angle, k_size, 3);
    const glm::vec3 before = orbit.pivot();
    orbit.fit({}, k_size);
    EXPECT_EQ(orbit.pivot(), before) << "nothing is shown";
}

}   // namespace
}   // namespace gnomon::viewer
#endif
