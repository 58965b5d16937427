// SPDX-License-Identifier: Apache-2.0
// AFF tracks from small files, compared with a second, slow implementation of the formulas.
#include <algorithm>
#include <array>

#include "aff_files.h"
#include "base/random.h"
#include "scene/state.h"

namespace gnomon::io {
namespace {

using test::AffFolder;
using test::k_material;
using test::k_mesh;

struct Key {
    double time;
    std::array<double, 4> value;   // x y z, or axis and degrees
    double t = 0, c = 0, b = 0;
};

std::string text_of(const std::string& kind, const std::vector<Key>& keys, int values)
{
    std::string text = kind + " " + std::to_string(keys.size()) + "\n";
    const auto add = [&](double x) {
        char number[40];
        std::snprintf(number, sizeof number, "%.17g ", x);
        text += number;
    };
    for (const Key& key : keys) {
        add(key.time);
        for (int i = 0; i < values; ++i) add(key.value[static_cast<std::size_t>(i)]);
        add(key.t), add(key.c), add(key.b);
    }
    return text;
}

std::shared_ptr<const scene::TransformTrack> track_of(const std::string& text)
{
    const AffFolder folder;
    return folder.load(k_material + "x a {" + k_mesh + "} k a {" + text + "}").nodes[0].transform;
}

glm::dvec3 point_of(const Key& key)
{
    return {key.value[0], key.value[1], key.value[2]};
}

// The segment at a time: the first, searched from 0, that ends later.
std::pair<std::size_t, double> place(const std::vector<Key>& keys, double t)
{
    const std::size_t n = keys.size();
    if (t <= keys[1].time) return {0, 0};
    if (t >= keys[n - 2].time) return {n - 4, 1};
    std::size_t i = 0;
    while (!(t < keys[i + 2].time)) ++i;
    return {i, (t - keys[i + 1].time) / (keys[i + 2].time - keys[i + 1].time)};
}

glm::dvec3 slow_position(const std::vector<Key>& keys, double time)
{
    const auto [i, u] = place(keys, time);
    const Key &k0 = keys[i], &k1 = keys[i + 1], &k2 = keys[i + 2], &k3 = keys[i + 3];
    const double whole1 = k2.time - k0.time, whole2 = k3.time - k1.time;
    const double a = whole1 == 0 ? 0 : 2 * (k2.time - k1.time) / whole1;
    const double b = whole2 == 0 ? 0 : 2 * (k2.time - k1.time) / whole2;
    const glm::dvec3 out = a / 2 * (1 - k1.t) * (1 + k1.c) * (1 + k1.b) * (point_of(k1) - point_of(k0)) +
                           a / 2 * (1 - k1.t) * (1 - k1.c) * (1 - k1.b) * (point_of(k2) - point_of(k1));
    const glm::dvec3 in = b / 2 * (1 - k2.t) * (1 - k2.c) * (1 + k2.b) * (point_of(k2) - point_of(k1)) +
                          b / 2 * (1 - k2.t) * (1 + k2.c) * (1 - k2.b) * (point_of(k3) - point_of(k2));
    // Evaluate the Hermite basis.
    return (2 * u * u * u - 3 * u * u + 1) * point_of(k1) + (u * u * u - 2 * u * u + u) * out +
           (3 * u * u - 2 * u * u * u) * point_of(k2) + (u * u * u - u * u) * in;
}

void expect_near(const glm::dvec3& value, const glm::dvec3& expected, double tolerance, const std::string& what)
{
    for (int c = 0; c < 3; ++c) ASSERT_NEAR(value[c], expected[c], tolerance) << what << ", coordinate " << c;
}

// Checks that the track is constant between two times outside its changing intervals.
void check_announcements(const scene::TransformTrack& track, double first, double last, int steps)
{
    const std::vector<scene::Interval> changing = track.changing();
    for (std::size_t i = 0; i < changing.size(); ++i) {
        EXPECT_LE(changing[i].first, changing[i].last);
        EXPECT_TRUE(i == 0 || changing[i - 1].last < changing[i].first);
    }
    const auto may_change = [&](double a, double b) {
        return std::any_of(changing.begin(), changing.end(),
                           [&](const scene::Interval& x) { return x.first <= b && x.last > a; });
    };
    double before = first;
    for (int i = 1; i <= steps; ++i) {
        const double now = first + (last - first) * i / steps;
        ASSERT_TRUE(may_change(before, now) || track.evaluate(before) == track.evaluate(now))
            << before << " to " << now;
        before = now;
    }
}

TEST(AffTrack, PositionsFollowTheFormula)
{
    Random random(7);
    for (int round = 0; round < 40; ++round) {
        std::vector<Key> keys;
        double time = -1;
        for (std::uint32_t i = 0, n = 4 + random.below(6); i < n; ++i) {
            // Some keys share their time, also in the middle.
            if (i > 0 && random.below(4) != 0) time += 0.25 * (1 + random.below(8));
            Key key{time, {random.uniform(-5, 5), random.uniform(-5, 5), random.uniform(-5, 5), 0}};
            if (random.below(2))
                key.t = random.uniform(-1, 1), key.c = random.uniform(-1, 1), key.b = random.uniform(-1, 1);
            keys.push_back(key);
        }
        const auto moved = track_of(text_of("transl", keys, 3));
        const auto scaled = track_of(text_of("scale", keys, 3));
        for (double t = -2; t < time + 1; t += 0.0625) {
            expect_near(glm::dvec3(moved->evaluate(t)[3]), slow_position(keys, t), 1e-9, "time " + std::to_string(t));
            const glm::dmat4 s = scaled->evaluate(t);
            expect_near({s[0][0], s[1][1], s[2][2]}, slow_position(keys, t), 1e-9, "scale, time " + std::to_string(t));
        }
        check_announcements(*moved, -2, time + 1, 64 * 8);
    }
}

TEST(AffTrack, FirstAndLastKeyOnlySetTangents)
{
    const std::vector<Key> keys{{0, {9, 0, 0, 0}}, {1, {1, 0, 0, 0}}, {2, {2, 0, 0, 0}}, {3, {9, 0, 0, 0}}};
    const auto track = track_of(text_of("transl", keys, 3));
    for (const double t : {-5.0, 0.0, 0.5, 1.0}) EXPECT_EQ(track->evaluate(t)[3].x, 1) << t;
    for (const double t : {2.0, 2.5, 9.0}) EXPECT_NEAR(track->evaluate(t)[3].x, 2, 1e-12) << t;
    const auto changing = track->changing();
    ASSERT_EQ(changing.size(), 1u);
    EXPECT_EQ(changing[0].first, 1);
    EXPECT_GE(changing[0].last, 2);
    EXPECT_LT(changing[0].last, 2.0001);
}

TEST(AffTrack, ChangingIntervalsIncludeJumpsAndExcludeRests)
{
    // Rest, jump at 2, rest; a jump right after the first time; a jump at the end.
    const auto at = [](double time, double x) { return Key{time, {x, 0, 0, 0}, 1, 0, 0}; };
    for (const std::vector<Key>& keys : {std::vector<Key>{at(0, 1), at(1, 1), at(2, 1), at(2, 5), at(3, 5), at(4, 5)},
                                         std::vector<Key>{at(0, 1), at(1, 1), at(1, 5), at(3, 5), at(4, 5)},
                                         std::vector<Key>{at(0, 1), at(1, 1), at(2, 1), at(2, 7), at(2, 7)}}) {
        const auto track = track_of(text_of("transl", keys, 3));
        check_announcements(*track, 0, 5, 5);
        check_announcements(*track, 0.5, 5.5, 10);
        check_announcements(*track, 0, 5, 500);
    }
    // The long rest is not part of a changing interval.
    const auto track = track_of(text_of("transl", {at(0, 1), at(1, 1), at(2, 1), at(2, 5), at(3, 5), at(4, 5)}, 3));
    for (const scene::Interval& interval : track->changing()) EXPECT_LT(interval.last - interval.first, 0.01);
}

TEST(AffTrack, AcceptsDecreasingKeyTimes)
{
    const std::vector<Key> keys{{0, {0, 0, 0, 0}},  {1, {1, 0, 0, 0}},  {48, {2, 0, 0, 0}},
                                {42, {3, 0, 0, 0}}, {50, {4, 0, 0, 0}}, {60, {5, 0, 0, 0}}};
    const auto track = track_of(text_of("transl", keys, 3));
    for (double t = 0; t < 61; t += 0.25)
        expect_near(glm::dvec3(track->evaluate(t)[3]), slow_position(keys, t), 1e-9, "time " + std::to_string(t));
    check_announcements(*track, 0, 61, 61 * 4);
}

// --- Rotations: the formulas again, as matrices of four numbers.

using Four = std::array<double, 4>;   // w x y z

Four times(const Four& p, const Four& q)
{
    return {
        p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3], p[0] * q[1] + p[1] * q[0] + p[2] * q[3] - p[3] * q[2],
        p[0] * q[2] - p[1] * q[3] + p[2] * q[0] + p[3] * q[1], p[0] * q[3] + p[1] * q[2] - p[2] * q[1] + p[3] * q[0]};
}
Four conjugate(const Four& q)
{
    return {q[0], -q[1], -q[2], -q[3]};
}
double dot(const Four& p, const Four& q)
{
    return p[0] * q[0] + p[1] * q[1] + p[2] * q[2] + p[3] * q[3];
}
Four sum(double a, const Four& p, double b, const Four& q)
{
    return {a * p[0] + b * q[0], a * p[1] + b * q[1], a * p[2] + b * q[2], a * p[3] + b * q[3]};
}
Four slow_log(const Four& q)
{
    double factor = 1;
    if (std::abs(q[0]) < 1 && std::abs(std::sin(std::acos(q[0]))) >= 1e-3)
        factor = std::acos(q[0]) / std::sin(std::acos(q[0]));
    return {0, q[1] * factor, q[2] * factor, q[3] * factor};
}
Four slow_exp(const Four& v)
{
    const double a = std::sqrt(v[1] * v[1] + v[2] * v[2] + v[3] * v[3]);
    const double factor = std::abs(std::sin(a)) >= 1e-3 ? std::sin(a) / a : 1;
    return {std::cos(a), v[1] * factor, v[2] * factor, v[3] * factor};
}
Four slow_slerp(double t, const Four& p, const Four& q)
{
    const double a = std::acos(std::min(1.0, std::max(-1.0, dot(p, q))));
    if (std::sin(a) < 1e-3) return p;
    return sum(std::sin((1 - t) * a) / std::sin(a), p, std::sin(t * a) / std::sin(a), q);
}

glm::dmat3 slow_rotation(const std::vector<Key>& keys, double time)
{
    std::vector<Four> q;
    for (const Key& key : keys) {
        const double h = key.value[3] * k_pi / 360;
        q.push_back({std::cos(h), std::sin(h) * key.value[0], std::sin(h) * key.value[1], std::sin(h) * key.value[2]});
    }
    const auto [i, u] = place(keys, time);
    for (std::size_t j = 0; j <= i; ++j)
        if (dot(q[j + 1], q[j + 2]) < 0) q[j + 2] = sum(-1, q[j + 2], 0, q[j + 2]);
    const Key &k0 = keys[i], &k1 = keys[i + 1], &k2 = keys[i + 2], &k3 = keys[i + 3];
    const double whole1 = k2.time - k0.time, whole2 = k3.time - k1.time;
    const double a = whole1 == 0 ? 0 : 2 * (k2.time - k1.time) / whole1;
    const double b = whole2 == 0 ? 0 : 2 * (k2.time - k1.time) / whole2;
    const Four l = slow_log(times(conjugate(q[i + 1]), q[i + 2]));
    const Four to = sum(a / 2 * (1 - k1.t) * (1 - k1.c) * (1 - k1.b), l, a / 2 * (1 - k1.t) * (1 + k1.c) * (1 + k1.b),
                        slow_log(times(conjugate(q[i]), q[i + 1])));
    const Four ti = sum(b / 2 * (1 - k2.t) * (1 - k2.c) * (1 + k2.b), l, b / 2 * (1 - k2.t) * (1 + k2.c) * (1 - k2.b),
                        slow_log(times(conjugate(q[i + 2]), q[i + 3])));
    const Four inner1 = times(q[i + 1], slow_exp(sum(0.5, to, -0.5, l)));
    const Four inner2 = times(q[i + 2], slow_exp(sum(0.5, l, -0.5, ti)));
    const Four r = slow_slerp(2 * u * (1 - u), slow_slerp(u, q[i + 1], q[i + 2]), slow_slerp(u, inner1, inner2));
    const glm::dvec3 v(r[1], r[2], r[3]);
    if (glm::length(v) == 0) return glm::dmat3(1);
    const double angle = 2 * std::acos(std::min(1.0, std::max(-1.0, r[0])));
    // Rodrigues' formula.
    const glm::dvec3 n = v / glm::length(v);
    const glm::dmat3 cross(0, n.z, -n.y, -n.z, 0, n.x, n.y, -n.x, 0);
    return glm::dmat3(1) + std::sin(angle) * cross + (1 - std::cos(angle)) * cross * cross;
}

void check_rotation(const std::vector<Key>& keys, double from, double to, double step)
{
    const auto track = track_of(text_of("rot", keys, 4));
    for (double t = from; t < to; t += step) {
        const glm::dmat4 m = track->evaluate(t);
        const glm::dmat3 expected = slow_rotation(keys, t);
        for (int c = 0; c < 3; ++c)
            for (int r = 0; r < 3; ++r) ASSERT_NEAR(m[c][r], expected[c][r], 1e-9) << "time " << t;
        ASSERT_NEAR(glm::determinant(glm::dmat3(m)), 1, 1e-9);
    }
    check_announcements(*track, from, to, 300);
}

TEST(AffTrack, RotationsFollowTheFormula)
{
    Random random(11);
    for (int round = 0; round < 40; ++round) {
        std::vector<Key> keys;
        double time = -1;
        for (std::uint32_t i = 0, n = 4 + random.below(6); i < n; ++i) {
            if (i > 0 && random.below(4) != 0) time += 0.25 * (1 + random.below(8));
            glm::dvec3 axis(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
            // Half of the axes have length 1, the others do not.
            axis = random.below(2) ? glm::normalize(axis) : 1.1 * axis;
            Key key{time, {axis.x, axis.y, axis.z, random.uniform(-400, 400)}};
            if (random.below(2))
                key.t = random.uniform(-1, 1), key.c = random.uniform(-1, 1), key.b = random.uniform(-1, 1);
            keys.push_back(key);
        }
        check_rotation(keys, -2, time + 1, 0.0625);
    }
}

TEST(AffTrack, RotationsContinueBeyondFullTurns)
{
    // Angles grow by 90 degrees beyond full turns, so that key quaternions change sign on the way.
    std::vector<Key> keys;
    for (int i = 0; i < 12; ++i) keys.push_back({double(i), {0, 0, 1, 90.0 * i}});
    check_rotation(keys, -1, 12, 0.03125);
    const auto track = track_of(text_of("rot", keys, 4));
    double before = 90;
    for (double t = 1.1; t < 10; t += 0.1) {
        const glm::dmat4 m = track->evaluate(t);
        double degrees = glm::degrees(std::atan2(m[0][1], m[0][0]));
        while (degrees < before - 180) degrees += 360;
        ASSERT_GT(degrees, before - 1e-9) << "the wheel turns backwards at " << t;
        ASSERT_LT(degrees, before + 30);
        before = degrees;
    }
    EXPECT_NEAR(before, 890, 15);
}

TEST(AffTrack, AxesAreNotNormalised)
{
    const auto angle_at_key = [](double length) {
        std::vector<Key> keys;
        for (int i = 0; i < 4; ++i) keys.push_back({double(i), {0, 0, length, 60}});
        const glm::dmat4 m = track_of(text_of("rot", keys, 4))->evaluate(0);
        return glm::degrees(std::atan2(m[0][1], m[0][0]));
    };
    // The angle is read from the real part alone.
    EXPECT_NEAR(angle_at_key(1), 60, 1e-9);
    EXPECT_NEAR(angle_at_key(0.9), 60, 1e-9);

    // Between keys it matters, because the real parts of the blended quaternions differ from those of unit quaternions.
    std::vector<Key> keys;
    for (int i = 0; i < 4; ++i) keys.push_back({double(i), {0, 0.9, 0, 40.0 * i}});
    const glm::dmat4 m = track_of(text_of("rot", keys, 4))->evaluate(1.5);
    EXPECT_GT(std::abs(glm::degrees(std::atan2(-m[0][2], m[0][0])) - 60), 0.5);
}

TEST(AffTrack, RealPartsBeyondOneAreClamped)
{
    // A long axis gives quaternions whose blend has a real part beyond 1.
    const std::vector<Key> keys{{0, {0, 3, 0, 5}}, {1, {0, 3, 0, 5}}, {2, {0, 3, 0, -5}}, {3, {0, 3, 0, -5}}};
    const auto track = track_of(text_of("rot", keys, 4));
    for (double t = 0; t <= 3; t += 0.01) {
        const glm::dmat4 m = track->evaluate(t);
        for (int c = 0; c < 4; ++c)
            for (int r = 0; r < 4; ++r) ASSERT_TRUE(std::isfinite(m[c][r])) << t;
    }
}

TEST(AffTrack, AppliesScaleFirst)
{
    const std::string keys =
        text_of("transl", {{0, {10, 0, 0, 0}}, {1, {10, 0, 0, 0}}, {2, {10, 0, 0, 0}}, {3, {10, 0, 0, 0}}}, 3) +
        text_of("rot", {{0, {0, 0, 1, 90}}, {1, {0, 0, 1, 90}}, {2, {0, 0, 1, 90}}, {3, {0, 0, 1, 90}}}, 4) +
        text_of("scale", {{0, {2, 3, 4, 0}}, {1, {2, 3, 4, 0}}, {2, {2, 3, 4, 0}}, {3, {2, 3, 4, 0}}}, 3);
    const auto track = track_of(keys);
    const glm::dmat4 m = track->evaluate(1.5);
    expect_near(transform_point(m, glm::dvec3(1, 0, 0)), {10, 2, 0}, 1e-12, "x");
    expect_near(transform_point(m, glm::dvec3(0, 1, 0)), {7, 0, 0}, 1e-12, "y");
    EXPECT_TRUE(track->changing().empty());
}

TEST(AffTrack, VisibilityIsAStepFunction)
{
    const AffFolder folder;
    const scene::Scene scene = folder.load(k_material + "x a {" + k_mesh + "} k a { visibility 3  1 0  2 1  2 0 }");
    const auto& track = scene.nodes[0].visibility;
    ASSERT_NE(track, nullptr);
    EXPECT_EQ(scene.nodes[0].transform, nullptr);
    EXPECT_TRUE(track->evaluate(0.5));
    EXPECT_FALSE(track->evaluate(1));
    EXPECT_FALSE(track->evaluate(1.9));
    EXPECT_FALSE(track->evaluate(2));   // of two at the same time the later one holds
}

}   // namespace
}   // namespace gnomon::io
