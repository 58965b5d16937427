// SPDX-License-Identifier: Apache-2.0
// What surface points found in the irradiance cache is used again, with the present light, as long as it holds.
#include <gtest/gtest.h>

#include "base/bits.h"
#include "irradiance_cache/irradiance_cache.h"
#include "seen_points.h"
#include "world.h"

namespace gnomon {
namespace {

using irradiance_cache::CacheOptions;
using irradiance_cache::IndirectPoint;
using irradiance_cache::IrradianceCache;
using irradiance_cache::RememberedBatch;
using test::World;

constexpr int k_tile = 32, k_tiles = 2;   // pixels a side, and tiles a side

// The points of static surfaces that a camera sees, by tile. Dynamic objects move through the scene, not through these
// points.
std::vector<std::vector<IndirectPoint>> tiles_of(const World& world)
{
    constexpr int k_side = k_tiles * k_tile;
    std::vector<std::size_t> pixels;
    const std::vector<IndirectPoint> points =
        test::seen_points(world, k_side, &pixels, [&](scene::ObjectId o) { return !world.state.is_dynamic(o); });
    std::vector<std::vector<IndirectPoint>> tiles(k_tiles * k_tiles);
    for (std::size_t i = 0; i < points.size(); ++i) {
        const std::size_t x = pixels[i] % k_side, y = pixels[i] / k_side;
        std::vector<IndirectPoint>& tile = tiles[y / k_tile * k_tiles + x / k_tile];
        tile.push_back(points[i]);
        tile.back().x = static_cast<std::int16_t>(x % k_tile), tile.back().y = static_cast<std::int16_t>(y % k_tile);
    }
    std::erase_if(tiles, [](const std::vector<IndirectPoint>& tile) { return tile.empty(); });
    return tiles;
}

// A cache with what the tiles of an image remember of it.
struct Cached {
    World& world;
    CacheOptions options;
    IrradianceCache cache{world.state, world.rays, options, world.tasks};
    std::vector<std::unique_ptr<RememberedBatch>> remembered;
    std::vector<std::unique_ptr<IrradianceCache::Batch>> batches;

    Cached(World& of, const CacheOptions& with) : world(of), options(with) { batches.push_back(cache.make_batch()); }
    void begin() { cache.update(world.state, world.rays, world.tasks); }
    void end() { cache.end_frame(batches); }

    /// @return  the light of all tiles
    std::vector<glm::vec3> shade_and_remember(const std::vector<std::vector<IndirectPoint>>& tiles)
    {
        std::vector<glm::vec3> all;
        remembered.resize(tiles.size());
        for (std::size_t t = 0; t < tiles.size(); ++t) {
            std::vector<glm::vec3> light(tiles[t].size());
            cache.shade_and_remember(*batches[0], tiles[t], light.data(), remembered[t]);
            all.insert(all.end(), light.begin(), light.end());
        }
        return all;
    }
    /// @return  the same; tiles for which nothing is remembered, or it does not hold, are shaded anew
    std::vector<glm::vec3> shade_again(const std::vector<std::vector<IndirectPoint>>& tiles)
    {
        std::vector<glm::vec3> all;
        held = 0;
        for (std::size_t t = 0; t < tiles.size(); ++t) {
            std::vector<glm::vec3> light(tiles[t].size());
            if (remembered[t] && cache.shade_again(*batches[0], *remembered[t], light.data()))
                ++held;
            else
                cache.shade(*batches[0], tiles[t], light.data());
            all.insert(all.end(), light.begin(), light.end());
        }
        return all;
    }
    int held = 0;   // tiles of the last shade_again() whose memory did
};

// The light of all tiles, of a cache that knows nothing.
std::vector<glm::vec3> light_anew(World& world, const CacheOptions& options,
                                  const std::vector<std::vector<IndirectPoint>>& tiles)
{
    Cached fresh(world, options);
    fresh.begin();
    std::vector<glm::vec3> all;
    for (const std::vector<IndirectPoint>& tile : tiles) {
        std::vector<glm::vec3> light(tile.size());
        fresh.cache.shade(*fresh.batches[0], tile, light.data());
        all.insert(all.end(), light.begin(), light.end());
    }
    return all;
}

bool same(const std::vector<glm::vec3>& a, const std::vector<glm::vec3>& b)
{
    const auto floats = [](const std::vector<glm::vec3>& v) {
        std::vector<float> all;
        for (const glm::vec3& light : v) all.insert(all.end(), {light.x, light.y, light.z});
        return all;
    };
    return same_bits(floats(a), floats(b));
}

void expect_same_as_anew(const char* name, int first, const CacheOptions& options, int frames = 5)
{
    World world(name, first);
    const auto tiles = tiles_of(world);
    Cached cached(world, options);
    std::vector<glm::vec3> before;
    std::size_t cached_points = 0, rest = 0, near = 0, bytes = 0;
    for (int frame = first; frame < first + frames; ++frame) {
        if (frame > first) world.go(frame);
        cached.begin();
        const std::vector<glm::vec3> light =
            frame == first ? cached.shade_and_remember(tiles) : cached.shade_again(tiles);
        cached.end();
        EXPECT_TRUE(same(light, light_anew(world, options, tiles))) << name << ", frame " << frame;
        EXPECT_FALSE(same(light, before)) << "dynamic objects change the light";
        if (frame > first) {
            EXPECT_GT(cached.held, 0) << name << ", frame " << frame;
        }
        before = light;
    }
    for (const auto& batch : cached.remembered)
        if (batch)
            cached_points += batch->cached.size(), rest += batch->rest.size(), near += batch->near.size(),
                bytes += batch->bytes();
    std::printf("%s: %zu cache points, %zu of near fields, %zu surface points anew, %zu bytes in %zu tiles\n", name,
                cached_points, near, rest, bytes, tiles.size());
    EXPECT_GT(cached_points, 0u);
    EXPECT_EQ(near > 0, options.near_radius > 10) << "near fields are wide enough";
}

CacheOptions with_near_field()
{
    CacheOptions options;
    options.near_radius = 12;
    options.near_spacing = 100;
    return options;
}

TEST(RememberedBatch, LightIsThatOfNewLookUps)
{
    CacheOptions far;
    far.near_radius = 0;
    expect_same_as_anew("cornell", 5, far);
    expect_same_as_anew("cornell", 5, with_near_field());
}

TEST(RememberedBatch, LightOfAllBouncesIsThatOfNewLookUps)
{
    expect_same_as_anew("cornell", 5, irradiance_cache::options_for_bounces(1000, false));
}

// Small triangles take light from parts, which are found anew.
TEST(RememberedBatch, LightOfPartsIsThatOfNewLookUps)
{
    CacheOptions far;
    far.near_radius = 0;
    expect_same_as_anew("spheres?objects=40&dynamic=10", 3, far);
}

// Surface points that lie below cache points, and are hidden from some of them.
TEST(RememberedBatch, LightInJointsAndFoldsIsThatOfNewLookUps)
{
    World world("kinetic", 3);
    const auto tiles = tiles_of(world);
    CacheOptions far;
    far.near_radius = 0;
    Cached cached(world, far);
    cached.begin();
    const std::vector<glm::vec3> light = cached.shade_and_remember(tiles);
    cached.end();
    world.go(3);
    cached.begin();
    EXPECT_TRUE(same(cached.shade_again(tiles), light));
    EXPECT_GT(cached.held, 0);
}

// The table drops what the last frame did not use, and keeps what a remembered batch did.
TEST(RememberedBatch, HoldsWithLittleMemory)
{
    CacheOptions little = with_near_field();
    little.memory = little.ample_memory = 1;
    expect_same_as_anew("cornell", 5, little);
}

struct Remembering : testing::Test {
    World world{"cornell", 5};
    std::vector<std::vector<IndirectPoint>> tiles = tiles_of(world);
    Cached cached{world, with_near_field()};

    void SetUp() override
    {
        cached.begin();
        cached.shade_and_remember(tiles);
        cached.end();
    }
    void go(int frame)
    {
        world.go(frame);
        cached.begin();
    }
    void expect_dropped()
    {
        cached.shade_again(tiles);
        EXPECT_EQ(cached.held, 0);
        EXPECT_TRUE(same(cached.shade_and_remember(tiles), light_anew(world, with_near_field(), tiles)));
    }
};

// Its cache points may have been dropped.
TEST_F(Remembering, IsDroppedAfterAFrameWithoutIt)
{
    go(6);
    cached.end();
    go(7);
    expect_dropped();
}

TEST_F(Remembering, IsDroppedWhenALightChanges)
{
    scene::Light brighter = world.state.scene().lights[0];
    brighter.color *= 2.0f;
    world.state.set_light(0, brighter);
    go(6);
    expect_dropped();
}

TEST_F(Remembering, IsDroppedWhenAStaticObjectMoves)
{
    scene::ObjectId block = 0;
    while (world.state.is_dynamic(block)) ++block;
    const scene::NodeId node = world.scene->objects[block].node;
    const glm::dmat4 moved = glm::translate(world.scene->nodes[node].local, glm::dvec3(0.01, 0, 0));
    world.state.override_transform(node, &moved);
    go(6);
    cached.shade_again(tiles);
    EXPECT_EQ(cached.held, 0);
}

TEST_F(Remembering, IsDroppedByAnotherCacheAndWithLimitedRays)
{
    Cached other(world, with_near_field());
    other.remembered.swap(cached.remembered);
    go(6);
    other.begin(), other.end(), other.begin();
    other.shade_again(tiles);
    EXPECT_EQ(other.held, 0);
    other.remembered.swap(cached.remembered);
    cached.cache.limit_rays(1u << 20);
    cached.shade_again(tiles);
    EXPECT_EQ(cached.held, 0);
    cached.shade_and_remember(tiles);
    for (const auto& batch : cached.remembered) EXPECT_FALSE(batch);
}

}   // namespace
}   // namespace gnomon
