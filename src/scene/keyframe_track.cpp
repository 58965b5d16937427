// SPDX-License-Identifier: Apache-2.0
#include "scene/keyframe_track.h"

#include <algorithm>
#include <cmath>

#include "base/check.h"

namespace gnomon::scene {

namespace {

// A position in time: at or after key `before`, at fraction `u` (0 to 1) of the way to the next. Outside the keys u
// is 0.
struct Place {
    std::size_t before = 0;
    double u = 0;
    double span = 0;   // seconds between the two keys
};

Place locate(const std::vector<double>& times, double time)
{
    const auto after = static_cast<std::size_t>(std::upper_bound(times.begin(), times.end(), time) - times.begin());
    if (after == 0) return {0, 0, 0};
    if (after == times.size()) return {after - 1, 0, 0};
    const double span = times[after] - times[after - 1];
    return {after - 1, (time - times[after - 1]) / span, span};
}

double dot(const glm::dquat& a, const glm::dquat& b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z + a.w * b.w;
}

glm::dvec3 finish(const glm::dvec3& v, const glm::dvec3&)
{
    return v;
}
// Normalises an interpolated quaternion. A spline may pass through zero; the key is used there.
glm::dquat finish(const glm::dquat& q, const glm::dquat& key)
{
    const double length = std::sqrt(dot(q, q));
    return length > 0 ? q * (1.0 / length) : key;
}

glm::dvec3 linear(const glm::dvec3& a, const glm::dvec3& b, double u)
{
    return a * (1 - u) + b * u;
}

// Spherical linear interpolation; linear for nearly equal rotations, where the sine would be a divisor near zero.
glm::dquat linear(const glm::dquat& a, glm::dquat b, double u)
{
    double cosine = dot(a, b);
    if (cosine < 0) b = -b, cosine = -cosine;   // the shorter way
    constexpr double nearly_equal = 1 - 1e-10;
    if (cosine > nearly_equal) return finish(a * (1 - u) + b * u, a);
    const double angle = std::acos(cosine);
    return finish((a * std::sin((1 - u) * angle) + b * std::sin(u * angle)) * (1 / std::sin(angle)), a);
}

// Cubic Hermite interpolation [glTF 2.0, C.5] of numbers, vectors, and quaternions by component.
template <class T>
T hermite(const T& v0, const T& out0, const T& in1, const T& v1, double u, double span)
{
    const double u2 = u * u, u3 = u2 * u;
    return v0 * (2 * u3 - 3 * u2 + 1) + out0 * (span * (u3 - 2 * u2 + u)) + v1 * (3 * u2 - 2 * u3) +
           in1 * (span * (u3 - u2));
}

bool zero(const glm::dvec3& v)
{
    return v == glm::dvec3(0);
}
bool zero(const glm::dquat& q)
{
    return dot(q, q) == 0;
}

template <class T>
T evaluate_channel(const KeyChannel<T>& channel, double time)
{
    const Place p = locate(channel.times, time);
    const auto& v = channel.values;
    if (channel.interpolation == KeyInterpolation::cubic_spline) {
        const std::size_t i = 3 * p.before;
        if (p.u == 0) return v[i + 1];
        if (v[i + 1] == v[i + 4] && zero(v[i + 2]) && zero(v[i + 3])) return v[i + 1];
        return finish(hermite(v[i + 1], v[i + 2], v[i + 3], v[i + 4], p.u, p.span), v[i + 1]);
    }
    if (p.u == 0 || channel.interpolation == KeyInterpolation::step || v[p.before] == v[p.before + 1])
        return v[p.before];
    return linear(v[p.before], v[p.before + 1], p.u);
}

template <class T>
void note_changes(const KeyChannel<T>& channel, std::vector<Interval>& out)
{
    const auto& t = channel.times;
    const auto& v = channel.values;
    for (std::size_t k = 0; k + 1 < t.size(); ++k) {
        switch (channel.interpolation) {
            case KeyInterpolation::step:
                if (v[k] != v[k + 1]) out.push_back({t[k + 1], t[k + 1]});
                break;
            case KeyInterpolation::linear:
                if (v[k] != v[k + 1]) out.push_back({t[k], t[k + 1]});
                break;
            case KeyInterpolation::cubic_spline:
                if (v[3 * k + 1] != v[3 * k + 4] || !zero(v[3 * k + 2]) || !zero(v[3 * k + 3]))
                    out.push_back({t[k], t[k + 1]});
        }
    }
}

template <class T>
void check_channel(const std::optional<KeyChannel<T>>& channel)
{
    if (!channel) return;
    GNOMON_CHECK(!channel->times.empty());
    const std::size_t each = channel->interpolation == KeyInterpolation::cubic_spline ? 3 : 1;
    GNOMON_CHECK_EQ(channel->values.size(), channel->times.size() * each);
}

}   // namespace

std::vector<Interval> join_intervals(std::vector<Interval> intervals)
{
    std::sort(intervals.begin(), intervals.end(),
              [](const Interval& a, const Interval& b) { return a.first < b.first; });
    std::vector<Interval> joined;
    for (const Interval& interval : intervals) {
        if (!joined.empty() && interval.first <= joined.back().last)
            joined.back().last = std::max(joined.back().last, interval.last);
        else
            joined.push_back(interval);
    }
    return joined;
}

KeyframeTrack::KeyframeTrack(TransformParts rest, std::optional<KeyChannel<glm::dvec3>> translation,
                             std::optional<KeyChannel<glm::dquat>> rotation,
                             std::optional<KeyChannel<glm::dvec3>> scale)
    : rest_(rest), translation_(std::move(translation)), scale_(std::move(scale)), rotation_(std::move(rotation))
{
    check_channel(translation_);
    check_channel(scale_);
    check_channel(rotation_);
}

TransformParts KeyframeTrack::parts(double time) const
{
    TransformParts parts = rest_;
    if (translation_) parts.translation = evaluate_channel(*translation_, time);
    if (rotation_) parts.rotation = evaluate_channel(*rotation_, time);
    if (scale_) parts.scale = evaluate_channel(*scale_, time);
    return parts;
}

glm::dmat4 KeyframeTrack::evaluate(double time) const
{
    return parts(time).matrix();
}

std::vector<Interval> KeyframeTrack::changing() const
{
    std::vector<Interval> intervals;
    if (translation_) note_changes(*translation_, intervals);
    if (rotation_) note_changes(*rotation_, intervals);
    if (scale_) note_changes(*scale_, intervals);
    return join_intervals(std::move(intervals));
}

KeyframeWeights::KeyframeWeights(KeyInterpolation interpolation, std::vector<double> times, std::vector<double> values,
                                 std::size_t targets)
    : interpolation_(interpolation), times_(std::move(times)), values_(std::move(values)), targets_(targets)
{
    GNOMON_CHECK(!times_.empty());
    const std::size_t each = interpolation_ == KeyInterpolation::cubic_spline ? 3 : 1;
    GNOMON_CHECK_EQ(values_.size(), times_.size() * targets_ * each);
}

void KeyframeWeights::evaluate(double time, std::vector<float>& weights) const
{
    const Place p = locate(times_, time);
    weights.resize(targets_);
    const bool cubic = interpolation_ == KeyInterpolation::cubic_spline;
    for (std::size_t i = 0; i < targets_; ++i) {
        // A spline stores, per key, all in-tangents, then all values, then all out-tangents.
        const double* v = values_.data() + (cubic ? (3 * p.before + 1) * targets_ : p.before * targets_) + i;
        double value = *v;
        if (p.u > 0 && interpolation_ == KeyInterpolation::linear && v[0] != v[targets_])
            value = v[0] * (1 - p.u) + v[targets_] * p.u;
        if (p.u > 0 && cubic && (v[0] != v[3 * targets_] || v[targets_] != 0 || v[2 * targets_] != 0))
            value = hermite(v[0], v[targets_], v[2 * targets_], v[3 * targets_], p.u, p.span);
        weights[i] = static_cast<float>(value);
    }
}

std::vector<Interval> KeyframeWeights::changing() const
{
    std::vector<Interval> intervals;
    const bool cubic = interpolation_ == KeyInterpolation::cubic_spline;
    for (std::size_t k = 0; k + 1 < times_.size(); ++k) {
        bool changes = false;
        for (std::size_t i = 0; i < targets_ && !changes; ++i) {
            const double* v = values_.data() + (cubic ? (3 * k + 1) * targets_ : k * targets_) + i;
            changes = cubic ? v[0] != v[3 * targets_] || v[targets_] != 0 || v[2 * targets_] != 0 : v[0] != v[targets_];
        }
        if (!changes) continue;
        const double first = interpolation_ == KeyInterpolation::step ? times_[k + 1] : times_[k];
        intervals.push_back({first, times_[k + 1]});
    }
    return join_intervals(std::move(intervals));
}

}   // namespace gnomon::scene
