// SPDX-License-Identifier: Apache-2.0
// The views of the half space before a place on a surface.

#include <gtest/gtest.h>

#include "base/random.h"
#include "light_views/projection.h"

namespace gnomon::light_views {
namespace {

// The view of a half cube in which a direction lies, as view_of_light.glsl finds it.
std::size_t view_of(const std::vector<ViewProjection>& views, const glm::vec3& d)
{
    const float stretch = glm::length(views[0].across);
    const glm::vec2 aside(glm::dot(d, views[0].across) / stretch, glm::dot(d, views[0].down) / stretch);
    const glm::vec2 size = glm::abs(aside);
    if (std::max(size.x, size.y) <= glm::dot(d, views[0].forward)) return 0;
    const std::size_t axis = size.x >= size.y ? 0 : 1;
    return 1 + 2 * axis + (aside[static_cast<int>(axis)] < 0 ? 1u : 0u);
}

TEST(HalfCube, EveryDirectionBeforeTheLightLiesInsideItsViewAndItsBorder)
{
    scene::Light light;
    light.type = scene::LightType::spot;
    light.outer_angle = static_cast<float>(k_pi / 2);
    SceneBounds bounds;
    bounds.whole.add(glm::vec3(-5)), bounds.whole.add(glm::vec3(5));
    ProjectionOptions options;
    EXPECT_EQ(view_count(light, bounds, options), 6) << "a wide spot of a scene keeps its six faces";
    options.half_cubes = true;
    ASSERT_EQ(view_count(light, bounds, options), 5);
    Random random(3);
    constexpr int k_size = 128;
    for (int i = 0; i < 20; ++i) {
        scene::LightState state;
        state.position = {random.uniform(-2, 2), random.uniform(-2, 2), random.uniform(-2, 2)};
        const auto direction = [&] {
            return glm::normalize(glm::vec3(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)) +
                                  glm::vec3(1e-3f));
        };
        state.direction = direction();
        const std::vector<ViewProjection> views = project(light, state, bounds, k_size, options);
        ASSERT_EQ(views.size(), 5u);
        const float inside = 1 - 2 * static_cast<float>(options.border) / k_size;
        for (int k = 0; k < 1000; ++k) {
            glm::vec3 d = direction();
            if (glm::dot(d, state.direction) < 0) d = -d;
            const ViewProjection& view = views[view_of(views, d)];
            const glm::vec4 clip = view.clip_from_world * glm::vec4(state.position + 3.0f * d, 1);
            ASSERT_GT(clip.w, 0);
            EXPECT_LE(std::abs(clip.x / clip.w), inside + 1e-4f);
            EXPECT_LE(std::abs(clip.y / clip.w), inside + 1e-4f);
        }
    }
}

}   // namespace
}   // namespace gnomon::light_views
