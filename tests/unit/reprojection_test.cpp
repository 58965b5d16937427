// SPDX-License-Identifier: Apache-2.0
// Images that are moved to another camera are what that camera shows.
#ifdef GNOMON_VIEWER
#include "viewer/reprojection.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>

#include "viewer/orbit_camera.h"
#include "viewer/projection.h"

namespace gnomon::viewer {
namespace {

constexpr int k_width = 160, k_height = 90;
constexpr glm::vec2 k_size{k_width, k_height};

// A camera at a place, which looks along -Z, turned to the left and upwards.
Camera camera_at(const glm::vec3& eye, float left = 0, float up = 0)
{
    OrbitCamera orbit;
    Camera camera;
    camera.transform.m[12] = static_cast<double>(eye.x);
    camera.transform.m[13] = static_cast<double>(eye.y);
    camera.transform.m[14] = static_cast<double>(eye.z);
    orbit.follow(camera, {k_width, k_height}, 5);
    orbit.look(-left, up);
    return orbit.camera();
}

struct Seen {
    Image8 image;
    std::vector<float> nearness;
};

// A floor at y = 0 as far as a wall at z = -8, whose upper edge is at y = 3, under a sky. Their colours are smooth
// functions of the place, and of the direction.
Seen seen_by(const Camera& camera)
{
    const Projection view(camera, k_size);
    const glm::vec3 forward = forward_of(camera);
    Seen seen;
    seen.image.width = k_width, seen.image.height = k_height, seen.image.channels = 3;
    for (int y = 0; y < k_height; ++y)
        for (int x = 0; x < k_width; ++x) {
            const auto line = view.line_at((glm::vec2(x, y) + 0.5f) / k_size);
            const float to_wall = (-8 - line.origin.z) / line.direction.z;
            const float to_floor = line.direction.y < 0 ? -line.origin.y / line.direction.y : k_infinity;
            const float distance = std::min(to_wall, to_floor);
            const glm::vec3 at = line.origin + distance * line.direction;
            const bool sky = to_wall < to_floor && at.y > 3;
            const glm::vec3 what = sky ? 4.0f * line.direction : to_floor < to_wall ? 1.5f * at : 0.8f * at;
            for (int channel = 0; channel < 3; ++channel)
                seen.image.data.push_back(
                    static_cast<std::uint8_t>(128 + 100 * std::sin(what[channel] + (sky ? 1 : 0))));
            seen.nearness.push_back(sky ? 0 : 1 / (distance * glm::dot(line.direction, forward)));
        }
    return seen;
}

// The mean difference of two images, away from their rims.
double difference(const Image8& a, const Image8& b)
{
    constexpr int k_rim = 12;
    double sum = 0;
    for (int y = k_rim; y < k_height - k_rim; ++y)
        for (int x = k_rim; x < k_width - k_rim; ++x)
            for (int channel = 0; channel < 3; ++channel)
                sum += std::abs(a.pixel(x, y)[channel] - b.pixel(x, y)[channel]);
    return sum / (3.0 * (k_width - 2 * k_rim) * (k_height - 2 * k_rim));
}

TEST(Reprojection, MovesPlacesAsTheOtherCameraShowsThem)
{
    Camera from = camera_at({0, 1.5f, 0}), to = camera_at({0.4f, 1.7f, -0.5f}, 0.2f, -0.1f);
    from.shift_x = 0.1, to.shift_y = -0.2;
    to.vertical_fov = 0.6;
    const auto change = Reprojection::between(from, to, k_size);
    ASSERT_TRUE(change);
    const Projection before(from, k_size), after(to, k_size);
    for (const glm::vec3& point : {glm::vec3(0, 1, -4), glm::vec3(1, 2, -6), glm::vec3(-2, 0, -9)}) {
        const glm::vec2 place = before.place_of(point).value();
        const auto moved = change->moved(place, 1 / glm::dot(point - eye_of(from), forward_of(from)));
        ASSERT_TRUE(moved);
        EXPECT_LT(glm::length(*moved - after.place_of(point).value()), 1e-5f);
    }
    // Of something behind the other camera, there is no place.
    EXPECT_FALSE(Reprojection::between(from, camera_at({0, 1.5f, -7}), k_size)->moved({0.5f, 0.5f}, 1.0f / 4));
    from.orthographic_height = 4;
    EXPECT_FALSE(Reprojection::between(from, to, k_size));
}

TEST(Reprojection, AMovedImageIsAlmostThatOfTheOtherCamera)
{
    const Camera from = camera_at({0, 1.5f, 0});
    const Seen seen = seen_by(from);
    const struct {
        const char* what;
        Camera to;
        double most;   // mean difference of bytes; what comes into view at the edge of the wall has none
    } cases[] = {{"turned", camera_at({0, 1.5f, 0}, 0.06f, 0.03f), 1},
                 {"forward", camera_at({0, 1.5f, -0.4f}), 1},
                 {"sideways", camera_at({0.25f, 1.5f, 0}), 1},
                 {"all", camera_at({-0.2f, 1.6f, 0.2f}, -0.05f, 0.04f), 1.5}};
    for (const auto& c : cases) {
        const Image8 shown = seen_by(c.to).image;
        const auto change = Reprojection::between(from, c.to, k_size);
        ASSERT_TRUE(change);
        const Image8 moved = change->moved(seen.image, seen.nearness);
        const double before = difference(seen.image, shown), after = difference(moved, shown);
        RecordProperty(c.what, std::to_string(after));
        EXPECT_GT(before, 4) << c.what << ": the test sees nothing";
        EXPECT_LT(after, c.most) << c.what << ", " << before << " where it is not moved";
    }
    // A camera that is no camera makes an image of some kind.
    Camera flat = from;
    flat.vertical_fov = 0;
    if (const auto any = Reprojection::between(from, flat, k_size)) any->moved(seen.image, seen.nearness);
    if (const auto any = Reprojection::between(flat, from, k_size)) any->moved(seen.image, seen.nearness);
    const auto none = Reprojection::between(from, from, k_size);
    ASSERT_TRUE(none);
    EXPECT_LT(difference(none->moved(seen.image, seen.nearness), seen.image), 0.1);
}

// Before a near object, another step is taken: what lies before stays before.
TEST(Reprojection, ANearObjectMovesFartherThanWhatIsBehindIt)
{
    const Camera from = camera_at({0, 0, 0}), to = camera_at({0.2f, 0, 0});
    Seen seen;
    seen.image.width = k_width, seen.image.height = k_height, seen.image.channels = 3;
    const auto is_near = [](int x) { return x >= 60 && x < 100; };   // a post, two metres away before a wall at ten
    for (int y = 0; y < k_height; ++y)
        for (int x = 0; x < k_width; ++x) {
            for (int channel = 0; channel < 3; ++channel) seen.image.data.push_back(is_near(x) ? 220 : 30);
            seen.nearness.push_back(is_near(x) ? 0.5f : 0.1f);
        }
    const auto change = Reprojection::between(from, to, k_size);
    ASSERT_TRUE(change);
    const Image8 moved = change->moved(seen.image, seen.nearness);
    const auto column = [&](float x) {
        return static_cast<int>(change->moved({x / k_size.x, 0.5f}, 0.5f)->x * k_size.x);
    };
    EXPECT_LT(column(60), 52);
    constexpr int k_edge = 3;   // pixels between two searches
    for (int x = column(60) + k_edge; x < column(100) - k_edge; ++x) EXPECT_EQ(moved.pixel(x, 45)[0], 220) << x;
    for (int x = 0; x < column(60) - k_edge; ++x) EXPECT_EQ(moved.pixel(x, 45)[0], 30) << x;
    for (int x = 102; x < k_width; ++x) EXPECT_EQ(moved.pixel(x, 45)[0], 30) << x;
}

}   // namespace
}   // namespace gnomon::viewer
#endif
