// SPDX-License-Identifier: Apache-2.0
#pragma once
// Where a camera that looks in a fixed direction must stand so that an image of any aspect shows a set of points whole:
// as near as possible, with the points in the middle.
//
// A point with coordinates r to the right, u up and b back is within the frame's width, seen from (x, y, d), if
// |r - x| <= t (d - b), with t the tangent of half the horizontal angle. So the greatest r + t b bounds x + t d from
// below, and the greatest -r + t b bounds -x + t d; the smallest d that satisfies both has x half-way between. The
// height is treated likewise. For any t, only corners of the convex hulls of (b, r) and (b, u) reach these bounds.
//
// Cost: O(n log n) for n points, a few hundred bytes; a position costs one pass over the hulls.

#include <vector>

#include "base/math.h"

namespace gnomon::scene {

class CameraFit {
 public:
    struct Lens {
        double vertical_fov = 0.7;   // radians
        double margin = 1.08;        // the points fill one part in so much of the image
        double least_distance = 0;   // in front of the nearest point
    };
    explicit CameraFit(const Lens& lens) : lens_(lens) {}

    /// @param p  right, up, back
    void add(const glm::dvec3& p);
    bool empty() const { return hulls_[0].empty(); }
    double vertical_fov() const { return lens_.vertical_fov; }
    void set_least_distance(double distance) { lens_.least_distance = distance; }
    /// The position, in the coordinates of the points, for an image so many times as wide as high.
    glm::dvec3 eye(double aspect) const;
    /// The aspect at which the camera's node stands.
    static constexpr double k_node_aspect = 16.0 / 9.0;

 private:
    Lens lens_;
    std::vector<glm::dvec2> hulls_[2];   // (back, right) and (back, up); a few points that no bound needs among them
    std::size_t reduced_ = 0;            // length of the longer hull when it was last reduced
    double nearest_ = 0;                 // the greatest coordinate back
};

}   // namespace gnomon::scene
