// SPDX-License-Identifier: Apache-2.0
// Every cache at once, driven through random sequences of what can change in a scene, equals a cache made anew in each
// step, to the bit.
//
// A sequence mixes steps in time, forwards and back, with user overrides: objects, members of rigid groups, parents and
// lights are moved (some far outside of the clip's bounds), put back, made singular, or set to where they already are;
// they are hidden and shown; objects get other weights and vertices, lights other colours and cones, materials other
// colours and roughness. The scenes hold what caches treat differently: static objects (one of them flat, one a
// constant morph), rigid groups, a parent that becomes singular, objects that appear, vanish and deform, a skin, and
// lights of all types that move and blink.
//
// Where a scene declares what may move, a state that lived through the sequence also equals a state made anew with the
// overrides that are in force, and so do the caches made from it.
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>

#include "base/bits.h"
#include "base/tasks.h"
#include "changing_clip.h"
#include "frame/rasterizer.h"
#include "irradiance_cache/irradiance_cache.h"
#include "light_quadtree/map_light.h"
#include "light_views/software.h"
#include "ray/kdtree/kdtree.h"
#include "ray_helpers.h"
#include "scene/view.h"
#include "shadow_culling/certified/certified_culling.h"
#include "trace/indirect_lights.h"
#include "trace/shadow_testers.h"
#include "trace/traced_frame.h"
#include "vk_helpers.h"

namespace gnomon {
namespace {

using scene::NodeId;
using scene::ObjectId;
using test::RandomClip;
using test::User;

// Everything of a state that FrameChanges speaks of.
struct Snapshot {
    struct Item {
        bool visible = false, there = false, dynamic = false;
        glm::mat4 matrix{1};
        std::vector<glm::vec3> positions;
        bool operator==(const Item&) const = default;
    };
    std::vector<Item> objects;

    explicit Snapshot(const scene::SceneState& state)
    {
        for (ObjectId o = 0; o < state.scene().objects.size(); ++o) {
            Item& item = objects.emplace_back();
            item.visible = state.object_visible(o);
            item.dynamic = state.is_dynamic(o);
            if (!item.visible) continue;
            item.there = state.object_there(o);
            item.matrix = state.object_matrix(o);
            if (state.scene().objects[o].deforming) item.positions = state.deformed(o).positions;
        }
    }
};

bool holds(const std::vector<ObjectId>& list, ObjectId object)
{
    return std::binary_search(list.begin(), list.end(), object);
}

void expect_lists_cover(const Snapshot& before, const Snapshot& now, const scene::SceneState& state)
{
    const scene::FrameChanges& changes = state.changes();
    for (const auto* list : {&changes.changed, &changes.promoted, &changes.separated})
        EXPECT_TRUE(std::adjacent_find(list->begin(), list->end(), std::greater_equal<>()) == list->end());
    for (ObjectId o = 0; o < now.objects.size(); ++o) {
        const bool listed = holds(changes.moved, o) || holds(changes.deformed, o) || holds(changes.appeared, o) ||
                            holds(changes.vanished, o);
        EXPECT_EQ(holds(changes.changed, o), listed) << o;
        Snapshot::Item then = before.objects[o];
        then.dynamic = now.objects[o].dynamic;
        if (!listed) {
            EXPECT_EQ(then, now.objects[o]) << o << " differs and is in no list";
        }
        EXPECT_EQ(holds(changes.promoted, o), now.objects[o].dynamic && !before.objects[o].dynamic) << o;
        if (!now.objects[o].dynamic) {
            EXPECT_FALSE(listed) << o;
        }
        const std::uint32_t index = state.dynamic_index(o);
        EXPECT_EQ(state.is_dynamic(o), index != scene::none);
        if (index != scene::none) {
            EXPECT_EQ(state.dynamic_objects()[index], o);
        }
    }
}

light_quadtree::MapLightOptions map_options()
{
    light_quadtree::MapLightOptions options;
    options.map.side = options.map.least_side = 64;
    options.grid = 0;
    return options;
}

// @param seed  of some sequences, the light tree has no room for the weakest light
irradiance_cache::CacheOptions cache_options(std::uint64_t seed = 0)
{
    irradiance_cache::CacheOptions options;
    options.light_tree.side = 32;
    if (seed % 2) options.light_tree.views = 8;
    options.widest = 12, options.narrowest = 6;
    return options;
}

// Blocks of the dynamic mask are drawn for few points, too.
shadow_culling::CertifiedOptions culling_options()
{
    shadow_culling::CertifiedOptions options;
    options.mask.asked = 1;
    options.mask.edges_per_ray = k_infinity;
    return options;
}

light_views::LightViewsOptions view_options(std::uint64_t seed)
{
    light_views::LightViewsOptions options;
    options.atlas.view_size = 32;
    options.quiet_frames = seed % 2 ? 1 : 4;
    return options;
}

light_views::SoftwareBuffer drawn_anew(const light_views::LightView& view, const light_views::LightViews& views,
                                       const scene::SceneState& state)
{
    light_views::SoftwareBuffer buffer(view.tile.size);
    for (ObjectId o = 0; o < state.scene().objects.size(); ++o)
        if (views.casters().casts(o) && state.object_there(o))
            light_views::draw_object(buffer, view.projection, state, o, view.projection.whole());
    return buffer;
}

std::size_t differing(const light_quadtree::LightMap& a, const light_quadtree::LightMap& b)
{
    std::size_t count = a.nodes().size() == b.nodes().size() ? 0 : ~std::size_t{0} / 2;
    for (std::size_t id = 0; id < std::min(a.nodes().size(), b.nodes().size()); ++id)
        count += !same_bits(a.node(id), b.node(id)) || a.valid(id) != b.valid(id);
    return count;
}

// Whether two maps differ by rounding alone. A packet of closest-hit rays may give other last bits than a packet of
// other rays around the same one, and a map that is repaired traces fewer texels at once than a new one.
bool equal_up_to_rounding(const light_quadtree::LightMap& a, const light_quadtree::LightMap& b)
{
    constexpr float k_tolerance = 1e-5f;
    const auto near = [](float x, float y) { return std::abs(x - y) <= k_tolerance * std::max(1.0f, std::abs(x)); };
    if (a.nodes().size() != b.nodes().size()) return false;
    for (std::size_t id = 0; id < a.nodes().size(); ++id) {
        const light_quadtree::LightNode x = a.node(id), y = b.node(id);
        if (a.valid(id) != b.valid(id) || x.members != y.members) return false;
        if (!near(x.depth, y.depth) || !near(x.area, y.area)) return false;
        for (int c = 0; c < 3; ++c)
            if (!near(x.position[c], y.position[c]) || !near(x.normal[c], y.normal[c]) || !near(x.flux[c], y.flux[c]))
                return false;
    }
    return true;
}

struct Tally {
    std::uint64_t promoted = 0, separated = 0, relit = 0, skipped = 0, hits = 0, lit = 0;
    std::uint64_t outside = 0;   // steps in which objects are outside of the clip's bounds
    std::uint64_t rounded = 0;   // steps in which the light map differed by rounding alone
};

// All caches of one sequence.
class Caches {
 public:
    Caches(const scene::SceneState& state, std::uint64_t seed)
        : state_(state),
          seed_(seed),
          rays_(state),
          kdtree_(state, rays_),
          culling_(state, rays_, culling_options()),
          visible_(state, rays_, cache_options(seed_), tasks_),
          map_(state, rays_, map_options(), tasks_),
          views_(state, view_options(seed))
    {
        make_buffers();
        options_.layers = true;
        options_.max_depth = 2;
    }

    /// Follows one advance() and compares everything with what remembers nothing.
    /// @param as  the state to make it from: this one, or one made anew that must be equal
    void follow(const scene::SceneState& as, Tally& tally)
    {
        rays_.update(state_);
        const ray::RayScene anew(as);
        const ray::RayQueue queue = test::random_rays(seed_ * 1000 + step_++, 400, 5);
        const test::Answers answers = test::trace(rays_, queue);
        EXPECT_EQ(test::differences(answers, test::trace(anew, queue)), 0u) << "rays";
        tally.hits += test::count_hits(answers);
        compare_kdtrees(as, anew, queue);

        // The caches below share the ray scene: packets of closest-hit rays may differ in the last bit between two
        // builds of the same trees. Frames: shadows and bounced light remembered, against neither; then bounced light
        // by the light map.
        trace::CertifiedShadows shadows(culling_);
        irradiance_cache::IrradianceCache fresh_cache(as, rays_, cache_options(seed_), tasks_);
        trace::CachedIndirect cached(visible_), fresh_cached(fresh_cache);
        tally.skipped +=
            compare_frames(as, {&shadows, &cached}, {nullptr, &fresh_cached}, "shadows and irradiance cache", tally);
        light_quadtree::MapLight fresh_map(as, rays_, map_options(), tasks_);
        trace::MapIndirect mapped(map_), fresh_mapped(fresh_map);
        std::size_t differ = 0;
        compare_frames(as, {nullptr, &mapped}, {nullptr, &fresh_mapped}, "light map", tally, [&] {
            differ = differing(map_.map(), fresh_map.map());
            return differ == 0;
        });
        if (differ > 0) {
            EXPECT_TRUE(equal_up_to_rounding(map_.map(), fresh_map.map())) << differ << " nodes of the light map";
            ++tally.rounded;
        }
        tally.outside += !(state_.present_bounds() == scene::clip_bounds(state_.scene()));
        compare_light_views(as);
    }

 private:
    void compare_light_views(const scene::SceneState& as)
    {
        views_.update(state_);
        if (layout_ != views_.layout_version()) make_buffers();
        light_views::LightViews fresh(as, view_options(seed_));
        fresh.update(as);
        ASSERT_EQ(views_.views().size(), fresh.views().size()) << "light views";
        for (std::size_t v = 0; v < buffers_.size(); ++v) {
            const light_views::LightView& view = views_.views()[v];
            EXPECT_EQ(view.shown, fresh.views()[v].shown);
            if (!view.shown) continue;
            EXPECT_TRUE(view.projection.same_bits(fresh.views()[v].projection)) << "light view " << v;
            buffers_[v].execute(view.plan, view.projection, state_);
            EXPECT_TRUE(buffers_[v].rendering() == drawn_anew(view, views_, state_)) << "light view " << v;
        }
    }

    void make_buffers()
    {
        layout_ = views_.layout_version();
        buffers_.clear();
        for (const light_views::LightView& view : views_.views()) buffers_.emplace_back(view.tile.size);
    }

    void compare_kdtrees(const scene::SceneState& as, const ray::RayScene& anew, const ray::RayQueue& queue)
    {
        kdtree_.update(state_, rays_);
        const ray::CountingKdTree fresh(as, anew);
        ray::KdCounts counts;
        std::size_t differ = 0;
        for (std::size_t i = 0; i < queue.size(); i += 2) {
            const glm::vec3 from = queue.origin(i), along = queue.direction(i);
            const auto closest = [&](const ray::CountingKdTree& tree) {
                return tree.closest(from, queue.tnear[i], along, queue.tfar[i], ray::Sides::both, counts);
            };
            differ += !test::same_bits(closest(kdtree_), closest(fresh));
            for (const ray::Against against : {ray::Against::static_only, ray::Against::dynamic_only}) {
                const auto occluded = [&](const ray::CountingKdTree& tree) {
                    return tree.occluded(from, queue.tnear[i], along, queue.tfar[i], against, counts);
                };
                differ += occluded(kdtree_) != occluded(fresh);
            }
        }
        EXPECT_EQ(differ, 0u) << "k-d tree";
    }

    std::uint64_t compare_frames(
        const scene::SceneState& as, const trace::Techniques& kept, const trace::Techniques& made_anew,
        const char* what, Tally& tally, const std::function<bool()>& must_be_equal = [] { return true; })
    {
        const scene::View view = scene::make_view(state_, 0, {24, 18});
        shading::FrameBuffers mine, fresh;
        const std::uint64_t skipped =
            trace::trace_frame(state_, rays_, view, options_, tasks_, mine, kept).shadow.rays_skipped;
        trace::trace_frame(as, rays_, view, options_, tasks_, fresh, made_anew);
        if (must_be_equal()) {
            EXPECT_TRUE(same_bits(mine.color.data, fresh.color.data)) << what;
            EXPECT_TRUE(same_bits(mine.indirect.data, fresh.indirect.data)) << what << ", indirect light";
        }
        for (const float value : mine.indirect.data) tally.lit += value > 0;
        return skipped;
    }

    const scene::SceneState& state_;
    std::uint64_t seed_, step_ = 0;
    Tasks tasks_{1};
    ray::RayScene rays_;
    ray::CountingKdTree kdtree_;
    shadow_culling::CertifiedCulling culling_;
    irradiance_cache::IrradianceCache visible_;
    light_quadtree::MapLight map_;
    light_views::LightViews views_;
    std::uint32_t layout_ = 0;
    std::vector<light_views::SoftwareView> buffers_;
    trace::TracedOptions options_;
};

// What a state shows, wherever it came from, equals what another one shows.
void expect_same_state(const scene::SceneState& state, const scene::SceneState& anew)
{
    const Snapshot mine(state), fresh(anew);
    for (ObjectId o = 0; o < mine.objects.size(); ++o) {
        EXPECT_EQ(mine.objects[o].visible, fresh.objects[o].visible) << o;
        EXPECT_EQ(mine.objects[o].matrix, fresh.objects[o].matrix) << o;
        EXPECT_EQ(mine.objects[o].positions, fresh.objects[o].positions) << o;
    }
    for (scene::LightId l = 0; l < state.scene().lights.size(); ++l) {
        EXPECT_EQ(state.light(l), anew.light(l));
        EXPECT_TRUE(scene::same_reach(state.scene().lights[l], anew.scene().lights[l]));
        EXPECT_EQ(state.scene().lights[l].color, anew.scene().lights[l].color);
    }
    for (scene::MaterialId m = 0; m < state.scene().materials.size(); ++m)
        EXPECT_TRUE(scene::same_values(state.scene().materials[m], anew.scene().materials[m]));
    EXPECT_TRUE(state.present_bounds() == anew.present_bounds());
}

// @param declared  the scene declares what may move, so a state made anew is equal in all that caches see
void follow_sequence(std::uint64_t seed, int steps, bool declared, Tally& tally)
{
    const RandomClip clip = test::random_clip(seed, declared);
    User user(clip, seed);
    scene::SceneState state(clip.scene, 0);
    Caches caches(state, seed);
    caches.follow(state, tally);   // the first frame is of the step in which the caches were made
    for (int step = 0; step < steps && !testing::Test::HasFailure(); ++step) {
        SCOPED_TRACE(testing::Message() << "seed " << seed << ", step " << step << ", time " << state.time());
        const Snapshot before(state);
        user.act(state);
        state.advance(user.next_time(state.time()));
        expect_lists_cover(before, Snapshot(state), state);
        scene::SceneState anew(clip.scene, state.time());
        user.apply(anew);
        anew.advance(state.time());
        expect_same_state(state, anew);
        if (declared) {
            EXPECT_TRUE(state.taken_objects().empty());
        }
        caches.follow(declared ? anew : state, tally);
        tally.promoted += state.changes().promoted.size();
        tally.separated += state.changes().separated.size();
        tally.relit += state.changes().lights_relit.size() + state.changes().materials_changed.size();
    }
}

TEST(Changes, EveryCacheEqualsOneMadeAnew)
{
    Tally tally;
    for (std::uint64_t seed = 1; seed <= 16; ++seed) follow_sequence(seed, 12, seed % 4 > 1, tally);
    // The sequences were rich enough to mean something.
    EXPECT_GT(tally.promoted, 30u);
    EXPECT_GT(tally.separated, 10u);
    EXPECT_GT(tally.relit, 40u);
    EXPECT_GT(tally.outside, 40u);
    EXPECT_GT(tally.skipped, 5'000u);
    EXPECT_GT(tally.hits, 5'000u);
    EXPECT_GT(tally.lit, 20'000u);
    EXPECT_LE(tally.rounded, 2u);
}

TEST(ChangesFull, EveryCacheEqualsOneMadeAnewOverAThousandSeeds)
{
    Tally tally;
    for (std::uint64_t seed = 101; seed <= 1100 && !HasFailure(); ++seed)
        follow_sequence(seed, 16, seed % 4 > 1, tally);
    EXPECT_LE(tally.rounded, 160u);   // of 16,000 steps
}

#ifdef GNOMON_VULKAN
class ChangesVulkan : public test::VulkanTest {};
class ChangesVulkanFull : public test::VulkanTest {};

// @param every  steps between comparisons with a rasterizer made anew, which takes long
void follow_on_device(std::uint64_t seed, int steps, int every, Indirect indirect)
{
    const RandomClip clip = test::random_clip(seed);
    User user(clip, seed, false);   // the shadows of many emissive surfaces would take minutes
    scene::SceneState state(clip.scene, 0);
    ray::RayScene rays(state);
    Tasks tasks(1);
    const auto make = [&](const ray::RayScene& with) {
        return frame::make_rasterizer(state, {.layers = true,
                                              .indirect = indirect,
                                              .map = map_options(),
                                              .visible = cache_options(),
                                              .rays = &with,
                                              .tasks = &tasks});
    };
    const auto kept = make(rays);
    shading::FrameBuffers mine, fresh;
    kept->render(state, scene::make_view(state, 0, {48, 36}), mine, {});
    for (int step = 1; step <= steps && !testing::Test::HasFailure(); ++step) {
        SCOPED_TRACE(testing::Message() << "seed " << seed << ", step " << step << ", time " << state.time());
        user.act(state);
        state.advance(user.next_time(state.time()));
        rays.update(state);
        kept->update(state);
        const scene::View view = scene::make_view(state, 0, {48, 36});
        kept->render(state, view, mine, {});
        if (step % every) continue;
        const ray::RayScene anew(state);
        make(anew)->render(state, view, fresh, {});
        EXPECT_TRUE(same_bits(mine.color.data, fresh.color.data));
        EXPECT_TRUE(same_bits(mine.shadow.data, fresh.shadow.data)) << "shadows";
        EXPECT_TRUE(same_bits(mine.indirect.data, fresh.indirect.data)) << "indirect light";
    }
}

TEST_F(ChangesVulkan, RasterFrameEqualsOneMadeAnew)
{
    follow_on_device(1, 5, 5, Indirect::visible);
    follow_on_device(2, 6, 3, Indirect::quadtree);
    follow_on_device(14, 6, 3, Indirect::quadtree);   // lights are relit, and do not move afterwards
}

TEST_F(ChangesVulkanFull, RasterFrameEqualsOneMadeAnewOverManySeeds)
{
    for (std::uint64_t seed = 11; seed <= 60 && !HasFailure(); ++seed)
        follow_on_device(seed, 16, 2, seed % 2 ? Indirect::visible : Indirect::quadtree);
}
#else
TEST(ChangesVulkan, LeftOut)
{
    GNOMON_SKIP_WITHOUT_VULKAN;
}
#endif

}   // namespace
}   // namespace gnomon
