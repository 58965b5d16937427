// SPDX-License-Identifier: Apache-2.0
// The parts that a host hands to SceneBuilder, against closed forms: cameras, textures, environments, hierarchies,
// skins, clips, and what Scene tells about them.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "api/scene_access.h"
#include "gnomon/renderer.h"
#include "gnomon/scene_builder.h"
#include "host_scene.h"
#include "image_bytes.h"

namespace gnomon {
namespace {

using test::camera_along_z;
using test::plain;
using test::square;

constexpr Size k_size{80, 60};
constexpr double k_depth = 5;

// A wall at the depth of 5 m.
Scene wall()
{
    SceneBuilder b;
    b.instance(b.mesh(square(100).mesh()), {}, Transform::translation(0, 0, -k_depth));
    return b.finish();
}

struct Place {
    double x, y;
};

// Checks the point of the wall that each of some pixels shows.
void expect_places(const Camera& camera, const std::function<Place(double, double)>& expected)
{
    Renderer renderer(plain(k_size));
    const Frame frame = renderer.render(wall(), {.camera = camera});
    for (const int x : {0, 17, 40, 79})
        for (const int y : {0, 30, 44, 59}) {
            const Pick pick = renderer.pick(x, y);
            ASSERT_TRUE(pick.hit) << x << " " << y;
            const Place place = expected(x + 0.5, y + 0.5);
            EXPECT_NEAR(pick.position.x, place.x, 1e-4) << x << " " << y;
            EXPECT_NEAR(pick.position.y, place.y, 1e-4) << x << " " << y;
            EXPECT_NEAR(pick.depth, k_depth, 1e-5);
            EXPECT_NEAR(frame.layer("depth")->value(x, y), k_depth, 1e-5);
        }
}

TEST(HostCamera, HasAFieldOfView)
{
    Camera camera;
    camera.vertical_fov = 0.9;
    const double focal = 30 / std::tan(0.45);
    expect_places(camera, [&](double x, double y) {
        return Place{(x - 40) * k_depth / focal, (30 - y) * k_depth / focal};
    });
}

TEST(HostCamera, ShiftsItsImagePlaneByFractionsOfTheHeight)
{
    Camera camera;
    camera.vertical_fov = 0.9;
    camera.shift_x = 0.25, camera.shift_y = -0.1;
    const double focal = 30 / std::tan(0.45);
    expect_places(camera, [&](double x, double y) {
        return Place{(x - 40 + 15) * k_depth / focal, (30 - y - 6) * k_depth / focal};
    });
    camera.orthographic_height = 6;
    expect_places(camera, [&](double x, double y) { return Place{(x - 40 + 15) * 0.1, (30 - y - 6) * 0.1}; });
}

TEST(HostCamera, HasIntrinsicsWithAPrincipalPoint)
{
    Camera camera;
    camera.intrinsics = Intrinsics{50, 45, 37.5, 22};
    const auto expected = [](double x, double y) { return Place{(x - 37.5) * k_depth / 50, (22 - y) * k_depth / 45}; };
    expect_places(camera, expected);
    camera.intrinsics->size = k_size;
    expect_places(camera, expected);
    // Calibrated at half the resolution.
    camera.intrinsics = Intrinsics{25, 22.5, 18.75, 11, {40, 30}};
    expect_places(camera, expected);
}

TEST(HostCamera, IsOrthographic)
{
    Camera camera;
    camera.orthographic_height = 3;
    expect_places(camera, [](double x, double y) { return Place{(x - 40) * 0.05, (30 - y) * 0.05}; });
}

TEST(HostCamera, TakesOffCentreMatrices)
{
    // As glFrustum has it.
    const double l = -0.5, r = 0.8, b = -0.4, t = 0.3, n = 1, f = 50;
    Camera camera;
    camera.matrix.emplace();
    camera.matrix->m = {2 * n / (r - l),
                        0,
                        0,
                        0,
                        0,
                        2 * n / (t - b),
                        0,
                        0,
                        (r + l) / (r - l),
                        (t + b) / (t - b),
                        -(f + n) / (f - n),
                        -1,
                        0,
                        0,
                        -2 * f * n / (f - n),
                        0};
    expect_places(camera, [&](double x, double y) {
        return Place{(l + (r - l) * x / 80) * k_depth / n, (t - (t - b) * y / 60) * k_depth / n};
    });
    // As glOrtho has it.
    camera.matrix->m = {2 / (r - l),
                        0,
                        0,
                        0,
                        0,
                        2 / (t - b),
                        0,
                        0,
                        0,
                        0,
                        -2 / (f - n),
                        0,
                        -(r + l) / (r - l),
                        -(t + b) / (t - b),
                        -(f + n) / (f - n),
                        1};
    expect_places(camera, [&](double x, double y) { return Place{l + (r - l) * x / 80, t - (t - b) * y / 60}; });
}

TEST(HostCamera, SeesBetweenNearAndFar)
{
    Renderer renderer(plain(k_size));
    const Scene scene = wall();
    const struct {
        double near, far;
        bool visible;
    } cases[] = {{4.9, 5.1, true}, {0, 0, true}, {5.1, 0, false}, {0.01, 4.9, false}};
    for (const bool orthographic : {false, true})
        for (const auto& [near, far, visible] : cases) {
            Camera camera = camera_along_z();
            camera.near = near, camera.far = far;
            if (orthographic) camera.orthographic_height = 2;
            renderer.render(scene, {.camera = camera});
            // Both are planes: corners of the image are as deep as its middle.
            for (const int x : {0, 40}) EXPECT_EQ(renderer.pick(x, 0).hit, visible) << near << " " << far << " " << x;
        }
}

TEST(HostCamera, MovesWithItsNodeAndIgnoresScale)
{
    SceneBuilder b;
    b.instance(b.mesh(square(1).mesh()), {}, Transform::translation(7, 0, -3));
    const NodeId arm = b.node(Transform::translation(7, 0, 0) * Transform::scaling(3, 3, 3));
    Camera camera = camera_along_z();
    camera.transform = Transform::translation(0, 0, 1);
    camera.name = "eye";
    const CameraId id = b.camera(camera, {.parent = arm});
    const Scene scene = b.finish();
    EXPECT_EQ(scene.camera(id), camera);
    EXPECT_EQ(scene.parent(scene.node(id)), arm);
    Renderer renderer(plain({9, 9}));
    const Frame frame = renderer.render(scene, FrameInput{});
    EXPECT_NEAR(frame.layer("depth")->value(4, 4), 6, 1e-5);
    EXPECT_EQ(renderer.camera().transform.m[12], 7);
    EXPECT_EQ(renderer.camera().transform.m[14], 3);
}

TEST(HostScene, PartsComeBackAsTheyWere)
{
    SceneBuilder b;
    const std::vector<std::uint8_t> pixel(4, 9);
    const TextureId texture = b.texture({.width = 1, .height = 1, .pixels = pixel});
    Material material;
    material.name = "m";
    material.model = ShadingModel::whitted;
    material.base_color = {0.1f, 0.2f, 0.3f};
    material.base_color_texture = {texture, 1, {0.5f, 1}, {2, 3}, 0.25f};
    material.normal_texture = {texture, 0, {}, {1, 1}, 0};
    material.double_sided = true;
    material.alpha = 0.5f, material.alpha_mode = AlphaMode::blend, material.alpha_cutoff = 0.25f;
    material.metallic = 1, material.roughness = 0.125f, material.normal_scale = -2, material.occlusion_strength = 0.5f;
    material.emissive = {3, 2, 1}, material.transmission = 0.75f, material.ior = 1.25f;
    material.ambient = {1, 1, 0}, material.specular = {0, 1, 1}, material.shine = 20, material.transmittance = 0.5f;
    const MaterialId m = b.material(material);
    const Light light{"l", LightType::spot, {3, 2, 1}, Falloff::constant, SpotProfile::cosine, 0.25f, 0.5f, 8};
    const LightId l = b.light(light, Transform::translation(1, 2, 3), {.name = "at"});
    Camera camera;
    camera.name = "c";
    camera.transform = Transform::translation(3, 2, 1);
    camera.vertical_fov = 0.5, camera.orthographic_height = 4, camera.intrinsics = Intrinsics{1, 2, 3, 4, {5, 6}};
    camera.shift_x = 0.1, camera.shift_y = 0.2, camera.near = 0.3, camera.far = 40, camera.resolution = {70, 50};
    const CameraId c = b.camera(camera);
    const Scene scene = b.finish();
    EXPECT_EQ(scene.material(m), material);
    EXPECT_EQ(scene.light(l), light);
    EXPECT_EQ(scene.camera(c), camera);
    EXPECT_EQ(scene.name(scene.node(l)), "at");
    EXPECT_EQ(scene.transform(scene.node(l)), Transform::translation(1, 2, 3));
    EXPECT_EQ(default_size(scene), (Size{70, 50}));
    EXPECT_EQ(scene.lights(), std::vector<LightId>{l});
    EXPECT_EQ(scene.cameras(), std::vector<CameraId>{c});
    EXPECT_EQ(scene.materials(), std::vector<MaterialId>{m});
    EXPECT_EQ(scene.find_material("nothing"), MaterialId());
    EXPECT_EQ(scene.info().lights, std::vector<std::string>{"l"});

    // Set, they are other ones.
    b.set_light(l, {.color = {9, 9, 9}});
    b.set_camera(c, camera_along_z());
    b.set_material(m, {});
    const Scene changed = b.finish();
    EXPECT_EQ(changed.light(l), (Light{.color = {9, 9, 9}}));
    EXPECT_EQ(changed.camera(c), camera_along_z());
    EXPECT_EQ(changed.material(m), Material());
    EXPECT_EQ(changed.transform(changed.node(l)), Transform::translation(1, 2, 3));
    EXPECT_EQ(scene.light(l), light);
    b.remove(texture);   // no material uses it now
}

TEST(HostScene, LaterLightsKeepTheirIdsWhenOneIsRemoved)
{
    SceneBuilder b;
    const LightId first = b.light({.name = "a"}), second = b.light({.name = "b"}), third = b.light({.name = "c"});
    const CameraId eye = b.camera({}), other = b.camera({.name = "other"});
    const NodeId node = b.finish().node(first);
    b.remove(first);
    b.remove(eye);
    const Scene scene = b.finish();
    EXPECT_EQ(scene.light(third).name, "c");
    EXPECT_EQ(scene.light(second).name, "b");
    EXPECT_EQ(scene.camera(other).name, "other");
    EXPECT_NO_THROW(scene.name(node));
    EXPECT_THROW(scene.light(first), UsageError);
    EXPECT_THROW(scene.camera(eye), UsageError);
    b.set_light(third, {.name = "d"});
    EXPECT_EQ(b.finish().light(third).name, "d");
}

TEST(HostScene, MobilityIsThatOfTheNearestDeclaredAncestor)
{
    SceneBuilder b;
    const MeshId mesh = b.mesh(square(1).mesh());
    const NodeId root = b.node(), moving = b.node({}, {.mobility = Mobility::may_move, .parent = root});
    const InstanceId fixed = b.instance(mesh, {}, {}, {.parent = root});
    const InstanceId carried = b.instance(mesh, {}, {}, {.parent = moving});
    const InstanceId deforming = b.instance(mesh, {}, {}, {.mobility = Mobility::may_deform, .parent = root});
    const Scene scene = b.finish();
    EXPECT_EQ(scene.mobility(root), Mobility::fixed);
    EXPECT_EQ(scene.mobility(fixed), Mobility::fixed);
    EXPECT_EQ(scene.mobility(moving), Mobility::may_move);
    EXPECT_EQ(scene.mobility(carried), Mobility::may_move);
    EXPECT_EQ(scene.mobility(deforming), Mobility::may_deform);
    EXPECT_EQ(scene.moving_node(carried), moving);
    EXPECT_EQ(scene.moving_node(fixed), fixed);
    EXPECT_EQ(scene.info().objects_dynamic, 2u);
    b.set_mobility(moving, Mobility::fixed);
    b.set_mobility(root, Mobility::may_move);
    EXPECT_EQ(b.finish().moving_node(carried), root);
    EXPECT_EQ(b.finish().info().objects_dynamic, 3u);
}

TEST(HostScene, NothingIsAddedUnlessAskedFor)
{
    SceneBuilder b;
    b.instance(b.mesh(test::cube(1).mesh()));
    const Scene bare = b.finish();
    EXPECT_TRUE(bare.lights().empty());
    EXPECT_TRUE(bare.cameras().empty());
    EXPECT_TRUE(bare.info().warnings.empty());
    const Scene lit = b.finish({.default_light = true});
    EXPECT_FALSE(lit.lights().empty());
    EXPECT_TRUE(lit.cameras().empty());
    EXPECT_FALSE(lit.info().warnings.empty());
    const Scene seen = b.finish({.default_camera = true});
    EXPECT_TRUE(seen.lights().empty());
    ASSERT_EQ(seen.cameras().size(), 1u);
    EXPECT_TRUE(b.finish().lights().empty());   // the builder is as before
    EXPECT_TRUE(b.finish().cameras().empty());
    Renderer renderer(plain({16, 16}));
    EXPECT_THROW(renderer.render(bare, FrameInput{}), UsageError);
    renderer.render(seen, FrameInput{});
    EXPECT_TRUE(renderer.pick(8, 8).hit);
    // Without light, the image is black.
    for (const float value : renderer.render(bare, {.camera = renderer.camera()}).layers.front().values())
        ASSERT_EQ(value, 0);
}

// The colour that an unlit wall with a texture has at the middle of its left upper quarter.
Vec3 shown(SceneBuilder& b, const TextureId& texture)
{
    Material material;
    material.model = ShadingModel::unlit;
    material.base_color = {1, 1, 1};
    material.base_color_texture.texture = texture;
    const test::Shape shape = square(5);
    const std::vector<Vec2> texcoords{{0, 1}, {1, 1}, {1, 0}, {0, 0}};
    Mesh mesh = shape.mesh();
    mesh.texcoords[0] = texcoords;
    const InstanceId wall = b.instance(b.mesh(mesh), b.material(material), Transform::translation(0, 0, -5));
    const Frame frame = Renderer(plain({40, 40})).render(b.finish(), {.camera = camera_along_z()});
    b.remove(wall);
    const Layer& image = frame.layers.front();
    return {image.value(9, 9, 0), image.value(9, 9, 1), image.value(9, 9, 2)};
}

TEST(HostTexture, HasOneToFourChannelsAndPaddedRows)
{
    SceneBuilder b;
    const Vec3 expected[] = {{1, 1, 1}, {1, 1, 1}, {1, 0.2f, 0.4f}, {1, 0.2f, 0.4f}};
    for (int channels = 1; channels <= 4; ++channels)
        for (const std::ptrdiff_t padding : {0, 5}) {
            const std::ptrdiff_t row = 2 * channels + padding;
            std::vector<std::uint8_t> pixels(static_cast<std::size_t>(row + 2 * channels));
            const std::uint8_t color[] = {255, channels == 2 ? std::uint8_t{255} : std::uint8_t{51}, 102, 255};
            std::copy(color, color + channels, pixels.begin());   // the left upper pixel alone
            const TextureId texture = b.texture({.width = 2,
                                                 .height = 2,
                                                 .channels = channels,
                                                 .pixels = pixels,
                                                 .row_bytes = padding ? row : 0,
                                                 .srgb = false,
                                                 .magnify = Filter::nearest,
                                                 .minify = Filter::nearest,
                                                 .mipmaps = false});
            const Vec3 color_is = shown(b, texture), should = expected[channels - 1];
            EXPECT_NEAR(color_is.x, should.x, 1e-5) << channels << " " << padding;
            EXPECT_NEAR(color_is.y, should.y, 1e-5) << channels << " " << padding;
            EXPECT_NEAR(color_is.z, should.z, 1e-5) << channels << " " << padding;
        }
}

TEST(HostTexture, IsDecodedFromFilesInMemory)
{
    SceneBuilder b;
    const std::vector<std::uint8_t> png =
        test::png_bytes({2, 2, 8, PNG_COLOR_TYPE_RGB}, {{255, 0, 255, 0, 0, 0}, {0, 0, 0, 0, 0, 0}});
    const Texture as{.srgb = false, .magnify = Filter::nearest, .mipmaps = false, .name = "a.png"};
    EXPECT_EQ(shown(b, b.texture(std::as_bytes(std::span(png)), as)), (Vec3{1, 0, 1}));
    const std::size_t textures = api::scene_of(b.finish())->textures.size();
    EXPECT_THROW(b.texture(std::as_bytes(std::span(png)).first(40), as), InputError);
    EXPECT_THROW(b.texture(std::span<const std::byte>(), as), InputError);
    EXPECT_EQ(api::scene_of(b.finish())->textures.size(), textures);
}

TEST(HostScene, EnvironmentsReplaceEachOtherAndTheBackground)
{
    SceneBuilder b;
    b.instance(b.mesh(square(1).mesh()), {}, Transform::translation(0, 0, -5));
    const LightId own = b.light({});
    b.background({0, 0.5f, 0});
    Renderer renderer(plain({9, 9}));
    const auto corner = [&](const Scene& scene) {
        const Frame frame = renderer.render(scene, {.camera = camera_along_z()});
        const Layer& image = frame.layers.front();
        return Vec3{image.value(0, 0, 0), image.value(0, 0, 1), image.value(0, 0, 2)};
    };
    EXPECT_EQ(corner(b.finish()), (Vec3{0, 0.5f, 0}));
    const std::vector<float> sky(3 * 16 * 8, 0.25f);
    b.environment({16, 8, sky}, 8);
    EXPECT_EQ(b.finish().lights().size(), 9u);
    EXPECT_EQ(corner(b.finish()), (Vec3{0.25f, 0.25f, 0.25f}));
    const std::size_t nodes = b.finish().nodes().size();
    b.environment({16, 8, sky}, 8);
    EXPECT_EQ(b.finish().nodes().size(), nodes);
    // A node of an environment's light to which the host has given something stays.
    const Scene scene = b.finish();
    const NodeId sun = scene.node(scene.lights().back());
    const NodeId kept = b.node({}, {.parent = sun});
    b.background({0, 0, 1});
    EXPECT_EQ(b.finish().lights(), std::vector<LightId>{own});
    EXPECT_EQ(b.finish().nodes().size(), 4u);
    EXPECT_EQ(b.finish().parent(kept), sun);
    EXPECT_EQ(corner(b.finish()), (Vec3{0, 0, 1}));
}

TEST(HostScene, ClipsHaveFramesAtARate)
{
    SceneBuilder b;
    EXPECT_EQ(b.finish().frame_count(), 1);
    EXPECT_EQ(b.finish().time_of(1), 0);
    b.clip(2, 4, 10);
    const Scene scene = b.finish();
    EXPECT_EQ(scene.frame_count(), 21);
    EXPECT_EQ(scene.fps(), 10);
    EXPECT_DOUBLE_EQ(scene.time_of(1), 2);
    EXPECT_DOUBLE_EQ(scene.time_of(21), 4);
    b.clip(1, 1, 24);
    EXPECT_EQ(b.finish().frame_count(), 1);
    EXPECT_EQ(b.finish().time_of(1), 1);
}

TEST(HostScene, JointsCarrySkinnedMeshes)
{
    SceneBuilder b;
    const NodeId joint = b.node(Transform::translation(0, 0, -5), {.mobility = Mobility::may_move});
    const SkinId skin = b.skin({{joint}, {Transform::translation(1, 0, 0)}});
    const test::Shape shape = square(1);
    const std::vector<Joints> joints(4);
    const std::vector<Vec4> weights(4, Vec4{1, 0, 0, 0});
    Mesh mesh = shape.mesh();
    const MeshId rigid = b.mesh(mesh);
    mesh.joints[0] = joints, mesh.weights[0] = weights;
    const MeshId skinned = b.mesh(mesh);
    EXPECT_THROW(b.instance(rigid, {}, {}, {.skin = skin}), UsageError);
    const InstanceId instance = b.instance(skinned, {}, Transform::translation(100, 0, 0), {.skin = skin});
    EXPECT_THROW(b.remove(joint), UsageError);
    EXPECT_THROW(b.remove(skin), UsageError);
    EXPECT_THROW(b.set_mesh(skinned, square(1).mesh()), UsageError);

    // The instance's own transform does not count; the square is 1 m to the right of the joint.
    Renderer renderer(plain({50, 50}));
    const Scene scene = b.finish();
    const Frame frame = renderer.render(scene, {.camera = camera_along_z()});
    EXPECT_EQ(renderer.pick(30, 25).instance, instance);
    EXPECT_NEAR(frame.layer("depth")->value(30, 25), 5, 1e-5);
    EXPECT_FALSE(renderer.pick(23, 25).hit);
    renderer.render(scene, {.camera = camera_along_z(), .transforms = {{joint, Transform::translation(-2, 0, -5)}}});
    EXPECT_FALSE(renderer.pick(32, 25).hit);
    EXPECT_EQ(renderer.pick(20, 25).instance, instance);

    b.remove(instance);
    b.remove(skin);
    b.remove(joint);
    EXPECT_EQ(b.finish().nodes().size(), 0u);
}

}   // namespace
}   // namespace gnomon
