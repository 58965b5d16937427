// SPDX-License-Identifier: Apache-2.0
#include "scene/kochanek_track.h"

#include <algorithm>

#include "base/check.h"

namespace gnomon::scene {

namespace {

constexpr double k_cut_off = 1e-3;   // of sines, below which log, exp and slerp take their limits

struct Place {
    std::size_t segment;
    double u;
};

// The first segment, from 0, that ends after t; times may repeat, and in one known file go back once.
template <class Keys>
Place find_segment(const Keys& keys, double t)
{
    const std::size_t n = keys.size();
    if (t <= keys[1].time) return {0, 0};
    if (t >= keys[n - 2].time) return {n - 4, 1};
    for (std::size_t i = 0; i + 3 < n; ++i)
        if (t < keys[i + 2].time) return {i, (t - keys[i + 1].time) / (keys[i + 2].time - keys[i + 1].time)};
    return {n - 4, 1};
}

double quotient(double a, double b)
{
    return b != 0 ? a / b : 0;
}

// Weights of the outgoing tangent at key 1 and the incoming one at key 2.
struct Weights {
    double out0, out1, in0, in1;
};
template <class Keys>
Weights weights_of(const Keys& k, std::size_t i)
{
    const double a = 2 * quotient(k[i + 2].time - k[i + 1].time, k[i + 2].time - k[i].time);
    const double b = 2 * quotient(k[i + 2].time - k[i + 1].time, k[i + 3].time - k[i + 1].time);
    const auto& p = k[i + 1];
    const auto& q = k[i + 2];
    return {a / 2 * (1 - p.tension) * (1 + p.continuity) * (1 + p.bias),
            a / 2 * (1 - p.tension) * (1 - p.continuity) * (1 - p.bias),
            b / 2 * (1 - q.tension) * (1 - q.continuity) * (1 + q.bias),
            b / 2 * (1 - q.tension) * (1 + q.continuity) * (1 - q.bias)};
}

// Segment i runs from key i + 1 to key i + 2. A segment of no length is a jump.
template <class Keys, class Still>
void changes_of(const Keys& keys, const Still& still, std::vector<Interval>& intervals)
{
    const std::size_t n = keys.size();
    bool ordered = true;
    for (std::size_t i = 2; i + 1 < n; ++i) ordered = ordered && keys[i - 1].time <= keys[i].time;
    if (!ordered) {
        const auto [first, last] =
            std::minmax_element(keys.begin(), keys.end(), [](const auto& a, const auto& b) { return a.time < b.time; });
        intervals.push_back({first->time, last->time});
        return;
    }
    for (std::size_t i = 0; i + 3 < n; ++i)
        if (!still(i)) intervals.push_back({keys[i + 1].time, keys[i + 2].time});
}

}   // namespace

std::vector<Interval> merged(std::vector<Interval> intervals)
{
    std::sort(intervals.begin(), intervals.end(),
              [](const Interval& a, const Interval& b) { return a.first < b.first; });
    std::vector<Interval> result;
    for (const Interval& interval : intervals) {
        if (!result.empty() && interval.first <= result.back().last)
            result.back().last = std::max(result.back().last, interval.last);
        else
            result.push_back(interval);
    }
    return result;
}

glm::dvec3 VectorSpline::evaluate(double time) const
{
    const auto [i, u] = find_segment(keys, time);
    const Weights w = weights_of(keys, i);
    const glm::dvec3 d = values[i + 2] - values[i + 1];
    const glm::dvec3 out = w.out0 * (values[i + 1] - values[i]) + w.out1 * d;
    const glm::dvec3 in = w.in0 * d + w.in1 * (values[i + 3] - values[i + 2]);
    return values[i + 1] + u * (out + u * ((3.0 * d - 2.0 * out - in) + u * (out + in - 2.0 * d)));
}

void VectorSpline::add_changes(std::vector<Interval>& intervals) const
{
    if (keys.empty()) return;
    changes_of(
        keys,
        [&](std::size_t i) {
            const Weights w = weights_of(keys, i);
            const glm::dvec3 zero(0), d = values[i + 2] - values[i + 1];
            return d == zero && w.out0 * (values[i + 1] - values[i]) == zero &&
                   w.in1 * (values[i + 3] - values[i + 2]) == zero;
        },
        intervals);
}

RotationSpline::Quaternion RotationSpline::log_of(const Quaternion& q)
{
    if (std::abs(q.w) < 1) {
        const double angle = std::acos(q.w), sine = std::sin(angle);
        if (std::abs(sine) >= k_cut_off) return {0, q.v * (angle / sine)};
    }
    return {0, q.v};
}

RotationSpline::Quaternion RotationSpline::exp_of(const glm::dvec3& v)
{
    const double angle = glm::length(v), sine = std::sin(angle);
    return {std::cos(angle), std::abs(sine) >= k_cut_off ? v * (sine / angle) : v};
}

RotationSpline::Quaternion RotationSpline::product(const Quaternion& p, const Quaternion& q)
{
    return {p.w * q.w - glm::dot(p.v, q.v), p.w * q.v + q.w * p.v + glm::cross(p.v, q.v)};
}

RotationSpline::Quaternion RotationSpline::slerp(double t, const Quaternion& p, const Quaternion& q)
{
    const double angle = std::acos(std::clamp(p.w * q.w + glm::dot(p.v, q.v), -1.0, 1.0)), sine = std::sin(angle);
    if (sine < k_cut_off) return p;
    const double a = std::sin((1 - t) * angle) / sine, b = std::sin(t * angle) / sine;
    return {a * p.w + b * q.w, a * p.v + b * q.v};
}

RotationSpline::RotationSpline(std::vector<Key> keys) : keys_(std::move(keys))
{
    GNOMON_CHECK_LE(4u, keys_.size());
    std::vector<Quaternion> q;
    for (const Key& key : keys_) {
        const double half = key.angle * k_pi / 360;
        q.push_back({std::cos(half), std::sin(half) * key.axis});
    }
    const auto inverse_times = [](const Quaternion& a, const Quaternion& b) { return product({a.w, -a.v}, b); };
    for (std::size_t i = 0; i + 3 < q.size(); ++i) {
        // Take the shorter way; the turned quaternion stays turned for the segments that follow.
        if (q[i + 1].w * q[i + 2].w + glm::dot(q[i + 1].v, q[i + 2].v) < 0) q[i + 2] = {-q[i + 2].w, -q[i + 2].v};
        const Weights w = weights_of(keys_, i);
        const glm::dvec3 l = log_of(inverse_times(q[i + 1], q[i + 2])).v;
        const glm::dvec3 before = log_of(inverse_times(q[i], q[i + 1])).v;
        const glm::dvec3 after = log_of(inverse_times(q[i + 2], q[i + 3])).v;
        const glm::dvec3 out = w.out1 * l + w.out0 * before, in = w.in0 * l + w.in1 * after;
        Segment segment;
        segment.q1 = q[i + 1];
        segment.q2 = q[i + 2];
        segment.a = product(q[i + 1], exp_of((out - l) / 2.0));
        segment.b = product(q[i + 2], exp_of((l - in) / 2.0));
        segment.still = l == glm::dvec3(0) && out == glm::dvec3(0) && in == glm::dvec3(0);
        segments_.push_back(segment);
    }
}

glm::dmat3 RotationSpline::evaluate(double time) const
{
    const auto [i, u] = find_segment(keys_, time);
    const Segment& s = segments_[i];
    const Quaternion q = slerp(2 * u * (1 - u), slerp(u, s.q1, s.q2), slerp(u, s.a, s.b));
    // By angle and axis, not by the quaternion's length: keys need not be unit.
    const double length = glm::length(q.v);
    if (length == 0) return glm::dmat3(1);
    const double half = std::acos(std::clamp(q.w, -1.0, 1.0));
    const glm::dvec3 axis = q.v / length;
    return glm::mat3_cast(glm::dquat(std::cos(half), std::sin(half) * axis));
}

void RotationSpline::add_changes(std::vector<Interval>& intervals) const
{
    if (keys_.empty()) return;
    changes_of(
        keys_, [&](std::size_t i) { return segments_[i].still; }, intervals);
}

glm::dmat4 KochanekTrack::evaluate(double time) const
{
    glm::dmat4 m(1);
    if (!rotation.empty()) m = glm::dmat4(rotation.evaluate(time));
    if (!scale.keys.empty()) {
        const glm::dvec3 s = scale.evaluate(time);
        for (int c = 0; c < 3; ++c) m[c] *= s[c];
    }
    if (!translation.keys.empty()) m[3] = glm::dvec4(translation.evaluate(time), 1);
    return m;
}

std::vector<Interval> KochanekTrack::changing() const
{
    std::vector<Interval> intervals;
    translation.add_changes(intervals);
    scale.add_changes(intervals);
    rotation.add_changes(intervals);
    return merged(std::move(intervals));
}

}   // namespace gnomon::scene
