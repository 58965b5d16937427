// SPDX-License-Identifier: Apache-2.0
#pragma once
// Vectors and transforms as hosts pass them. They have the memory layout of plain arrays, so that a host's own arrays
// of floats can be passed without a copy.

#include <array>

namespace gnomon {

/// Texture coordinates.
struct Vec2 {
    float x = 0, y = 0;
    friend bool operator==(const Vec2&, const Vec2&) = default;
};

/// A point, a direction, or a colour (linear, Rec. 709 primaries).
struct Vec3 {
    float x = 0, y = 0, z = 0;
    friend bool operator==(const Vec3&, const Vec3&) = default;
};

/// A tangent with its sign, a colour with alpha (linear), or four weights.
struct Vec4 {
    float x = 0, y = 0, z = 0, w = 0;
    friend bool operator==(const Vec4&, const Vec4&) = default;
};

/// An axis-aligned box; empty if any low coordinate exceeds the high one.
struct Box {
    Vec3 low{1, 1, 1}, high{-1, -1, -1};
    /// Whether the box contains no point.
    bool empty() const { return !(low.x <= high.x && low.y <= high.y && low.z <= high.z); }
    friend bool operator==(const Box&, const Box&) = default;
};

/// A matrix for column vectors, stored by column: m[4 * column + row]. An affine transform has its translation in
/// m[12], m[13] and m[14], and the last row 0 0 0 1.
struct Transform {
    std::array<double, 16> m{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};

    /// Moves by x, y and z.
    static Transform translation(double x, double y, double z);
    /// Scales by x, y and z.
    static Transform scaling(double x, double y, double z);
    /// Turns about an axis through the origin.
    /// @param axis     need not have unit length
    /// @param radians  counter-clockwise, seen against the axis
    static Transform rotation(const Vec3& axis, double radians);
    /// From the space of a camera or a light, which look along -Z with +Y up, to the world.
    /// @param up  must not be parallel to the direction from `eye` to `target`
    static Transform look_at(const Vec3& eye, const Vec3& target, const Vec3& up = {0, 1, 0});

    /// Applies `inner` first, then `outer`.
    friend Transform operator*(const Transform& outer, const Transform& inner);
    friend bool operator==(const Transform&, const Transform&) = default;
};

}   // namespace gnomon
