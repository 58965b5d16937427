// SPDX-License-Identifier: Apache-2.0
#pragma once
// A bounding-sphere hierarchy of dynamic objects: a sphere around each object, and spheres around those, up to one
// around all that move together. What meets the sphere of an object is held against its box, because most of the sphere
// around a rod or a plate is empty.
//
// Nodes lie in depth-first order. A traversal goes through them in order, and skips to `next` from a sphere that is not
// met.

#include <algorithm>
#include <cmath>
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

/// A box around an object, whose sides need not be at right angles: what lies between three pairs of parallel planes.
struct MovingBox {
    static constexpr float k_rounding = 1e-6f;   // of the distance to what is held against the box
    static constexpr float k_slowest = 1e-30f;   // speed towards a plane that counts as one
    glm::vec3 centre{0};
    glm::vec3 normal[3]{};                               // of the planes, unit; 0: a pair that is everywhere
    float half[3]{k_infinity, k_infinity, k_infinity};   // of the distance between the planes of a pair

    /// @param own     box in the object's space
    /// @param sphere  around the same in the world: a margin against rounding is a fraction of its radius
    static MovingBox around(const Box3& own, const glm::mat4& to_world, const Sphere& sphere);
    /// What rounding may leave out of its reach, seen from a place.
    static float margin(const glm::vec3& at) { return k_rounding * (std::abs(at.x) + std::abs(at.y) + std::abs(at.z)); }
    /// A speed towards a plane by which distances can be divided.
    static float divisor(float speed) { return std::abs(speed) < k_slowest ? k_slowest : speed; }
};

/// Whether a box, grown on all sides, meets the way from a point: `far` times as long as `way`. Conservative.
inline bool meets_way(const MovingBox& box, const glm::vec3& from, const glm::vec3& way, float far, float grown = 0)
{
    const glm::vec3 at = from - box.centre;
    const float more = grown + MovingBox::margin(at);
    float begin = 0, end = far;
    for (int i = 0; i < 3; ++i) {
        const float away = glm::dot(box.normal[i], at), half = box.half[i] + more;
        const float speed = MovingBox::divisor(glm::dot(box.normal[i], way));
        const float a = (-half - away) / speed, b = (half - away) / speed;
        begin = std::max(begin, std::min(a, b)), end = std::min(end, std::max(a, b));
    }
    return begin <= end;
}

class MovingSpheres {
 public:
    struct Node {
        Sphere sphere;
        std::uint32_t next;   // the first after those inside it
        bool single;          // around one object
    };
    struct Object {
        Sphere sphere;
        MovingBox box;
    };
    void clear() { nodes_.clear(), boxes_.clear(); }
    bool empty() const { return nodes_.empty(); }
    /// Adds objects that move together. Cost: O(n log n).
    void add(std::vector<Object> together) { enclose(together); }
    /// Adds objects without boxes.
    void add(const std::vector<Sphere>& together);
    /// Replaces the sphere and the box of an object that was added alone.
    void move(std::uint32_t node, const Object& object)
    {
        nodes_[node].sphere = object.sphere, boxes_[node] = object.box;
    }
    const std::vector<Node>& nodes() const { return nodes_; }
    /// By node: that of a single object.
    const std::vector<MovingBox>& boxes() const { return boxes_; }

    /// Calls single(sphere, box) for every object for whose sphere, and those around it, meets(sphere) is true. Stops
    /// if it returns true, and returns whether it did.
    template <class Meets, class Single>
    bool any(const Meets& meets, const Single& single) const
    {
        for (std::uint32_t i = 0; i < nodes_.size();) {
            const Node& node = nodes_[i];
            const bool met = meets(node.sphere);
            if (met && node.single && single(node.sphere, boxes_[i])) return true;
            i = met ? i + 1 : node.next;
        }
        return false;
    }

 private:
    void enclose(std::span<Object> objects);
    std::vector<Node> nodes_;
    std::vector<MovingBox> boxes_;
};

}   // namespace gnomon::irradiance_cache
