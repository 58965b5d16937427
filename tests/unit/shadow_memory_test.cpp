// SPDX-License-Identifier: Apache-2.0
// What remembered shadows may take: a bound that holds, and what was not seen for longest goes first.
#include "shadow_culling/shadow_memory.h"

#include <gtest/gtest.h>

#include "shadow_stage.h"

namespace gnomon {
namespace {

using shadow_culling::k_no_slot;
using shadow_culling::RecordId;
using shadow_culling::RimCodes;
using shadow_culling::ShadowMemory;

constexpr std::uint32_t k_level = 2;

// Room for eight pyramids of one group of lights: states and evidence.
ShadowMemory memory_for_eight(std::size_t records = 100)
{
    return ShadowMemory(records, 1, 2 * 8 * pyramid_size(k_level));
}

TEST(ShadowMemory, DropsWhatWasNotSeenForLongestFirst)
{
    ShadowMemory memory = memory_for_eight();
    const std::uint32_t seen_in[] = {5, 2, 8, 1, 7, 3, 6, 4};
    for (RecordId r = 0; r < 8; ++r) {
        ASSERT_TRUE(memory.create(r, k_level, RimCodes{}));
        memory.note_seen(r, seen_in[r]);
    }
    EXPECT_FALSE(memory.full());
    EXPECT_FALSE(memory.create(8, k_level, RimCodes{}));
    EXPECT_TRUE(memory.full());

    memory.drop_unseen(9);
    EXPECT_FALSE(memory.full());
    EXPECT_EQ(memory.live_records(), 4u);   // half the room is free
    for (RecordId r = 0; r < 8; ++r) EXPECT_EQ(memory.base(r) != k_no_slot, seen_in[r] > 4) << "record " << r;
}

TEST(ShadowMemory, KeepsWhatTheFrameSees)
{
    ShadowMemory memory = memory_for_eight();
    for (RecordId r = 0; r < 8; ++r) {
        memory.create(r, k_level, RimCodes{});
        memory.note_seen(r, r < 2 ? 1 : 3);
    }
    memory.drop_unseen(3);
    for (RecordId r = 0; r < 8; ++r) EXPECT_EQ(memory.base(r) != k_no_slot, r >= 2) << "record " << r;
}

TEST(ShadowMemory, WhatWasDroppedLeavesNothingBehind)
{
    ShadowMemory memory = memory_for_eight();
    for (RecordId r = 0; r < 8; ++r) {
        memory.create(r, k_level, RimCodes{});
        memory.note_seen(r, r);
        std::fill_n(memory.states(0) + memory.base(r), pyramid_size(k_level), std::uint8_t{0xff});
        std::fill_n(memory.evidence(0) + memory.base(r), pyramid_size(k_level), std::uint8_t{0xff});
    }
    memory.drop_unseen(9);
    for (RecordId r = 50; r < 54; ++r) {
        ASSERT_TRUE(memory.create(r, k_level, RimCodes{}));
        for (std::uint32_t i = 0; i < pyramid_size(k_level); ++i) {
            EXPECT_EQ(memory.states(0)[memory.base(r) + i], 0);
            EXPECT_EQ(memory.evidence(0)[memory.base(r) + i], 0);
        }
    }
}

// A camera that looks around in a scene that asks for far more than it may have: never more than the bound, never
// wrong, and still of use.
TEST(ShadowMemory, BoundHoldsInUse)
{
    Random random(1);
    test::Stage stage;
    std::vector<glm::vec3> corners;
    for (int t = 0; t < 400; ++t) {
        const glm::vec3 at(random.uniform(-5, 5), random.uniform(-5, 5), random.uniform(-1, 1));
        for (int c = 0; c < 3; ++c)
            corners.push_back(at + glm::vec3(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)));
    }
    stage.add(corners);
    stage.add_light({1, 2, 9});
    shadow_culling::CertifiedOptions options;
    options.memory = 16 << 10;
    test::Rehearsal rehearsal(std::move(stage), options);
    rehearsal.set_view({glm::vec3(0, 0, 4), 0.01f, 0});
    const auto everywhere = rehearsal.points({0}, 60);

    std::uint64_t remembered = 0;
    std::size_t fewest = everywhere.size();
    for (int frame = 0; frame < 40; ++frame) {
        // A window that goes on every tenth frame.
        test::Rehearsal::Points seen;
        for (std::size_t i = 0; i < everywhere.size() / 4; ++i)
            seen.push_back(
                everywhere[(i + static_cast<std::size_t>(frame / 10) * everywhere.size() / 5) % everywhere.size()]);
        rehearsal.advance(0);
        const test::Outcome outcome = rehearsal.ask(seen);
        EXPECT_EQ(outcome.wrong, 0u) << "frame " << frame;
        remembered += outcome.none + outcome.full;
        EXPECT_LE(rehearsal.culling().bytes(), options.memory + rehearsal.culling().visible_triangles() * 32);
        fewest = std::min(fewest, rehearsal.culling().visible_triangles());
    }
    EXPECT_GT(remembered, 1000u);
    EXPECT_GT(fewest, 0u);
}

}   // namespace
}   // namespace gnomon
