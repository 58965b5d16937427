// SPDX-License-Identifier: Apache-2.0
// How the reference finds light: the tree that chooses sources, and places that rays from lights meet.
#include <gtest/gtest.h>

#include <random>

#include "reference/source_tree.h"
#include "reference_scenes.h"

namespace gnomon {
namespace {

using reference::IrradianceEstimate;
using reference::IrradiancePoint;
using reference::ReferenceOptions;
using reference::Source;
using reference::SourceTree;
using World = test::ReferenceWorld;

// Small triangles, spots and point lights at random places.
std::vector<Source> random_sources(std::size_t count)
{
    std::mt19937 random(7);
    const auto number = [&] { return static_cast<float>(random() >> 8) * 0x1p-24f; };
    std::vector<Source> sources(count);
    for (std::size_t s = 0; s < count; ++s) {
        Source& source = sources[s];
        source.bounds.add({4 * number(), 4 * number(), 4 * number()});
        source.axis = glm::normalize(glm::vec3(number(), number(), number()) - 0.5f);
        source.power = 0.1f + number();
        source.steady = s % 7 == 0;
        source.reach = static_cast<float>(k_pi / 2);
        if (s % 3 == 0) source.spread = static_cast<float>(k_pi);
        if (s % 3 == 1) source.reach = 0.5f;
        if (s % 3 == 2) source.bounds.add(source.bounds.low + 0.1f), source.two_sided = s % 2 == 0;
    }
    return sources;
}

// Chances add up to 1, are those with which sources are chosen, and are 0 only for sources that send nothing.
TEST(SourceTree, ChancesAreThoseOfChoices)
{
    const std::vector<Source> sources = random_sources(60);
    const SourceTree tree(sources);
    for (const glm::vec3& position : {glm::vec3(1, 1.5f, 2), glm::vec3(-3, 0, 9), glm::vec3(2, 2, 2)}) {
        const glm::vec3 normal = glm::normalize(glm::vec3(0.3f, 1, -0.5f));
        constexpr int k_choices = 200000;
        std::vector<int> chosen(sources.size(), 0);
        int none = 0;
        for (int i = 0; i < k_choices; ++i) {
            const SourceTree::Choice choice = tree.choose(position, normal, (i + 0.5) / k_choices);
            if (!(choice.chance > 0)) {
                ++none;
                continue;
            }
            ++chosen[choice.source];
            ASSERT_NEAR(choice.chance, tree.chance(choice.source, position, normal), 1e-5f * choice.chance);
        }
        for (std::uint32_t s = 0; s < sources.size(); ++s) {
            const double chance = static_cast<double>(tree.chance(s, position, normal));
            EXPECT_NEAR(chosen[s] / static_cast<double>(k_choices), chance, 2e-5 + 1e-3 * chance) << s;
            const glm::vec3 to = sources[s].bounds.centre() - position;
            const float facing = -glm::dot(sources[s].axis, to) / glm::length(to);
            const bool emits = sources[s].spread > 3 || facing > std::cos(sources[s].reach) + 1e-3f ||
                               (sources[s].two_sided && std::abs(facing) > 1e-3f);
            if (glm::dot(to, normal) > 1e-3f && emits) {
                EXPECT_GT(chance, 0) << s;
            }
        }
        EXPECT_LT(none, k_choices / 2);
    }
}

TEST(SourceTree, HoldsOneSourceAndNone)
{
    EXPECT_TRUE(SourceTree(std::span<const Source>{}).empty());
    const std::vector<Source> one = random_sources(1);
    const SourceTree tree(one);
    const SourceTree::Choice choice = tree.choose({0, -1, 0}, {0, 1, 0}, 0.99);
    EXPECT_EQ(choice.source, 0u);
    EXPECT_EQ(choice.chance, 1);
}

scene::Light& add_light(scene::Scene& scene, const glm::vec3& color, const glm::dvec3& at)
{
    scene::Light light;
    light.color = color;
    light.node = scene.add_node("", scene::none, glm::translate(glm::dmat4(1), at));
    scene.lights.push_back(light);
    return scene.lights.back();
}

// 60 lights, chosen by the tree, give what four quarters of them give, whose lights are listed.
TEST(Reference, ManyLightsGiveTheSumOfFew)
{
    const auto scene_with = [](int first, int last) {
        scene::Scene scene = test::closed_room();
        for (int l = first; l < last; ++l) {
            const double turn = 0.7 * l;
            scene::Light& light = add_light(scene, glm::vec3(0.1f * static_cast<float>(1 + l % 5)),
                                            {0.8 * std::cos(turn), 0.03 * l - 0.9, 0.8 * std::sin(turn)});
            if (l % 3 == 1) light.type = scene::LightType::spot;
            if (l % 8 == 2) light.falloff = scene::Falloff::constant;
        }
        return test::finished(scene);
    };
    ReferenceOptions options;
    options.samples = 1 << 13, options.bounces = 2;
    const std::vector<IrradiancePoint> points{test::point_at({0, -0.5f, 0}, {0, -1, 0}),
                                              test::point_at({0.3f, 0.1f, -0.4f}, {0.6f, 0.8f, 0}, 5)};
    const auto together = World(scene_with(0, 60)).irradiance(points, options);
    std::vector<double> sum(2, 0), variance(2, 0);
    for (int quarter = 0; quarter < 4; ++quarter) {
        options.seed = 1 + static_cast<std::uint64_t>(quarter);
        const auto part = World(scene_with(15 * quarter, 15 * quarter + 15)).irradiance(points, options);
        for (std::size_t i = 0; i < 2; ++i) {
            sum[i] += static_cast<double>(part[i].indirect.y);
            variance[i] += std::pow(static_cast<double>(part[i].indirect_error.y), 2);
        }
    }
    for (std::size_t i = 0; i < 2; ++i) {
        const double own = static_cast<double>(together[i].indirect_error.y);
        EXPECT_NEAR(static_cast<double>(together[i].indirect.y), sum[i], 4.5 * std::sqrt(variance[i] + own * own));
        EXPECT_LT(own, 0.01 * sum[i]);
    }
}

// A weak emitter above a floor, and far away a thousand times brighter ones that shine elsewhere: few samples are
// enough, because the tree does not choose those.
TEST(Reference, EmittersThatDoNotReachAPointTakeNoSamples)
{
    scene::Scene scene = test::emitter_scene(1, false);
    for (int i = 0; i < 10; ++i) {
        scene.materials.push_back(scene.materials[1]);
        scene.materials.back().emissive *= 1000.0f;
        scene.meshes.push_back(test::rectangle({0.5f, 0.5f}));
        scene.meshes.edit(scene.meshes.size() - 1).parts[0].material =
            static_cast<scene::MaterialId>(scene.materials.size() - 1);
        test::add_object(scene, static_cast<scene::MeshId>(scene.meshes.size() - 1), scene::none,
                         test::translation(30 + i, 2, 0));   // they shine upwards
    }
    const World world(test::finished(scene));
    ReferenceOptions options;
    options.samples = 256, options.shining = true, options.bounces = 0;
    const IrradianceEstimate e = world.irradiance({test::point_at({0.2f, 0, 0.1f}, {0, 1, 0})}, options)[0];
    const double truth = test::under_emitter({0.2, 0.1}, 1) * static_cast<double>(world.scene->materials[1].emissive.y);
    EXPECT_NEAR(e.surroundings.y, truth, 4.5f * e.error.y + 1e-3 * truth);
    EXPECT_LT(e.error.y, 0.02 * truth);
}

// Irradiance at a point by one bounce on a floor y = 0 with half-width `half` and albedo .5, summed over a grid.
template <class Direct>
double bounced(const IrradiancePoint& point, double half, const Direct& direct)
{
    constexpr int k_cells = 1500;
    double sum = 0;
    for (int i = 0; i < k_cells; ++i)
        for (int j = 0; j < k_cells; ++j) {
            const glm::dvec2 at = half * (glm::dvec2(2 * i + 1, 2 * j + 1) / static_cast<double>(k_cells) - 1.0);
            const glm::dvec3 to = glm::dvec3(at.x, 0, at.y) - glm::dvec3(point.position);
            const double square = glm::dot(to, to), receiver = glm::dot(to, glm::dvec3(point.normal));
            if (receiver > 0) sum += direct(at) * receiver * -to.y / (square * square);
        }
    const double cell = 2 * half / k_cells;
    return 0.5 / k_pi * sum * cell * cell;
}

// Light close to a floor: few paths meet the spot that it lights, but rays from the light do.
TEST(Reference, ABrightSpotIsFoundByRaysFromItsLight)
{
    for (const bool cone : {false, true}) {
        scene::Scene scene;
        scene.materials.resize(1);
        scene.materials[0].base_color = glm::vec3(0.5f);
        scene.meshes.push_back(test::rectangle({1.5f, 1.5f}));
        test::add_object(scene, 0);
        const glm::dvec3 place(0.3, 0.05, 0);
        scene::Light& light = add_light(scene, glm::vec3(1), place);
        if (cone) {
            light.type = scene::LightType::spot;
            light.profile = scene::SpotProfile::cosine;
            scene.nodes[light.node].local =
                glm::inverse(glm::lookAt(place, place - glm::dvec3(0, 1, 0), glm::dvec3(0, 0, 1)));
        }
        const World world(test::finished(scene));
        const IrradiancePoint point = test::point_at({0, 0.7f, 0.1f}, glm::normalize(glm::vec3(0.2f, -1, 0)));
        const double truth = bounced(point, 1.5, [&](const glm::dvec2& at) {
            const glm::dvec3 to = place - glm::dvec3(at.x, 0, at.y);
            const double square = glm::dot(to, to), cosine = to.y / std::sqrt(square);
            if (!cone) return cosine / square;
            return cosine > std::cos(k_pi / 4) ? cosine * cosine / square : 0.0;
        });
        ReferenceOptions options;
        options.samples = 1024;
        const IrradianceEstimate e = world.irradiance({point}, options)[0];
        EXPECT_NEAR(e.indirect.y, truth, 4.5f * e.indirect_error.y + 2e-3 * truth) << cone;
        EXPECT_LT(e.indirect_error.y, 0.01 * truth) << cone;
    }
}

// The same of an emissive surface, by its samples and by paths that meet it.
TEST(Reference, AnEmitterOverAFloorGivesTheIntegralOfItsBounce)
{
    for (const double height : {0.2, 1.0})
        for (const bool double_sided : {false, true}) {
            scene::Scene scene = test::emitter_scene(height, double_sided);
            scene.materials[0].base_color = glm::vec3(0.5f);
            scene.meshes.push_back(test::rectangle({3, 3}));
            test::add_object(scene, 1);
            const World world(test::finished(scene));
            // Below the emitter's height, so that nothing is in between.
            const IrradiancePoint point =
                test::point_at({1.5f, static_cast<float>(0.5 * height), 0.2f}, glm::normalize(glm::vec3(-1, -0.1f, 0)));
            const double truth = bounced(point, 3, [&](const glm::dvec2& at) {
                return test::under_emitter(at, height) * static_cast<double>(world.scene->materials[1].emissive.y);
            });
            ReferenceOptions options;
            options.samples = 1 << 13, options.shining = true;
            const IrradianceEstimate e = world.irradiance({point}, options)[0];
            EXPECT_NEAR(e.indirect.y, truth, 4.5f * e.indirect_error.y + 2e-3 * truth) << height << double_sided;
            EXPECT_LT(e.indirect_error.y, 0.06 * truth) << height << double_sided;
        }
}

// A plate that shines up into a narrow gap below the ceiling, too: independent runs differ by the reported error.
TEST(Reference, RunsInARoomWithAGapAboveItsLightDifferByTheReportedError)
{
    scene::Scene scene = test::closed_room();
    scene.materials[0].base_color = glm::vec3(0.5f);
    scene.materials.push_back(scene.materials[0]);
    scene.materials[1].emissive = glm::vec3(10);
    scene.meshes.push_back(test::rectangle({0.25f, 0.25f}));
    scene.meshes.edit(scene.meshes.size() - 1).parts[0].material = 1;
    test::add_object(scene, static_cast<scene::MeshId>(scene.meshes.size() - 1), scene::none,
                     test::translation(0, 0.995, 0));
    const World world(test::finished(scene));
    std::vector<IrradiancePoint> points;
    for (int i = 0; i < 400; ++i) {
        const float x = 0.09f * static_cast<float>(i % 20) - 0.85f, y = 0.09f * static_cast<float>(i / 20) - 0.85f;
        points.push_back(i % 2 ? test::point_at({x, -1, y}, {0, 1, 0}, points.size())
                               : test::point_at({-1, x, y}, {1, 0, 0}, points.size()));
        points.back().offset = 1e-5f;
    }
    ReferenceOptions options;
    options.samples = 512, options.shining = true, options.bounces = 32;
    const auto a = world.irradiance(points, options);
    options.seed = 1;
    const auto b = world.irradiance(points, options);
    double square = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const double z = static_cast<double>(a[i].indirect.y - b[i].indirect.y) /
                         std::hypot(a[i].indirect_error.y, b[i].indirect_error.y);
        square += z * z;
    }
    // Of errors with 7 degrees of freedom each.
    EXPECT_NEAR(square / static_cast<double>(points.size()), 14.0 / 12, 0.35);
}

}   // namespace
}   // namespace gnomon
