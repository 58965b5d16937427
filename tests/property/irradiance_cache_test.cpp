// SPDX-License-Identifier: Apache-2.0
// Indirect light with remembered visibility: the same bytes whatever came before and for any number of threads,
// repaired trees as good as new ones, and light where it must be.
#include <gtest/gtest.h>

#include "base/bits.h"
#include "irradiance_cache/irradiance_cache.h"
#include "seen_points.h"
#include "trace/traced_frame.h"
#include "world.h"

namespace gnomon {
namespace {

using irradiance_cache::LightTree;
using irradiance_cache::IrradianceCache;
using irradiance_cache::CacheOptions;
using test::World;

// The indirect layer of a frame, after others.
std::vector<float> indirect_of(const char* name, std::vector<int> frames, int threads, int size = 64,
                               const CacheOptions& visible_options = {})
{
    World world(name, frames.front(), threads);
    IrradianceCache visible(world.state, world.rays, visible_options, world.tasks);
    trace::Remembered remembered;
    remembered.visible = &visible;
    trace::TracedOptions options;
    options.layers = true;
    shading::FrameBuffers buffers;
    for (std::size_t f = 0; f < frames.size(); ++f) {
        if (f > 0) world.go(frames[f]);
        trace::trace_frame(world.state, world.rays, scene::make_view(world.state, 0, {size, size}), options,
                           world.tasks, buffers, remembered);
    }
    return buffers.indirect.data;
}

TEST(IrradianceCache, SameBytesColdAndWarm)
{
    for (const char* name : {"cornell", "kinetic"}) {
        const auto cold = indirect_of(name, {8}, 1);
        EXPECT_TRUE(same_bits(cold, indirect_of(name, {5, 6, 7, 8}, 1))) << name;
        EXPECT_TRUE(same_bits(cold, indirect_of(name, {20, 3, 8}, 1))) << name;
        EXPECT_FALSE(same_bits(cold, indirect_of(name, {7}, 1))) << name << ": something moves";
    }
}

TEST(IrradianceCache, SameBytesForAnyNumberOfThreads)
{
    const auto one = indirect_of("cornell", {1, 2}, 1, 128);
    EXPECT_TRUE(same_bits(one, indirect_of("cornell", {1, 2}, 2, 128)));
    EXPECT_TRUE(same_bits(one, indirect_of("cornell", {1, 2}, 5, 128)));
}

// Near light in small images, too, and much of it.
CacheOptions with_near_light()
{
    CacheOptions options;
    options.near_radius = 12;
    options.near_spacing = 100;
    return options;
}

double mean_of(const std::vector<float>& light)
{
    double sum = 0;
    for (const float value : light) sum += static_cast<double>(value);
    return sum / static_cast<double>(light.size());
}

TEST(IrradianceCache, NearLightIsTheSameColdWarmAndForAnyNumberOfThreads)
{
    const CacheOptions near = with_near_light();
    const auto cold = indirect_of("cornell", {8}, 1, 128, near);
    EXPECT_TRUE(same_bits(cold, indirect_of("cornell", {5, 6, 7, 8}, 3, 128, near)));
    EXPECT_TRUE(same_bits(cold, indirect_of("cornell", {20, 3, 8}, 1, 128, near)));
    EXPECT_FALSE(same_bits(cold, indirect_of("cornell", {8}, 1, 128)));
}

// Near light and the rest make up all light, wherever the line between them is drawn.
TEST(IrradianceCache, NearLightNeitherAddsNorTakes)
{
    CacheOptions far;
    far.near_radius = 0;
    const double all = mean_of(indirect_of("cornell", {1}, 2, 128, far)),
                 parted = mean_of(indirect_of("cornell", {1}, 2, 128, with_near_light()));
    EXPECT_NEAR(parted / all, 1, 0.03);
}

// Too little memory costs time; no image shows it, and no more than twice what a frame shows is held.
TEST(IrradianceCache, LittleMemoryChangesNoImage)
{
    const auto walk = [](std::size_t memory, std::size_t& most) {
        World world("kinetic", 1, 2);
        CacheOptions visible_options;
        visible_options.memory = memory;
        IrradianceCache visible(world.state, world.rays, visible_options, world.tasks);
        trace::Remembered remembered;
        remembered.visible = &visible;
        trace::TracedOptions options;
        options.layers = true;
        shading::FrameBuffers buffers;
        for (const int frame : {1, 30, 60, 90, 31}) {
            world.go(frame);
            trace::trace_frame(world.state, world.rays, scene::make_view(world.state, 0, {64, 64}), options,
                               world.tasks, buffers, remembered);
            most = std::max(most, visible.points());
        }
        return buffers.indirect.data;
    };
    std::size_t few = 0, all = 0;
    const auto small = walk(1, few), large = walk(std::size_t{1} << 30, all);
    EXPECT_TRUE(same_bits(small, large));
    EXPECT_LT(few, all);
}

TEST(IrradianceCache, LittleMemoryChangesNoNearLight)
{
    CacheOptions little = with_near_light();
    little.memory = 1;
    EXPECT_TRUE(same_bits(indirect_of("cornell", {5, 6, 7, 8}, 2, 128, with_near_light()),
                          indirect_of("cornell", {5, 6, 7, 8}, 2, 128, little)));
}

// With a limit of rays a frame lacks points; asked again and again it ends in the image that has none.
TEST(IrradianceCache, AFrameWithFewRaysIsWholeInTheEnd)
{
    World world("cornell", 3, 2);
    IrradianceCache visible(world.state, world.rays, with_near_light(), world.tasks);
    visible.limit_rays(1 << 14);
    trace::Remembered remembered;
    remembered.visible = &visible;
    trace::TracedOptions options;
    options.layers = true;
    shading::FrameBuffers buffers;
    constexpr int k_size = 128, k_most = 1000;
    int lacking = 0;
    for (; lacking < k_most; ++lacking) {
        world.go(3);
        trace::trace_frame(world.state, world.rays, scene::make_view(world.state, 0, {k_size, k_size}), options,
                           world.tasks, buffers, remembered);
        // One tile may overrun the limit by what it asks at once.
        if (!visible.lacks_points()) break;
    }
    EXPECT_GT(lacking, 3);
    EXPECT_LT(lacking, k_most);
    EXPECT_TRUE(same_bits(buffers.indirect.data, indirect_of("cornell", {3}, 1, k_size, with_near_light())));
}

// Static surfaces that a camera sees, at every few pixels, with shading as flat as the triangles.
std::vector<irradiance_cache::IndirectPoint> static_points(const World& world, int side,
                                                           std::vector<std::size_t>* pixels = nullptr)
{
    return test::seen_points(world, side, pixels, [&](scene::ObjectId o) { return !world.scene->objects[o].dynamic; });
}

// One level of detail fades into the next, of points on lattices, of parts of triangles and of those that stand for
// small ones, and of near light: as the view comes near, no light jumps.
TEST(IrradianceCache, LightChangesSmoothlyAsTheViewComesNear)
{
    constexpr float k_step = 1.01f;   // 3 % of a fade, which changes light by 5 % of what the two levels differ by
    for (const char* name : {"cornell", "kinetic"}) {
        World world(name, 1, 2);
        IrradianceCache visible(world.state, world.rays, with_near_light(), world.tasks);
        visible.update(world.state, world.rays, world.tasks);
        std::vector<irradiance_cache::IndirectPoint> points = static_points(world, 24);
        ASSERT_GT(points.size(), 200u) << name;
        const auto batch = visible.make_batch();
        std::vector<glm::vec3> light(points.size()), before;
        double sum = 0, largest = 0;
        for (float width = 0.0005f * world.rays.bounds().diagonal(), end = 16 * width; width < end; width *= k_step) {
            for (auto& point : points) point.width = width;
            visible.shade(*batch, points, light.data());
            if (before.empty()) {
                for (const glm::vec3& l : light) sum += static_cast<double>(l.y);
            }
            for (std::size_t i = 0; i < before.size(); ++i) {
                const double by = std::abs(static_cast<double>(light[i].y - before[i].y));
                largest = std::max(largest, by);
            }
            before = light;
        }
        const double mean = sum / static_cast<double>(points.size());
        ASSERT_GT(mean, 0) << name;
        EXPECT_LT(largest / mean, 0.15) << name;
    }
}

// At the foot of walls, straight or at an angle to the lattice, no pixel has the darkness of their far side.
TEST(IrradianceCache, NoDarkPixelsAtTheFootOfWalls)
{
    World world("cornell", 1, 2);
    IrradianceCache visible(world.state, world.rays, with_near_light(), world.tasks);
    visible.update(world.state, world.rays, world.tasks);
    const auto batch = visible.make_batch();
    constexpr int k_size = 512;
    std::vector<std::size_t> pixels;
    const std::vector<irradiance_cache::IndirectPoint> points = static_points(world, k_size, &pixels);
    std::vector<glm::vec3> light(points.size());
    visible.shade(*batch, points, light.data());
    std::vector<std::size_t> at(std::size_t{k_size} * k_size, points.size());   // by pixel
    for (std::size_t i = 0; i < points.size(); ++i) at[pixels[i]] = i;
    int dark = 0, looked_at = 0;
    for (std::size_t y = 1; y + 1 < k_size; ++y)
        for (std::size_t x = 1; x + 1 < k_size; ++x) {
            const std::size_t i = at[y * k_size + x];
            if (i == points.size()) continue;
            float least = k_infinity;
            int alike = 0;
            for (const std::size_t j :
                 {at[(y - 1) * k_size + x], at[(y + 1) * k_size + x], at[y * k_size + x - 1], at[y * k_size + x + 1]}) {
                if (j == points.size() || glm::dot(points[i].normal, points[j].normal) < 0.99f) continue;
                ++alike;
                least = std::min(least, light[j].x + light[j].y + light[j].z);
            }
            if (alike < 2) continue;
            ++looked_at;
            dark += light[i].x + light[i].y + light[i].z < 0.5f * least;
        }
    EXPECT_GT(looked_at, k_size * k_size / 2);
    EXPECT_EQ(dark, 0);
}

TEST(IrradianceCache, RepairedTreeEqualsANewOne)
{
    World world("cornell", 1, 2);
    LightTree repaired(world.state, world.rays, {}, world.tasks);
    std::uint64_t dirty = 0;
    for (const int frame : {2, 3, 7, 40, 39, 12, 12, 13}) {
        world.go(frame);
        repaired.update(world.state, world.rays, world.tasks);
        dirty += repaired.dirty_leaves();
        const LightTree fresh(world.state, world.rays, {}, world.tasks);
        ASSERT_EQ(repaired.size(), fresh.size());
        EXPECT_EQ(repaired.flux().r, fresh.flux().r) << "frame " << frame;
        EXPECT_EQ(repaired.flux().g, fresh.flux().g) << "frame " << frame;
        EXPECT_EQ(repaired.flux().b, fresh.flux().b) << "frame " << frame;
    }
    EXPECT_GT(dirty, 0u);
}

TEST(IrradianceCache, OnlyWhatMovedIsTouched)
{
    World world("cornell", 1, 1);
    LightTree tree(world.state, world.rays, {}, world.tasks);
    world.go(1);
    tree.update(world.state, world.rays, world.tasks);
    EXPECT_EQ(tree.dirty_leaves(), 0u);
    EXPECT_EQ(tree.dirty_nodes(), 0u);
    world.go(2);
    tree.update(world.state, world.rays, world.tasks);
    EXPECT_GT(tree.dirty_leaves(), 0u);
    EXPECT_LT(tree.dirty_leaves(), tree.size() / 50);
}

// The spot lights the red wall, the floor and the back; the ceiling above and the wall opposite see them.
TEST(IrradianceCache, LightComesRoundCornersAndBringsColour)
{
    constexpr int k_size = 64;
    const auto light = indirect_of("cornell", {1}, 2, k_size);
    const auto at = [&](int x, int y) {
        const float* p =
            &light[3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(k_size) + static_cast<std::size_t>(x))];
        return glm::vec3(p[0], p[1], p[2]);
    };
    const glm::vec3 ceiling = at(40, 4), green = at(58, 30), back_left = at(14, 20);
    EXPECT_GT(ceiling.y, 0.002f);
    EXPECT_GT(green.y, 2 * green.x);              // a green wall
    EXPECT_GT(back_left.x, 1.3f * back_left.y);   // beside the lit red wall
    for (const float value : light) ASSERT_TRUE(std::isfinite(value) && value >= 0);
}

TEST(IrradianceCache, NothingComesFromNoLight)
{
    scene::Scene dark = scene::make_builtin("cornell");
    for (scene::Light& light : dark.lights) light.color = glm::vec3(0);
    const auto scene = std::make_shared<const scene::Scene>(std::move(dark));
    scene::SceneState state(scene, 0);
    ray::RayScene rays(state);
    Tasks tasks(1);
    IrradianceCache visible(state, rays, {}, tasks);
    trace::Remembered remembered;
    remembered.visible = &visible;
    trace::TracedOptions options;
    options.layers = true;
    shading::FrameBuffers buffers;
    trace::trace_frame(state, rays, scene::make_view(state, 0, {32, 32}), options, tasks, buffers, remembered);
    for (const float value : buffers.indirect.data) ASSERT_EQ(value, 0);
}

}   // namespace
}   // namespace gnomon
