// SPDX-License-Identifier: Apache-2.0
#pragma once
// Interpolation between keys with tension, continuity and bias [Kochanek and Bartels 1984, "Interpolating splines with
// local tension, continuity, and bias control"], as BART's scene format AFF uses it [BART AFF, Lext, Assarsson and
// Moller 2000]: positions and scales by cubics, rotations by the same tangent weights on quaternion logarithms and
// spherical quadrangle interpolation (squad) [Shoemake 1987].
//
// The first and the last key only shape tangents: a spline of n keys (n >= 4) runs from the time of key 1 to that of
// key n - 2, counted from 0, and is constant outside. Key times may repeat and even decrease; the segment at a time is
// then the one that a linear search from the first finds.
// Cost: a binary search and one segment. All computations use double precision.

#include <optional>
#include <vector>

#include "scene/track.h"

namespace gnomon::scene {

/// The parameters that every key has besides its value.
struct KochanekKey {
    double time = 0;
    double tension = 0;
    double continuity = 0;
    double bias = 0;
};
struct VectorKey : KochanekKey {
    glm::dvec3 value{0};
};
/// The axis may have any length and is not normalised; the angle is in radians and may exceed a full turn.
struct RotationKey : KochanekKey {
    glm::dvec3 axis{0, 1, 0};
    double angle = 0;
};

/// Maps a time to a segment. Segment i runs from key i + 1 to key i + 2.
class SegmentTable {
 public:
    struct Stretch {
        double low = 0;   // applies where low <= t < high (the first one: low < t)
        double high = 0;
        std::size_t segment = 0;
    };
    struct Place {
        std::size_t segment = 0;
        double u = 0;   // 0 to 1
    };

    /// @param times  of all keys, at least four
    explicit SegmentTable(std::vector<double> times);

    Place find(double time) const;
    const std::vector<Stretch>& stretches() const { return stretches_; }
    double first_time() const { return times_[1]; }
    std::size_t segment_count() const { return times_.size() - 3; }

 private:
    std::vector<double> times_;
    std::vector<Stretch> stretches_;   // ascending, without gaps, none of them empty
};

/// Positions or scales.
class VectorSpline {
 public:
    /// @param keys  at least four
    explicit VectorSpline(const std::vector<VectorKey>& keys);
    glm::dvec3 evaluate(double time) const;
    std::vector<Interval> changing() const;
    /// Bound on the absolute value of all coordinates (the hull of the Bezier control points).
    double reach() const;

 private:
    struct Segment {
        glm::dvec3 p1, p2, out, in;   // ends, and the tangents there
    };
    glm::dvec3 at(const SegmentTable::Place& place) const;
    SegmentTable table_;
    std::vector<Segment> segments_;
};

/// Rotations.
class RotationSpline {
 public:
    /// @param keys  at least four
    explicit RotationSpline(const std::vector<RotationKey>& keys);
    /// A unit quaternion.
    glm::dquat evaluate(double time) const;
    std::vector<Interval> changing() const;

 private:
    struct Segment {
        glm::dquat q1, q2, a, b;   // ends and inner quadrangle points; not of unit length if the axes were not
    };
    glm::dquat at(const SegmentTable::Place& place) const;
    SegmentTable table_;
    std::vector<Segment> segments_;
};

/// T(t) R(t) S(t); parts without keys keep their rest value.
class KochanekTrack : public TransformTrack {
 public:
    std::optional<VectorSpline> translation;
    std::optional<RotationSpline> rotation;
    std::optional<VectorSpline> scale;
    TransformParts rest;

    glm::dmat4 evaluate(double time) const override;
    std::vector<Interval> changing() const override;
};

}   // namespace gnomon::scene
