// SPDX-License-Identifier: Apache-2.0
// Frames lit by light maps: the same bytes after any earlier frames and for any thread count; sparse receivers
// approximate the sum at every pixel, and are kept while nothing moves.
#include <gtest/gtest.h>

#include "light_quadtree/map_light.h"
#include "scene/builtin/builtin.h"
#include "trace/indirect_lights.h"
#include "trace/traced_frame.h"

namespace gnomon {
namespace {

using light_quadtree::MapLight;
using light_quadtree::MapLightOptions;
using light_quadtree::MapMethod;

struct Lit {
    std::vector<float> indirect;
    light_quadtree::MapLightCounters counters;
};

MapLightOptions small(MapMethod method, int grid)
{
    MapLightOptions options;
    options.method = method;
    options.map.side = 128;
    options.grid = grid;
    return options;
}

// The indirect layer of the last of several frames.
Lit lit_after(const std::vector<int>& frames, int threads, const MapLightOptions& options, int size = 96)
{
    const auto scene = std::make_shared<const scene::Scene>(scene::make_builtin("cornell"));
    scene::SceneState state(scene, scene->timeline.time_of(frames.front()));
    ray::RayScene rays(state);
    Tasks tasks(threads);
    MapLight light(state, rays, options, tasks);
    trace::MapIndirect indirect(light);
    trace::TracedOptions traced;
    traced.layers = true;
    shading::FrameBuffers buffers;
    for (std::size_t f = 0; f < frames.size(); ++f) {
        if (f > 0) {
            state.advance(scene->timeline.time_of(frames[f]));
            rays.update(state);
        }
        trace::trace_frame(state, rays, scene::make_view(state, 0, {size, size}), traced, tasks, buffers,
                           {nullptr, &indirect});
    }
    return {buffers.indirect.data, light.counters()};
}

TEST(MapLight, SameBytesColdAndWarmForAnyThreadCount)
{
    for (const MapMethod method : {MapMethod::quadtree, MapMethod::rsm}) {
        const MapLightOptions options = small(method, 16);
        const Lit cold = lit_after({8}, 1, options);
        EXPECT_EQ(cold.indirect, lit_after({5, 30, 8}, 3, options).indirect);
        EXPECT_NE(cold.indirect, lit_after({20}, 1, options).indirect) << "something moves";
    }
}

// Clusters with shadows, whose visibility is remembered for sparse receivers and for pixels.
TEST(MapLight, RememberedShadowsGiveTheSameBytes)
{
    for (const int grid : {0, 16}) {
        for (const bool separate : {false, true}) {
            MapLightOptions options = small(MapMethod::quadtree, grid);
            options.shadows = true;
            options.levels.limit = 6;
            options.map.separate_trees = separate;
            const Lit cold = lit_after({8}, 1, options, 64), warm = lit_after({6, 7, 8}, 3, options, 64);
            EXPECT_EQ(cold.indirect, warm.indirect) << grid << separate;
            EXPECT_EQ(cold.counters.shadow.pairs, warm.counters.shadow.pairs);
            EXPECT_GE(cold.counters.shadow.cast(), cold.counters.shadow.pairs * 9 / 10);
            EXPECT_LT(warm.counters.shadow.cast(), cold.counters.shadow.cast() / (separate ? 4 : 2))
                << grid << separate;
            EXPECT_NE(cold.indirect, lit_after({8}, 1, small(MapMethod::quadtree, grid), 64).indirect);
        }
    }
}

TEST(MapLight, SparseReceiversApproximateTheSumAtEveryPixel)
{
    const Lit sparse = lit_after({1}, 2, small(MapMethod::quadtree, 24)),
              full = lit_after({1}, 2, small(MapMethod::quadtree, 0));
    EXPECT_GT(sparse.counters.interpolated, 4 * 96 * 96 / 10u);
    EXPECT_EQ(full.counters.interpolated, 0u);
    EXPECT_LT(sparse.counters.gathered, full.counters.gathered);
    double error = 0, mean = 0;
    for (std::size_t i = 0; i < full.indirect.size(); ++i) {
        error += std::abs(static_cast<double>(sparse.indirect[i]) - static_cast<double>(full.indirect[i]));
        mean += static_cast<double>(full.indirect[i]);
    }
    EXPECT_GT(mean, 0);
    EXPECT_LT(error / mean, 0.05);
    EXPECT_GT(error, 0) << "nothing was interpolated";
}

TEST(MapLight, KeepsTheReceiverGridWhileNothingMoves)
{
    const MapLightOptions options = small(MapMethod::quadtree, 24);
    EXPECT_TRUE(lit_after({1, 1}, 1, options).counters.kept_grid);
    EXPECT_FALSE(lit_after({1, 2}, 1, options).counters.kept_grid);
    EXPECT_EQ(lit_after({1, 1}, 1, options).indirect, lit_after({1}, 1, options).indirect);
}

}   // namespace
}   // namespace gnomon
