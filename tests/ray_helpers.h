// SPDX-License-Identifier: Apache-2.0
#pragma once
// Random rays, and the results of a RayScene for them in one struct that can be compared to the bit.

#include <cstring>
#include <tuple>

#include "base/random.h"
#include "ray/ray_scene.h"

namespace gnomon::test {

/// Rays between random points of a cube, some long and some short; directions are not normalised.
inline ray::RayQueue random_rays(std::uint64_t seed, std::size_t count, float reach = 8)
{
    Random random(seed);
    const auto point = [&] {
        const float x = random.uniform(-reach, reach), y = random.uniform(-reach, reach);
        return glm::vec3(x, y, random.uniform(-reach, reach));
    };
    ray::RayQueue rays;
    for (std::size_t i = 0; i < count; ++i) {
        const glm::vec3 from = point(), to = point();
        const float tnear = i % 7 == 0 ? 0.1f : 0.0f;
        rays.push(from, tnear, to - from, i % 3 == 0 ? 1.0f : i % 3 == 1 ? 0.4f : k_infinity);
    }
    return rays;
}

struct Answers {
    std::vector<ray::Hit> both, front;
    std::vector<std::uint8_t> occluded, occluded_static, occluded_dynamic;
};

inline bool same_bits(const ray::Hit& a, const ray::Hit& b)
{
    if (a.object == scene::none || b.object == scene::none) return a.object == b.object;
    const auto bits = [](const ray::Hit& h) {
        std::uint32_t t, u, v;
        std::memcpy(&t, &h.t, 4), std::memcpy(&u, &h.u, 4), std::memcpy(&v, &h.v, 4);
        return std::tuple(t, u, v, h.object, h.triangle);
    };
    return bits(a) == bits(b);
}

/// The number of rays for which two sets of results differ.
inline std::size_t differences(const Answers& a, const Answers& b)
{
    std::size_t count = a.both.size() == b.both.size() ? 0 : 1;
    for (std::size_t i = 0; i < std::min(a.both.size(), b.both.size()); ++i)
        count += !same_bits(a.both[i], b.both[i]) || !same_bits(a.front[i], b.front[i]) ||
                 a.occluded[i] != b.occluded[i] || a.occluded_static[i] != b.occluded_static[i] ||
                 a.occluded_dynamic[i] != b.occluded_dynamic[i];
    return count;
}

inline std::size_t count_hits(const Answers& answers)
{
    std::size_t count = 0;
    for (const ray::Hit& hit : answers.both) count += hit.object != scene::none;
    return count;
}

/// The hit at (x, 0) of a ray from far up the Z axis, slightly offset so that it misses edges and poles.
inline ray::Hit look_at(const ray::RayScene& rays, float x, ray::Sides sides = ray::Sides::both)
{
    return rays.closest_single({x + 0.013f, 0.017f, 50}, 0, {0, 0, -1}, 1000, sides);
}

/// Traces packets. @param cut  rays are traced in pieces of this length; 0: all at once
inline Answers trace(const ray::RayScene& scene, const ray::RayQueue& rays, std::size_t cut = 0)
{
    using ray::Against;
    const std::size_t n = rays.size(), piece = cut == 0 ? n : cut;
    Answers answers;
    ray::Hits hits;
    hits.resize(n);
    for (const ray::Sides sides : {ray::Sides::both, ray::Sides::front}) {
        for (std::size_t at = 0; at < n; at += piece) scene.closest(rays, at, std::min(n, at + piece), hits, sides);
        auto& out = sides == ray::Sides::both ? answers.both : answers.front;
        for (std::size_t i = 0; i < n; ++i)
            out.push_back({hits.t[i], hits.u[i], hits.v[i], hits.object[i], hits.triangle[i]});
    }
    for (const auto& [against, out] :
         {std::pair(Against::everything, &answers.occluded), std::pair(Against::static_only, &answers.occluded_static),
          std::pair(Against::dynamic_only, &answers.occluded_dynamic)}) {
        out->assign(n, 2);
        for (std::size_t at = 0; at < n; at += piece)
            scene.occluded(rays, at, std::min(n, at + piece), out->data() + at, against);
    }
    return answers;
}

/// Traces single rays.
inline Answers trace_singly(const ray::RayScene& scene, const ray::RayQueue& rays)
{
    using ray::Against;
    Answers answers;
    for (std::size_t i = 0; i < rays.size(); ++i) {
        const glm::vec3 from = rays.origin(i), along = rays.direction(i);
        const float tnear = rays.tnear[i], tfar = rays.tfar[i];
        answers.both.push_back(scene.closest_single(from, tnear, along, tfar, ray::Sides::both));
        answers.front.push_back(scene.closest_single(from, tnear, along, tfar, ray::Sides::front));
        answers.occluded.push_back(scene.occluded_single(from, tnear, along, tfar));
        answers.occluded_static.push_back(scene.occluded_single(from, tnear, along, tfar, Against::static_only));
        answers.occluded_dynamic.push_back(scene.occluded_single(from, tnear, along, tfar, Against::dynamic_only));
    }
    return answers;
}

}   // namespace gnomon::test
