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
    std::shared_ptr<const scene::Scene> scene;
    KdOptions options;
    KdPart still, moving;
    const std::array<const KdPart*, 2> parts{&still, &moving};

    void regroup(const scene::SceneState& state)
    {
        std::vector<scene::ObjectId> of_still, of_moving;
        for (scene::ObjectId o = 0; o < scene->objects.size(); ++o)
            (state.is_dynamic(o) ? of_moving : of_still).push_back(o);
        still.groups = make_groups(*scene, of_still);
        moving.groups = make_groups(*scene, of_moving);
    }
    void rebuild(KdPart& part, const KdBuildOptions& how, const scene::SceneState& state, const RayScene& rays) const
    {
        collect(part, state, rays);
        part.build(how);
    }

    std::span<const KdPart* const> asked(Against against) const
    {
        const std::size_t first = against == Against::dynamic_only ? 1 : 0,
                          last = against == Against::static_only ? 1 : 2;
        return std::span(parts).subspan(first, last - first);
    }
    bool holed(const KdTriangle& t, const TriangleHit& hit) const
    {
        return t.surface == scene::SurfaceClass::masked &&
               cut_away(*scene, scene->meshes[scene->objects[t.object].mesh], scene->materials[t.material], t.triangle,
                        hit.u, hit.v);
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
    : impl_(std::make_unique<Impl>())
{
    Impl& in = *impl_;
    in.scene = state.shared_scene();
    in.options = options;
    in.regroup(state);
    in.rebuild(in.still, options.still, state, rays);
    in.rebuild(in.moving, options.moving, state, rays);
}

CountingKdTree::~CountingKdTree() = default;

void CountingKdTree::update(const scene::SceneState& state, const RayScene& rays)
{
    Impl& in = *impl_;
    const scene::FrameChanges& changes = state.changes();
    if (!changes.promoted.empty()) {
        in.regroup(state);
        in.rebuild(in.still, in.options.still, state, rays);
    }
    if (!changes.changed.empty()) in.rebuild(in.moving, in.options.moving, state, rays);
}

bool CountingKdTree::occluded(const glm::vec3& origin, float tnear, const glm::vec3& direction, float tfar,
                              Against against, KdCounts& counts) const
{
    const Impl& in = *impl_;
    if (!usable(origin, tnear, direction, tfar)) return false;
    const KdRay ray(origin, tnear, direction, tfar);
    ++counts.nodes;   // the root
    const auto in_part = [&](const KdPart* part) {
        return walk(*part, ray, ray.tfar, counts, [&](const KdNode& leaf) {
            for (std::uint32_t i = leaf.first; i < leaf.first + leaf.count; ++i)
                if (in.blocks(part->triangles[part->references[i]], ray, counts)) return true;
            return false;
        });
    };
    return std::ranges::any_of(in.asked(against), in_part);
}

Hit CountingKdTree::closest(const glm::vec3& origin, float tnear, const glm::vec3& direction, float tfar, Sides sides,
                            KdCounts& counts, Against against) const
{
    const Impl& in = *impl_;
    Hit best;
    best.t = tfar;
    if (!usable(origin, tnear, direction, tfar)) return best;
    const KdRay ray(origin, tnear, direction, tfar);
    ++counts.nodes;   // the root
    float limit = tfar;
    for (const KdPart* part : in.asked(against))
        walk(*part, ray, limit, counts, [&](const KdNode& leaf) {
            for (std::uint32_t i = leaf.first; i < leaf.first + leaf.count; ++i)
                if (in.nearest(part->triangles[part->references[i]], ray, sides, best, counts))
                    limit = std::min(limit, best.t + k_hit_slack * best.t);
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
    const auto blocks = [&](const KdTriangle& t) { return in.blocks(t, ray, counts); };
    return std::ranges::any_of(in.asked(against),
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
    for (const KdPart* part : in.asked(against))
        for (const KdTriangle& t : part->triangles) in.nearest(t, ray, sides, best, counts);
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
    return {of(impl_->still), of(impl_->moving)};
}

}   // namespace gnomon::ray
