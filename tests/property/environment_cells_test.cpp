// SPDX-License-Identifier: Apache-2.0
// Cells of directions, their light in closed form, and proofs of their visibility among random triangles.
// LONG: all share the random worlds, and the rays that proofs are compared with.
#include <gtest/gtest.h>

#include <bit>
#include <functional>

#include "environment_light/cell_light.h"
#include "environment_light/cell_sums.h"
#include "environment_light/cell_visibility.h"
#include "environment_light/environment_light.h"
#include "environment_light/lobe_tables.h"
#include "scene/builtin/builtin.h"
#include "soup.h"

namespace gnomon::environment_light {
namespace {

using visibility::ShadowPoint;

ImageF image_of(int width, int height, const std::function<glm::vec3(const glm::vec3&)>& radiance)
{
    ImageF image(width, height, 3);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const glm::vec3 value = radiance(scene::Environment::direction_at((x + 0.5) / width, (y + 0.5) / height));
            for (int c = 0; c < 3; ++c) image.pixel(x, y)[c] = value[c];
        }
    return image;
}

glm::vec3 any_direction(Random& random)
{
    const float z = random.uniform(-1, 1), a = random.uniform(0, static_cast<float>(2 * k_pi));
    const float r = std::sqrt(1 - z * z);
    return {r * std::cos(a), r * std::sin(a), z};
}

scene::Environment even_sky()
{
    return scene::Environment(image_of(2, 1, [](const glm::vec3&) { return glm::vec3(1, 2, 0.5f); }));
}

// A blue sky, brighter at the horizon, brown ground, and a sun of 3 degrees that brings most of the light.
scene::Environment sunny()
{
    const glm::vec3 sun = glm::normalize(glm::vec3(1, 1.2f, 0.7f));
    return scene::Environment(image_of(512, 256, [&](const glm::vec3& d) {
        if (glm::dot(d, sun) > std::cos(1.5f * static_cast<float>(k_pi) / 180)) return glm::vec3(900, 800, 700);
        return d.y > 0 ? glm::mix(glm::vec3(1, 1, 1.1f), glm::vec3(0.3f, 0.5f, 1), d.y) : glm::vec3(0.2f, 0.15f, 0.1f);
    }));
}

TEST(DirectionCells, AnEvenSkyIsDividedEvenly)
{
    const scene::Environment environment = even_sky();
    const DirectionCells cells(environment);
    EXPECT_EQ(cells.leaves(), 720u);
    double sum = 0, least = 1, most = 0;
    for (std::size_t leaf = 0; leaf < cells.leaves(); ++leaf) {
        const double part = static_cast<double>(cells.flux(leaf).x) / (4 * k_pi);
        sum += part, least = std::min(least, part), most = std::max(most, part);
        EXPECT_NEAR(cells.flux(leaf).y, 2 * cells.flux(leaf).x, 1e-6f);
    }
    EXPECT_NEAR(sum, 1, 1e-5);
    EXPECT_GT(least, 0.7 / 720);
    EXPECT_LT(most, 1.4 / 720);
}

// The directions of leaves lie in their cells, the children of a cell cover it, and every direction is in one leaf.
TEST(DirectionCells, CellsNest)
{
    const scene::Environment environment = sunny();
    const DirectionCells cells(environment);
    const auto contains = [](const DirectionNode& node, const glm::dvec3& d) {
        for (int c = 0; c < node.corners; ++c)
            if (glm::dot(d, glm::cross(node.corner[static_cast<std::size_t>(c)],
                                       node.corner[static_cast<std::size_t>((c + 1) % node.corners)])) < -1e-7)
                return false;
        return true;
    };
    for (const DirectionNode& node : cells.nodes()) {
        for (std::size_t leaf = node.first_leaf; leaf < node.first_leaf + node.leaves; ++leaf) {
            EXPECT_TRUE(contains(node, cells.direction(leaf)));
            EXPECT_TRUE(contains(node, glm::normalize(cells.mean(leaf))));
            EXPECT_GE(glm::dot(node.axis, cells.direction(leaf)), node.cosine);
        }
    }
    Random random(5);
    for (int i = 0; i < 1000; ++i) {
        const glm::dvec3 d(any_direction(random));
        int in = 0;
        for (std::size_t leaf = 0; leaf < cells.leaves(); ++leaf) in += contains(cells.nodes()[cells.node_of(leaf)], d);
        EXPECT_GE(in, 1);
        EXPECT_LE(in, 3);   // at an edge
    }
}

// The parts of a cell lie around its middle, and those above a horizon are marked one by one.
TEST(PartDirections, MarkThePartsAboveAHorizon)
{
    const scene::Environment environment = even_sky();
    const DirectionCells cells(environment);
    const PartDirections parts(cells);
    Random random(6);
    std::size_t divided = 0;
    for (std::size_t leaf = 0; leaf < cells.leaves(); leaf += 7) {
        const glm::vec3 aside = glm::cross(cells.direction(leaf), any_direction(random));
        for (const glm::vec3& normal : {glm::normalize(aside), any_direction(random)}) {
            const float least = random.uniform(0, 0.05f);
            const std::uint64_t above = parts.above(leaf, normal, least);
            for (std::uint32_t part = 0; part < k_parts; ++part) {
                const glm::vec3 direction = parts.direction(leaf, part);
                EXPECT_GT(glm::dot(direction, cells.direction(leaf)), 0.95f);
                EXPECT_EQ((above >> part & 1) != 0, glm::dot(direction, normal) > least);
            }
            divided += above != 0 && above != ~std::uint64_t{0};
        }
    }
    EXPECT_GT(divided, 50u);
}

TEST(DirectionCells, ASunHasCellsOfItsOwn)
{
    const scene::Environment environment = sunny();
    const DirectionCells cells(environment);
    const glm::vec3 sun = glm::normalize(glm::vec3(1, 1.2f, 0.7f));
    int in_sun = 0;
    float most = 0;
    const float all = luminance(cells.total_flux());
    for (std::size_t leaf = 0; leaf < cells.leaves(); ++leaf) {
        in_sun += glm::dot(cells.direction(leaf), sun) > std::cos(0.026f);
        most = std::max(most, luminance(cells.flux(leaf)) / all);
    }
    EXPECT_GT(in_sun, 200);
    EXPECT_LT(most, 1 / 256.0f);
    EXPECT_LE(cells.leaves(), 4096u);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(cells.total_flux()[c] / environment.flux()[c], 1, 0.01) << c;
}

// Cells at a place are the same, however the image is turned.
TEST(DirectionCells, DoNotDependOnTheImage)
{
    const scene::Environment a = even_sky(), b = sunny();
    const DirectionCells one(a), other(b);
    std::size_t same = 0;
    for (std::size_t leaf = 0; leaf < one.leaves(); ++leaf)
        for (std::size_t l = 0; l < other.leaves(); ++l)
            if (one.nodes()[one.node_of(leaf)].place == other.nodes()[other.node_of(l)].place) {
                ++same;
                EXPECT_EQ(one.direction(leaf), other.direction(l));
            }
    EXPECT_GT(same, 600u);
}

// Unoccluded irradiance by brute force: the sum over a fine grid.
glm::dvec3 irradiance_of(const scene::Environment& environment, const glm::vec3& normal)
{
    constexpr int rows = 512, columns = 1024;
    glm::dvec3 sum(0);
    for (int y = 0; y < rows; ++y) {
        const double angle = 2 * k_pi / columns * (std::cos(k_pi * y / rows) - std::cos(k_pi * (y + 1) / rows));
        for (int x = 0; x < columns; ++x) {
            const glm::vec3 d = scene::Environment::direction_at((x + 0.5) / columns, (y + 0.5) / rows);
            const float cosine = glm::dot(d, normal);
            if (cosine > 0) sum += angle * static_cast<double>(cosine) * glm::dvec3(environment.radiance(d));
        }
    }
    return sum;
}

TEST(CellLight, UnoccludedIrradianceIsThatOfTheImage)
{
    Random random(3);
    for (const scene::Environment& environment : {even_sky(), sunny()}) {
        const DirectionCells cells(environment);
        const CellLight light(cells, &environment);
        for (int i = 0; i < 12; ++i) {
            const glm::vec3 normal = any_direction(random);
            const glm::dvec3 truth = irradiance_of(environment, normal);
            const glm::vec3 found = light.irradiance(normal);
            for (int c = 0; c < 3; ++c)
                EXPECT_NEAR(found[c], truth[c], 0.004 * truth[c] + 0.0005 * static_cast<double>(environment.flux()[c]))
                    << i << ' ' << c;
        }
    }
}

TEST(CellLight, VisibleAndHiddenCellsAddUp)
{
    const scene::Environment environment = sunny();
    const DirectionCells cells(environment);
    const CellLight light(cells, &environment);
    Random random(8);
    for (int i = 0; i < 60; ++i) {
        const glm::vec3 normal = any_direction(random);
        std::vector<std::uint64_t> seen(cells.words()), rest(cells.words());
        const std::uint32_t of_eight = random.below(9);
        for (std::size_t leaf = 0; leaf < cells.leaves(); ++leaf)
            (random.below(8) < of_eight ? seen : rest)[leaf / 64] |= std::uint64_t{1} << (leaf % 64);
        const glm::vec3 a = light.irradiance(normal, seen), b = light.irradiance(normal, rest),
                        all = light.irradiance(normal);
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(a[c] + b[c], all[c], 0.004f * all[c] + 1e-4f) << c;
        if (of_eight == 0) {
            EXPECT_EQ(a, glm::vec3(0));
        }
    }
}

// The blurred radiance of an even sky is even, and a lobe that sees everything has all of it.
// Vectors of any width give the bits of a plain loop.
TEST(CellLight, SumsOfALobeAreThoseOfAPlainLoop)
{
    Random random(7);
    constexpr std::size_t k_words = 3;
    std::array<std::vector<float>, 7> list;
    for (auto& values : list)
        for (std::size_t i = 0; i < 64 * k_words; ++i) values.push_back(random.uniform(-1, 1));
    const CellLists cells{{list[0].data(), list[1].data(), list[2].data()},
                          {list[3].data(), list[4].data(), list[5].data()},
                          list[6].data()};
    for (int round = 0; round < 50; ++round) {
        const glm::vec3 v = any_direction(random), n = any_direction(random), g = any_direction(random);
        const float a2 = random.uniform(0.01f, 1), n_v = random.uniform(0.01f, 1);
        const float f0 = round % 2 == 0 ? 1 : random.uniform(0, 1), f90 = round % 2 == 0 ? 1 : random.uniform(0, 1);
        const WeightedLobe lobe{v, n, g, a2, n_v, std::sqrt(a2 + (1 - a2) * n_v * n_v), f0, f90};
        std::array<std::uint64_t, k_words> seen{};
        for (std::uint64_t& word : seen) word = std::uint64_t{random.next()} << 32 | random.next();
        LobeSums plain;
        for (std::size_t leaf = 0; leaf < 64 * k_words; ++leaf) {
            const auto dot = [&](const glm::vec3& a) {
                return a.x * list[0][leaf] + a.y * list[1][leaf] + a.z * list[2][leaf];
            };
            const float n_l = dot(n);
            if (!(n_l > 0) || !(dot(g) > 0)) continue;
            const float half2 = (n_l + n_v) * (n_l + n_v) / std::max(2 + 2 * dot(v), 1e-6f);
            const float d = half2 * (a2 - 1) + 1;
            const float away = 1 - std::sqrt(std::max(0.5f * (1 + dot(v)), 0.0f)), square = away * away;
            const float weight = (f0 + (f90 - f0) * (square * square * away)) *
                                 (n_l / (d * d * (n_l * lobe.masking + n_v * std::sqrt(a2 + (1 - a2) * n_l * n_l))));
            const std::size_t lane = leaf % k_sum_lanes;
            const bool visible = (seen[leaf / 64] >> (leaf % 64) & 1) != 0;
            plain.angles[lane] += weight * list[6][leaf];
            if (visible) plain.visible_angles[lane] += weight * list[6][leaf];
            for (std::size_t c = 0; c < 3; ++c) {
                plain.all[c][lane] += weight * list[3 + c][leaf];
                if (visible) plain.visible[c][lane] += weight * list[3 + c][leaf];
            }
        }
        const LobeSums sums = lobe_sums(lobe, cells, seen);
        EXPECT_EQ(sums.angles, plain.angles) << round;
        EXPECT_EQ(sums.visible_angles, plain.visible_angles) << round;
        EXPECT_EQ(sums.all, plain.all) << round;
        EXPECT_EQ(sums.visible, plain.visible) << round;
    }
}

// Likewise, and whichever leaves the mask has.
TEST(CellLight, SumsOfCosinesAreThoseOfAPlainLoop)
{
    Random random(8);
    constexpr std::size_t k_words = 3;
    std::array<std::vector<float>, 7> list;
    for (std::size_t l = 0; l < list.size(); ++l)
        for (std::size_t i = 0; i < 64 * k_words; ++i)
            list[l].push_back(l < 3 ? random.uniform(-1, 1) : random.uniform(0, 1e6f));
    const UnitLists cells{{list[0].data(), list[1].data(), list[2].data()},
                          {list[3].data(), list[4].data(), list[5].data()},
                          list[6].data()};
    std::size_t added = 0;
    for (int round = 0; round < 50; ++round) {
        const glm::vec3 n = any_direction(random);
        const std::uint64_t flip = round % 2 == 0 ? 0 : ~std::uint64_t{0};
        std::array<std::uint64_t, k_words> mask{}, exists{};
        for (std::uint64_t& word : mask)
            for (int bits = 0; bits < 1 + round; ++bits) word |= std::uint64_t{1} << random.next() % 64;
        for (std::uint64_t& word : exists) word = std::uint64_t{random.next()} << 32 | random.next();
        CosineSums plain;
        for (std::size_t leaf = 0; leaf < 64 * k_words; ++leaf) {
            const float cosine = n.x * list[0][leaf] + n.y * list[1][leaf] + n.z * list[2][leaf];
            if ((((mask[leaf / 64] ^ flip) & exists[leaf / 64]) >> (leaf % 64) & 1) == 0 || !(cosine > 0)) continue;
            ++added;
            for (std::size_t c = 0; c < 3; ++c) plain.flux[c] += static_cast<std::int32_t>(list[3 + c][leaf] * cosine);
            plain.angle += static_cast<std::int32_t>(list[6][leaf] * cosine);
        }
        const CosineSums sums = cosine_sums(n, cells, mask, exists, flip);
        EXPECT_EQ(sums.flux, plain.flux) << round;
        EXPECT_EQ(sums.angle, plain.angle) << round;
    }
    EXPECT_GT(added, 1000u);
}

TEST(CellLight, LobesSeeAnEvenSkyEven)
{
    const scene::Environment environment = even_sky();
    const DirectionCells cells(environment);
    const CellLight light(cells, &environment);
    const std::vector<std::uint64_t> all(cells.words(), ~std::uint64_t{0}), none(cells.words(), 0);
    Random random(9);
    for (int i = 0; i < 50; ++i) {
        const glm::vec3 d = any_direction(random);
        const float roughness = random.uniform(0.05f, 1);
        const glm::vec3 seen = light.blurred(d, roughness);
        EXPECT_NEAR(seen.x, 1, 1e-4f);
        EXPECT_NEAR(seen.y, 2, 1e-4f);
        // Seen from anywhere above the surface.
        const glm::vec3 normal = any_direction(random);
        const glm::vec3 viewer = glm::dot(d, normal) > 0 ? d : -d;
        const Lobe lobe{viewer, glm::reflect(-viewer, normal), normal, normal, roughness};
        const SeenByLobe whole = light.seen_by(lobe, all);
        EXPECT_NEAR(whole.light.x, 1, 1e-4f);
        EXPECT_NEAR(whole.light.y, 2, 2e-4f);
        EXPECT_NEAR(whole.share, 1, 1e-4f);
        EXPECT_EQ(light.seen_by(lobe, none).light, glm::vec3(0));
        // Where it sees the sky, it is as bright, however much of it is hidden.
        std::vector<std::uint64_t> some(cells.words());
        for (std::uint64_t& word : some) word = std::uint64_t{random.next()} << 32 | random.next();
        for (const std::vector<std::uint64_t>& mask : {all, some, none}) {
            const glm::vec3 open = light.seen_by(lobe, mask).open;
            EXPECT_NEAR(open.x, 1, 1e-3f);
            EXPECT_NEAR(open.y, 2, 2e-3f);
        }
    }
}

// What a lobe sees of an uneven sky, against a sum over evenly spaced directions.
TEST(CellLight, LobesSeeAnUnevenSkyAsTheirIntegralDoes)
{
    const auto radiance = [](const glm::vec3& d) {
        return glm::vec3(1 + d.x, d.y > 0 ? 2.0f : 0.5f, std::abs(d.z) * std::abs(d.z));
    };
    const scene::Environment environment(image_of(256, 128, radiance));
    const DirectionCells cells(environment);
    const CellLight light(cells, &environment);
    constexpr int k_rows = 256, k_columns = 512;
    Random random(3);
    for (const float roughness : {0.22f, 0.45f, 0.65f})
        for (int i = 0; i < 8; ++i) {
            const glm::vec3 around = any_direction(random);
            const float a2 = roughness * roughness * roughness * roughness;
            glm::dvec3 sum(0);
            double weights = 0;
            for (int row = 0; row < k_rows; ++row)
                for (int column = 0; column < k_columns; ++column) {
                    const double up = 1 - (2 * row + 1.0) / k_rows, angle = 2 * k_pi * (column + 0.5) / k_columns;
                    const double across = std::sqrt(1 - up * up);
                    const glm::vec3 d(glm::dvec3(across * std::cos(angle), up, across * std::sin(angle)));
                    const float cosine = glm::dot(d, around), t = 0.5f * (1 + cosine) * (a2 - 1) + 1;
                    if (!(cosine > 0)) continue;
                    const float shadowing = 0.5f * (1 + std::sqrt(1 + a2 * (1 / (cosine * cosine) - 1)));
                    const auto weight = static_cast<double>(1 / (t * t * shadowing));
                    sum += weight * glm::dvec3(radiance(d)), weights += weight;
                }
            const glm::vec3 seen = light.blurred(around, roughness);
            for (int c = 0; c < 3; ++c)
                EXPECT_NEAR(static_cast<double>(seen[c]), sum[c] / weights, 0.04) << roughness << ' ' << i << ' ' << c;
        }
}

// What a lobe on a surface that faces up sees of surroundings, at a slant in radians: their mean by the distribution of
// the microfacets' normals, with masking and shadowing [Heitz 2014] and reflectance [Schlick 1994].
template <class Radiance>
double lobe_integral(const Radiance& radiance, double slant, double roughness, double f0)
{
    constexpr int k_rows = 512, k_columns = 1024;
    const double a2 = std::pow(roughness, 4);
    const auto lambda = [&](double cosine) { return 0.5 * (std::sqrt(1 + a2 * (1 / (cosine * cosine) - 1)) - 1); };
    const glm::dvec3 viewer(std::sin(slant), std::cos(slant), 0);
    double sum = 0, weights = 0;
    for (int row = 0; row < k_rows; ++row)
        for (int column = 0; column < k_columns; ++column) {
            const double up = (row + 0.5) / k_rows, angle = 2 * k_pi * (column + 0.5) / k_columns;
            const double across = std::sqrt(1 - up * up);
            const glm::dvec3 d(across * std::cos(angle), up, across * std::sin(angle));
            const glm::dvec3 h = glm::normalize(d + viewer);
            const double t = h.y * h.y * (a2 - 1) + 1, fresnel = f0 + (1 - f0) * std::pow(1 - glm::dot(h, viewer), 5);
            const double weight = fresnel / (t * t * (1 + lambda(up) + lambda(viewer.y)));
            sum += weight * static_cast<double>(radiance(glm::vec3(d)).x), weights += weight;
        }
    return sum / weights;
}

// Of a bright ring in a dark surrounding, from a slant.
TEST(LobeTables, LobesAtASlantSeeABrightRingAsTheirIntegralDoes)
{
    const auto radiance = [](const glm::vec3& d) { return glm::vec3(d.y > 0.64f && d.y < 0.87f ? 8.0f : 0.125f); };
    const scene::Environment environment(image_of(1024, 512, radiance));
    LobeTables tables(environment);
    for (const float roughness : {0.2f, 0.3f, 0.4f})
        for (const double degrees : {0.0, 30.0, 45.0, 60.0, 75.0}) {
            const double slant = degrees * k_pi / 180;
            const glm::vec3 viewer(glm::dvec3(std::sin(slant), std::cos(slant), 0));
            const glm::vec3 seen =
                tables.reflected(viewer, {0, 1, 0}, glm::vec3(-viewer.x, viewer.y, viewer.z), roughness, {});
            const double truth = lobe_integral(radiance, slant, static_cast<double>(roughness), 1);
            EXPECT_NEAR(static_cast<double>(seen.x) / truth, 1, 0.1) << roughness << ' ' << degrees;
        }
}

// Surroundings that are bright above and dim at the horizon, by lobes of any width of a dielectric: weighted by what it
// reflects. The mean of all of the lobe was up to 1.5 times as bright.
TEST(CellLight, DielectricsReflectMoreOfWhatIsLow)
{
    const auto radiance = [](const glm::vec3& d) { return glm::vec3(0.2f + 4 * std::max(d.y, 0.0f)); };
    const scene::Environment environment(image_of(512, 256, radiance));
    const DirectionCells cells(environment);
    const CellLight light(cells, &environment);
    const std::vector<std::uint64_t> seen((cells.leaves() + 63) / 64, ~std::uint64_t{0});
    for (const float roughness : {0.2f, 0.35f, 0.5f, 0.7f, 1.0f})
        for (const double degrees : {30.0, 60.0, 75.0, 82.0}) {
            const double slant = degrees * k_pi / 180;
            const glm::vec3 viewer(glm::dvec3(std::sin(slant), std::cos(slant), 0));
            const SeenByLobe of = light.seen_by({.to_viewer = viewer,
                                                 .mirrored = glm::vec3(-viewer.x, viewer.y, viewer.z),
                                                 .normal = {0, 1, 0},
                                                 .horizon = {0, 1, 0},
                                                 .roughness = roughness,
                                                 .f0 = 0.04f,
                                                 .f90 = 1},
                                                seen);
            const double truth = lobe_integral(radiance, slant, static_cast<double>(roughness), 0.04);
            EXPECT_NEAR(static_cast<double>(of.light.x) / truth, 1, 0.1) << roughness << ' ' << degrees;
        }
}

struct World {
    std::shared_ptr<const scene::Scene> scene;
    scene::SceneState state;
    ray::RayScene rays;
    Surroundings surroundings;

    explicit World(std::uint64_t seed, int dynamic_objects = 0) : World(Soup(seed, dynamic_objects).take()) {}
    explicit World(std::shared_ptr<const scene::Scene> of)
        : scene(std::move(of)), state(scene, 0), rays(state), surroundings(state, rays)
    {
    }
    visibility::TriangleId id_of(const ShadowPoint& p) const
    {
        return surroundings.triangles().first_of(p.object) + p.triangle;
    }
};

struct Tally {
    std::uint64_t free = 0, blocked = 0, open = 0;
    std::uint64_t wrong_free = 0, wrong_blocked = 0;
};

// Compares what is proven of the parts of random points with rays from one or more points of each.
void compare(const World& world, Random& random, const DirectionCells& cells, const ProofOptions& options, Tally& tally,
             std::uint32_t level, int parts, int points_of_part = 1)
{
    if (world.surroundings.triangles().size() == 0) return;
    const CellProofs proofs(world.surroundings.triangles(), cells, options);
    for (const ShadowPoint& p : random_points(*world.scene, world.rays, random, parts)) {
        if (world.surroundings.triangles().first_of(p.object) == visibility::no_triangle) continue;   // it is dynamic
        const MicroTriangle part = micro_at(micro_index_at(p.u, p.v, level), level);
        const PartMasks masks = proofs.judge(world.id_of(p), p.front, part, level);
        glm::vec3 c[3];
        world.rays.geometry(p.object).corners(p.triangle, c);
        const float lift = glm::dot(p.origin - c[0], p.normal);
        for (int i = 0; i < points_of_part; ++i) {
            glm::vec3 origin = p.origin;
            if (i > 0) {
                // Another point of the part, on the same side.
                float u = random.uniform(), v = random.uniform();
                if (u + v > 1) u = 1 - u, v = 1 - v;
                const float n = static_cast<float>(1u << level), side = part.upper != 0 ? -1.0f : 1.0f;
                const float at_u = (static_cast<float>(part.i + part.upper) + side * u) / n,
                            at_v = (static_cast<float>(part.j + part.upper) + side * v) / n;
                origin = (1 - at_u - at_v) * c[0] + at_u * c[1] + at_v * c[2] + lift * p.normal;
            }
            for (std::size_t leaf = 0; leaf < cells.leaves(); ++leaf) {
                const bool free = masks.free[leaf / 64] >> (leaf % 64) & 1,
                           open = masks.open[leaf / 64] >> (leaf % 64) & 1;
                const glm::vec3& d = cells.direction(leaf);
                if (glm::dot(cells.mean(leaf), p.normal) <= 0 || glm::dot(d, p.normal) <= 1e-3f) continue;
                ++(open ? tally.open : free ? tally.free : tally.blocked);
                if (open) continue;
                const bool occluded = world.rays.occluded_single(origin, 0, d, k_infinity, ray::Against::static_only);
                tally.wrong_free += free && occluded, tally.wrong_blocked += !free && !occluded;
            }
        }
    }
}
void compare(std::uint64_t seed, const DirectionCells& cells, const ProofOptions& options, Tally& tally,
             std::uint32_t level, int parts = 24)
{
    Random random(seed * 977 + 5);
    compare(World(seed), random, cells, options, tally, level, parts);
}

TEST(CellProofs, AreNeverWrongAmongRandomTriangles)
{
    const scene::Environment sky = even_sky();
    const DirectionCells cells(sky);
    const DirectionCells sun(glm::normalize(glm::vec3(0.3f, 1, 0.2f)), 0.05, glm::vec3(1));
    Tally tally;
    for (std::uint64_t seed = 1; seed <= 40; ++seed) compare(seed, cells, {}, tally, seed % 4, 12);
    for (std::uint64_t seed = 1; seed <= 100; ++seed) compare(seed, sun, {}, tally, seed % 4);
    EXPECT_EQ(tally.wrong_free, 0u) << "of " << tally.free;
    EXPECT_EQ(tally.wrong_blocked, 0u) << "of " << tally.blocked;
    EXPECT_GT(tally.free, 60'000u) << tally.open << " open";
    EXPECT_GT(tally.blocked, 30'000u);
}

// All static triangles of a courtyard with foliage, from small parts to whole triangles.
// What is known of a cell as a whole holds for every direction of it, from every point of the part; without the check
// of whole cells it does not.
TEST(CellProofs, HoldForAllOfACellWhereTheySaySo)
{
    const scene::Environment sky = sunny();
    const DirectionCells cells(sky);
    for (const bool check : {true, false}) {
        ProofOptions options;
        if (!check) options.left_out = ProofCheck::whole_cell;
        std::uint64_t tested = 0, wrong = 0, leaves = 0;
        for (std::uint64_t seed = 1; seed <= 30; ++seed) {
            const World world(seed);
            if (world.surroundings.triangles().size() == 0) continue;
            Random random(seed);
            const CellProofs proofs(world.surroundings.triangles(), cells, options);
            for (const ShadowPoint& p : random_points(*world.scene, world.rays, random, 12)) {
                if (world.surroundings.triangles().first_of(p.object) == visibility::no_triangle) continue;
                constexpr std::uint32_t k_level = 5;
                const MicroTriangle part = micro_at(micro_index_at(p.u, p.v, k_level), k_level);
                const PartMasks thin = proofs.judge(world.id_of(p), p.front, part, k_level),
                                masks = proofs.judge(world.id_of(p), p.front, part, k_level, &thin, true);
                for (std::size_t leaf = 0; leaf < cells.leaves(); ++leaf) {
                    const auto has = [&](const std::vector<std::uint64_t>& mask) {
                        return (mask[leaf / 64] >> (leaf % 64) & 1) != 0;
                    };
                    if (!has(masks.whole)) continue;
                    EXPECT_FALSE(has(masks.open));
                    ++leaves;
                    const DirectionNode& node = cells.nodes()[cells.node_of(leaf)];
                    float u = random.uniform(), v = random.uniform();
                    if (u + v > 1) u = 1 - u, v = 1 - v;
                    const glm::vec3 d(glm::normalize(static_cast<double>(1 - u - v) * node.corner[0] +
                                                     static_cast<double>(u) * node.corner[1] +
                                                     static_cast<double>(v) * node.corner[2]));
                    if (glm::dot(d, p.normal) <= 2e-3f) continue;
                    ++tested;
                    wrong += has(masks.free) ==
                             world.rays.occluded_single(p.origin, 0, d, k_infinity, ray::Against::static_only);
                }
            }
        }
        EXPECT_GT(tested, 10'000u) << leaves;
        if (check)
            EXPECT_EQ(wrong, 0u);
        else
            EXPECT_GT(wrong, 0u);
    }
}

TEST(CellProofs, AreNeverWrongInACourtyard)
{
    const scene::Environment sky = even_sky();
    const DirectionCells cells(sky);
    const World world(std::make_shared<const scene::Scene>(scene::make_builtin("kinetic")));
    Random random(6);
    Tally tally;
    for (std::uint32_t level = 0; level < 4; ++level) compare(world, random, cells, {}, tally, level, 300, 8);
    EXPECT_EQ(tally.wrong_free, 0u) << "of " << tally.free;
    EXPECT_EQ(tally.wrong_blocked, 0u) << "of " << tally.blocked;
    EXPECT_GT(tally.free, 40'000u) << tally.open << " open";
    EXPECT_GT(tally.blocked, 100'000u);
}

// Without one of the checks, rays contradict some proof.
TEST(CellProofs, NeedEachCheck)
{
    const DirectionCells sun(glm::normalize(glm::vec3(0.3f, 1, 0.2f)), 0.3, glm::vec3(1));
    for (const ProofCheck check : {ProofCheck::whole_part, ProofCheck::whole_cell, ProofCheck::no_open_edge,
                                   ProofCheck::clear_of_part, ProofCheck::crosses, ProofCheck::signs}) {
        ProofOptions options;
        options.left_out = check;
        Tally tally;
        for (std::uint64_t seed = 1; seed <= 400 && tally.wrong_free + tally.wrong_blocked == 0; ++seed)
            compare(seed, sun, options, tally, 1);
        EXPECT_GT(tally.wrong_free + tally.wrong_blocked, 0u) << "check " << static_cast<int>(check);
    }
}

std::vector<std::uint32_t> all_of(const std::vector<ShadowPoint>& points)
{
    std::vector<std::uint32_t> asked(points.size());
    for (std::uint32_t i = 0; i < asked.size(); ++i) asked[i] = i;
    return asked;
}

// Whatever was proven and remembered, points see what rays see; dynamic objects, too. Without families, this holds for
// every cell; with them, for all but a few, and for a fraction of the rays.
TEST(CellVisibility, IsThatOfRays)
{
    const scene::Environment sky = even_sky();
    const DirectionCells by_families(sky), alone(sky, {.groups = false});
    std::size_t cells_asked = 0, wrong_by_families = 0;
    std::array<std::uint64_t, 2> rays{};
    for (std::uint64_t run = 0; run < 12; ++run) {
        const std::uint64_t seed = 1 + run / 2;
        const bool families = run % 2 == 1;
        const DirectionCells& cells = families ? by_families : alone;
        World world(seed, 3);
        ProofOptions eager;
        eager.first_asks = 2, eager.more_asks = 3;
        const CellVisibility visibility(world.surroundings, cells, eager);
        Random random(seed);
        const std::vector<ShadowPoint> points = random_points(*world.scene, world.rays, random, 50);
        const std::vector<std::uint32_t> asked = all_of(points);
        PointMemory memory;
        CellVisibility::Scratch scratch;
        SeenCells first;
        for (int frame = 0; frame < 4; ++frame) {
            memory.begin_frame();
            SeenCells seen;
            visibility.find(scratch, points, asked, {}, frame == 3 ? nullptr : &memory, seen);
            if (frame == 0) first = seen;
            EXPECT_EQ(seen.masks, first.masks) << frame;
            for (std::size_t k = 0; k < points.size(); ++k) {
                const auto shares = seen.partial_of(k), before = first.partial_of(k);
                EXPECT_TRUE(std::ranges::equal(shares, before, [](const PartialCell& a, const PartialCell& b) {
                    return a.leaf == b.leaf && a.share == b.share;
                })) << frame;
            }
            if (frame == 0) rays[families] += scratch.counters.rays;
        }
        EXPECT_GT(scratch.counters.remembered, 0u);
        std::size_t wrong = 0;
        for (std::size_t k = 0; k < points.size(); ++k)
            for (std::size_t leaf = 0; leaf < cells.leaves(); ++leaf) {
                const ShadowPoint& p = points[k];
                glm::vec3 d = cells.direction(leaf);
                if (glm::dot(d, p.normal) <= 1e-3f) d = glm::normalize(cells.mean(leaf));
                const bool visible =
                    glm::dot(cells.mean(leaf), p.normal) > 0 && !world.rays.occluded_single(p.origin, 0, d, k_infinity);
                wrong += visible != ((first.of(k)[leaf / 64] >> (leaf % 64) & 1) != 0);
            }
        if (families)
            wrong_by_families += wrong, cells_asked += points.size() * cells.leaves() / 2;
        else
            EXPECT_EQ(wrong, 0u) << seed;
    }
    EXPECT_LT(wrong_by_families, cells_asked / 50);
    EXPECT_LT(3 * rays[1], 2 * rays[0]);
}

// Where all or nothing of a bright place is visible, few of its cells have rays.
TEST(CellVisibility, BrightPlacesHaveScouts)
{
    const scene::Environment sky = sunny();
    const DirectionCells cells(sky);
    std::vector<bool> of_group(cells.leaves(), false);
    for (const LeafGroup& group : cells.groups())
        for (std::uint32_t leaf = group.first; leaf < group.first + group.leaves; ++leaf) of_group[leaf] = true;
    const auto follows = [&](std::size_t leaf) {
        return (cells.family_followers()[leaf / 64] >> (leaf % 64) & 1) != 0;
    };
    std::size_t divided = 0;
    for (const CellFamily& family : cells.families()) {
        EXPECT_TRUE(of_group[family.scout] || !follows(family.scout));
        std::size_t followers = 0;
        for (std::uint32_t leaf = family.first; leaf < family.first + family.leaves; ++leaf) {
            EXPECT_FALSE(of_group[leaf] && follows(leaf)) << leaf;
            followers += follows(leaf);
            // Whatever follows has a scout next to it.
            if (!follows(leaf)) continue;
            float next = -1;
            for (const std::uint32_t scout : family.scouts) {
                EXPECT_FALSE(follows(scout)) << scout;
                next = std::max(next, glm::dot(cells.direction(leaf), cells.direction(scout)));
            }
            EXPECT_GT(next, family.leaves > 4 ? 0.98f : 0.9f) << leaf;
        }
        if (family.leaves > 4 && followers > 0) ++divided;
    }
    EXPECT_GT(divided, 0u);

    // A point that sees everything.
    const auto rays_of = [&](World& world, const glm::vec3& position, bool expected) {
        const CellVisibility visibility(world.surroundings, cells, {});
        const ShadowPoint point{position, {0, 1, 0}, scene::none, 0, 0, 0, true};
        const std::vector<ShadowPoint> points{point};
        const std::vector<std::uint32_t> asked{0};
        CellVisibility::Scratch scratch;
        SeenCells seen;
        visibility.find(scratch, points, asked, {}, nullptr, seen);
        std::size_t above = 0;
        for (std::size_t leaf = 0; leaf < cells.leaves(); ++leaf) {
            if (!(cells.mean(leaf).y > 0)) continue;
            ++above;
            EXPECT_EQ((seen.of(0)[leaf / 64] >> (leaf % 64) & 1) != 0, expected) << leaf;
        }
        return static_cast<double>(scratch.counters.rays) / static_cast<double>(above);
    };
    World world(1);
    EXPECT_LT(rays_of(world, {0, 1e4f, 0}, true), 0.5);
}

// A coarse answer is that of the cells that stand in for others, whatever was proven and remembered: for a fraction of
// the rays, even where an image has a sun.
TEST(CellVisibility, ACoarseAnswerIsThatOfStandIns)
{
    const scene::Environment sky = sunny();
    const DirectionCells cells(sky);
    std::size_t stand_ins = 0;
    for (const std::uint64_t word : cells.stand_ins()) stand_ins += static_cast<std::size_t>(std::popcount(word));
    EXPECT_GE(stand_ins, cells.families().size());
    EXPECT_LE(stand_ins, 4 * cells.families().size());
    for (std::size_t leaf = 0; leaf < cells.leaves(); ++leaf) {
        const std::size_t stand_in = cells.stand_in_of(leaf);
        EXPECT_EQ(cells.stand_in_of(stand_in), stand_in);
        EXPECT_GT(glm::dot(cells.direction(leaf), cells.direction(stand_in)), 0.9f);
    }
    std::array<std::uint64_t, 2> rays{};
    std::size_t wrong = 0, others_wrong = 0, asked_cells = 0;
    for (std::uint64_t seed = 1; seed <= 4; ++seed) {
        World world(seed);
        ProofOptions eager;
        eager.first_asks = 2, eager.more_asks = 3;
        const CellVisibility visibility(world.surroundings, cells, eager);
        Random random(seed);
        const std::vector<ShadowPoint> points = random_points(*world.scene, world.rays, random, 50);
        const std::vector<std::uint32_t> asked = all_of(points);
        const std::vector<Guides> coarse(points.size(), Guides{.coarse = true});
        CellVisibility::Scratch scratch, fine_scratch;
        SeenCells fine, first;
        PointMemory memory;
        for (int frame = 0; frame < 3; ++frame) {
            memory.begin_frame();
            SeenCells seen;
            visibility.find(scratch, points, asked, coarse, frame == 2 ? nullptr : &memory, seen);
            if (frame == 0) first = seen, rays[1] += scratch.counters.rays;
            EXPECT_EQ(seen.masks, first.masks) << seed << " " << frame;
        }
        visibility.find(fine_scratch, points, asked, {}, nullptr, fine);
        rays[0] += fine_scratch.counters.rays;
        for (std::size_t k = 0; k < points.size(); ++k)
            for (std::size_t leaf = 0; leaf < cells.leaves(); ++leaf) {
                const ShadowPoint& p = points[k];
                const auto sees = [&](std::size_t l) {
                    glm::vec3 d = cells.direction(l);
                    if (glm::dot(d, p.normal) <= 1e-3f) d = glm::normalize(cells.mean(l));
                    return !world.rays.occluded_single(p.origin, 0, d, k_infinity);
                };
                const auto above = [&](std::size_t l) { return glm::dot(cells.mean(l), p.normal) > 0; };
                const std::size_t stand_in = cells.stand_in_of(leaf);
                const bool expected = above(leaf) && sees(above(stand_in) ? stand_in : leaf);
                const bool got = (first.of(k)[leaf / 64] >> (leaf % 64) & 1) != 0;
                wrong += got != expected;
                others_wrong += got != (above(leaf) && sees(leaf)), asked_cells += above(leaf);
            }
    }
    EXPECT_EQ(wrong, 0u);
    EXPECT_GT(others_wrong, 0u);
    EXPECT_LT(others_wrong, asked_cells / 8);
    EXPECT_LT(5 * rays[1], 3 * rays[0]);
}

// A point that sees little of the light is answered in full, because a cell is much of what it sees.
TEST(CellVisibility, ADarkPointIsNotCoarseUnlessAskedTo)
{
    const scene::Environment sky = even_sky();
    const DirectionCells cells(sky);
    std::size_t full = 0, coarse_points = 0;
    for (std::uint64_t seed = 1; seed <= 4; ++seed) {
        World world(seed, 3);
        const CellVisibility visibility(world.surroundings, cells, {});
        Random random(seed);
        const std::vector<ShadowPoint> points = random_points(*world.scene, world.rays, random, 50);
        const std::vector<std::uint32_t> asked = all_of(points);
        CellVisibility::Scratch scratch;
        SeenCells fine, coarse, either;
        visibility.find(scratch, points, asked, {}, nullptr, fine);
        visibility.find(scratch, points, asked, std::vector<Guides>(points.size(), Guides{.coarse = true}), nullptr,
                        coarse);
        visibility.find(scratch, points, asked,
                        std::vector<Guides>(points.size(), Guides{.coarse = true, .unless_dark = true}), nullptr,
                        either);
        for (std::size_t k = 0; k < points.size(); ++k) {
            float seen = 0, above = 0;
            for (std::size_t leaf = 0; leaf < cells.leaves(); ++leaf) {
                const float light = luminance(cells.flux(leaf)) * glm::dot(cells.mean(leaf), points[k].normal);
                if (light <= 0) continue;
                above += light;
                if ((coarse.of(k)[leaf / 64] >> (leaf % 64) & 1) != 0) seen += light;
            }
            // Not where rounding decides.
            if (std::abs(seen / above - 0.25f) < 1e-4f) continue;
            const bool dark = seen < 0.25f * above;
            (dark ? full : coarse_points) += 1;
            EXPECT_TRUE(std::ranges::equal(either.of(k), dark ? fine.of(k) : coarse.of(k))) << seed << " " << k;
        }
    }
    EXPECT_GT(full, 10u);
    EXPECT_GT(coarse_points, 10u);
}

// In the open, a point between others traces few rays: one to each of so many cells, others at each point.
TEST(CellVisibility, PointsBetweenOthersProbeFewCells)
{
    const scene::Environment sky = even_sky();
    const DirectionCells cells(sky);
    World world(1);
    const CellVisibility visibility(world.surroundings, cells, {});
    constexpr std::uint32_t k_between = 30;
    std::vector<ShadowPoint> points;
    std::vector<Guides> guides;
    for (std::uint32_t i = 0; i < 4 + k_between; ++i) {
        points.push_back({{static_cast<float>(i), 1e4f, 0}, {0, 1, 0}, scene::none, 0, 0, 0, true});
        guides.push_back({.corner = {0, 1, 2, 3}, .weight = {0.25f, 0.25f, 0.25f, 0.25f}});
        guides[i].guides = i < 4, guides[i].pass = i < 4 ? 0 : 1;
        guides[i].block = i / 3, guides[i].number = i % 3;
    }
    const std::vector<std::uint32_t> asked = all_of(points);
    CellVisibility::Scratch all, corners;
    SeenCells seen;
    visibility.find(all, points, asked, guides, nullptr, seen);
    visibility.find(corners, points, std::span(asked).first(4), std::span(guides).first(4), nullptr, seen);
    const std::uint64_t rays = all.counters.rays - corners.counters.rays;
    EXPECT_GT(rays, k_between * cells.leaves() / 2 / 256);
    EXPECT_LT(rays, k_between * cells.leaves() / 2 / 32);
}

// Proofs for one image serve another, and answers stay what they are.
TEST(CellProofs, AreTakenOverByAnotherImage)
{
    const scene::Environment sky = even_sky(), other = sunny();
    const DirectionCells before(sky), after(other);
    const World world(2);
    ProofOptions eager;
    eager.first_asks = 1, eager.more_asks = 1;
    const CellVisibility old(world.surroundings, before, eager);
    CellVisibility turned(world.surroundings, after, eager), fresh(world.surroundings, after, eager);
    Random random(2);
    const std::vector<ShadowPoint> points = random_points(*world.scene, world.rays, random, 40);
    const std::vector<std::uint32_t> asked = all_of(points);
    CellVisibility::Scratch scratch, scratch_turned, scratch_fresh;
    SeenCells seen, seen_turned, seen_fresh;
    for (int i = 0; i < 3; ++i) old.find(scratch, points, asked, {}, nullptr, seen);
    turned.proofs().take_over(old.proofs());
    turned.find(scratch_turned, points, asked, {}, nullptr, seen_turned);
    fresh.find(scratch_fresh, points, asked, {}, nullptr, seen_fresh);
    EXPECT_EQ(seen_turned.masks, seen_fresh.masks);
    EXPECT_LT(turned.proofs().counters().parts, fresh.proofs().counters().parts);

    // Where all cells are the same, rays are saved from the first question on.
    CellVisibility again(world.surroundings, before, eager), afresh(world.surroundings, before, eager);
    again.proofs().take_over(old.proofs());
    CellVisibility::Scratch scratch_again, scratch_afresh;
    again.find(scratch_again, points, asked, {}, nullptr, seen_turned);
    afresh.find(scratch_afresh, points, asked, {}, nullptr, seen_fresh);
    EXPECT_EQ(seen_turned.masks, seen_fresh.masks);
    EXPECT_LT(scratch_again.counters.rays, scratch_afresh.counters.rays);
}

}   // namespace
}   // namespace gnomon::environment_light
