// SPDX-License-Identifier: Apache-2.0
// Every cache at once, driven through random sequences of what can change in a scene, equals a cache made anew in each
// step, to the bit.
//
// A sequence mixes steps in time, forwards and back, with user overrides: objects, members of rigid groups, parents and
// lights are moved, put back, made singular, or set to where they already are. The scenes hold what caches treat
// differently: static objects (one of them flat, one a constant morph), rigid groups, a parent that becomes singular,
// objects that appear, vanish and deform, a skin, and lights of all types that move and blink.
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <set>

#include "base/bits.h"
#include "base/tasks.h"
#include "frame/rasterizer.h"
#include "irradiance_cache/irradiance_cache.h"
#include "light_quadtree/map_light.h"
#include "light_script.h"
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

constexpr int k_frames = 24;   // of a clip
constexpr double k_fps = 24;

// Regular, singular and regular again.
class CollapsingTrack final : public scene::TransformTrack {
 public:
    explicit CollapsingTrack(const glm::dmat4& place) : place_(place) {}
    glm::dmat4 evaluate(double time) const override
    {
        const int frame = static_cast<int>(time * k_fps + 0.5);
        return frame % 8 < 5 ? place_ : place_ * glm::scale(glm::dmat4(1), glm::dvec3(1, frame % 2 ? 0 : 1, 0));
    }
    std::vector<scene::Interval> changing() const override
    {
        std::vector<scene::Interval> intervals;
        for (int frame = 0; frame <= k_frames; ++frame) intervals.push_back({frame / k_fps - 0.03, frame / k_fps});
        return intervals;
    }

 private:
    glm::dmat4 place_;
};

struct RandomClip {
    std::shared_ptr<const scene::Scene> scene;
    std::vector<NodeId> movable;   // nodes that a user may take
};

RandomClip random_clip(std::uint64_t seed)
{
    Random random(seed, 3);
    scene::Scene made;
    test::add_materials(made);
    for (scene::MaterialId m = 0; m < test::material_count; ++m) made.meshes.push_back(test::ball(m, 4, 6, seed + m));
    const std::uint32_t rigid = static_cast<std::uint32_t>(made.meshes.size());
    const auto add_mesh = [&](scene::Mesh mesh) {
        made.meshes.push_back(std::move(mesh));
        return static_cast<scene::MeshId>(made.meshes.size() - 1);
    };
    RandomClip clip;
    const auto add = [&](scene::MeshId mesh, NodeId parent, const glm::dmat4& local) {
        clip.movable.push_back(test::add_object(made, mesh, parent, local));
        return clip.movable.back();
    };
    const auto scripted = [&](std::uint64_t n, float reach) {
        std::vector<glm::dmat4> places;
        for (int i = 0; i < 3; ++i) places.push_back(test::random_placement(random, reach));
        return std::make_shared<test::ScriptTrack>(std::move(places), k_frames, k_fps, seed * 31 + n);
    };
    const glm::dmat4 flat = glm::scale(glm::dmat4(1), glm::dvec3(1, 0, 1));

    // Static: a floor and a wall, a shelf of balls, a flat one, and a morph that never changes.
    add(0, scene::none, test::translation(0, -3, 0) * glm::scale(glm::dmat4(1), glm::dvec3(6, 0.2, 6)));
    add(0, scene::none, test::translation(0, 0, -5) * glm::scale(glm::dmat4(1), glm::dvec3(6, 4, 0.3)));
    const NodeId shelf = made.add_node("shelf", scene::none, test::translation(0.3, 0.2, 0));
    clip.movable.push_back(shelf);
    for (int i = 0; i < 4; ++i) add(random.below(rigid), shelf, test::random_placement(random, 2.5f));
    add(0, shelf, test::random_placement(random, 2) * flat);
    scene::Mesh morph = test::ball(0, 4, 6, seed + 50);
    morph.normals.clear();
    morph.morph_targets.resize(1);
    morph.morph_targets[0].positions.assign(morph.positions.size(), glm::vec3(0.1f, 0.2f, 0));
    morph.morph_weights = {0.5f};
    add(add_mesh(std::move(morph)), scene::none, test::random_placement(random, 2));

    // Rigid groups of two, one of the members flat; a group inside a parent that collapses.
    for (std::uint64_t g = 0; g < 2; ++g) {
        const NodeId anchor = made.add_node("anchor", scene::none);
        made.nodes[anchor].transform = scripted(g, 2.5f);
        const NodeId arm = made.add_node("arm", anchor, test::random_placement(random, 0.5f));
        clip.movable.insert(clip.movable.end(), {anchor, arm});
        add(random.below(rigid), arm, glm::scale(glm::dmat4(1), glm::dvec3(0.6)));
        add(random.below(rigid), arm, test::random_placement(random, 1) * (g ? flat : glm::dmat4(1)));
    }
    const NodeId collapsing = made.add_node("collapsing", scene::none);
    made.nodes[collapsing].transform = std::make_shared<CollapsingTrack>(test::random_placement(random, 2));
    clip.movable.push_back(collapsing);
    add(random.below(rigid), collapsing, glm::dmat4(1));
    add(random.below(rigid), collapsing, test::translation(1, 0, 0) * flat);
    made.nodes[add(random.below(rigid), collapsing, glm::dmat4(1))].transform = scripted(7, 1);

    // What appears and vanishes, deforms, or follows a joint.
    made.nodes[add(random.below(rigid), scene::none, test::random_placement(random, 2))].visibility =
        test::blinking(k_frames, k_fps, 5, random);
    scene::Mesh deforming = test::patchwork(seed + 60);
    test::add_vertex_keys(deforming);
    deforming.vertex_keys->times = {0.2, 0.4, 0.8};
    made.nodes[add(add_mesh(std::move(deforming)), scene::none, test::random_placement(random, 2))].visibility =
        test::blinking(k_frames, k_fps, 9, random);
    scene::Mesh skinned = test::ball(0, 4, 6, seed + 70);
    skinned.skin.emplace();
    skinned.skin->joints[0].assign(skinned.positions.size(), glm::u16vec4(0));
    skinned.skin->weights[0].assign(skinned.positions.size(), glm::vec4(1, 0, 0, 0));
    const NodeId joint = made.add_node("joint", scene::none);
    made.nodes[joint].transform = scripted(8, 2);
    made.skins.push_back({"", {joint}, {glm::dmat4(1)}});
    made.nodes[add(add_mesh(std::move(skinned)), scene::none, glm::dmat4(1))].skin = 0;

    const auto add_light = [&](scene::LightType type, const glm::dvec3& at) {
        scene::Light light;
        light.type = type;
        light.color = glm::vec3(type == scene::LightType::directional ? 2.0f : 60.0f);
        light.outer_angle = 0.7f;
        light.node = made.add_node("", scene::none,
                                   glm::inverse(glm::lookAt(at, glm::dvec3(0.1, -0.3, 0.2), glm::dvec3(0.1, 1, 0.3))));
        made.lights.push_back(light);
        return light.node;
    };
    clip.movable.push_back(add_light(scene::LightType::spot, {2, 7, 4}));
    clip.movable.push_back(add_light(scene::LightType::point, {-2, 2, 2}));
    made.nodes[add_light(scene::LightType::directional, {1, 3, 2})].visibility =
        test::blinking(k_frames, k_fps, 9, random);
    const NodeId moving = add_light(scene::LightType::spot, {-4, 5, 3});
    const glm::dmat4 from = made.nodes[moving].local;
    made.nodes[moving].transform = std::make_shared<test::JumpTrack>(0.5, from, test::translation(0.5, 0.2, 0) * from);

    scene::Camera camera;
    camera.node = made.add_node("camera", scene::none, test::translation(0, 0.5, 9));
    made.cameras.push_back(camera);
    clip.scene = test::finished(made);
    return clip;
}

// What a user has taken, and does next.
class User {
 public:
    User(const RandomClip& clip, std::uint64_t seed) : clip_(clip), random_(seed, 4) {}

    /// The time of the next step.
    double next_time(double now)
    {
        const std::uint32_t kind = random_.below(8);
        if (kind < 2) return now;
        if (kind < 6) return std::min(now + 1 / k_fps, k_frames / k_fps);
        return random_.below(k_frames) / k_fps;
    }
    void act(scene::SceneState& state)
    {
        for (std::uint32_t n = random_.below(4); n > 0; --n) {
            const NodeId node = clip_.movable[random_.below(static_cast<std::uint32_t>(clip_.movable.size()))];
            const scene::Node& of = clip_.scene->nodes[node];
            if (!taken_.contains(node) && of.transform == nullptr && random_.below(8) == 0) {
                state.override_transform(node, &of.local);   // where it is
                continue;
            }
            if (taken_.contains(node) && random_.below(2)) {
                put_back(state, node);
                continue;
            }
            glm::dmat4 local = of.transform ? of.transform->evaluate(0) : of.local;
            local[3] += glm::dvec4(move(), move(), move(), 0);
            if (random_.below(4) == 0)
                local *= glm::scale(glm::dmat4(1), glm::dvec3(1, random_.below(2), random_.below(2)));
            taken_.insert(node);
            state.override_transform(node, &local);
        }
        if (random_.below(10) == 0)
            while (!taken_.empty()) put_back(state, *taken_.begin());
    }

 private:
    double move() { return static_cast<double>(random_.uniform(-1, 1)); }
    void put_back(scene::SceneState& state, NodeId node)
    {
        state.override_transform(node, nullptr);
        taken_.erase(node);
    }

    const RandomClip& clip_;
    Random random_;
    std::set<NodeId> taken_;
};

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

irradiance_cache::CacheOptions cache_options()
{
    irradiance_cache::CacheOptions options;
    options.light_tree.side = 32;
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
    std::uint64_t promoted = 0, separated = 0, skipped = 0, hits = 0, lit = 0;
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
          visible_(state, rays_, cache_options(), tasks_),
          map_(state, rays_, map_options(), tasks_),
          views_(state, view_options(seed))
    {
        for (const light_views::LightView& view : views_.views()) buffers_.emplace_back(view.tile.size);
        options_.layers = true;
        options_.max_depth = 2;
    }

    /// Follows one advance() and compares everything with what remembers nothing.
    void follow(Tally& tally)
    {
        rays_.update(state_);
        const ray::RayScene anew(state_);
        const ray::RayQueue queue = test::random_rays(seed_ * 1000 + step_++, 400, 5);
        const test::Answers answers = test::trace(rays_, queue);
        EXPECT_EQ(test::differences(answers, test::trace(anew, queue)), 0u) << "rays";
        tally.hits += test::count_hits(answers);
        compare_kdtrees(anew, queue);

        // The caches below share the ray scene: packets of closest-hit rays may differ in the last bit between two
        // builds of the same trees. Frames: shadows and bounced light remembered, against neither; then bounced light
        // by the light map.
        trace::CertifiedShadows shadows(culling_);
        irradiance_cache::IrradianceCache fresh_cache(state_, rays_, cache_options(), tasks_);
        trace::CachedIndirect cached(visible_), fresh_cached(fresh_cache);
        tally.skipped +=
            compare_frames({&shadows, &cached}, {nullptr, &fresh_cached}, "shadows and irradiance cache", tally);
        light_quadtree::MapLight fresh_map(state_, rays_, map_options(), tasks_);
        trace::MapIndirect mapped(map_), fresh_mapped(fresh_map);
        std::size_t differ = 0;
        compare_frames({nullptr, &mapped}, {nullptr, &fresh_mapped}, "light map", tally, [&] {
            differ = differing(map_.map(), fresh_map.map());
            return differ == 0;
        });
        if (differ > 0) {
            EXPECT_TRUE(equal_up_to_rounding(map_.map(), fresh_map.map())) << differ << " nodes of the light map";
            ++tally.rounded;
        }

        views_.update(state_);
        for (std::size_t v = 0; v < buffers_.size(); ++v) {
            const light_views::LightView& view = views_.views()[v];
            if (!view.shown) continue;
            buffers_[v].execute(view.plan, view.projection, state_);
            EXPECT_TRUE(buffers_[v].rendering() == drawn_anew(view, views_, state_)) << "light view " << v;
        }
    }

 private:
    void compare_kdtrees(const ray::RayScene& anew, const ray::RayQueue& queue)
    {
        kdtree_.update(state_, rays_);
        const ray::CountingKdTree fresh(state_, anew);
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
        const trace::Techniques& kept, const trace::Techniques& made_anew, const char* what, Tally& tally,
        const std::function<bool()>& must_be_equal = [] { return true; })
    {
        const scene::View view = scene::make_view(state_, 0, {24, 18});
        shading::FrameBuffers mine, fresh;
        const std::uint64_t skipped =
            trace::trace_frame(state_, rays_, view, options_, tasks_, mine, kept).shadow.rays_skipped;
        trace::trace_frame(state_, rays_, view, options_, tasks_, fresh, made_anew);
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
    std::vector<light_views::SoftwareView> buffers_;
    trace::TracedOptions options_;
};

void follow_sequence(std::uint64_t seed, int steps, Tally& tally)
{
    const RandomClip clip = random_clip(seed);
    User user(clip, seed);
    scene::SceneState state(clip.scene, 0);
    Caches caches(state, seed);
    caches.follow(tally);   // the first frame is of the step in which the caches were made
    for (int step = 0; step < steps && !testing::Test::HasFailure(); ++step) {
        SCOPED_TRACE(testing::Message() << "seed " << seed << ", step " << step << ", time " << state.time());
        const Snapshot before(state);
        user.act(state);
        state.advance(user.next_time(state.time()));
        expect_lists_cover(before, Snapshot(state), state);
        caches.follow(tally);
        tally.promoted += state.changes().promoted.size();
        tally.separated += state.changes().separated.size();
    }
}

TEST(Changes, EveryCacheEqualsOneMadeAnew)
{
    Tally tally;
    for (std::uint64_t seed = 1; seed <= 16; ++seed) follow_sequence(seed, 12, tally);
    // The sequences were rich enough to mean something.
    EXPECT_GT(tally.promoted, 30u);
    EXPECT_GT(tally.separated, 10u);
    EXPECT_GT(tally.skipped, 5'000u);
    EXPECT_GT(tally.hits, 5'000u);
    EXPECT_GT(tally.lit, 20'000u);
    EXPECT_EQ(tally.rounded, 0u);
}

TEST(ChangesFull, EveryCacheEqualsOneMadeAnewOverAThousandSeeds)
{
    Tally tally;
    for (std::uint64_t seed = 101; seed <= 1100 && !HasFailure(); ++seed) follow_sequence(seed, 16, tally);
    EXPECT_LE(tally.rounded, 160u);   // of 16,000 steps
}

#ifdef GNOMON_VULKAN
class ChangesVulkan : public test::VulkanTest {};
class ChangesVulkanFull : public test::VulkanTest {};

// @param every  steps between comparisons with a rasterizer made anew, which takes long
void follow_on_device(std::uint64_t seed, int steps, int every, Indirect indirect)
{
    const RandomClip clip = random_clip(seed);
    User user(clip, seed);
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
    follow_on_device(1, 12, 4, Indirect::visible);
    follow_on_device(2, 12, 4, Indirect::quadtree);
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
