// SPDX-License-Identifier: Apache-2.0
// The light map and its pyramid: an update equals a rebuild to the bit, updates only texels of moved objects, and the
// map's content agrees with the surfaces.
#include <gtest/gtest.h>

#include "base/bits.h"
#include "base/random.h"
#include "light_quadtree/ball_footprint.h"
#include "light_quadtree/clusters.h"
#include "world.h"

namespace gnomon {
namespace {

using light_quadtree::LightMap;
using light_quadtree::LightMapOptions;
using light_quadtree::LightNode;
using test::World;

// The number of nodes or validity bits that differ, in all trees.
std::size_t differing(const LightMap& a, const LightMap& b)
{
    if (a.nodes().size() != b.nodes().size() || a.trees().size() != b.trees().size()) return ~std::size_t{0};
    std::size_t count = 0;
    for (std::size_t id = 0; id < a.nodes().size(); ++id)
        count += !same_bits(a.node(id), b.node(id)) || a.valid(id) != b.valid(id);
    if (a.trees().size() == 1) return count;
    for (const LightMap::Tree tree : a.trees())
        for (std::size_t v = 0; v < a.views().size(); ++v)
            for (int level = 0; level <= a.views()[v].levels; ++level)
                for (int y = 0; y < 1 << level; ++y)
                    for (int x = 0; x < 1 << level; ++x)
                        count += !same_bits(a.node(tree, a.views()[v], level, x, y),
                                            b.node(tree, b.views()[v], level, x, y)) ||
                                 a.share(tree, a.views()[v], level, x, y) != b.share(tree, b.views()[v], level, x, y);
    return count;
}

// Steps through random frames and compares with a rebuilt map in each.
void follow_random_frames(const char* name, int frames, int side, std::uint64_t seed, bool separate_trees = false)
{
    World world(scene::make_builtin(name));
    LightMapOptions options;
    options.side = side;
    options.separate_trees = separate_trees;
    LightMap repaired(world.state, world.rays, options, world.tasks);
    Random random(seed);
    std::uint64_t dirty = 0;
    for (int k = 0; k < frames; ++k) {
        const auto count = static_cast<std::uint32_t>(world.scene->timeline.frames);
        world.go(1 + static_cast<int>(random.below(count)));
        repaired.update(world.state, world.rays, world.tasks);
        dirty += repaired.work().dirty_texels;
        const LightMap fresh(world.state, world.rays, options, world.tasks);
        ASSERT_EQ(differing(repaired, fresh), 0u) << name << ", step " << k;
    }
    EXPECT_GT(dirty, 0u) << name;
}

TEST(LightMap, UpdateEqualsARebuild)
{
    follow_random_frames("cornell", 12, 256, 1);
    follow_random_frames("spheres?objects=40&dynamic=25", 6, 128, 2);
    follow_random_frames("kinetic", 3, 64, 3);
}

TEST(LightMap, UpdateOfSeparateTreesEqualsARebuild)
{
    follow_random_frames("cornell", 8, 128, 1, true);
    follow_random_frames("spheres?objects=40&dynamic=25", 4, 128, 2, true);
    follow_random_frames("kinetic", 2, 64, 3, true);
}

// Random spheres, and places within them, as seen by spot and directional lights.
TEST(LightMap, FootprintContainsTheSphere)
{
    Random random(11);
    scene::Light light;
    light_views::SceneBounds bounds;
    bounds.whole.add(glm::vec3(-8)), bounds.whole.add(glm::vec3(8));
    int found = 0, inside = 0;
    for (int k = 0; k < 4000; ++k) {
        light.type = k % 3 == 0   ? scene::LightType::directional
                     : k % 3 == 1 ? scene::LightType::spot
                                  : scene::LightType::point;
        light.outer_angle = random.uniform(0.1f, 1.2f);
        scene::LightState at;
        const auto place = [&](float size) {
            return glm::vec3(random.uniform(-size, size), random.uniform(-size, size), random.uniform(-size, size));
        };
        at.position = place(4), at.direction = glm::normalize(place(1) + glm::vec3(0, 0, 1e-3f));
        const glm::vec3 centre = place(5);
        const float radius = random.uniform(0.01f, 1.5f);
        for (const auto& view : light_views::project(light, at, bounds, 512, {})) {
            const auto rect = light_quadtree::ball_footprint(view, glm::dvec3(centre), static_cast<double>(radius));
            if (!rect) continue;
            ++found;
            for (int i = 0; i < 20; ++i) {
                const glm::vec3 way = glm::normalize(place(1) + glm::vec3(1e-4f));
                const glm::vec4 clip = view.clip_from_world * glm::vec4(centre + radius * way, 1);
                ASSERT_GT(clip.w, 0);
                const glm::vec2 texel = (glm::vec2(clip) / clip.w * 0.5f + 0.5f) * 512.0f;
                if (texel.x < 0 || texel.x > 512 || texel.y < 0 || texel.y > 512) continue;
                ++inside;
                ASSERT_TRUE(texel.x >= static_cast<float>(rect->x0) && texel.x <= static_cast<float>(rect->x1) &&
                            texel.y >= static_cast<float>(rect->y0) && texel.y <= static_cast<float>(rect->y1))
                    << k << ": " << texel.x << " " << texel.y;
            }
        }
    }
    EXPECT_GT(found, 2000);
    EXPECT_GT(inside, 2000);
}

// Rays against dynamic objects, limited to the depth of the static layer, equal rays against everything, at all texels.
TEST(LightMap, StaticAndDynamicLayersEqualTheWholeScene)
{
    for (const char* name : {"cornell", "spheres?objects=40&dynamic=25", "kinetic"}) {
        World world(scene::make_builtin(name));
        LightMapOptions options, whole;
        options.side = whole.side = 128;
        whole.against_everything = true;
        const int last = world.scene->timeline.frames;
        for (const int frame : {1, last / 2, last}) {
            world.go(frame);
            const LightMap layered(world.state, world.rays, options, world.tasks);
            const LightMap reference(world.state, world.rays, whole, world.tasks);
            EXPECT_EQ(differing(layered, reference), 0u) << name << ", frame " << frame;
        }
    }
}

TEST(LightMapFull, UpdateEqualsARebuildOverAThousandFrames)
{
    follow_random_frames("cornell", 1000, 512, 4);
}

TEST(LightMap, UpdatesOnlyTexelsOfMovedObjects)
{
    World world(scene::make_builtin("cornell"));
    LightMap map(world.state, world.rays, {}, world.tasks);
    EXPECT_GE(map.work().cast, 512u * 512u);
    const std::uint32_t version = map.version();
    world.go(1);
    map.update(world.state, world.rays, world.tasks);
    EXPECT_EQ(map.work().cast, 0u);
    EXPECT_EQ(map.version(), version);
    world.go(2);
    map.update(world.state, world.rays, world.tasks);
    EXPECT_GT(map.work().dirty_texels, 0u);
    EXPECT_LT(map.work().cast, 512u * 512u / 20);
    EXPECT_LT(map.work().dirty_nodes, map.nodes().size() / 50);
    EXPECT_GT(map.version(), version);
}

TEST(LightMap, FollowsUserOverridesOfStaticObjects)
{
    World world(scene::make_builtin("cornell"));
    LightMap map(world.state, world.rays, {}, world.tasks);
    const auto& objects = world.scene->objects;
    scene::ObjectId block = scene::none;   // the last one found: not a wall
    for (scene::ObjectId o = 0; o < objects.size(); ++o)
        if (!objects[o].dynamic) block = o;
    ASSERT_NE(block, scene::none);
    for (int k = 1; k <= 3; ++k) {
        glm::dmat4 there = world.state.world(objects[block].node);
        there[3] += glm::dvec4(0.05, 0.1, 0, 0);
        world.state.override_transform(objects[block].node, &there);
        world.go(1 + k);
        map.update(world.state, world.rays, world.tasks);
        EXPECT_GT(map.work().cast, 0u);
        const LightMap fresh(world.state, world.rays, {}, world.tasks);
        EXPECT_EQ(differing(map, fresh), 0u) << k;
    }
}

TEST(LightMap, MovingLightRebuildsItsMap)
{
    World world(scene::make_builtin("cornell"));
    LightMap map(world.state, world.rays, {}, world.tasks);
    glm::dmat4 there(1);
    there[3] = glm::dvec4(0.2, 0.9, 0.1, 1);
    const scene::NodeId node = world.scene->lights[0].node;
    world.state.override_transform(node, &there);
    world.go(3);
    ASSERT_FALSE(world.state.changes().lights_moved.empty());
    map.update(world.state, world.rays, world.tasks);
    const LightMap fresh(world.state, world.rays, {}, world.tasks);
    EXPECT_EQ(differing(map, fresh), 0u);
}

// In a closed room every direction of a point light ends on a surface, so all of its light becomes flux, times the
// albedo.
TEST(LightMap, HoldsAllFluxOfAPointLight)
{
    scene::Scene made = scene::make_builtin("cornell");
    for (scene::Material& material : made.materials) material.base_color = glm::vec3(1);
    for (scene::Light& light : made.lights) {
        light.type = scene::LightType::point;
        light.color = glm::vec3(1, 2, 3);
    }
    World world(std::move(made));
    const LightMap map(world.state, world.rays, {}, world.tasks);
    ASSERT_EQ(map.views().size(), 6u);
    glm::dvec3 sum(0);
    double hit = 0, all = 0;
    for (const LightMap::View& view : map.views()) {
        sum += glm::dvec3(map.node(view.node(0, 0, 0)).flux);
        hit += map.node(view.node(0, 0, 0)).members;
        all += static_cast<double>(view.side()) * view.side();
    }
    EXPECT_LT(hit, all);   // the room is open at the front
    EXPECT_GT(hit, 0.5 * all);
    // Texels of a cube's faces cover unequal solid angles; the open front bounds the sum from above.
    EXPECT_LT(sum.x, 4 * k_pi);
    EXPECT_GT(sum.x, 4 * k_pi * 0.5);
    EXPECT_NEAR(sum.y / sum.x, 2, 1e-3);
    EXPECT_NEAR(sum.z / sum.x, 3, 1e-3);
}

TEST(LightMap, NodeIsInvalidIfItsChildrenDiffer)
{
    using light_quadtree::Validity;
    LightNode four[4];
    for (LightNode& child : four) child.normal = {0, 0, 1}, child.members = 1, child.depth = 0.5f;
    const Validity validity;
    EXPECT_TRUE(is_valid(four, mean_of(four), validity));
    four[2].depth = 0.5f + 0.07f;   // the mean moves by a quarter of that
    EXPECT_FALSE(is_valid(four, mean_of(four), validity));
    four[2].depth = 0.5f + 0.06f;
    EXPECT_TRUE(is_valid(four, mean_of(four), validity));
    four[1].normal = {0, 1, 0};
    EXPECT_FALSE(is_valid(four, mean_of(four), validity));
    four[1] = four[0];
    four[3] = {};   // no hit
    EXPECT_FALSE(is_valid(four, mean_of(four), validity));
    EXPECT_FLOAT_EQ(mean_of(four).normal.z, 1);   // means are taken over texels with a hit
    for (LightNode& child : four) child = {};
    EXPECT_TRUE(is_valid(four, mean_of(four), validity));
}

// While objects move, the tree of static objects keeps its means and its validity; only flux comes and goes. Both trees
// together have the light of the map, and each texel's light is in one of them.
TEST(LightMap, SeparateTreesKeepStaticNodesWhereTheyAre)
{
    for (const char* name : {"cornell", "spheres?objects=40&dynamic=25"}) {
        World world(scene::make_builtin(name));
        LightMapOptions options;
        options.side = 128;
        options.separate_trees = true;
        LightMap map(world.state, world.rays, options, world.tasks);
        const LightMap first = map;
        std::size_t flux_changed = 0, dynamic = 0, moved = 0;
        for (const int frame : {2, 5, 9}) {
            world.go(frame);
            map.update(world.state, world.rays, world.tasks);
            using Tree = LightMap::Tree;
            for (std::size_t v = 0; v < map.views().size(); ++v) {
                const LightMap::View &view = map.views()[v], &then = first.views()[v];
                for (int level = 0; level <= view.levels; ++level)
                    for (int y = 0; y < 1 << level; ++y)
                        for (int x = 0; x < 1 << level; ++x) {
                            LightNode now = map.node(Tree::static_objects, view, level, x, y),
                                      before = first.node(Tree::static_objects, then, level, x, y);
                            flux_changed += now.flux != before.flux;
                            now.flux = before.flux = glm::vec3(0);
                            moved +=
                                !same_bits(now, before) || map.share(Tree::static_objects, view, level, x, y) !=
                                                               first.share(Tree::static_objects, then, level, x, y);
                        }
                double whole = 0;
                for (int y = 0; y < view.side(); ++y)
                    for (int x = 0; x < view.side(); ++x) {
                        const LightNode& texel = map.node(view.node(view.levels, x, y));
                        whole += static_cast<double>(texel.flux.y);
                        const Tree tree = map.tree_of(view, x, y);
                        dynamic += tree == Tree::dynamic_objects;
                        ASSERT_EQ(map.node(tree, view, view.levels, x, y).flux, texel.flux);
                        const Tree other = tree == Tree::dynamic_objects ? Tree::static_objects : Tree::dynamic_objects;
                        ASSERT_EQ(map.node(other, view, view.levels, x, y).flux, glm::vec3(0));
                    }
                const double both = static_cast<double>(map.node(Tree::static_objects, view, 0, 0, 0).flux.y) +
                                    static_cast<double>(map.node(Tree::dynamic_objects, view, 0, 0, 0).flux.y);
                EXPECT_NEAR(both, whole, 1e-4 * whole) << name;
            }
        }
        EXPECT_EQ(moved, 0u) << name;
        EXPECT_GT(flux_changed, 50u) << name;
        EXPECT_GT(dynamic, 50u) << name;
    }
}

// Every texel with flux lies below exactly one cluster, and the flux of the clusters is that of the map.
TEST(LightMap, ClustersAreADisjointCut)
{
    World world(scene::make_builtin("cornell"));
    const LightMap map(world.state, world.rays, {}, world.tasks);
    std::size_t before = 0;
    for (const int level : {6, 5, 4}) {
        light_quadtree::Clusters clusters;
        light_quadtree::find_clusters(map, {7, level}, clusters);
        double flux = 0;
        std::uint64_t members = 0;
        for (std::size_t c = 0; c < clusters.size(); ++c) {
            flux += static_cast<double>(clusters.g[c]) * k_pi;
            members += map.node(clusters.node[c]).members;
        }
        const LightMap::View& view = map.views()[0];
        EXPECT_NEAR(flux / static_cast<double>(map.node(view.node(0, 0, 0)).flux.y), 1, 1e-4);
        EXPECT_LE(members, map.node(view.node(0, 0, 0)).members);
        EXPECT_LE(clusters.size(), std::size_t{1} << (2 * light_quadtree::grid_of_paper_level(level)));
        EXPECT_GT(clusters.size(), before);
        before = clusters.size();
    }
}

}   // namespace
}   // namespace gnomon
