// SPDX-License-Identifier: Apache-2.0
// Pixels within a plane are interpolated between computed ones; all others are computed.
#include <gtest/gtest.h>

#include <algorithm>

#include "irradiance_cache/points/sparse_pixels.h"

namespace gnomon::irradiance_cache {
namespace {

std::vector<IndirectPoint> tile_of(float step_at)
{
    std::vector<IndirectPoint> points;
    for (int y = 0; y < SparsePixels::k_side; ++y)
        for (int x = 0; x < SparsePixels::k_side; ++x) {
            IndirectPoint p;
            p.position = {static_cast<float>(x), static_cast<float>(y), static_cast<float>(x) < step_at ? 0.0f : 5.0f};
            p.geometric_normal = p.normal = {0, 0, 1};
            p.object = 0, p.triangle = static_cast<float>(x) < step_at ? 0 : 1;
            p.width = 1;
            p.x = static_cast<std::int16_t>(x), p.y = static_cast<std::int16_t>(y);
            points.push_back(p);
        }
    return points;
}

glm::vec3 light_at(const IndirectPoint& p)
{
    return {p.position.x, p.position.y, 1 + p.position.z};
}

// Computes the selected pixels and interpolates the others.
std::vector<glm::vec3> light_of(const std::vector<IndirectPoint>& points, SparsePixels& pixels,
                                std::vector<std::uint8_t> exempt)
{
    exempt.resize(points.size());
    std::vector<glm::vec3> light(points.size(), glm::vec3(-1));
    pixels.choose(points, exempt);
    for (const std::uint32_t i : pixels.computed()) light[i] = light_at(points[i]);
    pixels.fill(light.data());
    return light;
}

TEST(SparsePixels, ReproducesLinearLightOnAPlane)
{
    const auto points = tile_of(100);
    SparsePixels pixels;
    const auto light = light_of(points, pixels, {});
    EXPECT_EQ(pixels.computed().size(), 81u);
    for (std::size_t i = 0; i < points.size(); ++i)
        EXPECT_LT(glm::length(light[i] - light_at(points[i])), 1e-4f) << points[i].x << ", " << points[i].y;
}

TEST(SparsePixels, DoesNotInterpolateAcrossAStep)
{
    const auto points = tile_of(14);
    SparsePixels pixels;
    const auto light = light_of(points, pixels, {});
    EXPECT_LT(pixels.computed().size(), 300u);
    for (std::size_t i = 0; i < points.size(); ++i)
        EXPECT_LT(glm::length(light[i] - light_at(points[i])), 1e-4f) << points[i].x << ", " << points[i].y;
}

TEST(SparsePixels, ComputesExemptAndUnplacedPoints)
{
    auto points = tile_of(100);
    points[33].x = points[33].y = -1;   // of (1, 1)
    points.push_back(points[200]);      // once more
    std::vector<std::uint8_t> exempt(points.size());
    exempt[500] = 1;
    SparsePixels pixels;
    const auto light = light_of(points, pixels, exempt);
    for (const std::size_t i : {std::size_t{33}, std::size_t{500}, points.size() - 1})
        EXPECT_TRUE(
            std::binary_search(pixels.computed().begin(), pixels.computed().end(), static_cast<std::uint32_t>(i)));
    for (std::size_t i = 0; i < points.size(); ++i) EXPECT_LT(glm::length(light[i] - light_at(points[i])), 1e-4f) << i;
}

}   // namespace
}   // namespace gnomon::irradiance_cache
