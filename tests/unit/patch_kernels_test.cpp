// SPDX-License-Identifier: Apache-2.0
// What patches receive of dynamic objects' light, several patches at once, against one patch at a time.
#include <gtest/gtest.h>

#include <cstring>

#include "base/random.h"
#include "irradiance_cache/light_tree/patch_kernels.h"

namespace gnomon::test {
namespace {

using irradiance_cache::DynamicVirtualLight;
using irradiance_cache::PatchRows;

constexpr float k_untested = 0.02f;

glm::vec3 random_point(Random& random)
{
    const float x = random.uniform(-3, 3), y = random.uniform(-3, 3);
    return {x, y, random.uniform(-3, 3)};
}

glm::vec3 sample(const PatchRows& rows, std::size_t k)
{
    return {rows.sample[0][k], rows.sample[1][k], rows.sample[2][k]};
}

// The irradiance of a disk.
glm::vec3 irradiance(const PatchRows& rows, std::size_t k, const DynamicVirtualLight& light)
{
    const glm::vec3 to = light.sample - sample(rows, k),
                    normal(rows.normal[0][k], rows.normal[1][k], rows.normal[2][k]);
    const float square = glm::dot(to, to), cosine = glm::dot(to, normal), facing = light.facing(to, std::sqrt(square));
    if (!(cosine > 0 && facing > 0)) return glm::vec3(0);
    return facing * cosine / (square * (static_cast<float>(k_pi) * square + light.area)) * light.flux;
}

TEST(PatchKernels, ReceiveAsOnePatchAtATimeToTheBit)
{
    Random random(7);
    std::size_t added = 0, tests = 0, near_tests = 0;
    for (const std::size_t count : {1u, 15u, 16u, 509u, 512u}) {
        PatchRows rows;
        rows.count = count;
        for (std::size_t k = 0; k < count; ++k) {
            const glm::vec3 at = random_point(random), normal = glm::normalize(random_point(random));
            for (int i = 0; i < 3; ++i) rows.sample[i][k] = at[i], rows.normal[i][k] = normal[i];
            rows.albedo[k] = random.uniform(0, 1), rows.already[k] = random.uniform(0, 10);
            if (k % 9 == 0) rows.already[k] = 0;
        }
        std::vector<glm::vec3> expected(count, glm::vec3(0));
        for (int l = 0; l < 12; ++l) {
            DynamicVirtualLight light;
            light.position = light.sample = random_point(random);
            light.normal = random.uniform(0.3f, 1) * glm::normalize(random_point(random));
            light.flux = glm::abs(random_point(random));
            light.area = random.uniform(0.01f, 0.5f);
            if (l % 2 == 0) light.halves = 0;
            std::vector<std::uint16_t> asked, tested(count);
            for (std::size_t k = 0; k < count; ++k) {
                const glm::vec3 way = light.sample - sample(rows, k), brings = irradiance(rows, k, light);
                const bool near = light.is_near(glm::dot(way, way));
                const bool faint = rows.albedo[k] * luminance(brings) < k_untested * rows.already[k];
                if (near || (!faint && brings != glm::vec3(0))) {
                    asked.push_back(static_cast<std::uint16_t>(k));
                    near_tests += near;
                } else if (faint && brings != glm::vec3(0)) {
                    expected[k] += brings;
                    ++added;
                }
            }
            tested.resize(irradiance_cache::receive_untested(rows, light, k_untested, tested.data()));
            EXPECT_EQ(tested, asked);
            tests += asked.size();
        }
        for (std::size_t k = 0; k < count; ++k)
            for (int i = 0; i < 3; ++i)
                EXPECT_EQ(std::memcmp(&rows.received[i][k], &expected[k][i], sizeof(float)), 0) << k;
    }
    EXPECT_GT(added, 500u);
    EXPECT_GT(tests, 500u);
    EXPECT_GT(near_tests, 20u);
}

}   // namespace
}   // namespace gnomon::test
