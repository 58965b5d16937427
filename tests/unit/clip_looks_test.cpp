// SPDX-License-Identifier: Apache-2.0
// Looks at whole clips, which set-up takes often: what makes them cheap must not change what they find.
#include <gtest/gtest.h>

#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <random>

#include "base/bits.h"
#include "scene/defaults/default_view.h"
#include "scene/defaults/surroundings.h"
#include "scene/node_poses.h"
#include "scene/state.h"

namespace gnomon::scene {
namespace {

// Turns and moves evenly.
class Turning : public TransformTrack {
 public:
    explicit Turning(const glm::dvec3& speed) : speed_(speed) {}
    glm::dmat4 evaluate(double time) const override
    {
        return glm::rotate(glm::translate(glm::dmat4(1), time * speed_), time, glm::normalize(speed_));
    }
    std::vector<Interval> changing() const override { return {{0, 2}}; }

 private:
    glm::dvec3 speed_;
};

class RandomScene {
 public:
    explicit RandomScene(unsigned seed) : random_(seed) {}

    // Nodes in a tree, of which some move and some are hidden for a time; each shows a quad or a triangle.
    Scene make(int nodes)
    {
        Scene scene;
        scene.materials.emplace_back();
        for (const std::uint32_t corners : {3u, 6u}) {
            Mesh mesh;
            for (std::uint32_t i = 0; i < corners; ++i) mesh.positions.push_back(point(1));
            if (corners == 6) mesh.positions[3] = mesh.positions[2], mesh.positions[4] = mesh.positions[1];
            for (std::uint32_t i = 0; i < corners; i += 3) mesh.triangles.emplace_back(i, i + 1, i + 2);
            mesh.parts = {{0, 0, corners / 3}};
            scene.meshes.push_back(std::move(mesh));
        }
        for (int n = 0; n < nodes; ++n) {
            const NodeId parent =
                n == 0 || number() < 0.2f ? none : static_cast<NodeId>(number() * static_cast<float>(n));
            const glm::dmat4 turned = glm::rotate(glm::dmat4(1), 6.0 * number(), glm::dvec3(point(1)));
            const NodeId node = scene.add_node("", parent, glm::translate(turned, glm::dvec3(point(0.5f))));
            scene.nodes[node].mesh = static_cast<MeshId>(n % 2);
            if (number() < 0.2f) scene.nodes[node].transform = std::make_shared<Turning>(glm::dvec3(point(1)));
            if (number() > 0.1f) continue;
            auto hidden = std::make_shared<VisibilityTrack>();
            hidden->times = {0.4, 1.2}, hidden->visible = {false, true};
            scene.nodes[node].visibility = hidden;
        }
        scene.timeline = {0, 2, 12, 6, false};
        scene.finish();
        return scene;
    }
    float number() { return std::uniform_real_distribution<float>(0, 1)(random_); }
    glm::vec3 point(float size) { return size * (2.0f * glm::vec3(number(), number(), number()) - 1.0f); }

 private:
    std::mt19937 random_;
};

TEST(NodePoses, EqualThoseOfASceneState)
{
    RandomScene random(5);
    const Scene scene = random.make(60);
    SceneState state({std::shared_ptr<const Scene>(), &scene}, 0);
    NodePoses poses(scene, 0);
    int moved = 0, hidden = 0;
    for (const double time : {0.0, 0.3, 0.5, 1.9, 1.0, 0.1}) {
        state.advance(time);
        poses.go_to(time);
        for (NodeId n = 0; n < scene.nodes.size(); ++n) {
            ASSERT_TRUE(same_bits(poses.world(n), state.world(n))) << n << " at " << time;
            ASSERT_EQ(poses.visible(n), state.visible(n)) << n << " at " << time;
            moved += poses.world(n) != scene.world_matrix(n, 0), hidden += !poses.visible(n);
        }
    }
    EXPECT_GT(moved, 50);
    EXPECT_GT(hidden, 5);
}

TEST(ClipBounds, AreThoseOfAllTransformedCorners)
{
    for (unsigned seed = 0; seed < 8; ++seed) {
        RandomScene random(seed);
        Scene scene = random.make(20);
        // Beyond the range of float, a corner does not count.
        if (seed == 7) scene.nodes[3].local[3] = glm::dvec4(3.402e38, 1, 1, 1);
        Box3 expected;
        for (int frame = 1; frame <= scene.timeline.frames; ++frame) {
            const std::vector<glm::dmat4> world = scene.world_matrices(scene.timeline.time_of(frame));
            for (const Object& object : scene.objects) {
                const Box3 box = scene.meshes[object.mesh].bounds();
                for (int corner = 0; corner < 8; ++corner) {
                    const glm::dvec3 p(corner & 1 ? box.high.x : box.low.x, corner & 2 ? box.high.y : box.low.y,
                                       corner & 4 ? box.high.z : box.low.z);
                    const glm::vec3 q(transform_point(world[object.node], p));
                    if (is_finite(q)) expected.add(q);
                }
            }
        }
        EXPECT_TRUE(same_bits(clip_bounds(scene).whole, expected)) << seed;
    }
}

// The camera's choice asks whether the scene is a room, and where the clip takes its objects.
TEST(Surroundings, NeedNotAskAgainWhatTheCameraFoundOut)
{
    RandomScene random(9);
    const Scene scene = random.make(40);
    Scene asked = scene, told = scene;
    add_default_camera(asked);
    add_surroundings(asked);
    Survey survey;
    add_default_camera(told, survey);
    EXPECT_TRUE(survey.judged);
    ASSERT_TRUE(survey.clip);
    add_surroundings(told, {}, survey);
    EXPECT_EQ(asked.warnings, told.warnings);
    ASSERT_EQ(asked.nodes.size(), told.nodes.size());
    ASSERT_GT(told.objects.size(), scene.objects.size());
    for (std::size_t n = 0; n < told.nodes.size(); ++n)
        EXPECT_TRUE(same_bits(asked.nodes[n].local, told.nodes[n].local)) << told.nodes[n].name;
    EXPECT_TRUE(same_bits(asked.bounds(0), told.bounds(0)));
    const std::size_t ground = told.objects.back().mesh;
    EXPECT_TRUE(same_bits(asked.meshes[ground].positions, told.meshes[ground].positions));
    // It is what was handed over that counts.
    Scene other = scene;
    add_default_camera(other, survey);
    survey.clip->box.low.y -= 1;
    add_surroundings(other, {}, survey);
    EXPECT_NEAR(other.nodes.back().local[3].y, told.nodes.back().local[3].y - 1, 1e-5);
}

// The nearest surface is drawn first, and of equally near ones the first object counts all the same.
TEST(TestImage, ShowsTheNearestSurfaceInWhateverOrderObjectsCome)
{
    for (const bool from_front : {true, false}) {
        Scene scene;
        scene.materials.emplace_back();
        // Objects 0 and 1 have the same large triangle; of 1, a small one far in front is the first. The others lie
        // behind, one behind the other.
        for (int n = 0; n < 6; ++n) {
            Mesh mesh;
            if (n == 1) {
                mesh.positions = {{-9, -9, 3}, {-8.9f, -9, 3}, {-9, -8.9f, 3}};
                mesh.triangles.emplace_back(0, 1, 2);
            }
            const auto first = static_cast<std::uint32_t>(mesh.positions.size());
            const float z = n < 2 ? 0.0f : -0.1f * static_cast<float>(from_front ? n : 7 - n);
            for (const glm::vec2& p : {glm::vec2(-1, -1), glm::vec2(1, -1), glm::vec2(0, 1)})
                mesh.positions.emplace_back(p, z);
            mesh.triangles.emplace_back(first, first + 1, first + 2);
            mesh.parts = {{0, 0, static_cast<std::uint32_t>(mesh.triangles.size())}};
            scene.meshes.push_back(std::move(mesh));
            scene.nodes.emplace_back().mesh = static_cast<MeshId>(n);
        }
        scene.finish();
        const SceneState state({std::shared_ptr<const Scene>(), &scene}, 0);
        const TestImage image = draw_test_image(state, {0, 0, 5}, glm::dmat3(1), {.near = 0.1});
        int shown = 0;
        for (const TestPixel& pixel : image.pixels) {
            if (pixel.object == none) continue;
            if (pixel.depth < 4) continue;   // the small triangle
            ++shown;
            EXPECT_EQ(pixel.object, 0u);
            EXPECT_NEAR(pixel.depth, 5, 1e-5);
            EXPECT_EQ(pixel.first, pixel.depth);
        }
        EXPECT_GT(shown, 200);
    }
}

// What is hidden for certain is left out without being looked at pixel by pixel, and no pixel depends on that.
TEST(TestImage, IsMadeOfTheImagesOfSingleObjects)
{
    RandomScene random(11);
    Scene scene;
    scene.materials.emplace_back();
    scene.materials.emplace_back().double_sided = true;
    constexpr MeshId k_objects = 80;
    for (MeshId n = 0; n < k_objects; ++n) {
        Mesh mesh;
        const float size = n % 3 == 0 ? 3.0f : 0.8f;
        const glm::vec3 middle = random.point(1.5f);
        for (int i = 0; i < 3; ++i) mesh.positions.push_back(middle + random.point(size) * glm::vec3(1, 1, 0.2f));
        mesh.triangles.emplace_back(0, 1, 2);
        mesh.parts = {{n % 2, 0, 1}};
        scene.meshes.push_back(std::move(mesh));
        scene.nodes.emplace_back().mesh = n;
    }
    scene.finish();
    const auto draw = [](const Scene& of) {
        const SceneState state({std::shared_ptr<const Scene>(), &of}, 0);
        return draw_test_image(state, {0.3, 0.2, 6}, glm::dmat3(1), {.near = 0.1, .side = 61});
    };
    TestImage expected;
    for (MeshId n = 0; n < k_objects; ++n) {
        Scene one = scene;
        for (MeshId other = 0; other < k_objects; ++other)
            if (other != n) one.nodes[other].mesh = none;
        one.finish();
        const TestImage image = draw(one);
        if (expected.pixels.empty()) expected = image, expected.pixels.assign(image.pixels.size(), {});
        for (std::size_t i = 0; i < image.pixels.size(); ++i) {
            TestPixel& pixel = expected.pixels[i];
            const float first = std::min(pixel.first, image.pixels[i].first);
            const ObjectId id = n;
            if (image.pixels[i].depth < pixel.depth) pixel = image.pixels[i], pixel.object = id;
            pixel.first = first;
        }
    }
    const TestImage image = draw(scene);
    std::size_t shown = 0, behind = 0;
    for (std::size_t i = 0; i < image.pixels.size(); ++i) {
        const TestPixel &a = image.pixels[i], &b = expected.pixels[i];
        EXPECT_EQ(a.first, b.first) << i;
        EXPECT_EQ(a.depth, b.depth) << i;
        EXPECT_EQ(a.object, b.object) << i;
        EXPECT_EQ(a.normal, b.normal) << i;
        EXPECT_EQ(a.position, b.position) << i;
        shown += a.object != none, behind += a.first < a.depth;
    }
    EXPECT_GT(shown, 1500u);
    EXPECT_GT(behind, 100u);
}

}   // namespace
}   // namespace gnomon::scene
