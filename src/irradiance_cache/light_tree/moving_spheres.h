// SPDX-License-Identifier: Apache-2.0
#pragma once
// What moves, enclosed: a sphere about each thing, and spheres about those, down to one about all that moves together.
//
// They lie one after another, parents first. Who asks which spheres something meets goes through them in order, and
// jumps to `next` from one that it does not meet.

#include <cstdint>
#include <span>
#include <vector>

#include "base/math.h"

namespace gnomon::irradiance_cache {

struct Sphere {
    glm::vec3 centre{0};
    float radius = 0;
};

inline constexpr float k_grown = 1.0001f;   // spheres around what moves, against rounding

class MovingSpheres {
 public:
    struct Node {
        Sphere sphere;
        std::uint32_t next;   // the first after those inside it
        bool single;          // about one thing
    };
    void clear() { nodes_.clear(); }
    bool empty() const { return nodes_.empty(); }
    /// Encloses what moves together. Cost: O(n log n).
    void add(std::vector<Sphere> together) { enclose(together); }
    const std::vector<Node>& nodes() const { return nodes_; }

    /// Calls `single` for every thing whose sphere, and those about it, `meets` says yes to; stops where it returns
    /// true, and returns whether it did.
    template <class Meets, class Single>
    bool any(const Meets& meets, const Single& single) const
    {
        for (std::uint32_t i = 0; i < nodes_.size();) {
            const Node& node = nodes_[i];
            const bool met = meets(node.sphere);
            if (met && node.single && single(node.sphere)) return true;
            i = met ? i + 1 : node.next;
        }
        return false;
    }

 private:
    void enclose(std::span<Sphere> spheres);
    std::vector<Node> nodes_;
};

}   // namespace gnomon::irradiance_cache
