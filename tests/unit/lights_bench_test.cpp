// SPDX-License-Identifier: Apache-2.0
// The bench of lights with size: what it counts as wrong.
#include "bench/lights/bench.h"

#include <gtest/gtest.h>

#include "scene/builtin/builtin.h"

namespace gnomon::bench {
namespace {

std::uint64_t wrong_without(area_light::DarkCheck left_out)
{
    LightsBenchOptions options;
    options.size = {48, 32};
    options.side = 0.5f;
    options.samples = {4};
    options.check = 8;
    options.truth = 64, options.truth_points = 20, options.repeats = 1;
    options.proofs.dark.left_out = left_out;
    const LightsBenchResult result =
        bench_lights(std::make_shared<scene::Scene>(scene::make_builtin("cornell")), options);
    EXPECT_EQ(result.rows.size(), 1u);
    EXPECT_GT(result.rows[0].segments, 1000u);
    EXPECT_LE(result.rows[0].wrong, result.rows[0].segments);
    return result.rows[0].wrong;
}

TEST(LightsBench, CountsWrongResultsIfAProofLacksACheck)
{
    EXPECT_EQ(wrong_without(area_light::DarkCheck::none), 0u);
    EXPECT_GT(wrong_without(area_light::DarkCheck::no_open_edge) + wrong_without(area_light::DarkCheck::crosses), 10u);
}

}   // namespace
}   // namespace gnomon::bench
