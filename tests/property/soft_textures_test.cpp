// SPDX-License-Identifier: Apache-2.0
// Soft shadow textures: kept ones equal those made anew to the bit, and where light, occluder and receiver are
// parallel, a penumbra is the closed form.
#include "shadow_textures/soft_textures.h"

#include <gtest/gtest.h>

#include <cmath>

#include "light_script.h"
#include "shadow_textures/lookup.h"

namespace gnomon::shadow_textures {
namespace {

using light_views::LightView;
using light_views::LightViews;
using light_views::LightViewsOptions;
using light_views::SoftwareView;

constexpr SoftLight k_light{{0.3f, 0, 0.1f}, {0, 0.2f, 0}};

struct Kept {
    std::vector<CoherentSoftTextures> textures{CoherentSoftTextures(SoftScale::receiver),
                                               CoherentSoftTextures(SoftScale::occluder)};
};

constexpr SoftScale k_scales[] = {SoftScale::receiver, SoftScale::occluder};

TEST(SoftTextures, KeptOnesEqualThoseMadeAnew)
{
    std::uint64_t updated = 0, made = 0, soft = 0;
    for (std::uint64_t seed = 1; seed <= 2; ++seed) {
        constexpr int k_frames = 40;
        const test::LightScript script = test::make_light_script(seed, k_frames);
        scene::SceneState state(script.scene, 0);
        LightViewsOptions options;
        options.atlas.view_size = 64;
        options.quiet_frames = 3;
        options.receivers = true;
        LightViews views(state, options);
        std::vector<SoftwareView> buffers;
        for (const LightView& view : views.views()) buffers.emplace_back(view.tile.size);
        std::vector<Kept> kept(buffers.size());
        for (int frame = 0; frame < k_frames; ++frame) {
            state.advance(script.time(frame));
            views.update(state);
            SoftLight light = k_light;
            if (frame >= k_frames / 2) light.half_s *= 2.0f;
            for (std::size_t v = 0; v < buffers.size(); ++v) {
                const LightView& view = views.views()[v];
                if (!view.shown) continue;
                buffers[v].execute(view.plan, view.projection, state);
                for (std::size_t way = 0; way < 2; ++way) {
                    CoherentSoftTextures& textures = kept[v].textures[way];
                    textures.update(view, buffers[v].rendering(), views.casters(), state, light);
                    updated += textures.updated();
                    for (scene::ObjectId o = 0; o < state.scene().objects.size(); ++o) {
                        const light_views::Rect rect = views.casters().footprint(view.projection, state, o);
                        const auto found = textures.textures().find(o);
                        ASSERT_EQ(found != textures.textures().end(), !rect.empty()) << "object " << o;
                        if (rect.empty()) continue;
                        ++made;
                        const SoftTexture anew =
                            soft_texture(view.projection, buffers[v].rendering(), state, o, rect, light, k_scales[way]);
                        ASSERT_TRUE(found->second == anew) << "object " << o << ", view " << v << ", frame " << frame;
                        for (const float visible : anew.visible) soft += visible > 0.05f && visible < 0.95f;
                    }
                }
            }
        }
    }
    EXPECT_LT(updated, made * 3 / 4);   // the scripts move many objects
    EXPECT_GT(soft, 100'000u);
}

// A floor at height 0 and a sheet over its half x < 0.
std::shared_ptr<const scene::Scene> floor_and_sheet(float height)
{
    scene::Scene scene;
    scene.materials.resize(1);
    scene.materials[0].double_sided = true;
    const auto add = [&](const char* name, float low, float high, float y) {
        scene::Mesh mesh;
        mesh.positions = {{low, y, -4}, {low, y, 4}, {high, y, 4}, {high, y, -4}};
        mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
        mesh.parts = {{0, 0, 2}};
        scene.meshes.push_back(mesh);
        scene.nodes[scene.add_node(name, scene::none)].mesh = static_cast<scene::MeshId>(scene.meshes.size() - 1);
    };
    add("floor", -4, 4, 0);
    add("sheet", -4, 0, height);
    scene::Light light;
    light.type = scene::LightType::spot;
    light.outer_angle = 1;
    light.node =
        scene.add_node("light", scene::none,
                       glm::rotate(glm::translate(glm::dmat4(1), glm::dvec3(0, 2, 0)), -k_pi / 2, glm::dvec3(1, 0, 0)));
    scene.lights.push_back(light);
    scene.finish();
    return std::make_shared<const scene::Scene>(std::move(scene));
}

// The penumbra of a straight edge at height h, under a light of half-width a at height H: the visible part rises
// linearly over 2 a h / (H - h), because light, sheet and floor are parallel.
TEST(SoftTextures, PenumbraOfAParallelEdgeIsTheClosedForm)
{
    constexpr float k_height = 2, k_half = 0.2f;
    for (const float sheet : {0.25f, 0.5f, 1.0f}) {
        const auto scene = floor_and_sheet(sheet);
        const scene::SceneState state(scene, 0);
        LightViewsOptions options;
        options.atlas.view_size = 512;
        options.receivers = true;
        LightViews views(state, options);
        views.update(state);
        ASSERT_EQ(views.views().size(), 1u);
        const LightView& view = views.views()[0];
        SoftwareView buffer(view.tile.size);
        buffer.execute(view.plan, view.projection, state);
        const SoftLight light{{k_half, 0, 0}, {0, 0, k_half}};
        for (const SoftScale scale : k_scales) {
            CoherentSoftTextures textures(scale);
            textures.update(view, buffer.rendering(), views.casters(), state, light);
            const SoftTexture& floor = textures.textures().at(0);
            const float half_width = k_half * sheet / (k_height - sheet);   // of the penumbra on the floor
            double most = 0;
            for (int k = -150; k <= 150; ++k) {
                const float x = half_width * static_cast<float>(k) / 100;
                const float seen = soft_visibility(view.projection, floor, {x, 0, 0.1f}, {0, 1, 0});
                const float truth = std::clamp(0.5f + 0.5f * x / half_width, 0.0f, 1.0f);
                most = std::max(most, static_cast<double>(std::abs(seen - truth)));
            }
            // A texel is a part of the penumbra.
            const double texel = 2 * std::tan(1.0) * static_cast<double>(k_height) / view.tile.size /
                                 (2 * static_cast<double>(half_width));
            EXPECT_LT(most, texel) << "sheet at " << sheet;
            // The sheet itself is lit, and the floor far from it, too.
            EXPECT_FLOAT_EQ(soft_visibility(view.projection, textures.textures().at(1), {-1, sheet, 0}, {0, 1, 0}), 1);
            EXPECT_FLOAT_EQ(soft_visibility(view.projection, floor, {1.5f, 0, 0}, {0, 1, 0}), 1);
            EXPECT_FLOAT_EQ(soft_visibility(view.projection, floor, {-1.5f, 0, 0}, {0, 1, 0}), 0);
            EXPECT_FLOAT_EQ(soft_visibility(view.projection, floor, {1.5f, 0, 0}, {0, -1, 0}), 0);
        }
    }
}

// Five views of the half space before a light: each direction is found in the view that contains it.
TEST(SoftTextures, DirectionsOfAHalfCubeAreFoundInTheirViews)
{
    scene::Light kind;
    kind.type = scene::LightType::spot;
    kind.outer_angle = static_cast<float>(k_pi / 2);
    const glm::vec3 axis = glm::normalize(glm::vec3(0.3f, -0.8f, 0.4f));
    light_views::ProjectionOptions options;
    options.half_cubes = true;
    light_views::SceneBounds bounds;
    bounds.whole.add({-3, -3, -3}), bounds.whole.add({3, 3, 3});
    const auto projections = light_views::project(kind, {{0.1f, 0.2f, 0.3f}, axis, true}, bounds, 128, options);
    ASSERT_EQ(projections.size(), 5u);
    std::vector<LightView> views(5);
    for (std::size_t v = 0; v < 5; ++v) views[v].projection = projections[v];
    Random random(5);
    std::array<int, 5> found{};
    for (int k = 0; k < 2000; ++k) {
        glm::vec3 way(random.uniform() - 0.5f, random.uniform() - 0.5f, random.uniform() - 0.5f);
        if (glm::dot(way, axis) <= 0.01f) continue;
        const glm::vec3 point = projections[0].origin + 2.0f * way;
        const LightView* view = view_of(views, point);
        const glm::vec4 clip = view->projection.clip_from_world * glm::vec4(point, 1);
        ASSERT_GT(clip.w, 0);
        ASSERT_LE(std::max(std::abs(clip.x), std::abs(clip.y)), clip.w);
        ++found[static_cast<std::size_t>(view - views.data())];
    }
    for (const int count : found) EXPECT_GT(count, 50);
}

}   // namespace
}   // namespace gnomon::shadow_textures
