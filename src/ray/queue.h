// SPDX-License-Identifier: Apache-2.0
#pragma once
// Queues of rays and of their hits, as structures of arrays, so that packets of 8 or 16 load without shuffling.

#include <algorithm>
#include <cstdint>
#include <vector>

#include "base/math.h"
#include "scene/ids.h"

namespace gnomon::ray {

inline constexpr std::size_t k_packet_pad = 16;   // arrays are padded so that the last packet can be loaded whole

/// The purpose of rays, for counting; it does not change the results. `check`: rays of a measurement, which the image
/// does not need.
enum class RayClass : std::uint8_t { primary, reflection, refraction, shadow, indirect, check };
inline constexpr int k_ray_classes = 6;

/// Rays that are traced together. Neighbours in the queue share a packet, so rays of similar direction should be side
/// by side.
struct RayQueue {
    std::vector<float> ox, oy, oz, tnear;
    std::vector<float> dx, dy, dz, tfar;
    RayClass purpose = RayClass::shadow;

    std::size_t size() const { return count_; }
    bool empty() const { return count_ == 0; }
    void clear() { count_ = 0; }
    void reserve(std::size_t n)
    {
        const std::size_t padded = (n + 2 * k_packet_pad) / k_packet_pad * k_packet_pad;
        if (padded <= ox.size()) return;
        for (auto* a : {&ox, &oy, &oz, &tnear, &dx, &dy, &dz, &tfar}) a->resize(padded);
    }
    /// The direction need not be a unit vector; distances are multiples of its length.
    void push(const glm::vec3& origin, float near_distance, const glm::vec3& direction, float far_distance)
    {
        // A packet that begins at the last ray is loaded whole, too.
        if (count_ + k_packet_pad >= ox.size()) reserve(2 * count_ + k_packet_pad);
        ox[count_] = origin.x, oy[count_] = origin.y, oz[count_] = origin.z, tnear[count_] = near_distance;
        dx[count_] = direction.x, dy[count_] = direction.y, dz[count_] = direction.z, tfar[count_] = far_distance;
        ++count_;
    }
    glm::vec3 origin(std::size_t i) const { return {ox[i], oy[i], oz[i]}; }
    glm::vec3 direction(std::size_t i) const { return {dx[i], dy[i], dz[i]}; }

 private:
    std::size_t count_ = 0;
};

/// Moves barycentric coordinates of a hit off the triangle's edges by a few millionths. Surfaces meet at edges, and a
/// point on an edge that rounding puts behind the other surface would be in its shadow.
inline glm::vec2 off_edges(float u, float v)
{
    constexpr float k_off = 4e-6f;
    u = std::max(u, k_off), v = std::max(v, k_off);
    const float beyond = u + v - (1 - k_off);
    if (beyond > 0) u > v ? u -= beyond : v -= beyond;
    return {u, v};
}

/// Results of closest-hit rays, in the queue's order. `object` is scene::none where a ray hit nothing; the rest is then
/// undefined. The hit is at (1-u-v) p0 + u p1 + v p2 (see off_edges()).
struct Hits {
    std::vector<float> t, u, v;
    std::vector<scene::ObjectId> object;
    std::vector<std::uint32_t> triangle;   // of the object's mesh

    void resize(std::size_t n)
    {
        const std::size_t padded = (n + 2 * k_packet_pad) / k_packet_pad * k_packet_pad;
        if (padded <= t.size()) return;
        t.resize(padded), u.resize(padded), v.resize(padded), object.resize(padded), triangle.resize(padded);
    }
};

}   // namespace gnomon::ray
