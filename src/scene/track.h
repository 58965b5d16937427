// SPDX-License-Identifier: Apache-2.0
#pragma once
// Animation tracks: values as functions of time that report when they change.
//
// A track reports the closed time intervals in which it is not constant. Between two frames, only tracks whose
// intervals overlap the time between them are evaluated, so constant parts of a clip cost nothing.

#include <memory>
#include <vector>

#include "base/math.h"

namespace gnomon::scene {

/// A closed interval; first <= last.
struct Interval {
    double first = 0;
    double last = 0;
};

/// A node's transform relative to its parent.
class TransformTrack {
 public:
    virtual ~TransformTrack() = default;
    /// The affine matrix at a time. The same time gives the same bits, whatever was evaluated before.
    virtual glm::dmat4 evaluate(double time) const = 0;
    /// The intervals of change, ascending and disjoint. Outside of them (and between their ends) the value is constant.
    virtual std::vector<Interval> changing() const = 0;
};

/// Visibility as a step function; visible before the first key.
struct VisibilityTrack {
    std::vector<double> times;   // increasing, or equal (the later key then applies)
    std::vector<bool> visible;

    bool evaluate(double time) const;
};

/// Weights of a mesh's morph targets.
class WeightsTrack {
 public:
    virtual ~WeightsTrack() = default;
    /// @param weights  resized to the number of targets; every element is written
    virtual void evaluate(double time, std::vector<float>& weights) const = 0;
    virtual std::vector<Interval> changing() const = 0;
};

/// Translation, rotation and scale of a node, as in glTF.
struct TransformParts {
    glm::dvec3 translation{0};
    glm::dquat rotation{1, 0, 0, 0};
    glm::dvec3 scale{1};
    glm::dmat4 matrix() const;
};

}   // namespace gnomon::scene
