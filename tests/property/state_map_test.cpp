// SPDX-License-Identifier: Apache-2.0
// The overlay of shadow states is correct: its marks are those of the shadow memory, and agree with rays.
#include <gtest/gtest.h>

#include "ray/origin.h"
#include "ray/ray_scene.h"
#include "scene/builtin/builtin.h"
#include "shadow_culling/certified/certified_culling.h"
#include "shadow_culling/nah2009/paper_culling.h"
#include "support.h"
#include "trace/checked_shadows.h"
#include "trace/traced_frame.h"

namespace gnomon {
namespace {

using shadow_culling::ShadowPoint;
using trace::StateMark;

// The primary hits of an image.
struct FirstHits {
    std::vector<ShadowPoint> points;
    std::vector<std::pair<int, int>> pixels;
};

// Traced in the packets of the traced frame, tile by tile along a Z curve: other packets may differ in which of two
// coplanar surfaces they hit, and in the last bits of a hit, and so in its part.
FirstHits first_hits(const ray::RayScene& rays, const scene::View& view)
{
    constexpr int k_tile = 32;
    FirstHits result;
    for (int top = 0; top < view.size.height; top += k_tile)
        for (int left = 0; left < view.size.width; left += k_tile) {
            ray::RayQueue queue;
            std::vector<std::pair<int, int>> pixels;
            for (int code = 0; code < k_tile * k_tile; ++code) {
                int x = left, y = top;
                for (int b = 0; b < 5; ++b) x += (code >> (2 * b) & 1) << b, y += (code >> (2 * b + 1) & 1) << b;
                if (x >= view.size.width || y >= view.size.height) continue;
                glm::vec3 origin, direction;
                float tnear, tfar;
                view.ray(static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f, origin, direction, tnear, tfar);
                queue.push(origin, tnear, direction, tfar);
                pixels.emplace_back(x, y);
            }
            ray::Hits hits;
            hits.resize(queue.size());
            rays.closest(queue, 0, queue.size(), hits, ray::Sides::front);
            for (std::size_t i = 0; i < queue.size(); ++i) {
                if (hits.object[i] == scene::none) continue;
                glm::vec3 p[3];
                rays.geometry(hits.object[i]).corners(hits.triangle[i], p);
                const float u = hits.u[i], v = hits.v[i];
                const glm::vec3 cross = glm::cross(p[1] - p[0], p[2] - p[0]);
                const bool front = glm::dot(cross, queue.direction(i)) < 0;
                const glm::vec3 normal = glm::normalize(front ? cross : -cross);
                const glm::vec3 position = (1 - u - v) * p[0] + u * p[1] + v * p[2];
                result.points.push_back(
                    {position + ray::origin_lift(p) * normal, normal, hits.object[i], hits.triangle[i], u, v, front});
                result.pixels.push_back(pixels[i]);
            }
        }
    return result;
}

class StateMapTest : public testing::Test {
 protected:
    void start(scene::Scene made, int frame)
    {
        scene = std::make_shared<scene::Scene>(std::move(made));
        state = std::make_unique<scene::SceneState>(scene, scene->timeline.time_of(frame));
        rays = std::make_unique<ray::RayScene>(*state);
        states.lights.clear();
        for (int l = 0; l < static_cast<int>(scene->lights.size()); ++l) states.lights.push_back(l);
    }
    void go_to(int frame)
    {
        state->advance(scene->timeline.time_of(frame));
        rays->update(*state);
        view = scene::make_view(*state, 0, {128, 96});
    }
    void trace(trace::ShadowTester& shadows)
    {
        trace::trace_frame(*state, *rays, view, {}, tasks, buffers, {&shadows});
    }
    glm::vec3 to_light(int l, const glm::vec3& from) const
    {
        const scene::LightState& at = state->light(static_cast<scene::LightId>(l));
        const bool directional = scene->lights[static_cast<std::size_t>(l)].type == scene::LightType::directional;
        return directional ? -at.direction : at.position - from;
    }
    bool occluded_by_static(int l, const glm::vec3& from) const
    {
        const bool directional = scene->lights[static_cast<std::size_t>(l)].type == scene::LightType::directional;
        return rays->occluded_single(from, 0, to_light(l, from), directional ? k_infinity : 0.9999f,
                                     ray::Against::static_only);
    }

    std::shared_ptr<const scene::Scene> scene;
    std::unique_ptr<scene::SceneState> state;
    std::unique_ptr<ray::RayScene> rays;
    scene::View view;
    trace::StateMap states;
    shading::FrameBuffers buffers;
    Tasks tasks{2};
};

StateMark mark_of(shadow_culling::ShadowState state)
{
    switch (state) {
        case shadow_culling::ShadowState::none:
            return StateMark::none;
        case shadow_culling::ShadowState::full:
            return StateMark::full;
        case shadow_culling::ShadowState::partial:
            return StateMark::partial;
        case shadow_culling::ShadowState::unknown:
            break;
    }
    return StateMark::unknown;
}

TEST_F(StateMapTest, ShowsCertifiedStatesThatAgreeWithRays)
{
    for (scene::Scene& made : std::array{scene::make_kinetic(), scene::make_cornell()}) {
        start(std::move(made), 20);
        shadow_culling::CertifiedCulling culling(*state, *rays, {});
        std::size_t seen[trace::k_state_marks] = {}, compared = 0;
        for (int frame = 20; frame < 25; ++frame) {
            go_to(frame);
            const FirstHits hits = first_hits(*rays, view);
            // The state before the frame adds to it.
            culling.begin_frame(*state, *rays, {view.eye, view.pixel_spread, view.pixel_width});
            const auto batch = culling.make_batch();
            culling.classify(*batch, hits.points);
            std::vector<shadow_culling::ShadowState> expected;
            for (std::uint32_t p = 0; p < hits.points.size(); ++p)
                for (const int l : states.lights) expected.push_back(culling.state_of(*batch, p, l));

            trace::CertifiedShadows shadows(culling);
            trace::CheckedShadows checked(shadows, states);
            trace(checked);

            std::size_t at = 0;
            for (std::size_t p = 0; p < hits.points.size(); ++p)
                for (const int l : states.lights) {
                    const auto [x, y] = hits.pixels[p];
                    const ShadowPoint& point = hits.points[p];
                    const trace::StateCell cell = states.cell(static_cast<std::size_t>(l), x, y);
                    const shadow_culling::ShadowState state_then = expected[at++];
                    ++seen[static_cast<std::size_t>(cell.mark)];
                    EXPECT_FALSE(cell.wrong || cell.wrong_behind || cell.untrusted);
                    if (cell.mark == StateMark::away) continue;
                    EXPECT_GT(glm::dot(to_light(l, point.origin), point.normal), 0);
                    if (scene->objects[point.object].dynamic) {
                        EXPECT_EQ(cell.mark, StateMark::moving);
                        continue;
                    }
                    ASSERT_EQ(cell.mark, mark_of(state_then)) << "frame " << frame << " at " << x << ", " << y;
                    if (cell.mark == StateMark::none || cell.mark == StateMark::full) {
                        EXPECT_EQ(occluded_by_static(l, point.origin), cell.mark == StateMark::full);
                    }
                    ++compared;
                }
            for (std::size_t l = 0; l < states.lights.size(); ++l)   // without a surface there is no mark
                EXPECT_EQ(std::count_if(states.panel(l), states.panel(l) + states.pixels(),
                                        [](std::uint8_t byte) { return byte != 0; }),
                          static_cast<std::ptrdiff_t>(hits.points.size()));
        }
        EXPECT_GT(compared, 10'000u);
        for (const StateMark mark : {StateMark::away, StateMark::moving, StateMark::unknown, StateMark::none,
                                     StateMark::full, StateMark::partial})
            EXPECT_GT(seen[static_cast<std::size_t>(mark)], 0u) << static_cast<int>(mark);
    }
}

TEST_F(StateMapTest, ShowsModesOfThePublishedCulling)
{
    using shadow_culling::OcclusionMode;
    start(scene::make_kinetic(), 20);
    shadow_culling::PaperCulling paper(*state, *rays);
    std::size_t seen[trace::k_state_marks][2] = {};
    for (int frame = 20; frame < 24; ++frame) {
        go_to(frame);
        const FirstHits hits = first_hits(*rays, view);
        paper.begin_frame(*state, *rays);
        const shadow_culling::Modes then = paper.modes();

        trace::NahShadows shadows(paper);
        trace::CheckedShadows checked(shadows, states);
        trace(checked);
        for (std::size_t p = 0; p < hits.points.size(); ++p)
            for (const int l : states.lights) {
                const auto [x, y] = hits.pixels[p];
                const ShadowPoint& point = hits.points[p];
                const trace::StateCell cell = states.cell(static_cast<std::size_t>(l), x, y);
                ++seen[static_cast<std::size_t>(cell.mark)][cell.untrusted];
                if (cell.mark == StateMark::away) continue;
                if (paper.is_dynamic(point.object)) {
                    EXPECT_EQ(cell.mark, StateMark::moving);
                    continue;
                }
                const shadow_culling::PrimitiveId primitive =
                    paper.primitive(point.object, point.triangle, point.u, point.v);
                constexpr StateMark k_marks[] = {StateMark::unknown, StateMark::full, StateMark::none,
                                                 StateMark::partial};
                ASSERT_EQ(cell.mark, k_marks[static_cast<std::size_t>(then.shadow(primitive, l))])
                    << "frame " << frame << " at " << x << ", " << y;
                EXPECT_EQ(cell.untrusted, then.occlusion(primitive) != OcclusionMode::fully_rendered);
                // A traced result cannot be wrong.
                const bool culled = !cell.untrusted && (cell.mark == StateMark::none || cell.mark == StateMark::full);
                EXPECT_FALSE(cell.wrong && !culled);
            }
    }
    for (const StateMark mark : {StateMark::none, StateMark::full, StateMark::partial})
        for (const int untrusted : {0, 1})
            EXPECT_GT(seen[static_cast<std::size_t>(mark)][untrusted], 0u) << static_cast<int>(mark);
}

}   // namespace
}   // namespace gnomon
