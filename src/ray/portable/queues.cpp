// SPDX-License-Identifier: Apache-2.0
// Keeps the portable ray tracer's trees up to date, and traces queues of rays with it.
#include <algorithm>

#include "ray/embree/impl.h"
#include "ray/limits_shared.h"
#include "ray/portable/judge.h"
#include "ray/portable/kernels.h"

namespace gnomon::ray {

namespace {

// Loads up to 16 rays. @return bits of those that may be traced
unsigned load(RayPacket& packet, const RayQueue& rays, std::size_t begin, std::size_t count)
{
    unsigned lanes = 0;
    for (std::size_t i = 0; i < k_packet_rays; ++i) {
        const std::size_t r = begin + std::min(i, count - 1);   // all lanes hold numbers
        const bool fits = traceable(rays.ox[r], rays.oy[r], rays.oz[r], rays.tnear[r], rays.dx[r], rays.dy[r],
                                    rays.dz[r], rays.tfar[r]);
        packet.origin[0][i] = fits ? rays.ox[r] : 0, packet.origin[1][i] = fits ? rays.oy[r] : 0,
        packet.origin[2][i] = fits ? rays.oz[r] : 0;
        packet.direction[0][i] = fits ? rays.dx[r] : 1, packet.direction[1][i] = fits ? rays.dy[r] : 1,
        packet.direction[2][i] = fits ? rays.dz[r] : 1;
        packet.tnear[i] = fits ? rays.tnear[r] : 0;
        const bool traced = fits && i < count;
        packet.t[i] = traced ? rays.tfar[r] : -1;
        lanes |= static_cast<unsigned>(traced) << i;
        packet.instance[i] = nullptr;
    }
    return lanes;
}

}   // namespace

void RayScene::Impl::commit_portable_still()
{
    portable_still.build(still_records, tasks);
    portable_still_scene.clear();
    portable_still_scene.add(portable_still);
    for (const Placed& placed : still_instances)
        for (const unsigned id : still_ids[placed.object])
            portable_still_scene.add(placed.shared->portable, id, placed.object, placed.to_world);
    portable_still_scene.build();
    count_portable_bytes();
}

void RayScene::Impl::commit_portable_moving()
{
    portable_moving_scene.clear();
    for (unsigned id = 0; id < solid_of_instance.size(); ++id) {
        const Solid& solid = solids[solid_of_instance[id]];
        if (solid.enabled) portable_moving_scene.add(solid.portable, id, scene::none, solid.to_world);
    }
    portable_moving_scene.build();
    count_portable_bytes();
}

void RayScene::Impl::build_portable_one()
{
    portable_one_scene.clear();
    for (const SceneTree* part : {&portable_still_scene, &portable_moving_scene}) portable_one_scene.add(*part);
    portable_one_scene.build();
}

void RayScene::Impl::count_portable_bytes()
{
    portable_bytes = portable_still.bytes() + portable_still_scene.bytes() + portable_moving_scene.bytes();
    for (const auto& [mesh, shared] : shared_meshes) portable_bytes += shared->portable.bytes();
    for (const Solid& solid : solids) portable_bytes += solid.portable.bytes();
    device.limit().check(device.bytes() + baked_bytes + portable_bytes, "the ray tracing trees");
}

Box3 RayScene::Impl::portable_bounds() const
{
    Box3 result;
    for (const SceneTree* part : {&portable_still_scene, &portable_moving_scene})
        if (!part->box().empty()) result.add(part->box());
    return result;
}

RayScene::Impl::Scenes RayScene::Impl::scenes_of(Against against) const
{
    switch (against) {
        case Against::static_only:
            return {{&portable_still_scene}, 1};
        case Against::dynamic_only:
            return {{&portable_moving_scene}, 1};
        case Against::one_tree:
            return {{&portable_one_scene}, 1};
        case Against::everything:
            break;
    }
    return {{&portable_still_scene, &portable_moving_scene}, 2};
}

void RayScene::Impl::closest_portably(const RayQueue& rays, std::size_t begin, std::size_t end, Hits& hits, Sides sides,
                                      Against against) const
{
    RayQuery query;
    query.front_only = sides == Sides::front;
    const Scenes scenes = scenes_of(against);
    RayPacket packet;
    for (std::size_t at = begin; at < end; at += k_packet_rays) {
        const std::size_t count = std::min(k_packet_rays, end - at);
        load(packet, rays, at, count);
        find_closest(scenes.span(), query, packet);
        for (std::size_t i = 0; i < count; ++i) {
            const std::size_t to = at + i;
            const TreeInstance* const met = packet.instance[i];
            hits.object[to] = met ? object_of(*met, packet.geometry[i]) : scene::none;
            if (!met) continue;
            hits.triangle[to] = triangle_of(*met, packet.geometry[i], packet.triangle[i]);
            const glm::vec2 uv = off_edges(packet.u[i], packet.v[i]);
            hits.t[to] = packet.t[i], hits.u[to] = uv.x, hits.v[to] = uv.y;
        }
    }
}

void RayScene::Impl::occluded_portably(const RayQueue& rays, std::size_t begin, std::size_t end, std::uint8_t* occluded,
                                       Against against) const
{
    RayQuery query;
    query.mask = k_mask_blocks;
    const Scenes scenes = scenes_of(against);
    RayPacket packet;
    for (std::size_t at = begin; at < end; at += k_packet_rays) {
        const std::size_t count = std::min(k_packet_rays, end - at);
        const unsigned lanes = load(packet, rays, at, count);
        const unsigned dark = find_occluded(scenes.span(), query, packet, lanes);
        for (std::size_t i = 0; i < count; ++i) occluded[at - begin + i] = static_cast<std::uint8_t>((dark >> i) & 1);
    }
}

void RayScene::Impl::thin_portably(const SceneTree& tree, const RayQueue& rays, std::size_t begin, std::size_t end,
                                   const Box3* within, std::vector<ThinHit>& hits) const
{
    if (within && within->empty()) return;
    RayQuery query;
    query.mask = k_mask_thins;
    query.thin = &hits;
    RayPacket packet;
    unsigned lanes = load(packet, rays, begin, end - begin);
    // These rays pass through everything on their way: leave out those that miss the box.
    for (std::size_t i = 0; within && i < end - begin; ++i) {
        float first = packet.tnear[i], last = packet.t[i];
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const float inverse = 1 / packet.direction[axis][i];
            const int a = static_cast<int>(axis);
            const float low = (within->low[a] - packet.origin[axis][i]) * inverse,
                        high = (within->high[a] - packet.origin[axis][i]) * inverse;
            // A ray in the plane of a face, for which one of them is no number, is kept.
            first = std::max(first, std::min(low, high)), last = std::min(last, std::max(low, high));
        }
        if (first > last) lanes &= ~(1u << i), packet.t[i] = -1;
    }
    if (lanes == 0) return;
    const SceneTree* const trees[] = {&tree};
    find_occluded(trees, query, packet, lanes);
}

namespace {

RayQueue& queue_of(const glm::vec3& origin, float tnear, const glm::vec3& direction, float tfar)
{
    thread_local RayQueue queue;
    queue.clear();
    queue.push(origin, tnear, direction, tfar);
    return queue;
}

}   // namespace

Hit RayScene::Impl::closest_single_portably(const glm::vec3& origin, float tnear, const glm::vec3& direction,
                                            float tfar, Sides sides) const
{
    thread_local Hits hits;
    hits.resize(1);
    closest_portably(queue_of(origin, tnear, direction, tfar), 0, 1, hits, sides, Against::everything);
    if (hits.object[0] == scene::none) return Hit{.t = tfar};
    return {hits.t[0], hits.u[0], hits.v[0], hits.object[0], hits.triangle[0]};
}

bool RayScene::Impl::occluded_single_portably(const glm::vec3& origin, float tnear, const glm::vec3& direction,
                                              float tfar, Against against) const
{
    std::uint8_t occluded = 0;
    occluded_portably(queue_of(origin, tnear, direction, tfar), 0, 1, &occluded, against);
    return occluded != 0;
}

}   // namespace gnomon::ray
