// SPDX-License-Identifier: Apache-2.0
#include "scene/defaults/framing.h"

#include <gtest/gtest.h>

#include "base/random.h"

namespace gnomon::scene {
namespace {

// Moves from the origin to `there` in one second.
class Straight : public TransformTrack {
 public:
    explicit Straight(const glm::dvec3& there) : there_(there) {}
    glm::dmat4 evaluate(double time) const override
    {
        glm::dmat4 result(1);
        result[3] = glm::dvec4(std::clamp(time, 0.0, 1.0) * there_, 1);
        return result;
    }
    std::vector<Interval> changing() const override { return {{0, 1}}; }

 private:
    glm::dvec3 there_;
};

// A static cloud of triangles, and one that moves `there`.
Scene clouds(std::uint64_t seed, const glm::dvec3& there, std::uint32_t vertices = 30)
{
    Random random(seed);
    Scene scene;
    scene.materials.emplace_back();
    Mesh mesh;
    const glm::vec3 size(random.uniform(0.2f, 4), random.uniform(0.2f, 4), random.uniform(0.2f, 4));
    for (std::uint32_t i = 0; i < vertices; ++i)
        mesh.positions.push_back(size * glm::vec3(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)));
    for (std::uint32_t i = 0; i < vertices; i += 3) mesh.triangles.emplace_back(i, i + 1, i + 2);
    mesh.parts = {{0, 0, vertices / 3}};
    scene.meshes.push_back(mesh);
    scene.add_node("still", none);
    scene.add_node("goes", none);
    scene.nodes[0].mesh = scene.nodes[1].mesh = 0;
    scene.nodes[1].transform = std::make_shared<Straight>(there);
    scene.timeline.end = 1;
    scene.finish();
    return scene;
}

// The fraction of the image's half width and half height that the vertices reach at a time; infinite behind the
// eye.
glm::dvec2 reach(const Scene& scene, const FramingOptions& options, const glm::dvec3& eye, double time, double aspect)
{
    const glm::dvec3 right = glm::normalize(glm::cross(glm::dvec3(0, 1, 0), options.back));
    const glm::dvec3 up = glm::cross(options.back, right);
    const double tangent = std::tan(options.vertical_fov / 2);
    glm::dvec2 most(0);
    for (const Object& object : scene.objects) {
        for (const glm::vec3& p : scene.meshes[object.mesh].positions) {
            const glm::dvec3 to = transform_point(scene.world_matrix(object.node, time), glm::dvec3(p)) - eye;
            const double depth = -glm::dot(to, options.back);
            if (depth <= 0) return glm::dvec2(1e9);
            most.x = std::max(most.x, std::abs(glm::dot(to, right)) / (depth * tangent * aspect));
            most.y = std::max(most.y, std::abs(glm::dot(to, up)) / (depth * tangent));
        }
    }
    return most;
}

FramingOptions from_the_right()
{
    FramingOptions options;
    options.back = glm::normalize(glm::dvec3(0.55, 0.36, 1.0));
    return options;
}

TEST(Framing, SceneStaysInTheImageAndFillsItAtAllTimes)
{
    const FramingOptions options = from_the_right();
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
        const Scene scene = clouds(seed, {0.7, 1.2, -0.4});
        const Framed framed = frame_clip(scene, options);
        for (const double aspect : {0.4, 1.0, 4.0 / 3, 16.0 / 9, 3.0}) {
            glm::dvec2 most(0);
            for (int look = 0; look < options.looks; ++look) {
                const double time = static_cast<double>(look) / (options.looks - 1);
                most = glm::max(most, reach(scene, options, framed.eye(aspect), time, aspect));
            }
            EXPECT_LE(std::max(most.x, most.y), 1.0) << seed << " " << aspect;
            // In a wide image, the nearest point may keep the camera away.
            if (aspect < 2) {
                EXPECT_NEAR(std::max(most.x, most.y), 1 / options.margin, 1e-3) << seed << " " << aspect;
            }
        }
        EXPECT_GT(framed.size, 0);
    }
}

// The least and the greatest coordinate in the image at a time, from -1 to 1: of x or of y.
glm::dvec2 extent(const Scene& scene, const FramingOptions& options, const glm::dvec3& eye, double time, double aspect,
                  int axis)
{
    const glm::dmat3 axes = camera_axes(options.back);
    const double tangent = std::tan(options.vertical_fov / 2) * (axis == 0 ? aspect : 1);
    glm::dvec2 result(1e9, -1e9);
    for (const Object& object : scene.objects)
        for (const glm::vec3& p : scene.meshes[object.mesh].positions) {
            const glm::dvec3 to = transform_point(scene.world_matrix(object.node, time), glm::dvec3(p)) - eye;
            const double at = glm::dot(to, axes[axis]) / (-glm::dot(to, options.back) * tangent);
            result = glm::dvec2(std::min(result.x, at), std::max(result.y, at));
        }
    return result;
}

TEST(Framing, SceneIsInTheMiddleAlongBothAxes)
{
    const FramingOptions options = from_the_right();
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
        const Scene scene = clouds(seed, {0, 0, 0});
        const Framed framed = frame_clip(scene, options);
        for (const double aspect : {0.4, 1.0, 16.0 / 9, 3.0})
            for (int axis = 0; axis < 2; ++axis) {
                const glm::dvec2 at = extent(scene, options, framed.eye(aspect), 0, aspect, axis);
                EXPECT_NEAR(at.x, -at.y, 1e-4) << seed << ' ' << aspect << ' ' << axis;
                EXPECT_LE(at.y, 1 / options.margin + 1e-6);
            }
    }
}

// Leaps up and down between any two of 17 looks.
class Leaps : public TransformTrack {
 public:
    glm::dmat4 evaluate(double time) const override
    {
        glm::dmat4 result(1);
        result[3].y = 3 * std::pow(std::sin(16 * k_pi * time), 2);
        return result;
    }
    std::vector<Interval> changing() const override { return {{0, 1}}; }
};

TEST(Framing, EveryFrameOfAShortClipIsWhole)
{
    const FramingOptions options = from_the_right();
    Scene scene = clouds(4, {0, 0, 0});
    scene.nodes[1].transform = std::make_shared<Leaps>();
    scene.timeline.frames = 97;
    scene.timeline.fps = 96;
    scene.finish();
    const Framed framed = frame_clip(scene, options);
    for (int frame = 1; frame <= scene.timeline.frames; ++frame) {
        const glm::dvec2 most = reach(scene, options, framed.eye(1), scene.timeline.time_of(frame), 1);
        EXPECT_LE(std::max(most.x, most.y), 1 / options.margin + 1e-3) << frame;
    }
}

TEST(Framing, OfManyVerticesTheOuterOnesSuffice)
{
    const FramingOptions options = from_the_right();
    const glm::dvec3 there(0.7, 1.2, -0.4);
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
        const Scene scene = clouds(seed, there, 30'000);
        const Framed framed = frame_clip(scene, options);
        CameraFit all({options.vertical_fov, options.margin, 0});
        const glm::dmat3 to_camera = glm::transpose(framed.axes);
        for (int look = 0; look < options.looks; ++look)
            for (const glm::vec3& p : scene.meshes[0].positions) {
                all.add(to_camera * glm::dvec3(p));
                all.add(to_camera * (glm::dvec3(p) + look / (options.looks - 1.0) * there));
            }
        for (const double aspect : {0.4, 1.0, 3.0}) {
            const glm::dvec3 difference = framed.eye(aspect) - framed.axes * all.eye(aspect);
            EXPECT_LT(glm::length(difference), 1e-5 * framed.size) << seed << ' ' << aspect;
        }
    }
}

TEST(Framing, TheBoxOfAClipIsThatOfItsFraming)
{
    const Scene scene = clouds(5, {0.7, 1.2, -0.4});
    const Framed framed = frame_clip(scene, {}), box = box_of_clip(scene);
    EXPECT_EQ(box.box.low, framed.box.low);
    EXPECT_EQ(box.box.high, framed.box.high);
    EXPECT_EQ(box.size, framed.size);
}

TEST(Framing, DistantObjectsDoNotShrinkTheRest)
{
    const FramingOptions options = from_the_right();
    const Scene scene = clouds(3, {400, 0, 0});
    const Framed framed = frame_clip(scene, options);
    const glm::dvec2 most = reach(scene, options, framed.eye(1.5), 0, 1.5);
    EXPECT_NEAR(std::max(most.x, most.y), 1 / options.margin, 1e-3);
    EXPECT_LT(framed.size, 20);
}

TEST(Framing, HandlesEmptyAndPointScenes)
{
    const Framed nothing = frame_clip(Scene(), from_the_right());
    EXPECT_TRUE(is_finite(glm::vec3(nothing.eye(1))));
    EXPECT_GT(glm::length(nothing.eye(1)), 1);
    Scene point;
    point.materials.emplace_back();
    Mesh mesh;
    mesh.positions.assign(3, {5, 6, 7});
    mesh.triangles.emplace_back(0, 1, 2);
    mesh.parts = {{0, 0, 1}};
    point.meshes.push_back(mesh);
    point.add_node("", none);
    point.nodes[0].mesh = 0;
    point.finish();
    const Framed framed = frame_clip(point, from_the_right());
    EXPECT_TRUE(is_finite(glm::vec3(framed.eye(1))));
    EXPECT_GT(framed.size, 0);
}

}   // namespace
}   // namespace gnomon::scene
