// SPDX-License-Identifier: Apache-2.0
#include "scene/kochanek_track.h"

#include <algorithm>
#include <cmath>

#include "base/check.h"

namespace gnomon::scene {

namespace {

// Below this sine, BART's quaternion functions take the limit instead of dividing. Its scenes were made with this
// threshold.
constexpr double k_small_sine = 1e-3;

// The tangent at a key as weights of the two chords that meet there.
struct TangentWeights {
    double before = 0, after = 0;
};

// 2 (length of the segment) / (time between the neighbours of the key); 0 where three keys share one time.
double speed_adjustment(double segment, double span)
{
    return span == 0 ? 0 : 2 * segment / span;
}

// Outgoing tangent, where a segment begins [Kochanek and Bartels 1984, eq. 9, with the adjustment of section 6].
TangentWeights outgoing(const KochanekKey& k, double adjustment)
{
    return {adjustment / 2 * (1 - k.tension) * (1 + k.continuity) * (1 + k.bias),
            adjustment / 2 * (1 - k.tension) * (1 - k.continuity) * (1 - k.bias)};
}

// Incoming tangent, where a segment ends [eq. 8].
TangentWeights incoming(const KochanekKey& k, double adjustment)
{
    return {adjustment / 2 * (1 - k.tension) * (1 - k.continuity) * (1 + k.bias),
            adjustment / 2 * (1 - k.tension) * (1 + k.continuity) * (1 - k.bias)};
}

struct SegmentWeights {
    TangentWeights out, in;
};

template <class Key>
SegmentWeights weights_of(const std::vector<Key>& keys, std::size_t i)
{
    const double t0 = keys[i].time, t1 = keys[i + 1].time, t2 = keys[i + 2].time, t3 = keys[i + 3].time;
    return {outgoing(keys[i + 1], speed_adjustment(t2 - t1, t2 - t0)),
            incoming(keys[i + 2], speed_adjustment(t2 - t1, t3 - t1))};
}

template <class Key>
std::vector<double> times_of(const std::vector<Key>& keys)
{
    std::vector<double> times;
    times.reserve(keys.size());
    for (const Key& key : keys) times.push_back(key.time);
    return times;
}

// Quaternion functions as the format defines them, for quaternions of any length.

glm::dvec3 vector_of(const glm::dquat& q)
{
    return {q.x, q.y, q.z};
}
glm::dquat inverse_of(const glm::dquat& q)
{
    return {q.w, -q.x, -q.y, -q.z};
}

// The logarithm's real part is 0.
glm::dvec3 logarithm(const glm::dquat& q)
{
    if (!(std::abs(q.w) < 1)) return vector_of(q);
    const double angle = std::acos(q.w), sine = std::sin(angle);
    return std::abs(sine) >= k_small_sine ? vector_of(q) * (angle / sine) : vector_of(q);
}

glm::dquat exponential(const glm::dvec3& v)
{
    const double angle = glm::length(v), sine = std::sin(angle);
    const glm::dvec3 part = std::abs(sine) >= k_small_sine ? v * (sine / angle) : v;
    return {std::cos(angle), part.x, part.y, part.z};
}

double sine_between(const glm::dquat& p, const glm::dquat& q, double& angle)
{
    angle = std::acos(std::clamp(glm::dot(p, q), -1.0, 1.0));
    return std::sin(angle);
}

// Does not choose the shorter arc, because the keys' signs were settled before.
glm::dquat slerp(double t, const glm::dquat& p, const glm::dquat& q)
{
    double angle = 0;
    const double sine = sine_between(p, q, angle);
    if (sine < k_small_sine) return p;
    return (p * std::sin((1 - t) * angle) + q * std::sin(t * angle)) / sine;
}

bool slerp_is_constant(const glm::dquat& p, const glm::dquat& q)
{
    double angle = 0;
    return sine_between(p, q, angle) < k_small_sine;
}

// The merged intervals in which a spline changes, and the times at which it jumps from one constant interval to the
// next. The value before the first key may differ from the one just after, so the jump there extends slightly further.
template <class Constant, class Value>
std::vector<Interval> changing_intervals(const SegmentTable& table, const Constant& constant, const Value& value)
{
    std::vector<Interval> result;
    const auto add = [&](double first, double last) {
        if (!result.empty() && first <= result.back().last)
            result.back().last = std::max(result.back().last, last);
        else
            result.push_back({first, last});
    };
    auto before = value(SegmentTable::Place{0, 0.0});
    double from = table.first_time();
    for (const SegmentTable::Stretch& stretch : table.stretches()) {
        const auto here = value(SegmentTable::Place{stretch.segment, 0.0});
        if (!constant(stretch.segment))
            add(stretch.low, stretch.high);
        else if (here != before)
            add(from, std::nextafter(from, k_infinity));
        before = value(SegmentTable::Place{stretch.segment, 1.0});
        from = stretch.high;
    }
    if (value(SegmentTable::Place{table.segment_count() - 1, 1.0}) != before)
        add(from, std::nextafter(from, k_infinity));
    return result;
}

}   // namespace

SegmentTable::SegmentTable(std::vector<double> times) : times_(std::move(times))
{
    GNOMON_CHECK_LE(4u, times_.size());
    // The first segment whose end lies beyond t applies at t, so each applies from where all before it have ended.
    const double last = times_[times_.size() - 2];
    double low = times_[1];
    for (std::size_t i = 0; i < segment_count() && low < last; ++i) {
        const double high = std::min(times_[i + 2], last);
        if (!(low < high)) continue;
        stretches_.push_back({low, high, i});
        low = high;
    }
}

SegmentTable::Place SegmentTable::find(double time) const
{
    if (time <= times_[1]) return {0, 0};
    if (time >= times_[times_.size() - 2]) return {segment_count() - 1, 1};
    const auto stretch = std::upper_bound(stretches_.begin(), stretches_.end(), time,
                                          [](double t, const Stretch& s) { return t < s.high; });
    GNOMON_CHECK(stretch != stretches_.end());
    const double t1 = times_[stretch->segment + 1], t2 = times_[stretch->segment + 2];
    return {stretch->segment, (time - t1) / (t2 - t1)};
}

VectorSpline::VectorSpline(const std::vector<VectorKey>& keys) : table_(times_of(keys))
{
    for (std::size_t i = 0; i < table_.segment_count(); ++i) {
        const auto [out, in] = weights_of(keys, i);
        const glm::dvec3 p0 = keys[i].value, p1 = keys[i + 1].value, p2 = keys[i + 2].value, p3 = keys[i + 3].value;
        segments_.push_back(
            {p1, p2, out.before * (p1 - p0) + out.after * (p2 - p1), in.before * (p2 - p1) + in.after * (p3 - p2)});
    }
}

glm::dvec3 VectorSpline::at(const SegmentTable::Place& place) const
{
    const auto& [p1, p2, out, in] = segments_[place.segment];
    const double u = place.u;
    const glm::dvec3 d = p2 - p1;
    return p1 + u * (out + u * ((3.0 * d - 2.0 * out - in) + u * (out + in - 2.0 * d)));
}

glm::dvec3 VectorSpline::evaluate(double time) const
{
    return at(table_.find(time));
}

std::vector<Interval> VectorSpline::changing() const
{
    const auto constant = [&](std::size_t i) {
        const Segment& s = segments_[i];
        return s.p1 == s.p2 && s.out == glm::dvec3(0) && s.in == glm::dvec3(0);
    };
    return changing_intervals(table_, constant, [&](const SegmentTable::Place& place) { return at(place); });
}

double VectorSpline::reach() const
{
    double result = 0;
    for (const auto& [p1, p2, out, in] : segments_)
        for (const glm::dvec3& p : {p1, p2, p1 + out / 3.0, p2 - in / 3.0})
            for (int c = 0; c < 3; ++c)
                result = std::max(result, std::isfinite(p[c]) ? std::abs(p[c]) : double(k_infinity));
    return result;
}

RotationSpline::RotationSpline(const std::vector<RotationKey>& keys) : table_(times_of(keys))
{
    std::vector<glm::dquat> q;
    q.reserve(keys.size());
    for (const RotationKey& key : keys) {
        const glm::dvec3 v = std::sin(key.angle / 2) * key.axis;
        q.emplace_back(std::cos(key.angle / 2), v.x, v.y, v.z);
    }
    for (std::size_t i = 0; i < table_.segment_count(); ++i) {
        // Choose the nearer of q2 and -q2, and keep it for the segments that follow.
        const glm::dquat q0 = q[i], q1 = q[i + 1], q3 = q[i + 3];
        if (glm::dot(q1, q[i + 2]) < 0) q[i + 2] = -q[i + 2];
        const glm::dquat q2 = q[i + 2];

        // Compute tangents on logarithms, weighted like those of positions.
        const auto [out, in] = weights_of(keys, i);
        const glm::dvec3 chord = logarithm(inverse_of(q1) * q2);
        const glm::dvec3 leave = out.after * chord + out.before * logarithm(inverse_of(q0) * q1);
        const glm::dvec3 arrive = in.before * chord + in.after * logarithm(inverse_of(q2) * q3);
        segments_.push_back(
            {q1, q2, q1 * exponential((leave - chord) / 2.0), q2 * exponential((chord - arrive) / 2.0)});
    }
}

glm::dquat RotationSpline::at(const SegmentTable::Place& place) const
{
    // Interpolate by squad.
    const auto& [q1, q2, a, b] = segments_[place.segment];
    const double u = place.u;
    const glm::dquat q = slerp(2 * u * (1 - u), slerp(u, q1, q2), slerp(u, a, b));

    // Interpret the result as angle and axis. Normalising it would give another rotation if axes were not unit
    // vectors.
    const double half = std::acos(std::clamp(q.w, -1.0, 1.0));
    const double length = glm::length(vector_of(q));
    if (!(length > 0) || !std::isfinite(length)) return {1, 0, 0, 0};
    const glm::dvec3 v = vector_of(q) * (std::sin(half) / length);
    return {std::cos(half), v.x, v.y, v.z};
}

glm::dquat RotationSpline::evaluate(double time) const
{
    return at(table_.find(time));
}

std::vector<Interval> RotationSpline::changing() const
{
    const auto constant = [&](std::size_t i) {
        const Segment& s = segments_[i];
        return slerp_is_constant(s.q1, s.q2) && slerp_is_constant(s.a, s.b) && slerp_is_constant(s.q1, s.a);
    };
    return changing_intervals(table_, constant, [&](const SegmentTable::Place& place) { return at(place); });
}

glm::dmat4 KochanekTrack::evaluate(double time) const
{
    TransformParts parts = rest;
    if (translation) parts.translation = translation->evaluate(time);
    if (rotation) parts.rotation = rotation->evaluate(time);
    if (scale) parts.scale = scale->evaluate(time);
    return parts.matrix();
}

std::vector<Interval> KochanekTrack::changing() const
{
    std::vector<Interval> all;
    const auto take = [&](const std::vector<Interval>& more) { all.insert(all.end(), more.begin(), more.end()); };
    if (translation) take(translation->changing());
    if (rotation) take(rotation->changing());
    if (scale) take(scale->changing());

    // Join what overlaps.
    std::sort(all.begin(), all.end(), [](const Interval& x, const Interval& y) { return x.first < y.first; });
    std::vector<Interval> joined;
    for (const Interval& interval : all) {
        if (!joined.empty() && interval.first <= joined.back().last)
            joined.back().last = std::max(joined.back().last, interval.last);
        else
            joined.push_back(interval);
    }
    return joined;
}

}   // namespace gnomon::scene
