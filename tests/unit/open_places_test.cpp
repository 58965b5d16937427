// SPDX-License-Identifier: Apache-2.0
// Which places of static surfaces dynamic objects cover.
#include "patches/open_places.h"

#include <gtest/gtest.h>

#include "world.h"

namespace gnomon::patches {
namespace {

// Adds a box of triangles that face outwards.
scene::MeshId add_box(scene::Scene& made, const glm::vec3& low, const glm::vec3& high)
{
    scene::Mesh mesh;
    for (int corner = 0; corner < 8; ++corner)
        mesh.positions.emplace_back((corner & 1) != 0 ? high.x : low.x, (corner & 2) != 0 ? high.y : low.y,
                                    (corner & 4) != 0 ? high.z : low.z);
    mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 4, 2}, {2, 4, 6},
                      {1, 3, 5}, {3, 7, 5}, {2, 6, 3}, {3, 6, 7}, {0, 1, 4}, {1, 5, 4}};
    mesh.parts = {{0, 0, 12}};
    made.meshes.push_back(mesh);
    return static_cast<scene::MeshId>(made.meshes.size() - 1);
}

// A slab whose top is at y = 0, and a box that may move on it: 2 wide and 3 high.
test::World slab_and_box(float bottom)
{
    scene::Scene made;
    made.materials.emplace_back();
    for (const char* const name : {"slab", "box"}) made.add_node(name, scene::none);
    made.nodes[0].mesh = add_box(made, {-8, -1, -8}, {8, 0, 8});
    made.nodes[1].mesh = add_box(made, {-1, bottom, -1}, {1, bottom + 3, 1});
    made.nodes[1].animated = true;
    made.finish();
    return test::World(std::move(made));
}

TEST(OpenPlaces, AreThoseThatNoBoxStandsOn)
{
    const test::World world = slab_and_box(0);
    constexpr float k_above = 1e-3f, k_near = 0.1f;
    const auto covered = [&](float x, float z) { return is_covered(world.rays, {x, k_above, z}, {0, 1, 0}, k_near); };
    EXPECT_TRUE(covered(0, 0));
    EXPECT_TRUE(covered(0.95f, -0.95f));
    EXPECT_FALSE(covered(1.05f, 0)) << "beside the box";
    EXPECT_FALSE(covered(4, 4));
}

// Light arrives from the sides below a box that is high above, and next to none below one that all but stands.
TEST(OpenPlaces, LieBelowWhatIsHighAbove)
{
    constexpr float k_above = 1e-3f, k_near = 0.1f;
    const test::World high = slab_and_box(1), low = slab_and_box(0.05f);
    EXPECT_FALSE(is_covered(high.rays, {0, k_above, 0}, {0, 1, 0}, k_near));
    EXPECT_TRUE(is_covered(low.rays, {0, k_above, 0}, {0, 1, 0}, k_near));
}

// The patches around the box's foot are open in part, those below not at all, and those farther away as a whole.
TEST(OpenPlaces, ArePartsOfPatches)
{
    test::World world = slab_and_box(0);
    const SurfacePatches patches(world.state, world.rays, {}, world.tasks);
    const std::vector<float> open =
        open_parts(patches, world.rays, std::vector<BoundingSphere>{{{0, 1.5f, 0}, 2.1f}}, world.tasks);
    ASSERT_EQ(open.size(), patches.patches().size());
    int whole = 0, part = 0, none = 0;
    for (std::size_t p = 0; p < open.size(); ++p) {
        const glm::vec3& at = patches.patches()[p].position;
        if (patches.patches()[p].normal.y < 0.9f || at.y < -0.5f) continue;   // the slab has an inside, too
        const float far = std::max(std::abs(at.x), std::abs(at.z));
        if (far > 1 + patches.patches()[p].radius) {
            EXPECT_EQ(open[p], 1) << at.x << ' ' << at.z;
        }
        if (far < 1 - patches.patches()[p].radius) {
            EXPECT_EQ(open[p], 0) << at.x << ' ' << at.z;
        }
        ++(open[p] == 1 ? whole : open[p] == 0 ? none : part);
    }
    EXPECT_GT(whole, 0);
    EXPECT_GT(part, 0);
    EXPECT_GT(none, 0);
    EXPECT_TRUE(open_parts(patches, world.rays, {}, world.tasks).empty());
}

}   // namespace
}   // namespace gnomon::patches
