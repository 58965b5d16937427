// SPDX-License-Identifier: Apache-2.0
#pragma once
// A bounding-sphere hierarchy of dynamic objects: a sphere around each object, and spheres around those, up to one
// around all that move together.
//
// Nodes lie in depth-first order. A traversal goes through them in order, and skips to `next` from a sphere that is not
// met.

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "base/math.h"

namespace gnomon::irradiance_cache {

struct Sphere {
    glm::vec3 centre{0};
    float radius = 0;
};

/// Whether a sphere meets the way from a point: `far` times as long as `way`.
inline bool meets_way(const Sphere& sphere, const glm::vec3& from, const glm::vec3& way, float far)
{
    const glm::vec3 at = sphere.centre - from;
    const float square = glm::dot(way, way);
    const float along = square > 0 ? std::clamp(glm::dot(at, way) / square, 0.0f, far) : 0.0f;
    const glm::vec3 off = at - along * way;
    return glm::dot(off, off) <= sphere.radius * sphere.radius;
}

inline constexpr float k_grown = 1.0001f;   // factor on radii, against rounding

class MovingSpheres {
 public:
    struct Node {
        Sphere sphere;
        std::uint32_t next;   // the first after those inside it
        bool single;          // around one object
    };
    void clear() { nodes_.clear(); }
    bool empty() const { return nodes_.empty(); }
    /// Adds the spheres of objects that move together. Cost: O(n log n).
    void add(std::vector<Sphere> together) { enclose(together); }
    /// Replaces the sphere of an object that was added alone.
    void move(std::uint32_t node, const Sphere& sphere) { nodes_[node].sphere = sphere; }
    const std::vector<Node>& nodes() const { return nodes_; }

    /// Calls single(sphere) for every object for whose sphere, and those around it, meets(sphere) is true. Stops if it
    /// returns true, and returns whether it did.
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
