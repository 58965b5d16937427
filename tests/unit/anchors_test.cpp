// SPDX-License-Identifier: Apache-2.0
// Keys of cache points: the part of a triangle that represents a surface point, by level of detail.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "gnomon/error.h"
#include "irradiance_cache/points/anchors.h"
#include "irradiance_cache/points/slices.h"

namespace gnomon::irradiance_cache {
namespace {

TEST(Anchors, PartsAreNoLargerThanSpacing)
{
    for (std::uint32_t level = 0; level <= 6; ++level) {
        const float spacing = 3 / static_cast<float>(1u << level);
        const PartDetail exact = part_detail(9, spacing), finer = part_detail(9, 0.99f * spacing);
        EXPECT_EQ(exact.level, level);
        EXPECT_EQ(exact.fraction, 1);
        EXPECT_EQ(finer.level, level + 1);
        EXPECT_NEAR(finer.fraction, 0.01f, 0.001f) << "the fade has just begun";
        EXPECT_EQ(part_detail(9, 1.01f * spacing).level, level);
    }
    for (const float spacing : {1e-6f, 0.0f}) EXPECT_EQ(part_detail(9, spacing).level, k_part_levels);
    EXPECT_EQ(part_detail(0, 1).level, 0u);
    EXPECT_EQ(part_detail(0, 0).level, 0u);
    EXPECT_EQ(part_detail(std::numeric_limits<float>::quiet_NaN(), 1).level, 0u);
}

TEST(Anchors, KeyEncodesPart)
{
    for (const std::uint32_t level : {0u, 1u, 5u, k_part_levels}) {
        const Part part = part_of(part_key(123456, false, level, 0.2f, 0.3f));
        EXPECT_EQ(part.triangle, 123456u);
        EXPECT_FALSE(part.front);
        EXPECT_EQ(part.level, level);
        EXPECT_FALSE(is_lattice(part_key(123456, true, level, 0.2f, 0.3f)));
        // The largest triangle number.
        constexpr std::uint32_t last = std::numeric_limits<std::uint32_t>::max();
        const AnchorKey key = part_key(last, true, level, 0.2f, 0.3f);
        EXPECT_EQ(part_of(key).triangle, last);
        EXPECT_TRUE(part_of(key).front);
        EXPECT_EQ(part_of(key).level, level);
        EXPECT_EQ(part_of(key).index, part.index);
        EXPECT_FALSE(is_lattice(key) || is_near(key));
        EXPECT_TRUE(is_near(key | k_near_anchor));
    }
    EXPECT_NE(part_key(1, true, 3, 0.1f, 0.1f), part_key(1, true, 3, 0.8f, 0.1f));
    EXPECT_EQ(part_key(1, true, 0, 0.1f, 0.1f), part_key(1, true, 0, 0.8f, 0.1f));
}

TEST(Anchors, SlicesOfASlenderTriangleAreAboutAsLongAsWide)
{
    const glm::vec3 corner[3]{{0, 0, 0}, {0.5f, 0.02f, 0}, {2, 0, 0}};
    const SlenderTriangle slender = slender_triangle(corner);
    EXPECT_TRUE(is_slender(slender));
    EXPECT_FALSE(is_slender(slender_triangle(std::array<glm::vec3, 3>{glm::vec3(0), {0, 1, 0}, {1, 0, 0}}.data())));
    EXPECT_FLOAT_EQ(slender.length, 2);
    EXPECT_NEAR(slender.height, 0.02f, 1e-6f);
    for (const std::uint32_t level : {0u, 3u, 6u, k_part_levels})
        for (const glm::vec2 uv : {glm::vec2(0.1f, 0.1f), {0.3f, 0.6f}, {0.02f, 0.9f}, {0, 0}, {1, 0}, {0, 1}}) {
            const AnchorKey key = slice_key(slender, 77, true, level, uv.x, uv.y);
            const Part part = part_of(key);
            EXPECT_TRUE(part.slice && part.front && !is_near(key) && !is_lattice(key));
            EXPECT_EQ(part.level, level);
            EXPECT_EQ(part.triangle, 77u);
            const SliceMiddle middle = middle_of_slice(slender, part);
            // It lies within the triangle, in the slice, and no farther than half a slice along the side.
            for (const float w : middle.weight) EXPECT_GE(w, 0);
            EXPECT_EQ(slice_key(slender, 77, true, level, middle.weight[1], middle.weight[2]), key);
            const float x = uv.x * corner[1].x + uv.y * corner[2].x,
                        at = middle.weight[1] * corner[1].x + middle.weight[2] * corner[2].x;
            EXPECT_LE(std::abs(x - at), 1.001f / static_cast<float>(1u << level));
        }
    EXPECT_NE(slice_key(slender, 77, true, 0, 0.2f, 0.2f), part_key(77, true, 0, 0.2f, 0.2f));
}

// Places along the side are interpolated linearly between the middles of slices.
TEST(Anchors, SlicesAroundAPlaceLieOnBothSidesOfIt)
{
    const glm::vec3 corner[3]{{0, 0, 0}, {0.5f, 0.02f, 0}, {2, 0, 0}};
    const SlenderTriangle slender = slender_triangle(corner);
    const auto x_of = [&](float u, float v) { return u * corner[1].x + v * corner[2].x; };
    for (const std::uint32_t level : {0u, 3u, 5u})
        for (const glm::vec2 uv : {glm::vec2(0.1f, 0.2f), {0.3f, 0.6f}, {0.02f, 0.7f}}) {
            const SlicesAround around = slices_around(slender, 77, true, level, uv.x, uv.y);
            float x = 0;
            for (int i = 0; i < 2; ++i) {
                const SliceMiddle middle = middle_of_slice(slender, part_of(around.key[i]));
                x += around.weight[i] * x_of(middle.weight[1], middle.weight[2]);
            }
            EXPECT_FLOAT_EQ(around.weight[0] + around.weight[1], 1);
            EXPECT_NEAR(x, level > 0 ? x_of(uv.x, uv.y) : x, 1e-5f);
        }
}

TEST(Anchors, CornersOfMicroTriangles)
{
    for (const std::uint32_t level : {0u, 1u, 5u, k_corner_levels}) {
        const std::uint32_t n = 1u << level;
        for (const auto& [i, j] : {std::pair{0u, 0u}, {n, 0u}, {0u, n}, {n / 2, n / 2}}) {
            const AnchorKey key = corner_key(123456, true, level, i, j);
            EXPECT_FALSE(is_near(key) || is_lattice(key));
            const Part part = part_of(key);
            EXPECT_TRUE(part.corner && part.front && !part.slice);
            EXPECT_EQ(part.triangle, 123456u);
            EXPECT_EQ(part.level, level);
            const glm::vec2 at = place_of_corner(part, 0), inside = place_of_corner(part, k_corner_inset);
            EXPECT_FLOAT_EQ(at.x, static_cast<float>(i) / static_cast<float>(n));
            EXPECT_FLOAT_EQ(at.y, static_cast<float>(j) / static_cast<float>(n));
            EXPECT_GT(std::min({inside.x, inside.y, 1 - inside.x - inside.y}), 0);
        }
    }
    EXPECT_NE(corner_key(1, true, 0, 0, 0), part_key(1, true, 0, 0, 0));
}

TEST(Anchors, RejectsMoreTrianglesThanNumbers)
{
    scene::Scene scene;
    for (int i = 0; i < 2; ++i) scene.meshes.push_back({});
    scene.meshes.edit(0).triangles.resize(1 << 16);
    scene.meshes.edit(1).triangles.resize((1 << 16) - 1);
    scene.objects.resize(1 << 16);
    for (scene::Object& object : scene.objects) object.mesh = 0;
    EXPECT_THROW(first_triangles(scene), MissingError);
    scene.objects.back().mesh = 1;
    const std::vector<std::uint32_t> first = first_triangles(scene);
    EXPECT_EQ(first[0], 0u);
    EXPECT_EQ(first[1], 1u << 16);
    EXPECT_EQ(first.back(), 0xffff0000u);
}

}   // namespace
}   // namespace gnomon::irradiance_cache
