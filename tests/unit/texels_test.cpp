// SPDX-License-Identifier: Apache-2.0
// Vectorised texel addresses against the scalar reference implementation.
#include <gtest/gtest.h>

#include <random>

#include "shadow_culling/dynamic_mask/texels.h"

namespace gnomon::shadow_culling {
namespace {

TEST(Texels, VectorisedTexelsEqualScalarOnes)
{
    std::mt19937 random(5);
    std::uniform_real_distribution<float> any(-3, 3);
    const CullingView view{{0.5f, 1, 4}, 0.003f, 0.0001f};
    for (const bool directional : {false, true})
        for (const std::size_t count : {1u, 15u, 16u, 17u, 5000u}) {
            visibility::LightPoint light;
            light.directional = directional;
            light.place = directional ? glm::normalize(glm::dvec3(0.3, 1, -0.2)) : glm::dvec3(0.25, 0.5, -0.75);
            const LightSpace space(light, Box3{glm::vec3(-2), glm::vec3(2)});
            Texels points;
            points.resize(count);
            std::vector<glm::vec3> places;
            for (std::size_t i = 0; i < count; ++i) {
                glm::vec3 p(any(random), any(random), any(random));
                if (i % 7 == 0) p = glm::vec3(light.place) + glm::vec3(p.x, p.x, -p.x);   // between faces
                if (i % 31 == 0) p = glm::vec3(light.place);
                places.push_back(p);
                points.x[i] = p.x, points.y[i] = p.y, points.z[i] = p.z;
            }
            find_texels(space, view, 2, points);
            std::size_t in = 0;
            for (std::size_t i = 0; i < count; ++i) {
                const Projected at = space.project(places[i]);
                if (!(at.x >= 0 && at.x < 1 && at.y >= 0 && at.y < 1)) {
                    EXPECT_EQ(points.key(i), k_no_block);
                    continue;
                }
                ++in;
                const std::uint32_t level = level_of(space, view, 2, places[i], at.depth);
                const auto texels = static_cast<float>(1u << level);
                const auto x = static_cast<std::uint32_t>(at.x * texels), y = static_cast<std::uint32_t>(at.y * texels);
                const BlockKey key = points.key(i);
                EXPECT_EQ(points.depth[i], at.depth);
                EXPECT_EQ(level_of(key), level);
                EXPECT_EQ(face_of(key), at.face);
                EXPECT_EQ(x_of(key) * k_block_side + points.texel[i] % k_block_side, x);
                EXPECT_EQ(y_of(key) * k_block_side + points.texel[i] / k_block_side, y);
            }
            if (count > 1000) {
                EXPECT_GT(in, count / 4);
                EXPECT_LT(in, count);
            }
        }
}

TEST(Texels, ComparesDepthsWithTheTexelAbove)
{
    std::mt19937 random(11);
    std::uniform_real_distribution<float> unit(0, 1);
    MaskTexels over;
    over.begins = {k_infinity}, over.ends = {k_infinity};
    for (int p = 0; p < 255; ++p) {
        over.begins.push_back(unit(random));
        over.ends.push_back(over.begins.back() + 0.2f * unit(random));
    }
    for (std::uint32_t& texel : over.texel) texel = static_cast<std::uint32_t>(random()) & 0xffffff;
    over.texel[5] = 0;
    Texels points;
    points.resize(5000);
    std::size_t counted[5] = {}, cleared = 0;
    std::vector<std::uint8_t> moving(points.depth.size()), clear(points.depth.size(), 7);
    for (std::uint8_t& m : moving) m = random() & 1;
    const float still = 0.4f;
    for (std::size_t i = 0; i < 5000; ++i) {
        points.texel[i] = i % 17 == 0 ? 5 : static_cast<std::uint32_t>(random() % over.texel.size());
        points.depth[i] = 1.2f * unit(random);
    }
    std::vector<MaskAnswer> answer(points.depth.size(), MaskAnswer::not_drawn);
    compare_depths(points, 3, 4999, over, moving.data(), still, answer.data(), clear.data());
    for (std::size_t i = 3; i < 4999; ++i) {
        const std::uint32_t texel = points.texel[i];
        const float depth = points.depth[i];
        const MaskAnswer expected = depth > over.ends[over.full(texel)]                  ? MaskAnswer::occluded
                                    : depth < over.begins[over.first(texel)]             ? MaskAnswer::free
                                    : moving[i] && depth < over.begins[over.next(texel)] ? MaskAnswer::maybe_self
                                                                                         : MaskAnswer::unknown;
        EXPECT_EQ(answer[i], expected) << "point " << i;
        ++counted[static_cast<int>(answer[i])];
        EXPECT_EQ(clear[i], moving[i] && depth < still) << "point " << i;
        cleared += clear[i];
    }
    EXPECT_EQ(answer[2], MaskAnswer::not_drawn);
    EXPECT_EQ(answer[4999], MaskAnswer::not_drawn);
    for (const std::size_t beyond : {2u, 4999u}) EXPECT_EQ(clear[beyond], 7);
    for (const MaskAnswer a : {MaskAnswer::occluded, MaskAnswer::free, MaskAnswer::unknown, MaskAnswer::maybe_self})
        EXPECT_GT(counted[static_cast<int>(a)], 50u);
    EXPECT_GT(cleared, 50u);
}

}   // namespace
}   // namespace gnomon::shadow_culling
