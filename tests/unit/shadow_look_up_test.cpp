// SPDX-License-Identifier: Apache-2.0
// Vectorised look-ups against the scalar reference implementation, and the rim that they exclude.
#include <gtest/gtest.h>

#include <random>

#include "base/micro_triangles.h"
#include "shadow_culling/certified/look_up.h"
#include "shadow_culling/certified/rim.h"

namespace gnomon::shadow_culling {
namespace {

TEST(Rim, StripsHaveTheRequestedWidth)
{
    const glm::vec3 corner[3] = {{0, 0, 0}, {2, 0, 0}, {0, 1, 0}};
    const Rim rim(rim_of(corner, 0.01f));
    // The height over the edge u = 0 is 2, over v = 0 it is 1; codes round up by an eighth of an octave at most.
    EXPECT_GE(rim.u, 0.005f);
    EXPECT_LE(rim.u, 0.005f * 1.1f);
    EXPECT_GE(rim.v, 0.01f);
    EXPECT_LE(rim.v, 0.01f * 1.1f);
    float u, v;
    EXPECT_TRUE(rim.inside(0.3f, 0.3f, u, v));
    EXPECT_FALSE(rim.inside(0.001f, 0.3f, u, v));
    EXPECT_FALSE(rim.inside(0.3f, 0.001f, u, v));
    EXPECT_FALSE(rim.inside(0.5f, 0.499f, u, v));
}

TEST(Rim, MappingToTheInsideIsInvertible)
{
    const glm::vec3 corner[3] = {{0, 0, 0}, {1, 0.2f, 0}, {0.3f, 1, 0.5f}};
    const Rim rim(rim_of(corner, 0.004f));
    std::mt19937 random(1);
    std::uniform_real_distribution<float> unit(0, 1);
    for (int k = 0; k < 1000; ++k) {
        float u = unit(random), v = unit(random), inner_u, inner_v;
        if (u + v > 1) u = 1 - u, v = 1 - v;
        if (!rim.inside(u, v, inner_u, inner_v)) continue;
        const glm::dvec2 back = rim.outer({inner_u, inner_v});
        EXPECT_NEAR(back.x, u, 1e-6);
        EXPECT_NEAR(back.y, v, 1e-6);
    }
}

TEST(Rim, DegenerateTrianglesGetTheWidestStrips)
{
    const glm::vec3 point[3] = {{1, 1, 1}, {1, 1, 1}, {1, 1, 1}};
    const glm::vec3 line[3] = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}};
    for (const Rim& rim : {Rim(rim_of(point, 0.01f)), Rim(rim_of(line, 0.01f))}) {
        EXPECT_GT(rim.inner, 0.9f);
        EXPECT_LT(rim.inner, 1);
        EXPECT_GT(rim.u, 0.03f);
    }
}

// The scalar look-up of one point.
std::uint32_t one_part(float u, float v, const Rim& rim, std::uint32_t begin, std::uint32_t level)
{
    float inner_u, inner_v;
    if (begin == k_no_slot || !rim.inside(u, v, inner_u, inner_v)) return k_no_slot;
    return begin + micro_index_at(inner_u, inner_v, level);
}

// The same with pieces: a table marks the parts that have a piece of finer parts, which is looked up in turn.
std::uint32_t one_part_of_pieces(float u, float v, const Rim& rim, std::uint32_t begin, std::uint32_t level,
                                 const std::vector<std::uint32_t>& table)
{
    float inner_u, inner_v;
    if (!rim.inside(u, v, inner_u, inner_v)) return k_no_slot;
    const std::uint32_t piece = micro_index_at(inner_u, inner_v, level);
    const std::uint32_t below = table[begin / 4 + piece];
    if (!(below & k_has_piece)) return below;
    const MicroTriangle part = micro_at(piece, level);
    const float n = static_cast<float>(1u << level);
    float x = inner_u * n - static_cast<float>(part.i), y = inner_v * n - static_cast<float>(part.j);
    if (part.upper) x = 1 - x, y = 1 - y;
    return (below & ~k_has_piece) + micro_index_at(x, y, k_piece_levels);
}

TEST(LookUp, PiecesEqualTheScalarLookUp)
{
    std::mt19937 random(9);
    std::uniform_real_distribution<float> unit(0, 1);
    std::vector<std::uint32_t> table(5000);
    for (std::uint32_t& entry : table)
        entry = static_cast<std::uint32_t>(random() % 1000000) | (random() % 2 ? k_has_piece : 0);
    LookUp points;
    const std::size_t count = 4000;
    points.resize(count);
    std::vector<std::uint32_t> expected;
    Rim rim{RimCodes{}};
    std::uint32_t level = 0, begin = 0;
    for (std::size_t k = 0; k < count; ++k) {
        if (k % 37 == 0) {
            const glm::vec3 corner[3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
            rim = Rim(rim_of(corner, k % 2 ? 0.03f : 1e-5f));
            level = static_cast<std::uint32_t>(random() % (k_max_level - k_piece_levels + 1));
            begin = 4 * static_cast<std::uint32_t>(random() % 1000);
            points.runs.push_back({static_cast<std::uint32_t>(k), begin, rim.u, rim.v, rim.per_inner,
                                   static_cast<float>(1u << level), true});
        }
        float u = unit(random), v = unit(random);
        if (k % 5 == 0) v = 1 - u;
        if (k % 7 == 0) u = std::round(u * 64) / 64;
        if (k % 11 == 0) u = 1, v = 0;
        points.uv[k] = {u, v};
        expected.push_back(one_part_of_pieces(u, v, rim, begin, level, table));
    }
    find_parts(points, reinterpret_cast<const std::uint8_t*>(table.data()));
    for (std::size_t k = 0; k < count; ++k) EXPECT_EQ(points.slot[k], expected[k]) << "point " << k;
}

TEST(LookUp, VectorisedLookUpEqualsTheScalarOne)
{
    std::mt19937 random(7);
    std::uniform_real_distribution<float> unit(0, 1);
    for (const std::size_t count : {1u, 15u, 16u, 17u, 4096u}) {
        LookUp points;
        points.resize(count);
        std::vector<std::uint32_t> expected;
        std::size_t found = 0;
        Rim rim{RimCodes{}};
        std::uint32_t level = 0, begin = k_no_slot;
        for (std::size_t k = 0; k < count; ++k) {
            // Runs of all lengths, some of one point.
            if (k == 0 || random() % (1 + k % 29) == 0) {
                const glm::vec3 corner[3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
                rim = Rim(rim_of(corner, points.runs.size() % 3 == 0 ? 0.03f : 1e-5f));
                level = static_cast<std::uint32_t>(random() % (k_max_level + 1));
                begin = random() % 13 == 0 ? k_no_slot : static_cast<std::uint32_t>(random() % 100000);
                points.runs.push_back({static_cast<std::uint32_t>(k), begin, rim.u, rim.v, rim.per_inner,
                                       static_cast<float>(1u << level)});
            }
            float u = unit(random), v = unit(random);
            if (k % 5 == 0) v = 1 - u;                       // on the long edge
            if (k % 7 == 0) u = std::round(u * 256) / 256;   // on borders of parts
            if (k % 11 == 0) u = 1, v = 0;                   // in a corner
            points.uv[k] = {u, v};
            expected.push_back(one_part(u, v, rim, begin, level));
            found += expected.back() != k_no_slot;
        }
        find_parts(points, nullptr);
        for (std::size_t k = 0; k < count; ++k) EXPECT_EQ(points.slot[k], expected[k]) << "point " << k;
        for (std::size_t k = count; k < points.slot.size(); ++k) EXPECT_EQ(points.slot[k], k_no_slot);
        if (count > 1000) {
            EXPECT_GT(found, count / 4);
        }
    }
}

TEST(LookUp, FetchesStatesThroughTheMask)
{
    std::mt19937 random(3);
    std::vector<std::uint8_t> states(1000 + k_read_pad);
    for (std::uint8_t& s : states) s = static_cast<std::uint8_t>(random());
    LookUp points;
    points.resize(100);
    for (std::uint32_t r = 0; r < 100; r += 1 + r % 9)
        points.runs.push_back({r, r % 4 == 3 ? k_no_slot : 0, 0, 0, 1, 1});
    for (std::size_t k = 0; k < 100; ++k)
        points.slot[k] = k % 9 == 0 ? k_no_slot : k == 50 ? 999 : static_cast<std::uint32_t>(random() % 1000);
    for (std::size_t r = 0; r < points.runs.size(); ++r)
        if (points.runs[r].begin == k_no_slot)
            for (std::size_t k = points.runs[r].first;
                 k < (r + 1 < points.runs.size() ? points.runs[r + 1].first : 100); ++k)
                points.slot[k] = k_no_slot;
    std::vector<std::uint8_t> out(points.slot.size(), 0xaa);
    fetch_states(points, states.data(), 0x3c, out.data());
    for (std::size_t k = 0; k < out.size(); ++k)
        EXPECT_EQ(out[k], k >= 100 || points.slot[k] == k_no_slot ? 0 : states[points.slot[k]] & 0x3c) << "point " << k;
}

}   // namespace
}   // namespace gnomon::shadow_culling
