// SPDX-License-Identifier: Apache-2.0
// The irradiance cache: the same bytes after any frames and for any number of threads, updated light trees equal to new
// ones, and indirect light where it must be.
#include <gtest/gtest.h>

#include "base/bits.h"
#include "irradiance_cache/irradiance_cache.h"
#include "seen_points.h"
#include "trace/indirect_lights.h"
#include "trace/traced_frame.h"
#include "world.h"

namespace gnomon {
namespace {

using irradiance_cache::CacheOptions;
using irradiance_cache::IrradianceCache;
using irradiance_cache::LightTree;
using test::World;

// The indirect layer of the last of some frames.
std::vector<float> indirect_of(const char* name, std::vector<int> frames, int threads, int size = 64,
                               const CacheOptions& visible_options = {})
{
    World world(name, frames.front(), threads);
    IrradianceCache visible(world.state, world.rays, visible_options, world.tasks);
    trace::CachedIndirect indirect(visible);
    trace::TracedOptions options;
    options.layers = true;
    shading::FrameBuffers buffers;
    for (std::size_t f = 0; f < frames.size(); ++f) {
        if (f > 0) world.go(frames[f]);
        trace::trace_frame(world.state, world.rays, scene::make_view(world.state, 0, {size, size}), options,
                           world.tasks, buffers, {nullptr, &indirect});
    }
    return buffers.indirect.data;
}

TEST(IrradianceCache, SameBytesAfterAnyFrames)
{
    const auto cold = indirect_of("cornell", {8}, 1);
    EXPECT_TRUE(same_bits(cold, indirect_of("cornell", {20, 6, 7, 8}, 1)));
    EXPECT_FALSE(same_bits(cold, indirect_of("cornell", {7}, 1))) << "dynamic objects move";
    EXPECT_TRUE(same_bits(indirect_of("kinetic", {8}, 2, 32), indirect_of("kinetic", {20, 7, 8}, 2, 32)));
}

TEST(IrradianceCache, SameBytesForAnyThreadCount)
{
    const auto one = indirect_of("cornell", {1, 2}, 1, 128);
    EXPECT_TRUE(same_bits(one, indirect_of("cornell", {1, 2}, 2, 128)));
    EXPECT_TRUE(same_bits(one, indirect_of("cornell", {1, 2}, 5, 128)));
}

// A large near field, in small images, too.
CacheOptions with_near_field()
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

TEST(IrradianceCache, NearFieldHasSameBytesAfterAnyFramesAndForAnyThreadCount)
{
    const CacheOptions near = with_near_field();
    const auto cold = indirect_of("cornell", {8}, 1, 128, near);
    EXPECT_TRUE(same_bits(cold, indirect_of("cornell", {5, 6, 7, 8}, 3, 128, near)));
    EXPECT_TRUE(same_bits(cold, indirect_of("cornell", {20, 3, 8}, 1, 128, near)));
    EXPECT_FALSE(same_bits(cold, indirect_of("cornell", {8}, 1, 128)));
}

// The near field and the light tree sum to the same light for any radius of the near field.
TEST(IrradianceCache, NearFieldPreservesTotalLight)
{
    CacheOptions far;
    far.near_radius = 0;
    const double all = mean_of(indirect_of("cornell", {1}, 2, 128, far)),
                 parted = mean_of(indirect_of("cornell", {1}, 2, 128, with_near_field()));
    EXPECT_NEAR(parted / all, 1, 0.03);
}

// Light is interpolated between near-field points: along the corner of two walls it is even.
TEST(IrradianceCache, NearFieldHasNoFacets)
{
    constexpr int k_size = 128;
    const std::vector<float> light = indirect_of("cornell", {8}, 2, k_size, with_near_field());
    double uneven = 0, all = 0;
    for (int y = 26; y < 60; ++y)
        for (int x = 21; x < 24; ++x) {   // of the back wall, beside the left one
            const auto at = [&](int i) {
                return static_cast<double>(light[static_cast<std::size_t>(3 * (k_size * (y + i) + x))]);
            };
            uneven += std::abs(at(0) - (at(-1) + at(1)) / 2);
            all += at(0);
        }
    std::printf("%.5f of %.4f\n", uneven / all, all / (34 * 3));
    EXPECT_LT(uneven, 0.005 * all);
}

// Points of which a mean is shown share cache points also where those that lie far apart are hidden or dark.
TEST(IrradianceCache, PointsOfAMeanOnSmallTrianglesShareCachePoints)
{
    std::size_t made[2];
    double mean[2];
    for (const bool of_many : {false, true}) {
        World world("spheres?objects=40&dynamic=0");
        IrradianceCache cache(world.state, world.rays, {}, world.tasks);
        cache.update(world.state, world.rays, world.tasks);
        std::vector<irradiance_cache::IndirectPoint> points;
        for (scene::ObjectId o = 0; o < world.scene->objects.size(); ++o) {
            const ray::ObjectGeometry& geometry = world.rays.geometry(o);
            const auto triangles = static_cast<std::uint32_t>(geometry.mesh->triangles.size());
            if (triangles < 1000) continue;   // of the cube around
            glm::vec3 p[3];
            Box3 box;
            for (std::uint32_t t = 0; t < triangles; ++t) {
                geometry.corners(t, p);
                for (const glm::vec3& corner : p) box.add(corner);
            }
            for (std::uint32_t t = 0; t < triangles; t += 3) {
                geometry.corners(t, p);
                const glm::vec3 cross = glm::cross(p[1] - p[0], p[2] - p[0]);
                if (!(glm::length(cross) > 0)) continue;
                const glm::vec3 normal = glm::normalize(geometry.mirrored ? -cross : cross);
                points.push_back({(p[0] + p[1] + p[2]) / 3.0f, normal, normal, o, t, 1 / 3.0f, 1 / 3.0f,
                                  0.1f * box.diagonal(), glm::vec3(0)});
                points.back().of_many = of_many;
            }
        }
        ASSERT_GT(points.size(), 10000u);
        std::vector<glm::vec3> irradiance(points.size());
        const auto batch = cache.make_batch();
        ASSERT_TRUE(cache.shade(*batch, points, irradiance.data()));
        made[of_many] = cache.points();
        mean[of_many] = 0;
        for (const glm::vec3& light : irradiance) mean[of_many] += static_cast<double>(luminance(light));
    }
    std::printf("%zu cache points instead of %zu, mean light %.3f\n", made[1], made[0], mean[1] / mean[0]);
    EXPECT_LT(made[1], made[0] * 3 / 4);
    EXPECT_NEAR(mean[1] / mean[0], 1, .03);
}

// A memory limit costs time but changes no frame; at most twice the points of a frame are kept.
TEST(IrradianceCache, MemoryLimitChangesNoFrame)
{
    const auto walk = [](std::size_t memory, std::size_t& most) {
        World world("kinetic", 1, 2);
        CacheOptions visible_options;
        visible_options.memory = visible_options.ample_memory = memory;
        IrradianceCache visible(world.state, world.rays, visible_options, world.tasks);
        trace::CachedIndirect indirect(visible);
        trace::TracedOptions options;
        options.layers = true;
        shading::FrameBuffers buffers;
        for (const int frame : {1, 30, 60, 90, 31}) {
            world.go(frame);
            trace::trace_frame(world.state, world.rays, scene::make_view(world.state, 0, {64, 64}), options,
                               world.tasks, buffers, {nullptr, &indirect});
            most = std::max(most, visible.points());
        }
        return buffers.indirect.data;
    };
    std::size_t few = 0, all = 0;
    const auto small = walk(1, few), large = walk(std::size_t{1} << 30, all);
    EXPECT_TRUE(same_bits(small, large));
    EXPECT_LT(few, all);
}

TEST(IrradianceCache, MemoryLimitChangesNoNearField)
{
    CacheOptions little = with_near_field();
    little.memory = little.ample_memory = 1;
    EXPECT_TRUE(same_bits(indirect_of("cornell", {5, 6, 7, 8}, 2, 128, with_near_field()),
                          indirect_of("cornell", {5, 6, 7, 8}, 2, 128, little)));
}

// With a limit of rays, a frame defers points; repeating it converges to the frame without a limit. A frame casts about
// as many as that, once it knows what a point costs.
TEST(IrradianceCache, LimitedRaysConvergeToTheFullFrame)
{
    World world("cornell", 3, 2);
    IrradianceCache visible(world.state, world.rays, with_near_field(), world.tasks);
    visible.limit_rays(1 << 14);
    trace::CachedIndirect indirect(visible);
    trace::TracedOptions options;
    options.layers = true;
    shading::FrameBuffers buffers;
    constexpr int k_size = 128, k_most = 1000;
    std::uint64_t most_rays = 0;
    int lacking = 0;
    for (; lacking < k_most; ++lacking) {
        world.go(3);
        trace::trace_frame(world.state, world.rays, scene::make_view(world.state, 0, {k_size, k_size}), options,
                           world.tasks, buffers, {nullptr, &indirect});
        if (lacking > 0) most_rays = std::max(most_rays, visible.counters().rays);
        if (!visible.lacks_points()) break;
    }
    EXPECT_LT(most_rays, 3u << 13);
    EXPECT_GT(lacking, 3);
    EXPECT_LT(lacking, k_most);
    EXPECT_TRUE(same_bits(buffers.indirect.data, indirect_of("cornell", {3}, 1, k_size, with_near_field())));
}

// The mean bounced light of a frame of Cornell's box with all bounces.
double mean_of_all_bounces(std::uint64_t rays)
{
    World world("cornell", 3, 2);
    IrradianceCache visible(world.state, world.rays, irradiance_cache::options_for_bounces(1000, false), world.tasks);
    visible.limit_rays(rays);
    trace::CachedIndirect indirect(visible);
    trace::TracedOptions options;
    options.layers = true;
    shading::FrameBuffers buffers;
    world.go(3);
    trace::trace_frame(world.state, world.rays, scene::make_view(world.state, 0, {96, 96}), options, world.tasks,
                       buffers, {nullptr, &indirect});
    EXPECT_EQ(visible.lacks_points(), rays > 0);
    double sum = 0;
    for (const float value : buffers.indirect.data) sum += static_cast<double>(value);
    return sum / static_cast<double>(buffers.indirect.data.size());
}

// What stands for nearly all points of the first frame brings as much light as they do.
TEST(IrradianceCache, RoughLightBringsTheLightOfMissingPoints)
{
    EXPECT_NEAR(mean_of_all_bounces(1 << 10) / mean_of_all_bounces(0), 1, 0.08);
}

// Points on static surfaces that a camera sees, every few pixels, with geometric normals for shading.
std::vector<irradiance_cache::IndirectPoint> static_points(const World& world, int side,
                                                           std::vector<std::size_t>* pixels = nullptr)
{
    return test::seen_points(world, side, pixels, [&](scene::ObjectId o) { return !world.scene->objects[o].dynamic; });
}

// Levels of detail fade into each other, for lattice points, parts of triangles, clusters of small triangles, and the
// near field; so irradiance changes continuously with the distance.
TEST(IrradianceCache, IrradianceIsContinuousInViewDistance)
{
    constexpr float k_step = 1.01f;   // 3 % of a fade, which changes light by 5 % of the difference between two levels
    for (const char* name : {"cornell", "kinetic"}) {
        World world(name, 1, 2);
        IrradianceCache visible(world.state, world.rays, with_near_field(), world.tasks);
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

// At the foot of walls, aligned with the lattice or not, no pixel is as dark as the far side of the wall.
TEST(IrradianceCache, NoDarkPixelsAtTheFootOfWalls)
{
    World world("cornell", 1, 2);
    IrradianceCache visible(world.state, world.rays, with_near_field(), world.tasks);
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

// A node's flux is that of its children, summed in their order, so that none is lost or old.
void expect_sums_of_children(const LightTree& tree, int frame)
{
    for (const LightTree::Flux* flux : {&tree.flux(), &tree.static_flux()}) {
        std::size_t wrong = 0, inner = 0;
        for (irradiance_cache::NodeId id = 0; id < tree.first_patch(); ++id) {
            if (tree.children(id) == scene::none) continue;
            glm::vec3 sum(0);
            for (irradiance_cache::NodeId k = 0; k < 4; ++k) sum += flux->at(4 * tree.children(id) + k);
            wrong += sum != flux->at(id), ++inner;
        }
        EXPECT_EQ(wrong, 0u) << "frame " << frame;
        EXPECT_GT(inner, 1000u);
    }
}

TEST(LightTree, UpdatedTreeEqualsNewTree)
{
    World world("cornell", 1, 2);
    LightTree updated(world.state, world.rays, {}, world.tasks);
    std::uint64_t dirty = 0;
    for (const int frame : {2, 3, 7, 40, 39, 12, 12, 13}) {
        world.go(frame);
        updated.update(world.state, world.rays, world.tasks);
        dirty += updated.dirty_leaves();
        expect_sums_of_children(updated, frame);
        const LightTree fresh(world.state, world.rays, {}, world.tasks);
        ASSERT_EQ(updated.size(), fresh.size());
        EXPECT_EQ(updated.flux().r, fresh.flux().r) << "frame " << frame;
        EXPECT_EQ(updated.flux().g, fresh.flux().g) << "frame " << frame;
        EXPECT_EQ(updated.flux().b, fresh.flux().b) << "frame " << frame;
    }
    EXPECT_GT(dirty, 0u);
}

// Lights that approximate an environment image shine into no views: cells and patches have the image itself.
TEST(LightTree, HasNoViewsOfAnEnvironment)
{
    for (const bool of_environment : {false, true}) {
        scene::Scene scene = scene::make_builtin("cornell");
        for (scene::Light& light : scene.lights) light.of_environment = of_environment;
        World world(std::move(scene));
        const LightTree tree(world.state, world.rays, {}, world.tasks);
        EXPECT_EQ(tree.first_patch() > 1000, !of_environment);
        EXPECT_EQ(tree.first_patch() == 0, of_environment);
    }
}

TEST(LightTree, UpdateTouchesOnlyLeavesNearDynamicObjects)
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

// The spot light illuminates the red wall, the floor and the back wall, which the ceiling and the green wall see.
TEST(IrradianceCache, LightReachesHiddenSurfacesAndCarriesColour)
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

TEST(IrradianceCache, NoIrradianceWithoutLights)
{
    scene::Scene dark = scene::make_builtin("cornell");
    for (scene::Light& light : dark.lights) light.color = glm::vec3(0);
    const auto scene = std::make_shared<const scene::Scene>(std::move(dark));
    scene::SceneState state(scene, 0);
    ray::RayScene rays(state);
    Tasks tasks(1);
    IrradianceCache visible(state, rays, {}, tasks);
    trace::CachedIndirect indirect(visible);
    trace::TracedOptions options;
    options.layers = true;
    shading::FrameBuffers buffers;
    trace::trace_frame(state, rays, scene::make_view(state, 0, {32, 32}), options, tasks, buffers,
                       {nullptr, &indirect});
    for (const float value : buffers.indirect.data) ASSERT_EQ(value, 0);
}

}   // namespace
}   // namespace gnomon
