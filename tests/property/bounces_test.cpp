// SPDX-License-Identifier: Apache-2.0
// Bounced light that starts from lights with size and from the sky, and light of all diffuse bounces: closed forms, and
// frames that depend on the present state alone.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "base/bits.h"
#include "gnomon/gnomon.h"
#include "support.h"

namespace gnomon {
namespace {

constexpr double k_pi = std::numbers::pi;

const std::vector<Vec3> k_square{{-0.5f, 0, -0.5f}, {0.5f, 0, -0.5f}, {0.5f, 0, 0.5f}, {-0.5f, 0, 0.5f}};
const std::vector<std::uint32_t> k_up{0, 2, 1, 0, 3, 2};

// Without a specular reflection.
Material matte(float albedo)
{
    Material material{.base_color = {albedo, albedo, albedo}, .roughness = 1, .ior = 1};
    material.double_sided = true;
    return material;
}

void add_camera(SceneBuilder& builder, const Vec3& eye, const Vec3& target)
{
    Camera camera;
    camera.transform = Transform::look_at(eye, target);
    camera.vertical_fov = 1;
    builder.camera(camera);
}

// The inside of a cube of half-width 1.
void add_room(SceneBuilder& builder, MaterialId material)
{
    const MeshId mesh = builder.mesh({.positions = k_square, .indices = k_up});
    for (const Transform& turn : {Transform(), Transform::rotation({1, 0, 0}, k_pi),
                                  Transform::rotation({1, 0, 0}, k_pi / 2), Transform::rotation({1, 0, 0}, -k_pi / 2),
                                  Transform::rotation({0, 0, 1}, k_pi / 2), Transform::rotation({0, 0, 1}, -k_pi / 2)})
        builder.instance(mesh, material, turn * Transform::translation(0, -1, 0) * Transform::scaling(2, 1, 2));
}

struct Spread {
    double mean = 0, deviation = 0, least = 1e30, most = 0;
};
Spread spread_of(std::span<const float> values)
{
    Spread spread;
    double square = 0;
    for (const float value : values) {
        const auto v = static_cast<double>(value);
        spread.mean += v, square += v * v;
        spread.least = std::min(spread.least, v), spread.most = std::max(spread.most, v);
    }
    const auto count = static_cast<double>(values.size());
    spread.mean /= count;
    spread.deviation = std::sqrt(std::max(0.0, square / count - spread.mean * spread.mean));
    return spread;
}

RenderOptions with_bounces(int bounces, int size = 32)
{
    RenderOptions options;
    options.size = {size, size};
    options.bounces = bounces;
    options.keep_image = false;   // frames of one view are lit again and again
    return options;
}

// In a closed box of emissive walls every point shows its own radiance e, and e times the n-th power of the albedo from
// the n-th bounce.
TEST(Bounces, ClosedBoxOfEmissiveWalls)
{
    for (const float albedo : {0.5f, 0.8f}) {
        SceneBuilder builder;
        Material wall = matte(albedo);
        wall.emissive = {1, 1, 1};
        add_room(builder, builder.material(wall));
        add_camera(builder, {0.2f, 0.1f, 0.7f}, {-0.3f, -0.2f, -1});
        const Scene scene = builder.finish();
        const auto a = static_cast<double>(albedo);
        for (const auto& [bounces, truth] :
             {std::pair{1, 1 + a + a * a}, {2, 1 + a + a * a + a * a * a}, {k_all_bounces, 1 / (1 - a)}}) {
            const Frame frame = Renderer(with_bounces(bounces)).render(scene, 1);
            const Spread spread = spread_of(frame.layers.front().values());
            EXPECT_NEAR(spread.mean, truth, 0.01 * truth) << albedo << ' ' << bounces;
            EXPECT_LE(spread.deviation, 0.02 * truth) << albedo << ' ' << bounces;
        }
    }
}

// With nearly white walls, most of the light comes from bounces beyond those that are computed one by one.
TEST(Bounces, AWhiterBoxNeedsTheRestOfTheSeries)
{
    constexpr double k_albedo = 0.95, k_truth = 1 / (1 - k_albedo);
    SceneBuilder builder;
    Material wall = matte(static_cast<float>(k_albedo));
    wall.emissive = {1, 1, 1};
    add_room(builder, builder.material(wall));
    add_camera(builder, {0.2f, 0.1f, 0.7f}, {-0.3f, -0.2f, -1});
    const Frame frame = Renderer(with_bounces(k_all_bounces)).render(builder.finish(), 1);
    EXPECT_NEAR(spread_of(frame.layers.front().values()).mean, k_truth, 0.02 * k_truth);
}

// A lit sphere from inside: every point gets the same, one bounce of which is flux * albedo / area.
TEST(Bounces, LitSphereFromInside)
{
    constexpr int k_rings = 48, k_segments = 96;
    constexpr float k_albedo = 0.8f;
    std::vector<Vec3> positions, normals;
    std::vector<std::uint32_t> indices;
    for (int r = 0; r <= k_rings; ++r)
        for (int s = 0; s <= k_segments; ++s) {
            const double up = k_pi * r / k_rings, around = 2 * k_pi * (s % k_segments) / k_segments;
            const Vec3 p{static_cast<float>(std::sin(up) * std::cos(around)), static_cast<float>(std::cos(up)),
                         static_cast<float>(std::sin(up) * std::sin(around))};
            positions.push_back(p), normals.push_back({-p.x, -p.y, -p.z});
        }
    const auto at = [&](int r, int s) { return static_cast<std::uint32_t>(r * (k_segments + 1) + s); };
    for (int r = 0; r < k_rings; ++r)
        for (int s = 0; s < k_segments; ++s) {
            if (r > 0) indices.insert(indices.end(), {at(r, s), at(r + 1, s), at(r, s + 1)});
            if (r + 1 < k_rings) indices.insert(indices.end(), {at(r, s + 1), at(r + 1, s), at(r + 1, s + 1)});
        }
    SceneBuilder builder;
    builder.instance(builder.mesh({.positions = positions, .indices = indices, .normals = normals}),
                     builder.material(matte(k_albedo)));
    builder.light({.color = {1, 1, 1}});   // one candela in the middle: irradiance 1
    add_camera(builder, {0.1f, 0.2f, 0.6f}, {-0.2f, -0.1f, -1});
    const Scene scene = builder.finish();
    for (const auto& [bounces, truth] : {std::pair{1, 0.8}, {2, 0.8 + 0.64}, {k_all_bounces, 0.8 / (1 - 0.8)}}) {
        RenderOptions options = with_bounces(bounces, 128);
        options.layers = true;
        const Frame frame = Renderer(options).render(scene, 1);
        const Layer& indirect = *std::ranges::find(frame.layers, "indirect", &Layer::name);
        // The layer holds reflected radiance: irradiance * albedo / pi.
        const Spread spread = spread_of(indirect.values());
        const double expected = truth * 0.8 / k_pi;
        EXPECT_NEAR(spread.mean, expected, 0.015 * expected) << bounces;
        EXPECT_LE(spread.deviation, 0.03 * expected) << bounces;
    }
}

// Two closed rooms with a sheet between them, one of them lit; the camera is in the other.
TEST(Bounces, NoLightLeaksThroughASheet)
{
    double seen[2] = {};
    for (const bool lit : {false, true}) {
        SceneBuilder builder;
        const MaterialId material = builder.material(matte(0.8f));
        const MeshId mesh = builder.mesh({.positions = k_square, .indices = k_up});
        const auto wall = [&](const Transform& turn, double away, double x, double z) {
            builder.instance(mesh, material, turn * Transform::translation(0, -away, 0) * Transform::scaling(x, 1, z));
        };
        wall(Transform(), 1, 4, 2), wall(Transform::rotation({1, 0, 0}, k_pi), 1, 4, 2);
        wall(Transform::rotation({1, 0, 0}, k_pi / 2), 1, 4, 2),
            wall(Transform::rotation({1, 0, 0}, -k_pi / 2), 1, 4, 2);
        wall(Transform::rotation({0, 0, 1}, k_pi / 2), 2, 2, 2),
            wall(Transform::rotation({0, 0, 1}, -k_pi / 2), 2, 2, 2);
        builder.instance(mesh, material,
                         Transform::translation(0.017, 0, 0) * Transform::rotation({0, 0, 1}, k_pi / 2) *
                             Transform::scaling(2, 1, 2));
        builder.light({.color = {10, 10, 10}}, Transform::translation(-1, 0.3, 0.1));
        const double side = lit ? -1 : 1;
        Camera camera;
        camera.transform = Transform::look_at({static_cast<float>(1.5 * side), 0.2f, 0.8f},
                                              {static_cast<float>(0.7 * side), -0.3f, -1});
        camera.vertical_fov = 1.2f;
        builder.camera(camera);
        const Frame frame = Renderer(with_bounces(k_all_bounces, 256)).render(builder.finish(), 1);
        seen[lit] = spread_of(frame.layers.front().values()).mean;
    }
    EXPECT_GT(seen[1], 1);
    EXPECT_LE(seen[0], 1e-3 * seen[1]);
}

// A room lit by a light with size and by one without, with a board that moves.
struct Host {
    SceneBuilder builder;
    MaterialId panel;
    Material shining = matte(0);
    NodeId board;
    std::optional<Scene> scene;
    Host()
    {
        shining.emissive = {8, 6, 4};
        add_room(builder, builder.material(matte(0.6f)));
        panel = builder.material(shining);
        const MeshId mesh = builder.mesh({.positions = k_square, .indices = k_up});
        builder.instance(
            mesh, panel,
            Transform::translation(0, 0.9, 0) * Transform::rotation({1, 0, 0}, k_pi) * Transform::scaling(0.4, 1, 0.4));
        board = builder.node();
        builder.instance(mesh, builder.material(matte(0.7f)), Transform::scaling(0.5, 1, 0.5),
                         {.mobility = Mobility::may_move, .parent = board});
        builder.light({.color = {0.3f, 0.3f, 0.5f}}, Transform::translation(0.5, -0.2, 0.3));
        add_camera(builder, {0.2f, 0.1f, 0.7f}, {-0.3f, -0.2f, -1});
        scene = builder.finish();
    }
    FrameInput input(double height, float emission) const
    {
        Material other = shining;
        for (float* value : {&other.emissive.x, &other.emissive.y, &other.emissive.z}) *value *= emission;
        FrameInput input;
        input.transforms = {{board, Transform::translation(0.1, height, 0)}};
        input.materials = {{panel, other}};
        return input;
    }
};

std::vector<float> values_of(const Frame& frame)
{
    const auto values = frame.layers.front().values();
    return {values.begin(), values.end()};
}

// A frame has the bytes of one that is rendered by itself, whatever a host changed before, for any number of threads.
// Logs on a plain of snow, under a sun that shines on a kilometre of ground: a texel of its light map covers metres,
// and one that lies on a sliver of a log's end brought it two million times its light.
TEST(Bounces, SliversAreNotLitByWholeTexels)
{
    GNOMON_NEED_SCENE(file, "real/fireplace/fireplace.gltf");
    LoadOptions loading;
    loading.ground = true;
    const Scene scene = load(file.string(), loading);
    const auto mean_of = [&](int bounces) {
        RenderOptions options = with_bounces(bounces);
        options.layers = true;
        const Frame frame = Renderer(options).render(scene, 1);
        return spread_of(std::ranges::find(frame.layers, "indirect", &Layer::name)->values()).mean;
    };
    const double once = mean_of(1), twice = mean_of(2);
    EXPECT_GT(once, 0);
    RecordProperty("ratio", std::to_string(twice / once));
    EXPECT_NEAR(twice / once, 1.2, 0.25);
}

TEST(Bounces, FollowAHostAsIfNew)
{
    const Host host;
    for (const int bounces : {1, k_all_bounces}) {
        RenderOptions options = with_bounces(bounces, 48);
        options.threads = 2;
        Renderer warm(options);
        std::vector<float> last;
        for (const auto& [height, emission] :
             {std::pair{0.0, 1.0f}, {0.3, 1.0f}, {0.5, 1.0f}, {0.5, 0.2f}, {0.5, 0.0f}, {-0.4, 0.0f}, {-0.4, 2.0f}}) {
            const std::vector<float> now = values_of(warm.render(*host.scene, host.input(height, emission)));
            RenderOptions single = options;
            single.threads = 1;
            Renderer cold(single);
            EXPECT_TRUE(same_bits(now, values_of(cold.render(*host.scene, host.input(height, emission)))))
                << bounces << ' ' << height << ' ' << emission;
            EXPECT_FALSE(same_bits(now, last)) << bounces << ' ' << height << ' ' << emission;
            last = now;
        }
    }
}

// Twice the emission is twice the light, bounced light included.
TEST(Bounces, ChangedEmissionChangesBouncedLight)
{
    SceneBuilder builder;
    add_room(builder, builder.material(matte(0.6f)));
    Material shining = matte(0);
    shining.emissive = {1, 1, 1};
    const MaterialId panel = builder.material(shining);
    builder.instance(
        builder.mesh({.positions = k_square, .indices = k_up}), panel,
        Transform::translation(0, 0.9, 0) * Transform::rotation({1, 0, 0}, k_pi) * Transform::scaling(0.4, 1, 0.4));
    add_camera(builder, {0.2f, 0.1f, 0.7f}, {-0.3f, -0.2f, -1});
    const Scene scene = builder.finish();
    RenderOptions options = with_bounces(k_all_bounces);
    options.layers = true;
    Renderer renderer(options);
    const auto indirect = [&](float emission) {
        FrameInput input;
        shining.emissive = {emission, emission, emission};
        input.materials = {{panel, shining}};
        const Frame frame = renderer.render(scene, input);
        return spread_of(std::ranges::find(frame.layers, "indirect", &Layer::name)->values()).mean;
    };
    const double once = indirect(1);
    EXPECT_GT(once, 0.005);
    EXPECT_NEAR(indirect(2), 2 * once, 1e-3 * once);
    EXPECT_EQ(indirect(0), 0);
}

// Under an even environment, the light of an open floor reaches the lower side of a plate above it: by one bounce, as
// much as the floor's albedo times what arrives there.
TEST(Bounces, EnvironmentLightBounces)
{
    double light[2] = {};
    for (const bool plate_sees_floor : {false, true}) {
        SceneBuilder builder;
        const MeshId mesh = builder.mesh({.positions = k_square, .indices = k_up});
        builder.instance(mesh, builder.material(matte(plate_sees_floor ? 0.5f : 0.0f)), Transform::scaling(40, 1, 40));
        builder.instance(mesh, builder.material(matte(0.5f)), Transform::translation(0, 2, 0));
        const std::vector<float> white(16 * 8 * 3, 1.0f);
        builder.environment({.width = 16, .height = 8, .pixels = white});
        Camera camera;
        camera.transform = Transform::look_at({0, 0.5f, 0}, {0, 2, 0}, {0, 0, 1});
        camera.vertical_fov = 0.4f;
        builder.camera(camera);
        const Frame frame = Renderer(with_bounces(1, 16)).render(builder.finish(), 1);
        light[plate_sees_floor] = spread_of(frame.layers.front().values()).mean;
    }
    // The floor's radiance is its albedo, a little less below the plate.
    EXPECT_NEAR(light[1] - light[0], 0.25, 0.03);
}

}   // namespace
}   // namespace gnomon
