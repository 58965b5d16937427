// SPDX-License-Identifier: Apache-2.0
// The parts of light views: projections and footprints, the light-space index, the atlas, and the cost of a plan.
#include "light_views/light_views.h"

#include <gtest/gtest.h>

#include <set>

#include "light_script.h"
#include "light_views/software.h"

namespace gnomon::light_views {
namespace {

TEST(FootprintIndex, EqualsALinearSearch)
{
    constexpr int size = 256;
    constexpr scene::ObjectId count = 300;
    FootprintIndex index(size, count);
    std::vector<Rect> rects(count);
    Random random(3);
    const auto random_rect = [&] {
        const int wide = 1 + static_cast<int>(random.below(random.below(4) == 0 ? 250 : 20));
        const int high = 1 + static_cast<int>(random.below(random.below(4) == 0 ? 250 : 20));
        const int x = static_cast<int>(random.below(static_cast<std::uint32_t>(size - wide + 1)));
        const int y = static_cast<int>(random.below(static_cast<std::uint32_t>(size - high + 1)));
        return Rect{x, y, x + wide, y + high};
    };
    for (int step = 0; step < 5000; ++step) {
        const scene::ObjectId object = random.below(count);
        if (index.contains(object)) {
            EXPECT_EQ(index.rect(object), rects[object]);
            index.erase(object);
            rects[object] = {};
        } else {
            rects[object] = random_rect();
            index.insert(object, rects[object]);
        }
        if (step % 10) continue;
        const Rect query = random_rect();
        std::vector<scene::ObjectId> found, expected;
        index.query(query, found);
        std::sort(found.begin(), found.end());
        for (scene::ObjectId o = 0; o < count; ++o)
            if (!rects[o].empty() && rects[o].overlaps(query)) expected.push_back(o);
        ASSERT_EQ(found, expected) << "step " << step;
    }
}

TEST(FootprintIndex, VisitsNearbyCellsOnly)
{
    // The same objects around the query, and ever more elsewhere.
    std::uint64_t touched[2];
    for (const int many : {0, 1}) {
        FootprintIndex index(2048, 70000);
        scene::ObjectId next = 0;
        for (int y = 0; y < 2048; y += 8)
            for (int x = 0; x < 2048; x += 8)
                if (many || (x < 128 && y < 128)) index.insert(next++, {x, y, x + 7, y + 7});
        std::vector<scene::ObjectId> found;
        index.query({40, 40, 60, 60}, found);
        EXPECT_EQ(found.size(), 9u);
        touched[many] = index.touched();
    }
    EXPECT_EQ(touched[0], touched[1]);
    EXPECT_LE(touched[1], 40u);
}

TEST(LightAtlas, GivesEveryViewItsOwnSquareWithinTheBudget)
{
    for (const int lights : {1, 3, 17, 200}) {
        std::vector<int> views;
        for (int l = 0; l < lights; ++l) views.push_back(l % 3 == 1 ? 6 : 1);
        AtlasOptions options;
        options.budget_texels = 1 << 22;
        const Atlas atlas = make_atlas(views, options);
        EXPECT_LE(atlas.texels(), options.budget_texels);
        ASSERT_EQ(atlas.first_tile.size(), views.size() + 1);
        for (std::size_t a = 0; a < atlas.tiles.size(); ++a) {
            const Tile& tile = atlas.tiles[a];
            EXPECT_GE(tile.size, options.least_size);
            EXPECT_TRUE((Rect{0, 0, atlas.page_size, atlas.page_size}.contains(tile.rect())));
            EXPECT_LT(tile.page, atlas.pages);
            for (std::size_t b = a + 1; b < atlas.tiles.size(); ++b)
                EXPECT_FALSE(tile.page == atlas.tiles[b].page && tile.rect().overlaps(atlas.tiles[b].rect()))
                    << a << " and " << b << " of " << lights;
        }
        // No more pages are used than the tiles need.
        const std::int64_t page = static_cast<std::int64_t>(atlas.page_size) * atlas.page_size;
        EXPECT_LT((atlas.pages - 1) * page, atlas.texels());
    }
    AtlasOptions tiny;
    tiny.budget_texels = 1000;
    EXPECT_THROW(make_atlas(std::vector<int>(10, 6), tiny), MissingError);
    EXPECT_EQ(make_atlas({}, {}).pages, 0);
}

TEST(LightViews, FootprintsContainEveryDrawnTexel)
{
    const test::LightScript script = test::make_light_script(4, 40);
    scene::SceneState state(script.scene, 0);
    LightViewsOptions options;
    options.atlas.view_size = 64;
    LightViews views(state, options);
    std::uint64_t drawn = 0, covered = 0;
    for (int frame = 0; frame < 40; frame += 13) {
        state.advance(script.time(frame));
        views.update(state);
        for (const LightView& view : views.views()) {
            if (!view.shown) continue;
            for (scene::ObjectId o = 0; o < script.scene->objects.size(); ++o) {
                if (!state.object_visible(o)) continue;
                const Rect rect = views.casters().footprint(view.projection, state, o);
                SoftwareBuffer buffer(view.tile.size);
                draw_object(buffer, view.projection, state, o, view.projection.whole());
                Rect touched;
                for (int y = 0; y < buffer.size; ++y)
                    for (int x = 0; x < buffer.size; ++x)
                        if (buffer.item[buffer.at(x, y)]) touched = around(touched, {x, y, x + 1, y + 1});
                EXPECT_TRUE(touched.empty() || rect.contains(touched));
                drawn += static_cast<std::uint64_t>(touched.area());
                covered += static_cast<std::uint64_t>(touched.empty() ? 0 : rect.area());
            }
        }
    }
    EXPECT_GT(drawn, 0u);
    EXPECT_LT(covered, 3 * drawn);   // and not many more
}

TEST(LightViews, FacesOfAPointLightCoverEveryDirection)
{
    scene::Light light;
    light.type = scene::LightType::point;
    const auto views = project(light, {.position = {1, 2, 3}}, {{{-5, -5, -5}, {5, 5, 5}}, {}}, 64, {});
    ASSERT_EQ(views.size(), 6u);
    Random random(1);
    for (int i = 0; i < 1000; ++i) {
        const glm::vec3 d(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
        int seen = 0, axis = 0;
        for (int a = 1; a < 3; ++a)
            if (std::abs(d[a]) > std::abs(d[axis])) axis = a;
        const std::size_t face = 2 * static_cast<std::size_t>(axis) + (d[axis] < 0 ? 1 : 0);
        for (std::size_t f = 0; f < 6; ++f) {
            const glm::vec4 clip = views[f].clip_from_world * glm::vec4(glm::vec3(1, 2, 3) + d, 1);
            const bool inside = clip.w > 0 && std::abs(clip.x) <= clip.w && std::abs(clip.y) <= clip.w;
            seen += inside;
            if (f == face) {
                EXPECT_TRUE(inside);
            }
        }
        EXPECT_GE(seen, 1);
    }
}

std::shared_ptr<const scene::Scene> static_scene(int still, int dynamic_objects)
{
    scene::Scene scene = test::scene_with_balls();
    for (int i = 0; i < still; ++i) {   // a layer of balls of uniform density, the first ones under the dynamic objects
        const int x = i % 10 + 10 * (i / 100 % 32), z = i / 10 % 10 + 10 * (i / 3200);
        test::add_object(scene, 0, scene::none, glm::scale(test::translation(0.1 * x, 0, 0.1 * z), glm::dvec3(0.05)));
    }
    for (int i = 0; i < dynamic_objects; ++i) {
        const scene::NodeId node = test::add_object(scene, 0);
        const glm::dmat4 size = glm::scale(glm::dmat4(1), glm::dvec3(0.05));
        const glm::dmat4 a = test::translation(0.1 * i, 0.3, 0.4) * size,
                         b = test::translation(0.1 * i, 0.3, 0.5) * size;
        scene.nodes[node].transform = std::make_shared<test::JumpTrack>(1, a, b);
    }
    scene::Light light;
    light.type = scene::LightType::spot;
    light.outer_angle = 0.3f;
    light.node = scene.add_node(
        "", scene::none,
        glm::inverse(glm::lookAt(glm::dvec3(0.5, 3, 0.5), glm::dvec3(0.5, 0, 0.5), glm::dvec3(0, 0, 1))));
    scene.lights.push_back(light);
    return test::finished(scene);
}

TEST(LightViews, CostDependsOnMovedObjectsOnly)
{
    LightViewsOptions options;
    options.receivers = true;
    std::uint64_t touched[2], receivers[2], draws[2];
    for (const int many : {0, 1}) {
        scene::SceneState state(static_scene(many ? 20000 : 400, 10), 0);
        LightViews views(state, options);
        views.update(state);
        EXPECT_EQ(views.views()[0].plan.kind, ViewPlan::Kind::whole);
        for (const double time : {1.0, 0.0, 1.0, 0.0, 1.0}) {
            state.advance(time);
            views.update(state);
        }
        touched[many] = views.counts().touched;
        receivers[many] = views.views()[0].plan.receivers.size();
        draws[many] = views.counts().draws;
    }
    EXPECT_EQ(draws[0], 10u);
    EXPECT_EQ(draws[0], draws[1]);
    EXPECT_EQ(receivers[0], receivers[1]);
    EXPECT_LE(touched[1], touched[0] + touched[0] / 10);
}

TEST(LightViews, DoesNothingWhileNothingMoves)
{
    scene::SceneState state(static_scene(50, 3), 0);
    LightViewsOptions options;
    options.quiet_frames = 3;
    LightViews views(state, options);
    views.update(state);
    EXPECT_GT(views.counts().draws, 0u);
    const auto frame = [&](double time) {
        state.advance(time);
        views.update(state);
        return views.views()[0].plan;
    };
    EXPECT_EQ(frame(0.5).kind, ViewPlan::Kind::idle);
    EXPECT_FALSE(frame(1.5).rebuild.empty());   // they were in the static buffer until now
    EXPECT_EQ(frame(1.5).kind, ViewPlan::Kind::idle);
    EXPECT_EQ(frame(0.5).rebuild.size(), 0u);   // not moved back into it at once
    EXPECT_EQ(frame(0.5).kind, ViewPlan::Kind::idle);
    EXPECT_EQ(frame(0.5).kind, ViewPlan::Kind::idle);
    EXPECT_EQ(frame(0.5).settle.size(), 3u);
    for (int i = 0; i < 5; ++i) {
        EXPECT_EQ(frame(0.5).kind, ViewPlan::Kind::idle);
        EXPECT_EQ(views.counts().draws + views.counts().copies + views.counts().touched, 0u);
    }
}

TEST(LightViews, ManyLightsKeepTheirTiles)
{
    scene::Scene scene = test::scene_with_balls();
    for (int row = 0; row < 4; ++row)
        for (int column = 0; column < 5; ++column)
            test::add_object(scene, 0, scene::none, test::translation(3 * column, 0, 3 * row));
    const scene::NodeId dynamic_object = test::add_object(scene, 0);
    scene.nodes[dynamic_object].transform = std::make_shared<test::SwayTrack>(glm::dvec3(5, 2, 5), 1);
    for (int i = 0; i < 100; ++i) {
        const int column = i % 10, row = i / 10;
        scene::Light light;
        light.type = i % 2 ? scene::LightType::point : scene::LightType::spot;
        light.node = scene.add_node(
            "", scene::none, glm::rotate(test::translation(3 * column, 6, 2 * row), -k_pi / 2, glm::dvec3(1, 0, 0)));
        scene.lights.push_back(light);
    }
    scene::SceneState state(test::finished(scene), 0);
    LightViewsOptions options;
    options.atlas.budget_texels = 1 << 20;
    LightViews views(state, options);
    views.update(state);
    std::vector<Rect> places;
    for (const LightView& view : views.views()) places.push_back(view.tile.rect());
    for (int frame = 1; frame < 20; ++frame) {
        state.advance(0.1 * frame);
        views.update(state);
        for (std::size_t v = 0; v < places.size(); ++v) {
            EXPECT_EQ(views.views()[v].tile.rect(), places[v]);
            EXPECT_NE(views.views()[v].plan.kind, ViewPlan::Kind::whole);   // no view is ever redrawn
        }
        // Only the dynamic object, where it is visible; in the first frame it leaves the static buffer.
        if (frame > 1) {
            EXPECT_LE(views.counts().draws, views.views().size());
        }
    }
}

TEST(LightViews, MobilityOverridesChangeThePlan)
{
    scene::SceneState state(static_scene(50, 3), 0);
    LightViews views(state, {});
    views.set_override(0, scene::MobilityOverride::always_dynamic);
    views.set_override(50, scene::MobilityOverride::always_static);
    views.update(state);
    EXPECT_TRUE(views.is_dynamic(0));
    state.advance(1.5);
    views.update(state);
    EXPECT_FALSE(views.is_dynamic(50));
    EXPECT_TRUE(views.is_dynamic(51));
    const ViewPlan& plan = views.views()[0].plan;
    EXPECT_EQ(plan.dynamics, (std::vector<scene::ObjectId>{0, 51, 52}));
    ASSERT_EQ(plan.settle.size(),
              1u);   // the object that moved and counts as static is updated within the static buffer
    EXPECT_EQ(plan.settle[0].object, 50u);
}

}   // namespace
}   // namespace gnomon::light_views
