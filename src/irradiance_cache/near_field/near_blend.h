// SPDX-License-Identifier: Apache-2.0
#pragma once
// Puts the near field of near-field points in the place of what lattice points hold of it.
//
// The light of lattice points includes their near fields, so that it changes little from one to the next: on a wall
// above a bright floor, what leaves the near field at some height comes from beyond it from there on. Where near-field
// points lie between them, the near field N of the lattice gives way to that of these, n. The light from beyond changes
// with it: the form factor of the near surfaces is c here and C at the lattice points, and so much more of what is
// around is near. Its radiant exitance is about N/C; less, down to a half, where that of the near surfaces here, n/c,
// is less, because others are near here:
//
//   irradiance + n - N - min(c - C, C) M,  M = min(N/C, max(n/c, N/C / 2)) where c > C, N/C elsewhere
//
// Without the last term, a wall's foot was up to 25 % too dark and 20 % too bright, because light from beyond the near
// field rises from nothing to all light within its radius, and lattice points are as far apart.

#include <vector>

#include "irradiance_cache/points/cache_point.h"

namespace gnomon::irradiance_cache {

/// Holds a thread's scratch memory.
class NearBlend {
 public:
    /// Begins with so many surface points.
    void begin(std::size_t points);
    /// Adds a part of the near field of a surface point.
    /// @param weight  of its light
    /// @param known   likewise, and of what the lattice holds instead
    void add(std::uint32_t point, float weight, float known, const CachePoint& near, const glm::vec3& normal);
    /// Puts the sum of what was added into the irradiance of the surface points.
    /// @param known  by surface point, of the lattice: irradiance of near fields, and their form factor
    /// @param share  by surface point: the weight of those levels of the lattice that have any
    void finish(const glm::vec4* known, const float* share, glm::vec3* irradiance);

 private:
    struct Sum {
        glm::vec3 light{0};
        float factor = 0;         // of the near surfaces, by the weight of light
        float known_factor = 0;   // and by that of what is known
        float known = 0;
        bool any = false;
    };
    std::vector<Sum> sums_;               // by surface point
    std::vector<std::uint32_t> points_;   // those with a sum
};

}   // namespace gnomon::irradiance_cache
