// SPDX-License-Identifier: Apache-2.0
#include "ray/embree/packets.h"

#include <cstring>

#include "base/check.h"

namespace gnomon::ray {

namespace {

template <int W>
struct Packet;
template <>
struct Packet<16> {
    using Ray = RTCRay16;
    using RayHit = RTCRayHit16;
    static void intersect(const int* valid, RTCScene s, RTCIntersectContext* c, RayHit* r)
    {
        rtcIntersect16(valid, s, c, r);
    }
    static void occluded(const int* valid, RTCScene s, RTCIntersectContext* c, Ray* r)
    {
        rtcOccluded16(valid, s, c, r);
    }
};
template <>
struct Packet<8> {
    using Ray = RTCRay8;
    using RayHit = RTCRayHit8;
    static void intersect(const int* valid, RTCScene s, RTCIntersectContext* c, RayHit* r)
    {
        rtcIntersect8(valid, s, c, r);
    }
    static void occluded(const int* valid, RTCScene s, RTCIntersectContext* c, Ray* r) { rtcOccluded8(valid, s, c, r); }
};
template <>
struct Packet<4> {
    using Ray = RTCRay4;
    using RayHit = RTCRayHit4;
    static void intersect(const int* valid, RTCScene s, RTCIntersectContext* c, RayHit* r)
    {
        rtcIntersect4(valid, s, c, r);
    }
    static void occluded(const int* valid, RTCScene s, RTCIntersectContext* c, Ray* r) { rtcOccluded4(valid, s, c, r); }
};

// @param valid  cleared where a ray is not traceable
template <int W, class Ray>
void load(Ray& ray, const RayQueue& rays, std::size_t begin, unsigned mask, int (&valid)[W])
{
    constexpr std::size_t bytes = W * sizeof(float);
    std::memcpy(ray.org_x, &rays.ox[begin], bytes);
    std::memcpy(ray.org_y, &rays.oy[begin], bytes);
    std::memcpy(ray.org_z, &rays.oz[begin], bytes);
    std::memcpy(ray.dir_x, &rays.dx[begin], bytes);
    std::memcpy(ray.dir_y, &rays.dy[begin], bytes);
    std::memcpy(ray.dir_z, &rays.dz[begin], bytes);
    std::memcpy(ray.tnear, &rays.tnear[begin], bytes);
    std::memcpy(ray.tfar, &rays.tfar[begin], bytes);
    for (int i = 0; i < W; ++i) ray.time[i] = 0, ray.mask[i] = mask, ray.id[i] = 0, ray.flags[i] = 0;
    for (int i = 0; i < W; ++i)
        valid[i] &= -static_cast<int>(traceable(ray.org_x[i], ray.org_y[i], ray.org_z[i], ray.tnear[i], ray.dir_x[i],
                                                ray.dir_y[i], ray.dir_z[i], ray.tfar[i]));
}

template <int W>
void intersect_width(RTCScene scene, TraceContext& context, const RayQueue& rays, std::size_t begin, int count,
                     const float* tfar, RawHits& hits)
{
    typename Packet<W>::RayHit packet;
    alignas(64) int valid[W];
    for (int i = 0; i < W; ++i) valid[i] = i < count ? -1 : 0;
    load<W>(packet.ray, rays, begin, k_mask_seen, valid);
    for (int i = 0; i < W; ++i) {
        if (tfar) packet.ray.tfar[i] = tfar[i];
        packet.hit.geomID[i] = packet.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
        packet.hit.primID[i] = 0, packet.hit.u[i] = 0, packet.hit.v[i] = 0;
    }
    Packet<W>::intersect(valid, scene, &context.embree, &packet);
    std::memcpy(hits.t, packet.ray.tfar, sizeof packet.ray.tfar);
    std::memcpy(hits.u, packet.hit.u, sizeof packet.hit.u);
    std::memcpy(hits.v, packet.hit.v, sizeof packet.hit.v);
    std::memcpy(hits.geometry, packet.hit.geomID, sizeof packet.hit.geomID);
    std::memcpy(hits.instance, packet.hit.instID[0], sizeof packet.hit.instID[0]);
    std::memcpy(hits.triangle, packet.hit.primID, sizeof packet.hit.primID);
}

template <int W>
void occlude_width(RTCScene scene, RTCScene then, TraceContext& context, const RayQueue& rays, std::size_t begin,
                   int count, int* active)
{
    typename Packet<W>::Ray packet;
    alignas(64) int valid[W];
    for (int i = 0; i < W; ++i) valid[i] = i < count ? active[i] : 0;
    load<W>(packet, rays, begin, k_mask_blocks, valid);
    for (const RTCScene asked : {scene, then}) {
        if (!asked) continue;
        Packet<W>::occluded(valid, asked, &context.embree, &packet);
        int open = 0;
        for (int i = 0; i < W; ++i) {
            const int occluded = valid[i] & -static_cast<int>(packet.tfar[i] < 0);   // Embree marks occluded rays so
            valid[i] &= ~occluded;
            active[i] &= ~occluded;
            open |= valid[i];
        }
        if (open == 0) break;
    }
}

template <int W>
void thin_width(RTCScene scene, TraceContext& context, const RayQueue& rays, std::size_t begin, int count)
{
    typename Packet<W>::Ray packet;
    alignas(64) int valid[W];
    for (int i = 0; i < W; ++i) valid[i] = i < count ? -1 : 0;
    load<W>(packet, rays, begin, k_mask_thins, valid);
    for (int i = 0; i < W; ++i) packet.id[i] = static_cast<unsigned>(i);
    Packet<W>::occluded(valid, scene, &context.embree, &packet);
}

}   // namespace

void intersect_packet(int width, RTCScene scene, TraceContext& context, const RayQueue& rays, std::size_t begin,
                      int count, const float* tfar, RawHits& hits)
{
    switch (width) {
        case 16:
            intersect_width<16>(scene, context, rays, begin, count, tfar, hits);
            break;
        case 8:
            intersect_width<8>(scene, context, rays, begin, count, tfar, hits);
            break;
        default:
            intersect_width<4>(scene, context, rays, begin, count, tfar, hits);
            break;
    }
}

void occlude_packet(int width, RTCScene scene, RTCScene then, TraceContext& context, const RayQueue& rays,
                    std::size_t begin, int count, int* active)
{
    switch (width) {
        case 16:
            occlude_width<16>(scene, then, context, rays, begin, count, active);
            break;
        case 8:
            occlude_width<8>(scene, then, context, rays, begin, count, active);
            break;
        default:
            occlude_width<4>(scene, then, context, rays, begin, count, active);
            break;
    }
}

void thin_packet(int width, RTCScene scene, TraceContext& context, const RayQueue& rays, std::size_t begin, int count)
{
    switch (width) {
        case 16:
            thin_width<16>(scene, context, rays, begin, count);
            break;
        case 8:
            thin_width<8>(scene, context, rays, begin, count);
            break;
        default:
            thin_width<4>(scene, context, rays, begin, count);
            break;
    }
}

}   // namespace gnomon::ray
