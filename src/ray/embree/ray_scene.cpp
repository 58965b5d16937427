// SPDX-License-Identifier: Apache-2.0
// Traces rays, in packets and singly.
#include "ray/ray_scene.h"

#include <algorithm>
#include <chrono>
#include <tuple>
#include <utility>

#include "base/check.h"
#include "ray/embree/impl.h"
#include "ray/embree/packets.h"

namespace gnomon::ray {

namespace {

constexpr unsigned k_nothing = RTC_INVALID_GEOMETRY_ID;

RTCRay make_ray(const glm::vec3& origin, float tnear, const glm::vec3& direction, float tfar, unsigned mask)
{
    RTCRay ray{};
    ray.org_x = origin.x, ray.org_y = origin.y, ray.org_z = origin.z, ray.tnear = tnear;
    ray.dir_x = direction.x, ray.dir_y = direction.y, ray.dir_z = direction.z, ray.tfar = tfar;
    ray.mask = mask;
    return ray;
}

}   // namespace

RayScene::RayScene(const scene::SceneState& state, const MemoryLimit& limit, Arithmetic arithmetic, Tasks* tasks)
    : impl_(std::make_unique<Impl>())
{
    impl_->tasks = tasks;
    impl_->portable = arithmetic == Arithmetic::portable;
    impl_->device.limit_memory(limit);
    const auto start = std::chrono::steady_clock::now();
    impl_->build(state);
    impl_->statistics.build_ms =
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

RayScene::~RayScene() = default;

void RayScene::limit_memory(const MemoryLimit& limit)
{
    impl_->device.limit_memory(limit);
}

void RayScene::update(const scene::SceneState& state)
{
    impl_->update(state);
    if (!impl_->kdtree) return;
    impl_->kdtree->update(state, *this);
    for (Impl::Sums& sums : impl_->kdtree_sums) sums.nodes = 0, sums.tests = 0;
}

void RayScene::keep_one_tree()
{
    impl_->build_one_tree();
}

Met RayScene::Impl::met(unsigned geometry_id, unsigned instance, unsigned triangle, bool in_moving) const
{
    if (!in_moving && instance != k_nothing) {
        // In a static instance, the instance determines the object, and the shared mesh the triangle.
        const Placed& placed = still_instances[instance - first_instance];
        return {placed.object, placed.shared->records[geometry_id].first_triangle + triangle};
    }
    const GeometryRecord& record =
        in_moving ? solids[solid_of_instance[instance]].records[geometry_id] : still_records[geometry_id];
    return {record.object, record.first_triangle + triangle};
}

void RayScene::closest(const RayQueue& rays, std::size_t begin, std::size_t end, Hits& hits, Sides sides,
                       Against against) const
{
    const Impl& in = *impl_;
    if (in.kdtree) return in.closest_on_kdtree(rays, begin, end, hits, sides, against);
    if (in.portable) return in.closest_portably(rays, begin, end, hits, sides, against);
    TraceContext context(TraceContext::Kind::closest, sides == Sides::front);
    const bool asks_still = against != Against::dynamic_only;
    const bool anything_moves = !in.solid_of_instance.empty() && against != Against::static_only;
    RawHits still, moving;
    if (!asks_still) std::fill(std::begin(still.geometry), std::end(still.geometry), k_nothing);
    const auto step = static_cast<std::size_t>(in.width);
    for (std::size_t at = begin; at < end; at += step) {
        const int count = static_cast<int>(std::min(step, end - at));
        if (asks_still) intersect_packet(in.width, in.still.get(), context, rays, at, count, nullptr, still);
        if (anything_moves)
            intersect_packet(in.width, in.moving.get(), context, rays, at, count, asks_still ? still.t : nullptr,
                             moving);
        for (int i = 0; i < count; ++i) {
            const std::size_t to = at + static_cast<std::size_t>(i);
            const bool in_moving = anything_moves && moving.geometry[i] != k_nothing;
            const RawHits& raw = in_moving ? moving : still;
            if (raw.geometry[i] == k_nothing) {
                hits.object[to] = scene::none;
                continue;
            }
            const Met met = in.met(raw.geometry[i], raw.instance[i], raw.triangle[i], in_moving);
            hits.object[to] = met.object, hits.triangle[to] = met.triangle;
            const glm::vec2 uv = off_edges(raw.u[i], raw.v[i]);
            hits.t[to] = raw.t[i], hits.u[to] = uv.x, hits.v[to] = uv.y;
        }
    }
}

void RayScene::occluded(const RayQueue& rays, std::size_t begin, std::size_t end, std::uint8_t* occluded,
                        Against against) const
{
    const Impl& in = *impl_;
    if (in.kdtree) return in.occluded_on_kdtree(rays, begin, end, occluded, against);
    if (in.portable) return in.occluded_portably(rays, begin, end, occluded, against);
    if (against == Against::one_tree) GNOMON_CHECK(in.one.get() != nullptr);
    TraceContext context(TraceContext::Kind::any);
    RTCScene first = in.still.get(), then = in.solid_of_instance.empty() ? nullptr : in.moving.get();
    if (against == Against::static_only) then = nullptr;
    if (against == Against::dynamic_only) first = std::exchange(then, nullptr);
    if (against == Against::one_tree) first = in.one.get(), then = nullptr;
    const auto step = static_cast<std::size_t>(in.width);
    alignas(64) int active[16];
    for (std::size_t at = begin; at < end; at += step) {
        const int count = static_cast<int>(std::min(step, end - at));
        for (int i = 0; i < 16; ++i) active[i] = i < count ? -1 : 0;
        if (first) occlude_packet(in.width, first, then, context, rays, at, count, active);
        for (int i = 0; i < count; ++i) occluded[at - begin + static_cast<std::size_t>(i)] = active[i] == 0;
    }
}

bool RayScene::thins_light() const
{
    return impl_->thins_light;
}

void RayScene::let_through(const RayQueue& rays, std::size_t begin, std::size_t end, glm::vec3* to,
                           Against against) const
{
    const Impl& in = *impl_;
    std::fill(to, to + (end - begin), glm::vec3(1));
    if (!in.thins_light) return;
    std::vector<ThinHit> hits;
    TraceContext context(TraceContext::Kind::any);
    context.thin = &hits;
    const auto step = static_cast<std::size_t>(in.width);
    for (std::size_t at = begin; at < end; at += step) {
        const int count = static_cast<int>(std::min(step, end - at));
        for (const SceneHandle* tree : {&in.still, &in.moving}) {
            if (tree == &in.moving && (in.solid_of_instance.empty() || against == Against::static_only)) break;
            if (tree == &in.still && against == Against::dynamic_only) continue;
            hits.clear();
            if (in.portable)
                in.thin_portably(tree == &in.still ? in.portable_still_scene : in.portable_moving_scene, rays, at,
                                 at + static_cast<std::size_t>(count), tree == &in.still ? &in.thin_box : nullptr,
                                 hits);
            else
                thin_packet(in.width, tree->get(), context, rays, at, count);
            // Each surface counts once. Multiply in the order of the factors: surfaces' numbers depend on the history
            // of a host's scene.
            std::sort(hits.begin(), hits.end(),
                      [](const ThinHit& a, const ThinHit& b) { return a.place() < b.place(); });
            const auto past = std::unique(hits.begin(), hits.end(),
                                          [](const ThinHit& a, const ThinHit& b) { return a.place() == b.place(); });
            std::sort(hits.begin(), past, [](const ThinHit& a, const ThinHit& b) {
                return std::tie(a.ray, a.passes.x, a.passes.y, a.passes.z) <
                       std::tie(b.ray, b.passes.x, b.passes.y, b.passes.z);
            });
            for (auto hit = hits.begin(); hit != past; ++hit) to[at - begin + hit->ray] *= hit->passes;
        }
    }
}

const ObjectGeometry& RayScene::geometry(scene::ObjectId object) const
{
    return impl_->geometry[object];
}

Meeting RayScene::meeting(scene::ObjectId object) const
{
    if (const std::uint32_t s = impl_->solid_of(object); s != scene::none) return impl_->solids[s].meeting;
    const glm::mat4* to_world = impl_->geometry[object].to_world;
    return to_world ? meeting_by(*to_world) : Meeting::truly;
}

Box3 RayScene::bounds() const
{
    if (impl_->portable) return impl_->portable_bounds();
    Box3 result;
    for (const SceneHandle* part : {&impl_->still, &impl_->moving}) {
        RTCBounds box;
        rtcGetSceneBounds(part->get(), &box);
        const Box3 own{{box.lower_x, box.lower_y, box.lower_z}, {box.upper_x, box.upper_y, box.upper_z}};
        if (!own.empty()) result.add(own);
    }
    return result;
}

RaySceneStatistics RayScene::statistics() const
{
    const Impl& in = *impl_;
    RaySceneStatistics result = in.statistics;
    result.instances = in.solid_of_instance.size();
    result.bytes = in.device.bytes() + in.baked_bytes + in.portable_bytes;
    return result;
}

int RayScene::packet_width()
{
    static const int width = [] {
        const EmbreeDevice device;
        if (rtcGetDeviceProperty(device.get(), RTC_DEVICE_PROPERTY_NATIVE_RAY16_SUPPORTED)) return 16;
        return rtcGetDeviceProperty(device.get(), RTC_DEVICE_PROPERTY_NATIVE_RAY8_SUPPORTED) ? 8 : 4;
    }();
    return width;
}

// The reference implementation of the packets.

Hit RayScene::closest_single(const glm::vec3& origin, float tnear, const glm::vec3& direction, float tfar,
                             Sides sides) const
{
    const Impl& in = *impl_;
    if (in.portable) return in.closest_single_portably(origin, tnear, direction, tfar, sides);
    TraceContext context(TraceContext::Kind::closest, sides == Sides::front);
    Hit hit;
    hit.t = tfar;
    if (!traceable(origin.x, origin.y, origin.z, tnear, direction.x, direction.y, direction.z, tfar)) return hit;
    for (const bool in_moving : {false, true}) {
        RTCRayHit ray{};
        ray.ray = make_ray(origin, tnear, direction, hit.t, k_mask_seen);
        ray.hit.geomID = ray.hit.instID[0] = k_nothing;
        rtcIntersect1((in_moving ? in.moving : in.still).get(), &context.embree, &ray);
        if (ray.hit.geomID == k_nothing) continue;
        const Met met = in.met(ray.hit.geomID, ray.hit.instID[0], ray.hit.primID, in_moving);
        const glm::vec2 uv = off_edges(ray.hit.u, ray.hit.v);
        hit = {ray.ray.tfar, uv.x, uv.y, met.object, met.triangle};
    }
    return hit;
}

bool RayScene::occluded_single(const glm::vec3& origin, float tnear, const glm::vec3& direction, float tfar,
                               Against against) const
{
    const Impl& in = *impl_;
    if (in.portable) return in.occluded_single_portably(origin, tnear, direction, tfar, against);
    if (against == Against::one_tree) GNOMON_CHECK(in.one.get() != nullptr);
    if (!traceable(origin.x, origin.y, origin.z, tnear, direction.x, direction.y, direction.z, tfar)) return false;
    TraceContext context(TraceContext::Kind::any);
    const auto blocks = [&](const SceneHandle& tree) {
        RTCRay ray = make_ray(origin, tnear, direction, tfar, k_mask_blocks);
        rtcOccluded1(tree.get(), &context.embree, &ray);
        return ray.tfar < 0;   // Embree marks occluded rays so
    };
    if (against == Against::one_tree) return blocks(in.one);
    return (against != Against::dynamic_only && blocks(in.still)) ||
           (against != Against::static_only && blocks(in.moving));
}

}   // namespace gnomon::ray
