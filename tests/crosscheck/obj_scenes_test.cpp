// SPDX-License-Identifier: Apache-2.0
// Real OBJ scenes against known triangle counts, published or counted by other programs.
#include <sys/resource.h>

#include <chrono>
#include <cstdio>

#include "io/load.h"
#include "support.h"

namespace gnomon::io {
namespace {

std::uint64_t triangles(const std::filesystem::path& file)
{
    return load_obj(file).statistics().triangles;
}

TEST(ObjScenes, StanfordModelsHavePublishedCounts)
{
    GNOMON_NEED_SCENE(folder, "stanford");
    EXPECT_EQ(triangles(folder / "stanford-bunny.obj"), 69451u);
    EXPECT_EQ(triangles(folder / "buddha_50k_decimated.obj"), 50000u);
}

TEST(ObjScenes, CornellBoxHasKnownCounts)
{
    GNOMON_NEED_SCENE(file, "cornell/embree/cornell_box.obj");
    const scene::Scene scene = load_obj(file);
    EXPECT_EQ(scene.statistics().triangles, 34u);
    const Box3 box = scene.bounds(0);
    EXPECT_NEAR(box.high.x, 556.0f, 1e-3f);
    EXPECT_NEAR(box.high.y, 548.8f, 1e-3f);
    EXPECT_NEAR(box.high.z, 559.2f, 1e-3f);
}

TEST(ObjScenes, SponzaHasKnownCountsAndTextures)
{
    GNOMON_NEED_SCENE(file, "sponza/sponza.obj");
    const auto begin = std::chrono::steady_clock::now();
    const scene::Scene scene = load_obj(file);
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - begin;
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    std::printf("Sponza loaded in %.2f s, peak memory %ld MiB\n", seconds.count(), usage.ru_maxrss / 1024);

    EXPECT_EQ(scene.statistics().triangles, 279163u);
    EXPECT_EQ(scene.materials.size(), 26u);
    for (const std::string& warning : scene.warnings) ADD_FAILURE() << warning;
    // 25 colour images, three of them with a mask; each material that names an image has it.
    EXPECT_EQ(scene.textures.size(), 25u);
    int masked = 0;
    for (const scene::Material& material : scene.materials) {
        if (material.alpha_mode != scene::AlphaMode::mask) continue;
        ++masked;
        EXPECT_TRUE(scene.textures[material.base_color_texture.texture].has_alpha()) << material.name;
    }
    EXPECT_EQ(masked, 3);
}

}   // namespace
}   // namespace gnomon::io
