// SPDX-License-Identifier: Apache-2.0
// A cone whose tip is nearly a point has triangles that are ten thousand times as long as wide. The plane that a ray
// meets in single precision is inclined there; still, no triangle shadows itself, and certified culling agrees with
// rays to the bit.
#include <gtest/gtest.h>

#include <cmath>

#include "base/random.h"
#include "gnomon/renderer.h"
#include "gnomon/scene_builder.h"

namespace gnomon {
namespace {

constexpr Vec3 k_bulb{-1.4f, 2.6f, 1.2f};

// Open at both ends, 24 cm high.
MeshId add_cone(SceneBuilder& builder)
{
    constexpr int k_sides = 48;
    constexpr double k_radius = 0.1, k_height = 0.24, k_tip = 1e-4;
    const double slant = std::hypot(k_radius, k_height);
    std::vector<Vec3> positions, normals;
    for (const bool at_tip : {false, true})
        for (int k = 0; k <= k_sides; ++k) {
            const double angle = 2 * 3.14159265358979 * k / k_sides, radius = at_tip ? k_tip : k_radius;
            const double x = std::cos(angle), z = -std::sin(angle);
            positions.push_back({static_cast<float>(radius * x), at_tip ? static_cast<float>(k_height) : 0.0f,
                                 static_cast<float>(radius * z)});
            normals.push_back({static_cast<float>(x * k_height / slant), static_cast<float>(k_radius / slant),
                               static_cast<float>(z * k_height / slant)});
        }
    std::vector<std::uint32_t> indices;
    for (std::uint32_t a = 0; a < k_sides; ++a) {
        const std::uint32_t b = a + k_sides + 1;
        for (const std::uint32_t i : {a, a + 1, b + 1, a, b + 1, b}) indices.push_back(i);
    }
    return builder.mesh({.positions = positions, .indices = indices, .normals = normals});
}

std::span<const float> layer(const Frame& frame, const char* name)
{
    for (const Layer& of : frame.layers)
        if (of.name == name) return of.values();
    ADD_FAILURE() << "no layer " << name;
    return {};
}

TEST(NarrowTriangles, DoNotShadowThemselves)
{
    SceneBuilder builder;
    const MeshId mesh = add_cone(builder);
    const InstanceId cone = builder.instance(mesh, {}, Transform{}, {.mobility = Mobility::may_move});
    builder.light({.color = {26, 26, 26}}, Transform::translation(k_bulb.x, k_bulb.y, k_bulb.z));
    const Scene scene = builder.finish();
    RenderOptions options;
    options.size = {320, 240};
    options.layers = true;
    options.indirect = Indirect::off;
    Renderer culled(options);
    options.shadow_culling = ShadowCulling::off;
    Renderer by_rays(options);

    Random random(5);
    std::uint64_t lit = 0, dark = 0, different = 0;
    for (int frame = 0; frame < 25; ++frame) {
        FrameInput input;
        input.time = 0.0;
        const double turn = random.uniform(0, 6.28f), along = 0.3 * random.uniform(-1, 1),
                     place = 6.28 * random.uniform();
        input.transforms = {
            {NodeId(cone), Transform::translation(along, 0, 0.1) * Transform::rotation({0, 1, 0}, turn)}};
        Camera camera;
        camera.transform = Transform::look_at(
            {static_cast<float>(along + 0.5 * std::sin(place)), 0.4f, static_cast<float>(0.1 + 0.5 * std::cos(place))},
            {static_cast<float>(along), 0.1f, 0.1f});
        input.camera = camera;
        const Frame image = by_rays.render(scene, input), other = culled.render(scene, input);
        const auto normal = layer(image, "normal"), depth = layer(image, "depth"), shadow = layer(image, "shadow"),
                   shadow_too = layer(other, "shadow");
        for (std::size_t p = 0; p < depth.size(); ++p) {
            different += shadow[p] != shadow_too[p];
            // The outside, where it faces the light: a convex body.
            if (depth[p] == 0 || normal[3 * p + 1] < 0) continue;
            const Vec3 to{k_bulb.x - static_cast<float>(along), k_bulb.y - 0.1f, k_bulb.z - 0.1f};
            const float facing = normal[3 * p] * to.x + normal[3 * p + 1] * to.y + normal[3 * p + 2] * to.z;
            if (facing < 0.2f * std::hypot(to.x, to.y, to.z)) continue;
            ++(shadow[p] > 0 ? lit : dark);
        }
    }
    EXPECT_GT(lit, 20'000u);
    EXPECT_EQ(dark, 0u);
    EXPECT_EQ(different, 0u);
}

}   // namespace
}   // namespace gnomon
