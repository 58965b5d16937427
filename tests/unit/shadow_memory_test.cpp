// SPDX-License-Identifier: Apache-2.0
// The memory of the shadow cache: the limit holds, and the least recently seen records are evicted first.
#include "shadow_culling/certified/shadow_memory.h"

#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <chrono>
#include <thread>

#include "base/tasks.h"
#include "shadow_culling/certified/look_up.h"
#include "shadow_stage.h"

namespace gnomon {
namespace {

using shadow_culling::k_lights_per_group;
using shadow_culling::k_max_level;
using shadow_culling::k_no_slot;
using shadow_culling::LookUp;
using shadow_culling::RecordId;
using shadow_culling::Rim;
using shadow_culling::RimCodes;
using shadow_culling::ShadowMemory;
using shadow_culling::ShadowState;

constexpr std::uint32_t k_level = 2;

TEST(ShadowMemory, EvictsLeastRecentlySeenFirst)
{
    ShadowMemory memory(100, 1, 2 * 8);   // room for eight records without differing states
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
    EXPECT_EQ(memory.live_records(), 4u);   // half of the memory is free
    for (RecordId r = 0; r < 8; ++r) EXPECT_EQ(memory.has(r), seen_in[r] > 4) << "record " << r;
}

TEST(ShadowMemory, KeepsRecordsSeenInThisFrame)
{
    ShadowMemory memory(100, 1, 2 * 8);
    for (RecordId r = 0; r < 8; ++r) {
        memory.create(r, k_level, RimCodes{});
        memory.note_seen(r, r < 2 ? 1 : 3);
    }
    memory.drop_unseen(3);
    for (RecordId r = 0; r < 8; ++r) EXPECT_EQ(memory.has(r), r >= 2) << "record " << r;
}

// The blocks that a deeper pyramid freed, its table of pieces and its upper levels, are smaller than a piece.
TEST(ShadowMemory, DoesNotReuseSmallerFreeBlocks)
{
    constexpr std::uint32_t k_in_pieces = shadow_culling::k_piece_levels + 1;
    ShadowMemory memory(4, 1, 2 * 200);   // no room for a piece
    for (const RecordId r : {0u, 1u}) {
        ASSERT_TRUE(memory.create(r, k_in_pieces, RimCodes{}));
        ASSERT_TRUE(memory.open(r, micro_at(0, 0), 0));
    }
    ASSERT_TRUE(memory.drop(1));
    EXPECT_FALSE(memory.open(0, micro_at(2, 1), 1));
    EXPECT_TRUE(memory.full());
}

// A look-up may reach a record that is being created: it finds either none or a complete one. (ThreadSanitizer reports
// any other read.)
TEST(ShadowMemory, LooksUpRecordsAddedByAnotherThread)
{
    constexpr RecordId k_records = 400;
    ShadowMemory memory(k_records, 1, 2 * k_records);
    const RimCodes rim{{30, 50, 70}};
    std::atomic<unsigned> arrived = 0;
    const auto patience = std::chrono::steady_clock::now() + std::chrono::seconds(30);
    std::array<std::size_t, 2> wrong{}, made{};
    Tasks(2).for_each(2, [&](std::size_t i, int) {
        for (RecordId r = 0; r < k_records; ++r) {
            const ShadowMemory::Place before = memory.place(r);
            wrong[i] += before.level != 0 || before.pieces;
            // Both have looked up before either adds; nothing else orders them.
            arrived.fetch_add(1, std::memory_order_relaxed);
            while (arrived.load(std::memory_order_relaxed) < 2 * (r + 1) && std::chrono::steady_clock::now() < patience)
                std::this_thread::yield();
            if (before.begin == k_no_slot) made[i] += memory.create(r, k_level, rim);
            const ShadowMemory::Place place = memory.place(r);
            wrong[i] += place.begin >= k_records || place.level != 0 || place.pieces || memory.level(r) != k_level ||
                        memory.rim(r).inner != Rim(rim).inner;
        }
    });
    EXPECT_EQ(wrong[0] + wrong[1], 0u);
    EXPECT_EQ(made[0] + made[1], k_records);
}

// The states of all parts of a level, for one group of lights.
std::vector<std::uint8_t> parts_of(const ShadowMemory& memory, RecordId record, std::uint32_t level, int group)
{
    std::vector<std::uint8_t> states;
    for (std::uint32_t i = 0; i < 1u << (2 * level); ++i)
        states.push_back(memory.states(group)[memory.address(record, micro_at(i, level), level)]);
    return states;
}

TEST(ShadowMemory, EvictedRecordsLeaveNoStates)
{
    for (const std::uint32_t level : {2u, 6u}) {
        ShadowMemory memory(100, 1, 64 << 10);
        const auto open_all = [&](RecordId r) {
            for (std::uint32_t k = 0; k < level; ++k)
                for (std::uint32_t i = 0; i < 1u << (2 * k); ++i) ASSERT_TRUE(memory.open(r, micro_at(i, k), k));
        };
        const std::size_t before = memory.bytes();
        for (RecordId r = 0; r < 2; ++r) {
            ASSERT_TRUE(memory.create(r, level, RimCodes{}));
            open_all(r);
            for (std::uint32_t i = 0; i < 1u << (2 * level); ++i)
                memory.states(0)[memory.address(r, micro_at(i, level), level)] = 0xff;
            std::uint8_t* const evidence = memory.evidence(r);
            ASSERT_NE(evidence, nullptr);
            std::fill_n(evidence, 1u << (2 * level), std::uint8_t{0xff});
            EXPECT_TRUE(memory.drop(r));
            EXPECT_FALSE(memory.drop(r));
        }
        EXPECT_EQ(memory.bytes(), before);
        for (RecordId r = 0; r < 2; ++r) {
            ASSERT_TRUE(memory.create(r, level, RimCodes{}));
            EXPECT_EQ(memory.take_evidence(r), nullptr);
            open_all(r);
            for (const std::uint8_t states : parts_of(memory, r, level, 0)) EXPECT_EQ(states, 0);
        }
    }
}

TEST(ShadowMemory, EvidenceIsFreedWhenTaken)
{
    ShadowMemory memory(100, 5, 2 * 1000);
    ASSERT_TRUE(memory.create(7, 4, RimCodes{}));
    ASSERT_TRUE(memory.create(8, 4, RimCodes{}));
    const std::size_t without = memory.bytes();
    EXPECT_EQ(memory.take_evidence(7), nullptr);
    std::uint8_t* const evidence = memory.evidence(7);
    ASSERT_NE(evidence, nullptr);
    for (int i = 0; i < 2 * 256; ++i) EXPECT_EQ(evidence[i], 0);   // two groups of lights
    evidence[256 + 3] = 5;
    EXPECT_EQ(memory.evidence(7), evidence);
    EXPECT_EQ(memory.bytes(), without + 512);
    EXPECT_EQ(memory.evidence(8), nullptr);   // no room left
    const ShadowMemory::Evidence taken = memory.take_evidence(7);
    ASSERT_NE(taken, nullptr);
    EXPECT_EQ(taken[256 + 3], 5);
    EXPECT_EQ(memory.take_evidence(7), nullptr);
    EXPECT_EQ(memory.bytes(), without);
    EXPECT_EQ(memory.most_evidence_bytes(), 512u);
    EXPECT_NE(memory.evidence(8), nullptr);
}

TEST(MicroTriangles, AncestorsAreParentsOfParents)
{
    constexpr std::uint32_t k_finest = 5;
    for (std::uint32_t k = 0; k < 1u << (2 * k_finest); ++k) {
        const MicroTriangle part = micro_at(k, k_finest);
        MicroTriangle above = part;
        for (std::uint32_t up = 0; up <= k_finest; ++up, above = parent_of(above))
            EXPECT_EQ(ancestor_of(part, up), above) << k << " " << up;
    }
}

// The reference implementation: a full pyramid with a state for every part.
struct FullPyramid {
    std::uint32_t level = 0;
    std::vector<std::uint8_t> states = {0};

    std::uint8_t& at(const MicroTriangle& part, std::uint32_t k)
    {
        return states[pyramid_offset(k) + micro_index(part, k)];
    }
    void fill(const MicroTriangle& part, std::uint32_t k, int shift, ShadowState state)
    {
        at(part, k) =
            static_cast<std::uint8_t>((at(part, k) & ~(3u << shift)) | (static_cast<unsigned>(state) << shift));
        if (k == level) return;
        MicroTriangle child[4];
        children_of(part, child);
        for (const MicroTriangle& c : child) fill(c, k + 1, shift, state);
    }
    void deepen(std::uint32_t to)
    {
        states.resize(pyramid_size(to));
        for (std::uint32_t k = level + 1; k <= to; ++k)
            for (std::uint32_t i = 0; i < 1u << (2 * k); ++i) {
                unsigned states_above = at(parent_of(micro_at(i, k)), k - 1);
                states_above &= ~((states_above & (states_above >> 1) & 0x55u) * 3);
                states[pyramid_offset(k) + i] = static_cast<std::uint8_t>(states_above);
            }
        level = to;
    }
    void forget(int shift, bool but_none)
    {
        for (std::uint8_t& s : states)
            if (!but_none || static_cast<ShadowState>((s >> shift) & 3) != ShadowState::none)
                s &= static_cast<std::uint8_t>(~(3u << shift));
    }
};

// Writes into both as the certificates do.
class BothMemories {
 public:
    BothMemories(std::uint32_t level, int lights) : memory_(10, lights, 4 << 20), lights_(lights)
    {
        memory_.create(3, level, RimCodes{});
        reference_.resize(static_cast<std::size_t>(memory_.groups()));
        for (FullPyramid& reference : reference_)
            reference.level = level, reference.states.assign(pyramid_size(level), 0);
    }

    // Descends from the whole triangle: PARTIAL on the way, and some state at the end.
    void learn(Random& random)
    {
        const int light = static_cast<int>(random.below(static_cast<std::uint32_t>(lights_)));
        const int group = light / k_lights_per_group, shift = 2 * (light % k_lights_per_group);
        FullPyramid& reference = reference_[static_cast<std::size_t>(group)];
        const std::uint32_t end = random.below(reference.level + 1);
        MicroTriangle part;
        for (std::uint32_t k = 0;; ++k) {
            const auto state = static_cast<ShadowState>((reference.at(part, k) >> shift) & 3);
            if (state == ShadowState::none || state == ShadowState::full) return;
            if (k == end && random.below(3) > 0) {
                const ShadowState proven = random.below(2) ? ShadowState::none : ShadowState::full;
                reference.fill(part, k, shift, proven);
                fill(part, k, group, shift, proven);
                return;
            }
            if (k < reference.level) {
                ASSERT_TRUE(memory_.open(3, part, k));
            }
            reference.at(part, k) |= static_cast<std::uint8_t>(3u << shift);
            memory_.states(group)[memory_.address(3, part, k)] |= static_cast<std::uint8_t>(3u << shift);
            if (k == end || k == reference.level) return;
            MicroTriangle child[4];
            children_of(part, child);
            part = child[random.below(4)];
        }
    }
    void deepen(std::uint32_t level)
    {
        if (level > reference_[0].level) {
            EXPECT_TRUE(memory_.deepen(3, level));
            for (FullPyramid& reference : reference_) reference.deepen(level);
        }
    }
    void forget(int light, bool but_none)
    {
        if (but_none)
            memory_.reopen(3, light);
        else
            memory_.forget_light(light);
        reference_[static_cast<std::size_t>(light / k_lights_per_group)].forget(2 * (light % k_lights_per_group),
                                                                                but_none);
    }

    void expect_equal(Random& random) const
    {
        const std::uint32_t level = reference_[0].level;
        for (int g = 0; g < memory_.groups(); ++g) {
            const std::vector<std::uint8_t>& whole = reference_[static_cast<std::size_t>(g)].states;
            EXPECT_EQ(parts_of(memory_, 3, level, g),
                      std::vector<std::uint8_t>(whole.begin() + pyramid_offset(level), whole.end()));
        }
        // Look it up as the renderer does.
        LookUp points;
        points.resize(50);
        const ShadowMemory::Place place = memory_.place(3);
        points.runs.push_back({0, place.begin, 0, 0, 1, static_cast<float>(1u << place.level), place.pieces});
        for (std::size_t p = 0; p < 50; ++p) {
            // Use the middle of a part, so that rounding has no effect.
            const MicroTriangle part = micro_at(random.below(1u << (2 * level)), level);
            glm::dvec2 corner[3];
            corners_of(part, level, corner);
            points.uv[p] = glm::vec2((corner[0] + corner[1] + corner[2]) / 3.0);
        }
        find_parts(points, memory_.states(0));
        for (std::size_t p = 0; p < 50; ++p)
            for (int g = 0; g < memory_.groups(); ++g)
                EXPECT_EQ(memory_.states(g)[points.slot[p]],
                          reference_[static_cast<std::size_t>(g)]
                              .states[pyramid_offset(level) + micro_index_at(points.uv[p].x, points.uv[p].y, level)]);
    }
    std::size_t bytes() const { return memory_.bytes(); }
    std::size_t whole_bytes() const { return reference_.size() * reference_[0].states.size(); }

 private:
    void fill(const MicroTriangle& part, std::uint32_t k, int group, int shift, ShadowState state)
    {
        std::uint8_t& byte = memory_.states(group)[memory_.address(3, part, k)];
        byte = static_cast<std::uint8_t>((byte & ~(3u << shift)) | (static_cast<unsigned>(state) << shift));
        if (!memory_.is_open(3, part, k)) return;
        MicroTriangle child[4];
        children_of(part, child);
        for (const MicroTriangle& c : child) fill(c, k + 1, group, shift, state);
    }

    ShadowMemory memory_;
    int lights_;
    std::vector<FullPyramid> reference_;   // by group
};

TEST(ShadowMemory, EqualsAFullPyramid)
{
    Random random(5);
    for (int round = 0; round < 60; ++round) {
        const int lights = round % 3 == 0 ? 6 : 1;
        BothMemories both(random.below(k_max_level - 1), lights);
        for (int step = 0; step < 12; ++step) {
            for (std::uint32_t n = random.below(30); n > 0; --n) both.learn(random);
            if (step % 4 == 1)
                both.forget(static_cast<int>(random.below(static_cast<std::uint32_t>(lights))), random.below(2) != 0);
            if (step % 4 == 3) both.deepen(random.below(k_max_level + 1));
            both.expect_equal(random);
        }
    }
}

// A shadow edge across a large triangle needs pieces along the edge, not the full pyramid.
TEST(ShadowMemory, AllocatesOnlyWhereStatesDiffer)
{
    Random random(6);
    BothMemories both(k_max_level, 1);
    for (int n = 0; n < 40; ++n) both.learn(random);
    EXPECT_LT(both.bytes(), both.whole_bytes() / 4);
    both.expect_equal(random);
}

// A camera looks around in a scene that needs far more memory than the limit: the limit is never exceeded, no result is
// wrong, and some are still found.
TEST(ShadowMemory, StaysWithinItsLimit)
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
        // The visible window moves on every tenth frame.
        test::Rehearsal::Points seen;
        for (std::size_t i = 0; i < everywhere.size() / 4; ++i)
            seen.push_back(
                everywhere[(i + static_cast<std::size_t>(frame / 10) * everywhere.size() / 5) % everywhere.size()]);
        rehearsal.advance(0);
        const test::Outcome outcome = rehearsal.query(seen);
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
