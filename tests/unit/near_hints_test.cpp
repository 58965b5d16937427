// SPDX-License-Identifier: Apache-2.0
// Hints of where the near field is needed: unique names for all cells of many large triangles, and a memory limit that
// changes no answer.
#include "irradiance_cache/near_field/near_hints.h"

#include <gtest/gtest.h>

#include <limits>
#include <set>

#include "scene_helpers.h"
#include "world.h"

namespace gnomon {
namespace {

using irradiance_cache::NearHints;
using State = NearHints::State;

constexpr float k_radius = 0.01f;

TEST(NearHints, CellsHaveUniqueNames)
{
    const NearHints hints({.radius = k_radius});
    const glm::vec3 large[3] = {{0, 0, 0}, {100, 0, 0}, {0, 100, 0}},
                    small[3] = {{0, 0, 0}, {0.01f, 0, 0}, {0, 0.01f, 0}};
    const std::uint32_t side = hints.cells_along(large);
    EXPECT_EQ(side, 128u);
    EXPECT_EQ(hints.cells_along(small), 1u);
    std::set<NearHints::Cell> names;
    std::size_t expected = 0;
    // 2^17 such triangles have 2^31 cells, and twice as many sides of cells.
    for (const std::uint32_t triangle :
         {0u, 1u, (1u << 17) - 1, 1u << 17, 1u << 18, std::numeric_limits<std::uint32_t>::max()})
        for (const bool front : {false, true})
            for (const float u : {0.0f, 0.3f, 0.999f, 1.0f})
                for (const float v : {0.0f, 0.3f, 0.7f}) {
                    names.insert(NearHints::cell_at(triangle, side, u, v, front));
                    expected += u != 1;   // u = 1 is in the last cell, too
                }
    EXPECT_EQ(names.size(), expected);
}

TEST(NearHints, ForgottenCellsGetTheSameAnswer)
{
    scene::Scene scene = test::scene_with_balls();
    test::add_object(scene, 0);
    test::add_object(scene, 0, scene::none, test::translation(1.2, 0, 0));   // into the first
    scene.finish();
    const test::World world(std::move(scene));
    const auto triangles = static_cast<std::uint32_t>(world.scene->meshes[0].triangles.size());
    const auto claim_all = [&](NearHints& hints, int frame) {
        NearHints::Scratch scratch;
        std::vector<NearHints::Claim> claimed;
        std::vector<State> states;
        std::vector<NearHints::Cell> cells;
        for (std::uint32_t t = 0; t < triangles; ++t) {
            glm::vec3 p[3];
            world.rays.geometry(0).corners(t, p);
            const std::uint32_t side = hints.cells_along(p);
            for (std::uint32_t i = 0; i < side; ++i) {
                const float u = (static_cast<float>(i) + 0.5f) / static_cast<float>(side);
                cells.push_back(NearHints::cell_at(t, side, u, 0, true));
                const State state = hints.claim(cells.back());
                EXPECT_TRUE(state != State::claimed) << "frame " << frame;
                if (state == State::unknown) claimed.push_back({cells.back(), 0, t, side});
            }
        }
        hints.answer(world.rays, claimed, scratch);
        for (const NearHints::Cell cell : cells) states.push_back(hints.state(cell));
        hints.end_frame();
        return std::pair(states, claimed.size());
    };
    NearHints all({.radius = k_radius}), few({.radius = k_radius, .memory = 1});
    const auto [states, claimed] = claim_all(all, 1);
    EXPECT_GT(std::count(states.begin(), states.end(), State::near), 0);
    EXPECT_GT(std::count(states.begin(), states.end(), State::none), 0);
    EXPECT_EQ(claim_all(all, 2).second, 0u);
    EXPECT_EQ(claim_all(few, 1).first, states);
    EXPECT_EQ(claim_all(few, 2).second, 0u) << "cells of the last frame stay";
    few.end_frame();
    few.end_frame();
    EXPECT_EQ(few.bytes(), 0u);
    EXPECT_EQ(claim_all(few, 3), std::pair(states, claimed));
}

}   // namespace
}   // namespace gnomon
