// SPDX-License-Identifier: Apache-2.0
// Distributes the triangles among the two trees, rebuilds them from frame to frame, and traces rays.
#include "ray/kdtree/kdtree.h"

#include <algorithm>
#include <array>
#include <span>

#include "base/check.h"
#include "ray/embree/impl.h"
#include "ray/embree/packets.h"
#include "ray/embree/solid.h"
#include "ray/kdtree/walk.h"
#include "ray/triangle_test.h"
#include "scene/alpha_mask.h"
#include "scene/mobility.h"

namespace gnomon::ray {

namespace {

// Triangles are enlarged by this fraction of the largest coordinate, because intersections with planes are rounded.
constexpr float k_pad_per_coordinate = 0x1p-20f;

// Makes the groups of one of the trees; each node comes before those below it.
std::vector<KdGroup> make_groups(const scene::Scene& scene, const std::vector<scene::ObjectId>& objects)
{
    std::vector<scene::NodeId> used;
    std::vector<char> in_use(scene.nodes.size(), 0);
    for (const scene::ObjectId o : objects)
        for (scene::NodeId n = scene.objects[o].node; n != scene::none && !in_use[n]; n = scene.nodes[n].parent) {
            in_use[n] = 1;
            used.push_back(n);
        }
    std::sort(used.begin(), used.end());

    std::vector<KdGroup> groups(used.size());
    std::vector<std::uint32_t> group_of(scene.nodes.size(), scene::none);
    for (std::uint32_t g = 0; g < groups.size(); ++g) {
        group_of[used[g]] = g;
        const scene::NodeId parent = scene.nodes[used[g]].parent;
        if (parent == scene::none) continue;
        groups[g].parent = group_of[parent];
        groups[groups[g].parent].children.push_back(g);
    }
    // Each object is a group of its own, below its node.
    for (const scene::ObjectId o : objects) {
        const std::uint32_t node = group_of[scene.objects[o].node];
        groups[node].children.push_back(static_cast<std::uint32_t>(groups.size()));
        KdGroup& group = groups.emplace_back();
        group.parent = node;
        group.object = o;
    }
    return groups;
}

// Appends an object's triangles as rays hit them.
void add_triangles(const scene::Scene& scene, const ObjectGeometry& geometry, scene::ObjectId object,
                   std::vector<KdTriangle>& to)
{
    // No ray hits an instance with a singular transform, as in RayScene.
    if (geometry.to_world && !has_volume(*geometry.to_world)) return;
    for (const scene::MeshPart& part : geometry.mesh->parts) {
        const scene::Material& material = scene.materials[part.material];
        KdTriangle triangle;
        triangle.object = object;
        triangle.material = part.material;
        triangle.surface = material.surface_class();
        triangle.one_sided = material.one_sided();
        triangle.mirrored = geometry.mirrored;
        for (std::uint32_t t = 0; t < part.triangle_count; ++t) {
            triangle.triangle = part.first_triangle + t;
            geometry.corners(triangle.triangle, triangle.p);
            if (is_finite(triangle.p[0]) && is_finite(triangle.p[1]) && is_finite(triangle.p[2]))
                to.push_back(triangle);
        }
    }
}

// Fills a part's triangles and boxes from the present state.
void collect(KdPart& part, const scene::SceneState& state, const RayScene& rays)
{
    part.triangles.clear();
    part.box = {};
    for (KdGroup& group : part.groups) {
        group.box = {};
        group.triangles = 0;
        if (group.object == scene::none || !state.object_visible(group.object)) continue;
        group.first_triangle = static_cast<std::uint32_t>(part.triangles.size());
        add_triangles(state.scene(), rays.geometry(group.object), group.object, part.triangles);
        group.triangles = static_cast<std::uint32_t>(part.triangles.size()) - group.first_triangle;
        for (std::size_t i = group.first_triangle; i < part.triangles.size(); ++i)
            for (const glm::vec3& p : part.triangles[i].p) group.box.add(p);
        part.box.add(group.box);
    }
    float largest = 0;
    for (int axis = 0; axis < 3 && !part.box.empty(); ++axis)
        largest = std::max({largest, std::abs(part.box.low[axis]), std::abs(part.box.high[axis])});
    part.pad = std::max(k_pad_per_coordinate * largest, std::numeric_limits<float>::min());

    // Enlarge the boxes and propagate them to the parents, which come first.
    part.box = {part.box.low - part.pad, part.box.high + part.pad};
    for (std::size_t g = part.groups.size(); g-- > 0;) {
        KdGroup& group = part.groups[g];
        if (group.object != scene::none) group.box = {group.box.low - part.pad, group.box.high + part.pad};
        if (group.parent == scene::none || group.triangles == 0) continue;
        part.groups[group.parent].box.add(group.box);
        part.groups[group.parent].triangles += group.triangles;
    }
}

bool usable(const glm::vec3& o, float tnear, const glm::vec3& d, float tfar)
{
    return traceable(o.x, o.y, o.z, tnear, d.x, d.y, d.z, tfar);
}

}   // namespace

struct CountingKdTree::Impl {
    explicit Impl(std::size_t objects) : mobility(objects) {}

    std::shared_ptr<const scene::Scene> scene;
    KdOptions options;
    KdPart still, resting, moving;   // one tree over everything: `still`
    const std::array<const KdPart*, 3> parts{&still, &resting, &moving};
    scene::Mobility mobility;
    std::vector<char> clip_dynamic;   // by object
    bool still_is_due = false, resting_is_due = false, moving_is_due = false;

    bool is_dynamic(scene::ObjectId object) const
    {
        return options.mobility_by_frame ? mobility.is_dynamic(object) : clip_dynamic[object] != 0;
    }
    bool one_tree() const { return options.layout != KdLayout::separate; }
    void regroup(const scene::SceneState& state)
    {
        std::vector<scene::ObjectId> all, of_still, of_resting, of_moving;
        clip_dynamic.clear();
        for (scene::ObjectId o = 0; o < scene->objects.size(); ++o) {
            clip_dynamic.push_back(state.is_dynamic(o));
            all.push_back(o);
            (is_dynamic(o) ? of_moving : clip_dynamic[o] ? of_resting : of_still).push_back(o);
        }
        still.groups = make_groups(*scene, one_tree() ? all : of_still);
        resting.groups = make_groups(*scene, one_tree() ? std::vector<scene::ObjectId>{} : of_resting);
        moving.groups = make_groups(*scene, one_tree() ? std::vector<scene::ObjectId>{} : of_moving);
    }
    void rebuild(KdPart& part, const KdBuildOptions& how, const scene::SceneState& state, const RayScene& rays) const
    {
        collect(part, state, rays);
        part.build(how);
        part.holds.clear();
        if (one_tree() && !part.nodes.empty()) mark(part);
    }
    KdBuildOptions still_options() const
    {
        KdBuildOptions how = options.still;
        if (options.layout == KdLayout::mixed) how.from_hierarchy = false;
        if (options.layout == KdLayout::hierarchy) how.groups_above = 0, how.group_split_gain = 1;
        return how;
    }
    // Marks the nodes of one tree over everything. Children come after their parents.
    void mark(KdPart& part) const
    {
        part.holds.assign(part.nodes.size(), 0);
        for (std::size_t n = part.nodes.size(); n-- > 0;) {
            const KdNode& node = part.nodes[n];
            if (node.axis != KdNode::k_leaf) {
                part.holds[n] = part.holds[node.first] | part.holds[node.first + 1];
                continue;
            }
            for (std::uint32_t i = node.first; i < node.first + node.count; ++i)
                part.holds[n] |= holds(part.triangles[part.references[i]]);
        }
    }
    std::uint8_t holds(const KdTriangle& t) const
    {
        const unsigned bits =
            (clip_dynamic[t.object] ? k_holds_clip_dynamic : 0u) | (is_dynamic(t.object) ? k_holds_dynamic : 0u);
        return static_cast<std::uint8_t>(bits);
    }

    // The trees that such rays enter, and in one tree over everything the bits that nodes and triangles must have.
    struct Asked {
        std::span<const KdPart* const> parts;
        std::uint8_t only = 0;
        bool static_only = false;
        bool admits(const Impl& in, const KdTriangle& t) const
        {
            if (only == 0 && !static_only) return true;
            const std::uint8_t bits = in.holds(t);
            return static_only ? (bits & k_holds_clip_dynamic) == 0 : (bits & only) == only;
        }
    };
    Asked asked(Against against) const
    {
        if (one_tree())
            return {std::span(parts).first(1),
                    against == Against::dynamic_only ? k_holds_clip_dynamic : std::uint8_t{0},
                    against == Against::static_only};
        const std::size_t first = against == Against::dynamic_only ? 1 : 0,
                          last = against == Against::static_only ? 1 : 3;
        return {std::span(parts).subspan(first, last - first)};
    }
    Asked asked_dynamic() const
    {
        if (one_tree()) return {std::span(parts).first(1), k_holds_dynamic};
        return {std::span(parts).last(1)};
    }
    bool any_blocks(const Asked& of, const KdRay& ray, KdCounts& counts, Hit* occluder) const
    {
        if (!one_tree()) ++counts.nodes;   // the root
        return std::ranges::any_of(of.parts, [&](const KdPart* part) {
            return walk(*part, ray, ray.tfar, counts, of.only, [&](const KdNode& leaf) {
                for (std::uint32_t i = leaf.first; i < leaf.first + leaf.count; ++i) {
                    const KdTriangle& t = part->triangles[part->references[i]];
                    if (!of.admits(*this, t) || !blocks(t, ray, counts)) continue;
                    if (occluder && t.surface == scene::SurfaceClass::opaque)
                        occluder->object = t.object, occluder->triangle = t.triangle;
                    return true;
                }
                return false;
            });
        });
    }
    bool holed(const KdTriangle& t, const TriangleHit& hit) const
    {
        return t.surface == scene::SurfaceClass::masked &&
               scene::cut_away(*scene, scene->meshes[scene->objects[t.object].mesh], scene->materials[t.material],
                               t.triangle, hit.u, hit.v);
    }
    bool blocks(const KdTriangle& t, const KdRay& ray, KdCounts& counts) const
    {
        if (t.surface == scene::SurfaceClass::transparent) return false;
        ++counts.tests;
        TriangleHit hit;
        return meets(ray.origin, ray.direction, ray.tnear, ray.tfar, t.p, hit) && !holed(t, hit);
    }
    /// Whether a triangle is the nearest so far; if so, sets `best`.
    bool nearest(const KdTriangle& t, const KdRay& ray, Sides sides, Hit& best, KdCounts& counts) const
    {
        ++counts.tests;
        TriangleHit hit;
        if (!meets(ray.origin, ray.direction, ray.tnear, best.t, t.p, hit)) return false;
        // Of equal distances, the smaller ids win.
        if (best.object != scene::none && hit.t == best.t &&
            std::pair(t.object, t.triangle) >= std::pair(best.object, best.triangle))
            return false;
        if (sides == Sides::front && t.one_sided && hit.behind != t.mirrored) return false;
        if (holed(t, hit)) return false;
        best = {hit.t, hit.u, hit.v, t.object, t.triangle};
        return true;
    }
};

CountingKdTree::CountingKdTree(const scene::SceneState& state, const RayScene& rays, const KdOptions& options)
    : impl_(std::make_unique<Impl>(state.scene().objects.size()))
{
    Impl& in = *impl_;
    in.scene = state.shared_scene();
    in.options = options;
    in.still_is_due = in.resting_is_due = in.moving_is_due = true;
    in.regroup(state);
    build(state, rays);
}

CountingKdTree::~CountingKdTree() = default;

void CountingKdTree::follow(const scene::SceneState& state)
{
    Impl& in = *impl_;
    const scene::FrameChanges& changes = state.changes();
    in.mobility.update(changes);
    const bool regrouped =
        in.options.mobility_by_frame && (!in.mobility.became_dynamic().empty() || !in.mobility.became_static().empty());
    if (regrouped || !changes.promoted.empty()) in.regroup(state);
    if (!changes.promoted.empty()) in.still_is_due = true;
    if (regrouped) in.resting_is_due = true;
    if (regrouped || !changes.changed.empty()) in.moving_is_due = true;
}

void CountingKdTree::build(const scene::SceneState& state, const RayScene& rays)
{
    Impl& in = *impl_;
    if (in.one_tree()) in.still_is_due |= in.resting_is_due || in.moving_is_due;
    if (in.still_is_due) in.rebuild(in.still, in.still_options(), state, rays);
    if (in.resting_is_due && !in.one_tree()) in.rebuild(in.resting, in.options.still, state, rays);
    if (in.moving_is_due && !in.one_tree()) in.rebuild(in.moving, in.options.moving, state, rays);
    in.still_is_due = in.resting_is_due = in.moving_is_due = false;
}

bool CountingKdTree::is_dynamic(scene::ObjectId object) const
{
    return impl_->is_dynamic(object);
}

bool CountingKdTree::occluded(const glm::vec3& origin, float tnear, const glm::vec3& direction, float tfar,
                              Against against, KdCounts& counts, Hit* occluder) const
{
    if (!usable(origin, tnear, direction, tfar)) return false;
    return impl_->any_blocks(impl_->asked(against), KdRay(origin, tnear, direction, tfar), counts, occluder);
}

bool CountingKdTree::occluded_by_dynamic(const glm::vec3& origin, float tnear, const glm::vec3& direction, float tfar,
                                         KdCounts& counts) const
{
    if (!usable(origin, tnear, direction, tfar)) return false;
    return impl_->any_blocks(impl_->asked_dynamic(), KdRay(origin, tnear, direction, tfar), counts, nullptr);
}

Hit CountingKdTree::closest(const glm::vec3& origin, float tnear, const glm::vec3& direction, float tfar, Sides sides,
                            KdCounts& counts, Against against) const
{
    const Impl& in = *impl_;
    Hit best;
    best.t = tfar;
    if (!usable(origin, tnear, direction, tfar)) return best;
    const KdRay ray(origin, tnear, direction, tfar);
    if (!in.one_tree()) ++counts.nodes;   // the root
    float limit = tfar;
    const Impl::Asked asked = in.asked(against);
    for (const KdPart* part : asked.parts)
        walk(*part, ray, limit, counts, asked.only, [&](const KdNode& leaf) {
            for (std::uint32_t i = leaf.first; i < leaf.first + leaf.count; ++i) {
                const KdTriangle& t = part->triangles[part->references[i]];
                if (asked.admits(in, t) && in.nearest(t, ray, sides, best, counts))
                    limit = std::min(limit, best.t + k_hit_slack * best.t);
            }
            return false;
        });
    return best;
}

bool CountingKdTree::occluded_by_any(const glm::vec3& origin, float tnear, const glm::vec3& direction, float tfar,
                                     Against against) const
{
    const Impl& in = *impl_;
    if (!usable(origin, tnear, direction, tfar)) return false;
    const KdRay ray(origin, tnear, direction, tfar);
    KdCounts counts;
    const Impl::Asked asked = in.asked(against);
    const auto blocks = [&](const KdTriangle& t) { return asked.admits(in, t) && in.blocks(t, ray, counts); };
    return std::ranges::any_of(asked.parts,
                               [&](const KdPart* part) { return std::ranges::any_of(part->triangles, blocks); });
}

Hit CountingKdTree::closest_of_all(const glm::vec3& origin, float tnear, const glm::vec3& direction, float tfar,
                                   Sides sides, Against against) const
{
    const Impl& in = *impl_;
    Hit best;
    best.t = tfar;
    if (!usable(origin, tnear, direction, tfar)) return best;
    const KdRay ray(origin, tnear, direction, tfar);
    KdCounts counts;
    const Impl::Asked asked = in.asked(against);
    for (const KdPart* part : asked.parts)
        for (const KdTriangle& t : part->triangles)
            if (asked.admits(in, t)) in.nearest(t, ray, sides, best, counts);
    return best;
}

KdStatistics CountingKdTree::statistics() const
{
    const auto of = [](const KdPart& part) {
        KdTreeStatistics s;
        s.triangles = part.triangles.size();
        s.references = part.references.size();
        s.nodes = part.nodes.size();
        s.group_splits = part.group_splits;
        s.bytes = part.triangles.size() * sizeof(KdTriangle) + part.nodes.size() * sizeof(KdNode) +
                  part.references.size() * sizeof(std::uint32_t);
        s.builds = part.builds;
        s.build_ms = part.build_ms;
        return s;
    };
    return {of(impl_->still), of(impl_->resting), of(impl_->moving)};
}

}   // namespace gnomon::ray
