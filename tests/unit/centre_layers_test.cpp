// SPDX-License-Identifier: Apache-2.0
// Depth, ids and motion at the pixels' centres against closed forms.
#include "trace/centre_layers.h"
#include "api/scene_access.h"

#include <gtest/gtest.h>

#include <functional>

#include "gnomon/gnomon.h"
#include "scene_helpers.h"

namespace gnomon {
namespace {

using glm::dmat4;
using glm::dvec2;
using glm::dvec3;

// An odd number of rows, so that one goes through the image's centre. With a vertical field of view of 90 degrees, the
// focal length is half the height.
constexpr Size k_size{65, 49};
constexpr double k_focal = 24.5;
constexpr double k_fps = 10;

class FunctionTrack final : public scene::TransformTrack {
 public:
    explicit FunctionTrack(std::function<dmat4(double)> f) : f_(std::move(f)) {}
    dmat4 evaluate(double time) const override { return f_(time); }
    std::vector<scene::Interval> changing() const override { return {{-1e9, 1e9}}; }

 private:
    std::function<dmat4(double)> f_;
};

std::shared_ptr<scene::TransformTrack> moving(const dvec3& at, const dvec3& a_frame)
{
    return std::make_shared<FunctionTrack>(
        [=](double t) { return glm::translate(dmat4(1), at + k_fps * t * a_frame); });
}

std::shared_ptr<scene::TransformTrack> turning(const dvec3& at, double angle_a_frame, const dvec3& axis)
{
    return std::make_shared<FunctionTrack>(
        [=](double t) { return glm::rotate(glm::translate(dmat4(1), at), k_fps * t * angle_a_frame, axis); });
}

// A square in the plane z = 0 that faces +Z, of which the left half has the first material.
scene::Mesh square(float half)
{
    scene::Mesh mesh;
    mesh.positions = {{-half, -half, 0}, {0, -half, 0}, {half, -half, 0},
                      {-half, half, 0},  {0, half, 0},  {half, half, 0}};
    mesh.triangles = {{0, 1, 4}, {0, 4, 3}, {1, 2, 5}, {1, 5, 4}};
    mesh.parts = {{0, 0, 2}, {1, 2, 2}};
    return mesh;
}

// A camera at the origin that looks along -Z, and a clip of ten frames.
scene::Scene empty_scene()
{
    scene::Scene scene;
    scene.materials.resize(2);
    scene::Camera camera;
    camera.vertical_fov = k_pi / 2;
    camera.node = scene.add_node("camera", scene::none);
    scene.cameras.push_back(camera);
    scene.timeline.frames = 10;
    scene.timeline.fps = k_fps;
    scene.timeline.end = 0.9;
    return scene;
}

scene::NodeId add_square(scene::Scene& scene, float half, const dvec3& at)
{
    scene.meshes.push_back(square(half));
    return test::add_object(scene, static_cast<scene::MeshId>(scene.meshes.size() - 1), scene::none,
                            glm::translate(dmat4(1), at));
}

RenderOptions centre_options()
{
    RenderOptions options;
    options.size = k_size;
    options.indirect = Indirect::off;
    options.layers = options.ids = options.motion = true;
    return options;
}

Frame rendered(scene::Scene scene, int frame, const RenderOptions& options = centre_options())
{
    return Renderer(options).render(api::public_scene(test::finished(scene)), frame);
}

dvec2 motion_at(const Frame& frame, int x, int y)
{
    const Layer& motion = *frame.layer("motion");
    return {static_cast<double>(motion.value(x, y, 0)), static_cast<double>(motion.value(x, y, 1))};
}

// A pixel's centre from the image's centre, in units of the focal length: right and up.
dvec2 slope(int x, int y)
{
    return {(x + 0.5 - 32.5) / k_focal, (24.5 - (y + 0.5)) / k_focal};
}

// Checks the motion of all pixels with an object, or of all without.
void expect_motion(const Frame& frame, bool of_objects, const std::function<dvec2(int, int)>& expected,
                   double tolerance = 2e-4)
{
    int count = 0;
    for (int y = 0; y < k_size.height; ++y)
        for (int x = 0; x < k_size.width; ++x) {
            if ((frame.layer("id")->id(x, y) != 0) != of_objects) continue;
            const dvec2 is = motion_at(frame, x, y), should = expected(x, y);
            ASSERT_NEAR(is.x, should.x, tolerance) << x << " " << y;
            ASSERT_NEAR(is.y, should.y, tolerance) << x << " " << y;
            ++count;
        }
    EXPECT_GT(count, 100);
}

dvec2 nothing(int, int)
{
    return {0, 0};
}

TEST(CentreLayers, DepthIsAlongTheAxisAndIdsAreThoseOfNodesFromOne)
{
    for (const bool orthographic : {false, true}) {
        scene::Scene scene = empty_scene();
        if (orthographic) scene.cameras[0].orthographic_height = 12;
        const scene::NodeId near = add_square(scene, 2.1f, {0, 0, -5}), far = add_square(scene, 5.8f, {0, 0, -7});
        RenderOptions options = centre_options();
        const Frame one = rendered(scene, 1, options);
        options.samples = 5;
        const Frame five = rendered(scene, 1, options);
        const double scale = orthographic ? 49.0 / 12 : k_focal;
        std::size_t seen[3] = {};
        for (int y = 0; y < k_size.height; ++y)
            for (int x = 0; x < k_size.width; ++x) {
                const dvec2 place = slope(x, y) * k_focal / scale;   // at depth 1, or of the orthographic view
                const auto inside = [&](double half, double depth) {
                    const dvec2 at = orthographic ? place : depth * place;
                    return std::abs(at.x) < half && std::abs(at.y) < half;
                };
                const std::uint32_t object = inside(2.1, 5) ? 1 : inside(5.8, 7) ? 2 : 0;
                ++seen[object];
                const std::uint32_t material = object == 0 ? 0 : place.x < 0 ? 1 : 2;
                for (const Frame* frame : {&one, &five}) {
                    const std::uint32_t id = object == 0 ? 0 : (object == 1 ? near : far) + 1;
                    EXPECT_EQ(frame->layer("id")->id(x, y, 0), id) << x << " " << y;
                    if (place.x != 0) {
                        EXPECT_EQ(frame->layer("id")->id(x, y, 1), material) << x << " " << y;
                    }
                    EXPECT_NEAR(frame->layer("depth")->value(x, y), object == 1 ? 5 : object == 2 ? 7 : 0, 1e-5);
                }
            }
        for (const std::size_t count : seen) EXPECT_GT(count, 100u);
    }
}

TEST(CentreLayers, ObjectsMoveAcrossPerspectiveAndOrthographicViews)
{
    for (const bool orthographic : {false, true}) {
        scene::Scene scene = empty_scene();
        if (orthographic) scene.cameras[0].orthographic_height = 7;
        const scene::NodeId node = add_square(scene, 3, {0, 0, -5});
        scene.nodes[node].transform = moving({0, 0, -5}, {0.5, 0.25, 0});
        const double scale = orthographic ? 7 : k_focal / 5;
        EXPECT_EQ(rendered(scene, 1).layer("motion")->copy(), std::vector<float>(std::size_t{65} * 49 * 2, 0.0f));
        const Frame frame = rendered(scene, 3);
        expect_motion(frame, true, [&](int, int) { return dvec2(0.5, -0.25) * scale; });
        expect_motion(frame, false, nothing, 0);
    }
}

TEST(CentreLayers, ApproachingObjectsGrow)
{
    scene::Scene scene = empty_scene();
    const scene::NodeId node = add_square(scene, 2, {0, 0, -5});
    scene.nodes[node].transform = moving({0, 0, -5}, {0, 0, 0.25});
    // At depth 4.5; it was at 4.75.
    expect_motion(rendered(scene, 3), true, [](int x, int y) {
        const dvec2 now = slope(x, y) * k_focal, before = now * 4.5 / 4.75;
        return dvec2(now.x - before.x, -(now.y - before.y));
    });
}

TEST(CentreLayers, ObjectsTurn)
{
    scene::Scene scene = empty_scene();
    const scene::NodeId node = add_square(scene, 3, {0, 0, -5});
    constexpr double angle = 0.1;
    scene.nodes[node].transform = turning({0, 0, -5}, angle, {0, 0, 1});
    expect_motion(rendered(scene, 4), true, [](int x, int y) {
        const dvec2 now = slope(x, y) * k_focal;
        const dvec2 before(std::cos(angle) * now.x + std::sin(angle) * now.y,
                           -std::sin(angle) * now.x + std::cos(angle) * now.y);
        return dvec2(now.x - before.x, -(now.y - before.y));
    });
}

TEST(CentreLayers, MovedCamerasMoveWhatIsNearAndNotTheBackground)
{
    scene::Scene scene = empty_scene();
    add_square(scene, 3, {1, 0, -5});
    scene.nodes[scene.cameras[0].node].transform = moving({0, 0, 0}, {0.5, 0.25, 0});
    const Frame frame = rendered(scene, 2);
    expect_motion(frame, true, [](int, int) { return dvec2(-0.5, 0.25) * k_focal / 5.0; });
    expect_motion(frame, false, nothing, 1e-6);
}

TEST(CentreLayers, TurnedCamerasMoveEverything)
{
    scene::Scene scene = empty_scene();
    constexpr double angle = 0.05;   // to the left
    scene.nodes[scene.cameras[0].node].transform = turning({0, 0, 0}, angle, {0, 1, 0});
    add_square(scene, 2, {0, 0, -5});
    const auto expected = [](int x, int y) {
        const dvec2 now = slope(x, y);
        // The direction (now.x, now.y, -1) by the camera before, which looked further to the right.
        const double right = std::cos(angle) * now.x - std::sin(angle),
                     ahead = std::cos(angle) + std::sin(angle) * now.x;
        const dvec2 before = dvec2(right, now.y) / ahead;
        return k_focal * dvec2(now.x - before.x, -(now.y - before.y));
    };
    const Frame frame = rendered(scene, 2);
    expect_motion(frame, false, expected);
    expect_motion(frame, true, expected);
}

TEST(CentreLayers, TurntablesTurnTheBackground)
{
    scene::Scene scene = empty_scene();
    add_square(scene, 2, {0, 0, -5});
    RenderOptions options = centre_options();
    options.turntable_seconds = 20;
    const Frame frame = rendered(scene, 3, options);
    // A clip of 20 seconds at 10 frames a second turns by 1.8 degrees a frame.
    EXPECT_NEAR(std::abs(motion_at(frame, 32, 0).x), k_focal * std::tan(2 * k_pi / 200), 0.05);
    // The square's centre is the turntable's.
    EXPECT_NEAR(motion_at(frame, 32, 24).x, 0, 1e-3);
}

TEST(CentreLayers, DeformingAndSkinnedVerticesMove)
{
    scene::Scene keyed = empty_scene();
    const scene::NodeId node = add_square(keyed, 3, {0, 0, -5});
    scene::VertexKeys keys;
    keys.times = {0, 1};
    keys.positions.assign(2, keyed.meshes[0].positions);
    for (glm::vec3& p : keys.positions[1]) p += glm::vec3(2, 1, 0);
    keyed.meshes.edit(0).vertex_keys = keys;
    keyed.nodes[node].transform = moving({0, 0, -5}, {0.1, 0, 0});
    expect_motion(rendered(keyed, 3), true, [](int, int) { return dvec2(0.3, -0.1) * k_focal / 5.0; });

    scene::Scene skinned = empty_scene();
    const scene::NodeId bound = add_square(skinned, 3, {9, 9, 9});   // a skin ignores its node's transform
    scene::Skin skin;
    skin.joints = {skinned.add_node("joint", scene::none)};
    skin.inverse_bind = {dmat4(1)};
    skinned.nodes[skin.joints[0]].transform = moving({0, 0, -5}, {0.2, 0, 0});
    skinned.skins.push_back(skin);
    skinned.nodes[bound].skin = 0;
    scene::SkinBinding& binding = skinned.meshes.edit(0).skin.emplace();
    binding.joints[0].assign(6, glm::u16vec4(0));
    binding.weights[0].assign(6, glm::vec4(1, 0, 0, 0));
    expect_motion(rendered(skinned, 3), true, [](int, int) { return dvec2(0.2, 0) * k_focal / 5.0; });
}

TEST(CentreLayers, ObjectsThatAppearCountAsResting)
{
    scene::Scene scene = empty_scene();
    const scene::NodeId node = add_square(scene, 3, {0, 0, -5});
    scene.nodes[node].transform = moving({0, 0, -5}, {0.5, 0, 0});
    scene.nodes[node].visibility = test::visibility({0, 0.15}, {false, true});
    scene.nodes[node].animated = true;
    const Scene whole = api::public_scene(test::finished(scene));
    Renderer renderer(centre_options());
    EXPECT_EQ(renderer.render(whole, 2).layer("id")->id(40, 24), 0u);
    expect_motion(renderer.render(whole, 3), true, nothing, 0);
    expect_motion(renderer.render(whole, 4), true, [](int, int) { return dvec2(0.5, 0) * k_focal / 5.0; });
}

// Whatever was rendered before, with any number of threads, by either method.
TEST(CentreLayers, SameBytesAfterAnyFrames)
{
    scene::Scene random = *test::make_random_scene(5);
    random.timeline.frames = 5;
    scene::add_default_camera(random);
    const Scene scene = api::public_scene(std::make_shared<const scene::Scene>(std::move(random)));
    RenderOptions options = centre_options();
    options.threads = 1;
    Renderer kept(options);
    options.threads = 3;
    for (const int frame : {1, 2, 5, 1, 4}) {
        const Frame a = kept.render(scene, frame), b = Renderer(options).render(scene, frame);
        EXPECT_EQ(a.layer("motion")->copy(), b.layer("motion")->copy());
        const auto ids = a.layer("id")->ids(), others = b.layer("id")->ids();
        EXPECT_TRUE(std::equal(ids.begin(), ids.end(), others.begin(), others.end()));
    }
    const Scene cornell = load("builtin:cornell");
    Renderer far(options);
    options.threads = 2;
    for (const int frame : {7, 2, 8, 3, 1}) {
        const Frame a = far.render(cornell, frame), b = Renderer(options).render(cornell, frame);
        EXPECT_EQ(a.layer("motion")->copy(), b.layer("motion")->copy()) << frame;
    }
}

TEST(CentreLayers, OneIsMadeWithoutTheOther)
{
    scene::Scene scene = empty_scene();
    add_square(scene, 3, {0, 0, -5});
    RenderOptions options = centre_options();
    options.layers = false;
    const Frame both = rendered(scene, 2, options);
    options.ids = false;
    const Frame motion = rendered(scene, 2, options);
    EXPECT_EQ(motion.layer("id"), nullptr);
    EXPECT_EQ(motion.layer("motion")->copy(), both.layer("motion")->copy());
    EXPECT_EQ(motion.layers[0].copy(), both.layers[0].copy());
    EXPECT_EQ(motion.layers.size(), 2u);
    options.motion = false;
    EXPECT_EQ(rendered(scene, 2, options).layers.size(), 1u);
}

#ifdef GNOMON_VULKAN
TEST(CentreLayers, OfRasterisedFramesAreThoseOfTracedOnes)
{
    const Scene scene = load("builtin:cornell");
    RenderOptions options = centre_options();
    const Frame traced = Renderer(options).render(scene, 4);
    options.renderer = RenderMethod::raster;
    const Frame drawn = Renderer(options).render(scene, 4);
    EXPECT_EQ(traced.layer("motion")->copy(), drawn.layer("motion")->copy());
    const auto ids = traced.layer("id")->ids(), others = drawn.layer("id")->ids();
    EXPECT_TRUE(std::equal(ids.begin(), ids.end(), others.begin(), others.end()));
}
#endif

// The ray through where a point is projected passes through the point.
TEST(View, ProjectIsTheInverseOfRay)
{
    Random random(3);
    for (int i = 0; i < 2000; ++i) {
        scene::View view;
        const auto coordinate = [&](float reach) { return random.uniform(-reach, reach); };
        view.eye = {coordinate(5), coordinate(5), coordinate(5)};
        view.forward = glm::normalize(glm::vec3(coordinate(1), coordinate(1), 1.1f));
        const glm::vec3 side = glm::normalize(glm::cross(view.forward, {0, 1, 0}));
        view.right = random.uniform(0.1f, 2.0f) * side;
        view.up = random.uniform(0.1f, 2.0f) * glm::cross(side, view.forward);
        view.size = {640, 360};
        view.orthographic = i % 2 == 0;
        if (i % 3 > 0) view.shift = {coordinate(2), coordinate(2)};
        const glm::vec2 pixel(random.uniform(0, 640), random.uniform(0, 360));
        glm::vec3 origin, direction;
        float tnear, tfar;
        view.ray(pixel.x, pixel.y, origin, direction, tnear, tfar);
        const auto place = view.project(dvec3(origin) + 7.0 * dvec3(direction));
        ASSERT_TRUE(place);
        EXPECT_NEAR(place->x, pixel.x, 2e-3);
        EXPECT_NEAR(place->y, pixel.y, 2e-3);
        EXPECT_EQ(view.project_direction(direction).has_value(), !view.orthographic);
        if (!view.orthographic) {
            EXPECT_NEAR(view.project_direction(dvec3(direction))->x, pixel.x, 2e-3);
            EXPECT_FALSE(view.project(dvec3(view.eye) - dvec3(direction)));
        }
    }
}

// A view shifted by a pixel shows what the unshifted one shows a pixel further.
TEST(View, ShiftMovesTheImage)
{
    scene::View view;
    view.size = {64, 32};
    view.right = {2, 0, 0};
    scene::View shifted = view;
    shifted.shift = {2.0f / 64, 2.0f / 32};   // a pixel to the right, and one up
    glm::vec3 origin, a, b;
    float tnear, tfar;
    view.ray(11.5f, 6.5f, origin, a, tnear, tfar);
    shifted.ray(10.5f, 7.5f, origin, b, tnear, tfar);
    EXPECT_LT(glm::length(a - b), 1e-6f);
}

}   // namespace
}   // namespace gnomon
