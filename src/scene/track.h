// SPDX-License-Identifier: Apache-2.0
#pragma once
// Animation: values as functions of time, which know when they change.
//
// A track says in which closed time intervals it is not constant. Mobility rests on it: between two frames only tracks
// whose intervals meet the time between them are evaluated, so a clip's still stretches cost nothing.

#include <memory>
#include <vector>

#include "base/math.h"

namespace gnomon::scene {

/// Closed; first <= last.
struct Interval {
    double first = 0;
    double last = 0;
};

/// A node's transform relative to its parent.
class TransformTrack {
 public:
    virtual ~TransformTrack() = default;
    /// Affine; the same bits for the same time, whatever was asked before.
    virtual glm::dmat4 evaluate(double time) const = 0;
    /// Ascending and disjoint. Outside of them (and between their ends) the value is constant.
    virtual std::vector<Interval> changing() const = 0;
};

/// Visible or not: a step function. Visible before the first key.
struct VisibilityTrack {
    std::vector<double> times;   // rising, or equal (the later key then holds)
    std::vector<bool> visible;

    bool evaluate(double time) const;
};

/// Weights of a mesh's morph targets.
class WeightsTrack {
 public:
    virtual ~WeightsTrack() = default;
    /// @param weights  as many as the mesh has targets; written whole
    virtual void evaluate(double time, std::vector<float>& weights) const = 0;
    virtual std::vector<Interval> changing() const = 0;
};

/// T R S of a node, as glTF keeps it.
struct TransformParts {
    glm::dvec3 translation{0};
    glm::dquat rotation{1, 0, 0, 0};
    glm::dvec3 scale{1};
    glm::dmat4 matrix() const;
};

}   // namespace gnomon::scene
