// SPDX-License-Identifier: Apache-2.0
#pragma once
// Kochanek-Bartels animation as BART's AFF files use it [Kochanek and Bartels 1984; Lext, Assarsson, Moller 2000].
//
// Positions and scales: cubic Hermite segments whose tangents come from tension, continuity and bias. Rotations: the
// same weights on quaternion logarithms, then squad [Shoemake 1987]. The first and last key only shape tangents.
// Everything in double precision; the cut-offs in log, exp and slerp are those the files were made with.

#include <array>

#include "scene/track.h"

namespace gnomon::scene {

struct KochanekKey {
    double time = 0;
    double tension = 0, continuity = 0, bias = 0;
};

/// A position or scale over time. At least 4 keys.
struct VectorSpline {
    std::vector<KochanekKey> keys;
    std::vector<glm::dvec3> values;   // one a key

    glm::dvec3 evaluate(double time) const;
    void add_changes(std::vector<Interval>& intervals) const;
};

/// A rotation over time. At least 4 keys; axes are not normalised, angles may exceed a turn.
class RotationSpline {
 public:
    struct Key : KochanekKey {
        glm::dvec3 axis{0};
        double angle = 0;   // degrees
    };
    RotationSpline() = default;
    explicit RotationSpline(std::vector<Key> keys);

    bool empty() const { return keys_.empty(); }
    /// A pure rotation.
    glm::dmat3 evaluate(double time) const;
    void add_changes(std::vector<Interval>& intervals) const;

 private:
    struct Quaternion {
        double w = 1;
        glm::dvec3 v{0};
    };
    static Quaternion log_of(const Quaternion& q);
    static Quaternion exp_of(const glm::dvec3& v);
    static Quaternion product(const Quaternion& p, const Quaternion& q);
    static Quaternion slerp(double t, const Quaternion& p, const Quaternion& q);

    std::vector<Key> keys_;
    // Per segment: the two ends and the two inner control points of squad.
    struct Segment {
        Quaternion q1, q2, a, b;
        bool still = false;
    };
    std::vector<Segment> segments_;
};

/// M = T R S of the parts that are there; a missing part is the identity.
class KochanekTrack : public TransformTrack {
 public:
    VectorSpline translation, scale;   // empty: none
    RotationSpline rotation;

    glm::dmat4 evaluate(double time) const override;
    std::vector<Interval> changing() const override;
};

/// Sorts, and joins what overlaps or touches.
std::vector<Interval> merged(std::vector<Interval> intervals);

}   // namespace gnomon::scene
