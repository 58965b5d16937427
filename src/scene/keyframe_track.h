// SPDX-License-Identifier: Apache-2.0
#pragma once
// Keyframe animation as glTF 2.0 has it [glTF 2.0, appendix C]: translation, rotation and scale of a node, and weights
// of morph targets, each with its own keys, stepped, linear (rotations: along the shorter great arc) or cubic Hermite.
//
// Exact where nothing happens: between two equal keys, at keys, and outside of them the value is the key's own, to the
// bit, so that changing() can leave those times out. Doubles throughout. Cost: a binary search a channel.

#include <optional>
#include <vector>

#include "scene/track.h"

namespace gnomon::scene {

enum class KeyInterpolation : std::uint8_t { step, linear, cubic_spline };

/// Values at rising times. T: dvec3, or dquat (unit).
template <class T>
struct KeyChannel {
    KeyInterpolation interpolation = KeyInterpolation::linear;
    std::vector<double> times;   // strictly rising; not empty
    std::vector<T> values;       // one a key; cubic_spline: in-tangent, value, out-tangent of each key
};

class KeyframeTrack : public TransformTrack {
 public:
    /// @param rest  what holds for the parts without a channel
    KeyframeTrack(TransformParts rest, std::optional<KeyChannel<glm::dvec3>> translation,
                  std::optional<KeyChannel<glm::dquat>> rotation, std::optional<KeyChannel<glm::dvec3>> scale);

    glm::dmat4 evaluate(double time) const override;
    std::vector<Interval> changing() const override;
    TransformParts parts(double time) const;

 private:
    TransformParts rest_;
    std::optional<KeyChannel<glm::dvec3>> translation_, scale_;
    std::optional<KeyChannel<glm::dquat>> rotation_;
};

class KeyframeWeights : public WeightsTrack {
 public:
    /// @param values  times.size() * targets (cubic_spline: times three, in the order of KeyChannel), key after key
    KeyframeWeights(KeyInterpolation interpolation, std::vector<double> times, std::vector<double> values,
                    std::size_t targets);

    void evaluate(double time, std::vector<float>& weights) const override;
    std::vector<Interval> changing() const override;

 private:
    KeyInterpolation interpolation_;
    std::vector<double> times_, values_;
    std::size_t targets_;
};

/// Sorts, and joins what overlaps or touches.
std::vector<Interval> join_intervals(std::vector<Interval> intervals);

}   // namespace gnomon::scene
