// SPDX-License-Identifier: Apache-2.0
#pragma once
// Keyframe animation of glTF 2.0 [glTF 2.0, appendix C]: translation, rotation and scale of a node, and weights of
// morph targets. Each has its own keys and is stepped, linear (rotations: along the shorter great arc) or cubic
// Hermite.
//
// At keys, outside of the keys and between two equal keys, the value is exactly the key's own, bit for bit, so
// changing() can omit those times. All values are doubles. Cost: a binary search per channel.

#include <optional>
#include <vector>

#include "scene/track.h"

namespace gnomon::scene {

enum class KeyInterpolation : std::uint8_t { step, linear, cubic_spline };

/// Values at increasing times. T: dvec3, or dquat (unit).
template <class T>
struct KeyChannel {
    KeyInterpolation interpolation = KeyInterpolation::linear;
    std::vector<double> times;   // strictly increasing; not empty
    std::vector<T> values;       // one per key; cubic_spline: in-tangent, value, out-tangent of each key
};

class KeyframeTrack : public TransformTrack {
 public:
    /// @param rest  values of the parts without a channel
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
    /// @param values  times.size() * targets, key after key (cubic_spline: three times as many, in the order of
    ///                KeyChannel)
    KeyframeWeights(KeyInterpolation interpolation, std::vector<double> times, std::vector<double> values,
                    std::size_t targets);

    void evaluate(double time, std::vector<float>& weights) const override;
    std::vector<Interval> changing() const override;

 private:
    KeyInterpolation interpolation_;
    std::vector<double> times_, values_;
    std::size_t targets_;
};

/// Sorts intervals and merges those that overlap or touch.
std::vector<Interval> join_intervals(std::vector<Interval> intervals);

}   // namespace gnomon::scene
