// SPDX-License-Identifier: Apache-2.0
// Every check that a remembered shadow relies on is necessary: with the check, a small scene made for it gives the
// results of rays; without it, wrong ones.
#include <gtest/gtest.h>

#include "shadow_stage.h"

namespace gnomon {
namespace {

using shadow_culling::CertificateOptions;
using shadow_culling::Check;
using shadow_culling::LeftOut;
using test::Outcome;
using test::Rehearsal;
using test::Stage;
using test::Teach;

using Corners = std::vector<glm::vec3>;

// The receiver of most scenes is object 0, in the plane z = 0; the light is two units above it.
const Corners k_receiver = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
const glm::vec3 k_light(0.3f, 0.3f, 2);

Stage stage_with_receiver()
{
    Stage stage;
    stage.add(k_receiver);
    stage.add_light(k_light);
    return stage;
}

shadow_culling::CertifiedOptions with(const CertificateOptions& rules)
{
    shadow_culling::CertifiedOptions options;
    options.certificates = rules;
    return options;
}

// Teaches with points of one kind, then queries all points, with the receiver as one part.
Outcome play(Stage stage, const CertificateOptions& rules, Teach what, int points = 1000)
{
    Rehearsal rehearsal(std::move(stage), with(rules));
    const auto everywhere = rehearsal.points({0}, points);
    rehearsal.teach(everywhere, what);
    rehearsal.advance(0);
    return rehearsal.query(everywhere);
}

Corners small_triangle(float z)
{
    return {{0.3f, 0.3f, z}, {0.35f, 0.3f, z}, {0.3f, 0.35f, z}};
}
// Covers all of the receiver; its corners lie far outside.
Corners large_triangle(float z)
{
    return {{-9, -9, z}, {30, -9, z}, {-9, 30, z}};
}
// Covers all of x < edge, or of x > edge.
Corners left_half(float edge, float z)
{
    return {{edge, -9, z}, {edge, 9, z}, {-20, 0, z}};
}
Corners right_half(float edge, float z)
{
    return {{edge, 9, z}, {edge, -9, z}, {20, 0, z}};
}

glm::dvec3 anywhere(Random& random, double reach)
{
    const auto one = [&] { return static_cast<double>(random.uniform(-1, 1)) * reach; };
    const double x = one(), y = one();
    return {x, y, one()};
}

// A triangle whose edge grazes a side of the shaft, between the receiver's edge and the light, to within rounding. It
// extends outward (nothing is occluded) or inward (all but the very edge is occluded).
Outcome flush_with_the_shaft(const CertificateOptions& rules, bool inward)
{
    Outcome sum;
    for (std::uint64_t seed = 1; seed <= 100; ++seed) {
        Random random(seed);
        const glm::dvec3 far(
            50);   // offset from the origin, where rounding exceeds the tolerance of Embree's edge test
        const glm::dvec3 a = far + anywhere(random, 1), b = far + anywhere(random, 1), c = far + anywhere(random, 1);
        const glm::dvec3 light = a + 0.3 * (b - a) + 0.3 * (c - a) + 2.0 * glm::normalize(glm::cross(b - a, c - a));
        Stage stage;
        stage.add({glm::vec3(a), glm::vec3(b), glm::vec3(c)});
        stage.add_light(glm::vec3(light));
        const glm::dvec3 p = 0.5 * (a + light), q = 0.5 * (b + light);
        const glm::dvec3 along = q - p, out = glm::normalize(glm::cross(along, glm::cross(b - a, c - a)));
        const glm::dvec3 third = 0.5 * (p + q) + (inward ? -20.0 : 1.0) * out;
        const glm::dvec3 p2 = p - (inward ? 0.5 : 0.0) * along, q2 = q + (inward ? 0.5 : 0.0) * along;
        stage.add({glm::vec3(p2), glm::vec3(q2), glm::vec3(third)});

        // Interior points teach; points on the very edge are queried as well.
        Rehearsal rehearsal(std::move(stage), with(rules));
        auto points = rehearsal.points({0}, 50);
        rehearsal.teach(points, inward ? Teach::occluded_ones : Teach::free_ones);
        for (int i = 1; i < 400; ++i)
            points.push_back(test::shadow_point(rehearsal.rays(), 0, 0, static_cast<float>(i) / 400,
                                                1e-9f * random.uniform(1, 4), true));
        rehearsal.advance(0);
        sum += rehearsal.query(points);
    }
    return sum;
}

// An occluder that leaves a part of the receiver lit, and a light that jumps at time 0.5.
Outcome light_that_jumps(const CertificateOptions& rules, std::initializer_list<double> times)
{
    Stage stage;
    stage.add(k_receiver);
    stage.add_light(k_light, scene::LightType::point,
                    std::make_shared<test::JumpTrack>(0.5, test::translation(0.3, 0.3, 2), test::translation(9, 0, 2)));
    stage.add(left_half(2, 1));
    Rehearsal rehearsal(std::move(stage), with(rules));
    const auto points = rehearsal.points({0}, 1000);
    rehearsal.teach(points, Teach::all);
    Outcome outcome;
    for (const double time : times) {
        rehearsal.advance(time);
        outcome = rehearsal.query(points);
    }
    return outcome;
}

void override_translation(Rehearsal& rehearsal, scene::ObjectId object, const glm::dvec3& by)
{
    const glm::dmat4 place = test::translation(by.x, by.y, by.z);
    rehearsal.state().override_transform(rehearsal.scene().objects[object].node, &place);
    rehearsal.advance(0);
}

// A light in the receiver's plane, as high as ray origins, so that rounding decides which points face it.
Outcome light_that_grazes(const CertificateOptions& rules)
{
    Outcome sum;
    for (std::uint64_t seed = 1; seed <= 100; ++seed) {
        Random random(seed);
        const glm::vec3 p[3] = {glm::vec3(anywhere(random, 1)), glm::vec3(anywhere(random, 1)),
                                glm::vec3(anywhere(random, 1))};
        const glm::vec3 n = glm::normalize(glm::cross(p[1] - p[0], p[2] - p[0]));
        Stage stage;
        stage.add({p[0], p[1], p[2]});
        stage.add_light((p[0] + p[1] + p[2]) / 3.0f + ray::origin_lift(p) * n);
        sum += play(std::move(stage), rules, Teach::free_ones, 300);
    }
    return sum;
}

struct Scene {
    const char* name;
    std::function<void(CertificateOptions&)> leave_out;
    std::function<Outcome(const CertificateOptions&)> outcome;
};

std::function<void(CertificateOptions&)> without(LeftOut checks)
{
    return [checks](CertificateOptions& rules) { rules.left_out = checks; };
}

const Scene k_scenes[] = {
    // --- NONE
    {"nothing_in_shaft", without(Check::nothing_in_shaft),
     [](const CertificateOptions& rules) {
         Stage stage = stage_with_receiver();
         stage.add(small_triangle(1));
         return play(std::move(stage), rules, Teach::free_ones);
     }},
    {"masked_blocks", without(Check::masked_blocks),
     [](const CertificateOptions& rules) {
         Stage stage = stage_with_receiver();
         stage.add(small_triangle(1), test::cut_out);
         return play(std::move(stage), rules, Teach::free_ones, 4000);
     }},
    {"margin_of_none", [](CertificateOptions& rules) { rules.shaft.margin = 0; },
     [](const CertificateOptions& rules) { return flush_with_the_shaft(rules, false); }},
    {"base_below_rays", [](CertificateOptions& rules) { rules.shaft.room = -3; },
     [](const CertificateOptions& rules) {   // ray origins are 2e-6 above the receiver
         Stage stage = stage_with_receiver();
         stage.add(small_triangle(5e-6f));
         return play(std::move(stage), rules, Teach::free_ones);
     }},

    // --- FULL
    {"margin_of_full", [](CertificateOptions& rules) { rules.shaft.margin = 0; },
     [](const CertificateOptions& rules) { return flush_with_the_shaft(rules, true); }},
    {"opaque_occluder", without(Check::opaque_occluder),
     [](const CertificateOptions& rules) {
         Stage stage = stage_with_receiver();
         stage.add(large_triangle(1), test::cut_out);
         return play(std::move(stage), rules, Teach::occluded_ones);
     }},
    {"opaque_neighbour", without(Check::opaque_neighbour),
     [](const CertificateOptions& rules) {
         Stage stage = stage_with_receiver();
         stage.add(left_half(0.4f, 1));
         stage.add(right_half(0.4f, 1), test::cut_out);
         return play(std::move(stage), rules, Teach::occluded_ones);
     }},
    {"same_bits", without(Check::same_bits),
     [](const CertificateOptions& rules) {   // a slit
         Stage stage = stage_with_receiver();
         stage.add(left_half(0.3f, 1));
         stage.add(right_half(0.3005f, 1));
         return play(std::move(stage), rules, Teach::occluded_ones, 20000);
     }},
    {"no_open_edge", without(Check::no_open_edge),
     [](const CertificateOptions& rules) {
         Stage stage = stage_with_receiver();
         stage.add(left_half(0.4f, 1));
         return play(std::move(stage), rules, Teach::occluded_ones);
     }},
    {"no_silhouette", without(Check::no_silhouette),
     [](const CertificateOptions& rules) {   // a fold: both halves extend to the left
         Stage stage = stage_with_receiver();
         stage.add(left_half(0.4f, 1));
         stage.add({{0.4f, -9, 1}, {0.4f, 9, 1}, {-20, 0, 1.2f}});
         return play(std::move(stage), rules, Teach::occluded_ones);
     }},
    {"clearance", [](CertificateOptions& rules) { rules.clearance = -1; },
     [](const CertificateOptions& rules) {   // a plane that intersects the receiver
         Stage stage = stage_with_receiver();
         stage.add({{-20, -60, -20.3f}, {-20, 60, -20.3f}, {80, 0, 79.7f}});
         return play(std::move(stage), rules, Teach::occluded_ones);
     }},
    {"end_gap", [](CertificateOptions& rules) { rules.end_gap = -1; },
     [](const CertificateOptions& rules) {   // an occluder closer to the light than the end of the rays
         Stage stage = stage_with_receiver();
         stage.add({{0.2f, 0.2f, 1.9999f}, {0.5f, 0.2f, 1.9999f}, {0.2f, 0.5f, 1.9999f}});
         stage.add(small_triangle(1));
         return play(std::move(stage), rules, Teach::occluded_ones);
     }},

    // --- Both
    {"light_grazes", [](CertificateOptions& rules) { rules.graze_lifts = -1; }, light_that_grazes},

    // --- Dynamic objects
    {"dynamic_tested", without(Check::dynamic_tested),
     [](const CertificateOptions& rules) {
         Stage stage = stage_with_receiver();
         stage.add(small_triangle(1), test::two_sided,
                   std::make_shared<test::JumpTrack>(0.5, test::translation(0, 0, 50), glm::dmat4(1)));
         Rehearsal rehearsal(std::move(stage), with(rules));
         const auto points = rehearsal.points({0}, 1000);
         rehearsal.teach(points, Teach::all);
         rehearsal.advance(1);
         return rehearsal.query(points);
     }},
    {"light_moves", without(Check::light_moves),
     [](const CertificateOptions& rules) {
         return light_that_jumps(rules, {0, 1});
     }},
    {"light_stops", without(Check::light_stops),
     [](const CertificateOptions& rules) {
         return light_that_jumps(rules, {0, 1, 2});
     }},
    {"promoted_not_receiver", without(Check::promoted_not_receiver),
     [](const CertificateOptions& rules) {   // the receiver is moved below an object that did not shadow it
         Stage stage = stage_with_receiver();
         stage.add(left_half(-5, 1));
         Rehearsal rehearsal(std::move(stage), with(rules));
         rehearsal.teach(rehearsal.points({0}, 1000), Teach::all);
         override_translation(rehearsal, 0, {-15, 0, 0});
         return rehearsal.query(rehearsal.points({0}, 1000));
     }},
    {"promoted_not_occluder", without(Check::promoted_not_occluder),
     [](const CertificateOptions& rules) {   // the occluder vanishes before anything is learned
         Stage stage = stage_with_receiver();
         stage.add(large_triangle(1));
         stage.add(small_triangle(0.9f));
         Rehearsal rehearsal(std::move(stage), with(rules));
         override_translation(rehearsal, 1, {0, 0, 50});
         rehearsal.query({});
         const auto points = rehearsal.points({0}, 1000);
         rehearsal.teach(points, Teach::occluded_ones);
         rehearsal.advance(0);
         return rehearsal.query(points);
     }},
    {"promoted_shadow_gone", without(Check::promoted_shadow_gone),
     [](const CertificateOptions& rules) {
         Stage stage = stage_with_receiver();
         stage.add(large_triangle(1));
         Rehearsal rehearsal(std::move(stage), with(rules));
         const auto points = rehearsal.points({0}, 1000);
         rehearsal.teach(points, Teach::all);
         override_translation(rehearsal, 1, {0, 0, 50});
         return rehearsal.query(points);
     }},
};

void PrintTo(const Scene& scene, std::ostream* out)
{
    *out << scene.name;
}

class CertificateChecks : public testing::TestWithParam<Scene> {};

TEST_P(CertificateChecks, EachCheckIsNecessary)
{
    const Scene& scene = GetParam();
    CertificateOptions rules;
    const Outcome whole = scene.outcome(rules);
    EXPECT_GT(whole.asked, 0u);
    EXPECT_EQ(whole.wrong, 0u);
    scene.leave_out(rules);
    const Outcome part = scene.outcome(rules);
    EXPECT_GT(part.wrong, 0u) << "no wrong result without the check: NONE " << part.none << ", FULL " << part.full;
}

INSTANTIATE_TEST_SUITE_P(Each, CertificateChecks, testing::ValuesIn(k_scenes),
                         [](const auto& chosen) { return std::string(chosen.param.name); });

// The two sides of a triangle have separate states: if the back is looked up as the front, results are wrong.
TEST(CertificateRules, SidesOfATriangleAreStoredSeparately)
{
    for (const bool wrong_key : {false, true}) {
        Rehearsal rehearsal(stage_with_receiver());
        auto points = rehearsal.points({0}, 1000, 1, true);
        rehearsal.teach(points, Teach::free_ones);
        for (auto& p : points) p.front = p.front || wrong_key;
        rehearsal.advance(0);
        const Outcome outcome = rehearsal.query(points);
        EXPECT_GT(outcome.none, 0u);
        EXPECT_EQ(outcome.wrong > 0, wrong_key);
    }
}

// Where a wall leans over the very edge of the receiver, no state is stored for the rim: if its points are looked up as
// interior points, results are wrong. The lean is within the margin, and no proof detects it.
TEST(CertificateRules, RimIsAlwaysTraced)
{
    std::uint64_t asked = 0, in_shade = 0, wrong[2] = {0, 0};
    for (const bool wrong_key : {false, true}) {
        Stage stage;
        stage.add(k_receiver);
        stage.add_light({0, 0, 1}, scene::LightType::directional);
        stage.add({{-1, 0, 0}, {1, 0, 0}, {0, 2e-6f, 1.2f}});
        Rehearsal rehearsal(std::move(stage));
        rehearsal.teach(rehearsal.points({0}, 1000), Teach::free_ones);
        Rehearsal::Points points;
        for (int i = 1; i < 400; ++i) {
            auto p = test::shadow_point(rehearsal.rays(), 0, 0, static_cast<float>(i) / 1000, 5e-7f, true);
            in_shade += test::truly_occluded(rehearsal.state(), rehearsal.rays(), p, 0);
            if (wrong_key) p.v += 1e-3f;
            points.push_back(p);
        }
        rehearsal.advance(0);
        const Outcome outcome = rehearsal.query(points);
        asked += outcome.asked;
        wrong[wrong_key] = outcome.wrong;
    }
    EXPECT_GT(in_shade, 0u);
    EXPECT_GT(asked, in_shade / 2);
    EXPECT_EQ(wrong[false], 0u);
    EXPECT_GT(wrong[true], 0u);
}

// A point is answered by its own part: if it is looked up in another part, results are wrong.
TEST(CertificateRules, LookUpUsesThePartOfThePoint)
{
    for (const bool wrong_key : {false, true}) {
        Stage stage = stage_with_receiver();
        stage.add(left_half(0.4f, 1));
        Rehearsal rehearsal(std::move(stage));
        rehearsal.set_view({glm::vec3(0, 0, 4), 0.01f, 0});
        auto points = rehearsal.points({0}, 3000);
        rehearsal.teach(points, Teach::all, 4);
        if (wrong_key)
            for (auto& p : points) std::swap(p.u, p.v);
        rehearsal.advance(0);
        const Outcome outcome = rehearsal.query(points);
        EXPECT_GT(outcome.none, 0u);
        EXPECT_GT(outcome.full, 0u);
        EXPECT_EQ(outcome.wrong > 0, wrong_key);
    }
}

// Triangles that rays intersect in different object spaces do not close a patch, even if their shared vertices agree to
// the bit, because rays are rounded differently on the way to each space.
TEST(CertificateRules, PatchesDoNotSpanInstances)
{
    // As many adjacent sheets as are flattened, and one more, so that the mesh is stored once and instanced.
    constexpr std::uint32_t k_cells = 256;
    for (const int sheets : {7, 8}) {
        Stage stage;
        scene::Mesh mesh;
        for (std::uint32_t j = 0; j <= k_cells; ++j)
            for (std::uint32_t i = 0; i <= k_cells; ++i)
                mesh.positions.emplace_back(static_cast<float>(i), static_cast<float>(j), 0.0f);
        for (std::uint32_t j = 0; j < k_cells; ++j)
            for (std::uint32_t i = 0; i < k_cells; ++i) {
                const std::uint32_t a = j * (k_cells + 1) + i, above = a + k_cells + 1;
                mesh.triangles.emplace_back(a, a + 1, above + 1);
                mesh.triangles.emplace_back(a, above + 1, above);
            }
        mesh.parts = {{test::two_sided, 0, static_cast<std::uint32_t>(mesh.triangles.size())}};
        stage.scene.meshes.push_back(std::move(mesh));
        for (int s = 0; s < sheets; ++s)
            test::add_object(stage.scene, 0, scene::none, test::translation(s * static_cast<double>(k_cells), 0, 0));
        const auto scene = test::finished(stage.scene);
        const scene::SceneState state(scene, 0);
        const ray::RayScene rays(state);
        const shadow_culling::StaticTriangles triangles(state, rays);
        const bool instanced = rays.geometry(0).to_world != nullptr;
        EXPECT_EQ(instanced, sheets == 8);
        std::uint32_t open = 0;
        for (shadow_culling::TriangleId id = 0; id < triangles.size(); ++id)
            for (int e = 0; e < 3; ++e) open += triangles.across(id, e) == shadow_culling::no_triangle;
        const std::uint32_t outer = 2 * k_cells * static_cast<std::uint32_t>(sheets) + 2 * k_cells;
        const std::uint32_t seams = 2 * k_cells * static_cast<std::uint32_t>(sheets - 1);
        EXPECT_EQ(open, instanced ? outer + seams : outer);
    }
}

// A patch starts with a triangle inside the shaft: one beside the shaft closes nothing.
TEST(CertificateRules, PatchStartsInsideTheShaft)
{
    Stage stage = stage_with_receiver();
    stage.add({{5, 5, 1}, {6, 5, 1}, {5, 6, 1}});
    const auto scene = test::finished(stage.scene);
    const scene::SceneState state(scene, 0);
    const ray::RayScene rays(state);
    const shadow_culling::StaticTriangles triangles(state, rays);
    const glm::dvec3 piece[3] = {glm::dvec3(k_receiver[0]), glm::dvec3(k_receiver[1]), glm::dvec3(k_receiver[2])};
    const visibility::Shaft shaft(piece, {0, 0, 1}, {glm::dvec3(k_light), false}, 2e-6, {});
    CertificateOptions rules;
    EXPECT_FALSE(certify_full(triangles, shaft, 1, rules));
    rules.left_out = Check::occluder_in_way;
    EXPECT_TRUE(certify_full(triangles, shaft, 1, rules));
}

// The occlusion of a ray by a dynamic object is no evidence: ground in its shadow is still proven free of static
// shadows.
TEST(CertificateRules, DynamicOccludersAreNoEvidence)
{
    Stage stage = stage_with_receiver();
    stage.add(large_triangle(1), test::two_sided,
              std::make_shared<test::JumpTrack>(0.5, glm::dmat4(1), test::translation(0, 0, 50)));
    Rehearsal rehearsal(std::move(stage));
    const auto points = rehearsal.points({0}, 100);
    rehearsal.teach(points, Teach::all);
    for (const double time : {0.0, 1.0}) {
        rehearsal.advance(time);
        const Outcome outcome = rehearsal.query(points);
        EXPECT_EQ(outcome.none, points.size());
        EXPECT_EQ(outcome.wrong, 0u);
    }
}

}   // namespace
}   // namespace gnomon
