// SPDX-License-Identifier: Apache-2.0
// What dynamic objects hide of the cells that points of a floor see: by rays, and for a fraction of them by the points
// around.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <bit>
#include <glm/gtc/matrix_transform.hpp>

#include "environment_light/cell_visibility.h"
#include "scene/builtin/shapes.h"

namespace gnomon::environment_light {
namespace {

using visibility::ShadowPoint;

scene::Environment even_sky()
{
    ImageF image(2, 1, 3);
    for (int x = 0; x < 2; ++x)
        for (int c = 0; c < 3; ++c) image.pixel(x, 0)[c] = 1;
    return scene::Environment(std::move(image));
}

// Moves its node along a line.
struct Along : scene::TransformTrack {
    glm::dvec3 from;
    explicit Along(const glm::dvec3& start) : from(start) {}
    glm::dmat4 evaluate(double time) const override
    {
        return glm::translate(glm::dmat4(1), from + glm::dvec3(time, 0, 0));
    }
    std::vector<scene::Interval> changing() const override { return {{0, 10}}; }
};

// A floor of two triangles, and above it a wall that stands and three balls and a thin pole that move.
std::shared_ptr<const scene::Scene> make_scene()
{
    scene::Scene made;
    made.materials.emplace_back();
    const auto add = [&](const char* name, const auto& build, const glm::dvec3* moves) {
        scene::MeshBuilder builder;
        build(builder);
        const scene::NodeId node = made.add_node(name, scene::none);
        made.nodes[node].mesh = static_cast<scene::MeshId>(made.meshes.size());
        if (moves) made.nodes[node].transform = std::make_shared<Along>(*moves);
        made.meshes.push_back(builder.finish(name));
    };
    const auto rectangle = [](glm::vec3 a, glm::vec3 b, glm::vec3 c, glm::vec3 d) {
        return [=](scene::MeshBuilder& builder) {
            builder.flat_quad(a, b, c, d, glm::normalize(glm::cross(b - a, d - a)));
        };
    };
    add("floor", rectangle({-3, 0, -3}, {-3, 0, 3}, {3, 0, 3}, {3, 0, -3}), nullptr);
    add("wall", rectangle({-3, 0, -1}, {3, 0, -1}, {3, 2, -1}, {-3, 2, -1}), nullptr);
    const auto ball = [](float radius) {
        return [=](scene::MeshBuilder& builder) { builder.sphere(glm::vec3(0), radius, 24, 16); };
    };
    const glm::dvec3 places[] = {{-0.9, 0.5, 0.2}, {0.3, 1.2, 0.4}, {-0.2, 0.3, -0.5}, {-0.4, 0, 0.5}};
    add("ball", ball(0.3f), &places[0]);
    add("high ball", ball(0.4f), &places[1]);
    add("low ball", ball(0.2f), &places[2]);
    add("pole", rectangle({0, 0.1f, 0}, {0.01f, 0.1f, 0}, {0.01f, 1, 0}, {0, 1, 0}), &places[3]);
    made.timeline = {0, 1, 25, 24, false};
    made.finish();
    return std::make_shared<const scene::Scene>(std::move(made));
}

// Points of a square of the floor, in rows.
struct Floor {
    std::shared_ptr<const scene::Scene> scene = make_scene();
    scene::SceneState state{scene, 0.5};
    ray::RayScene rays{state};
    Surroundings surroundings{state, rays};
    std::vector<ShadowPoint> points;
    std::vector<std::uint32_t> asked;
    std::vector<Guides> guides;   // every fourth point of every fourth row guides the others
    static constexpr int k_side = 33, k_step = 4;

    Floor()
    {
        for (int row = 0; row < k_side; ++row)
            for (int column = 0; column < k_side; ++column) add_point(row, column);
    }
    void add_point(int row, int column)
    {
        // A ray from closely above finds the floor.
        const glm::vec3 from(0.02f * static_cast<float>(column) - 0.4f, 1e-3f, 0.02f * static_cast<float>(row) - 0.1f);
        const ray::Hit hit = rays.closest_single(from, 0, {0, -1, 0}, k_infinity, ray::Sides::both);
        ASSERT_TRUE(hit.object != scene::none);
        ShadowPoint p;
        p.object = hit.object, p.triangle = hit.triangle, p.u = hit.u, p.v = hit.v, p.front = true;
        p.normal = {0, 1, 0};
        p.origin = from + hit.t * glm::vec3(0, -1, 0) + glm::vec3(0, 1e-4f, 0);
        points.push_back(p);
        asked.push_back(static_cast<std::uint32_t>(asked.size()));
        const auto at = [](int r, int c) { return static_cast<std::uint32_t>(r * k_side + c); };
        Guides own;
        const int r = row / k_step * k_step, c = column / k_step * k_step;
        own.guides = r == row && c == column;
        if (!own.guides) {
            const int below = r == row ? r : std::min(r + k_step, k_side - 1), right = std::min(c + k_step, k_side - 1);
            own.corner = {at(r, c), at(r, right), at(below, c), at(below, right)};
            const float x = static_cast<float>(column - c) / k_step, y = static_cast<float>(row - r) / k_step;
            own.weight = {(1 - x) * (1 - y), x * (1 - y), (1 - x) * y, x * y};
            own.pass = 1;
            own.block = static_cast<std::uint32_t>((r == row ? k_side + r : r) / k_step * k_side + c / k_step);
            own.number = static_cast<std::uint32_t>((row - r) * k_step + column - c);
        }
        guides.push_back(own);
    }
    bool sees(const DirectionCells& cells, std::size_t k, std::size_t leaf) const
    {
        glm::vec3 d = cells.direction(leaf);
        if (glm::dot(d, points[k].normal) <= 1e-3f) d = glm::normalize(cells.mean(leaf));
        return glm::dot(cells.mean(leaf), points[k].normal) > 0 &&
               !rays.occluded_single(points[k].origin, 0, d, k_infinity);
    }
    struct Compared {
        double wrong = 0;      // share of the cells above the points that are other than rays say
        double light = 0;      // that the points see, of what rays say
        double farthest = 0;   // from it at one point, as a share of the open sky's light
    };
    Compared compare(const DirectionCells& cells, const SeenCells& seen) const
    {
        Compared result;
        double all = 0, light = 0;
        for (std::size_t k = 0; k < points.size(); ++k) {
            double found = 0, rays_say = 0, open = 0;
            for (std::size_t leaf = 0; leaf < cells.leaves(); ++leaf) {
                const double cosine = static_cast<double>(glm::dot(cells.mean(leaf), points[k].normal));
                if (!(cosine > 0)) continue;
                const bool is_seen = sees(cells, k, leaf), was_found = (seen.of(k)[leaf / 64] >> (leaf % 64) & 1) != 0;
                all += 1, open += cosine;
                result.wrong += is_seen != was_found ? 1 : 0;
                found += was_found ? cosine : 0, rays_say += is_seen ? cosine : 0;
            }
            result.light += found, light += rays_say;
            result.farthest = std::max(result.farthest, std::abs(found - rays_say) / open);
        }
        result.wrong /= all, result.light /= light;
        return result;
    }
};

// Without guides every cell is as its ray says. With them, few are otherwise, and most rays are saved.
TEST(DynamicCells, AreFoundForAFractionOfTheRays)
{
    const scene::Environment sky = even_sky();
    const DirectionCells cells(sky, {.groups = false});
    const Floor floor;
    CellVisibility::Scratch every, some;
    SeenCells seen;
    CellVisibility(floor.surroundings, cells).find(every, floor.points, floor.asked, {}, nullptr, seen);
    EXPECT_EQ(floor.compare(cells, seen).wrong, 0);
    CellVisibility(floor.surroundings, cells).find(some, floor.points, floor.asked, floor.guides, nullptr, seen);
    const Floor::Compared compared = floor.compare(cells, seen);
    EXPECT_LT(compared.wrong, 0.002);
    EXPECT_NEAR(compared.light, 1, 0.004);
    EXPECT_LT(compared.farthest, 0.03);
    EXPECT_GT(every.counters.dynamic_rays, 50'000u);
    EXPECT_LT(4 * some.counters.dynamic_rays, every.counters.dynamic_rays);
}

// Points between four others get what those agree on, but for probes, and a probe that finds otherwise is heard: a
// thin pole's shadow is not lost between guides that do not see it.
TEST(DynamicCells, ProbesAreHeard)
{
    const scene::Environment sky = even_sky();
    const DirectionCells cells(sky);
    const Floor floor;
    const CellVisibility visibility(floor.surroundings, cells);
    CellVisibility::Scratch scratch;
    SeenCells seen;
    visibility.find(scratch, floor.points, floor.asked, floor.guides, nullptr, seen);
    std::size_t otherwise = 0;
    for (std::size_t k = 0; k < floor.points.size(); ++k) {
        const Guides& guide = floor.guides[k];
        if (guide.pass == 0) continue;
        for (std::size_t w = 0; w < seen.words; ++w) {
            std::uint64_t all = ~std::uint64_t{0}, none = all;
            for (const std::uint32_t c : guide.corner) all &= seen.of(c)[w], none &= ~seen.of(c)[w];
            otherwise += static_cast<std::size_t>(std::popcount((all & ~seen.of(k)[w]) | (none & seen.of(k)[w])));
        }
    }
    EXPECT_GT(otherwise, 20u);
}

// Answers are the same from memory, and for points that are asked for one call after the other.
TEST(DynamicCells, DoNotDependOnMemoryNorOnCalls)
{
    const scene::Environment sky = even_sky();
    const DirectionCells cells(sky);
    const Floor floor;
    const CellVisibility visibility(floor.surroundings, cells);
    CellVisibility::Scratch scratch;
    SeenCells first, again;
    PointMemory memory;
    memory.begin_frame();
    visibility.find(scratch, floor.points, floor.asked, floor.guides, &memory, first);
    for (int frame = 0; frame < 2; ++frame) {
        memory.begin_frame();
        visibility.find(scratch, floor.points, floor.asked, floor.guides, &memory, again);
        EXPECT_EQ(again.masks, first.masks);
    }
    EXPECT_GT(scratch.counters.remembered, 0u);
    EXPECT_GT(scratch.counters.dynamic_rays, 0u);
    // Rows after a first part: their guides are among the answered ones and themselves.
    const std::size_t part = static_cast<std::size_t>(4 * Floor::k_step + 1) * Floor::k_side;
    SeenCells grown;
    visibility.find(scratch, floor.points, std::span(floor.asked).first(part), std::span(floor.guides).first(part),
                    nullptr, grown);
    std::vector<std::uint64_t> masks(grown.masks);
    visibility.find(scratch, floor.points, floor.asked, floor.guides, nullptr, grown, part);
    masks.insert(masks.end(), grown.masks.begin() + static_cast<std::ptrdiff_t>(masks.size()), grown.masks.end());
    EXPECT_EQ(masks, first.masks);
}

}   // namespace
}   // namespace gnomon::environment_light
