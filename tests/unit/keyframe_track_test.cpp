// SPDX-License-Identifier: Apache-2.0
#include "scene/keyframe_track.h"

#include <gtest/gtest.h>

#include "base/bits.h"

namespace gnomon::scene {
namespace {

using Vectors = KeyChannel<glm::dvec3>;
using Rotations = KeyChannel<glm::dquat>;

KeyframeTrack moving(KeyInterpolation interpolation, std::vector<double> times, std::vector<glm::dvec3> values)
{
    return KeyframeTrack({}, Vectors{interpolation, std::move(times), std::move(values)}, std::nullopt, std::nullopt);
}

glm::dquat about_z(double degrees)
{
    return glm::angleAxis(glm::radians(degrees), glm::dvec3(0, 0, 1));
}

TEST(KeyframeTrack, IsLinearBetweenKeysAndConstantOutside)
{
    const auto track = moving(KeyInterpolation::linear, {1, 2, 4}, {{0, 0, 0}, {1, 0, 0}, {1, 4, 0}});
    EXPECT_EQ(track.parts(0).translation, glm::dvec3(0, 0, 0));
    EXPECT_EQ(track.parts(1.25).translation, glm::dvec3(0.25, 0, 0));
    EXPECT_EQ(track.parts(2).translation, glm::dvec3(1, 0, 0));
    EXPECT_EQ(track.parts(3).translation, glm::dvec3(1, 2, 0));
    EXPECT_EQ(track.parts(9).translation, glm::dvec3(1, 4, 0));
}

TEST(KeyframeTrack, StepHoldsEachValueFromItsKeyOn)
{
    const auto track = moving(KeyInterpolation::step, {0, 1, 2}, {{0, 0, 0}, {5, 0, 0}, {5, 0, 0}});
    EXPECT_EQ(track.parts(0.999).translation.x, 0);
    EXPECT_EQ(track.parts(1).translation.x, 5);
    const auto changing = track.changing();
    ASSERT_EQ(changing.size(), 1u);
    EXPECT_EQ(changing[0].first, 1);
    EXPECT_EQ(changing[0].last, 1);
}

TEST(KeyframeTrack, CubicSplinePassesKeysWithTheirTangents)
{
    // in-tangent, value, out-tangent: with these it is x = t^3 on 0 to 2.
    const auto track = moving(KeyInterpolation::cubic_spline, {0, 2},
                              {{9, 9, 9}, {0, 0, 0}, {0, 0, 0}, {12, 0, 0}, {8, 0, 0}, {9, 9, 9}});
    for (const double t : {0.0, 0.5, 1.0, 1.7, 2.0}) EXPECT_NEAR(track.parts(t).translation.x, t * t * t, 1e-12) << t;
    EXPECT_EQ(track.parts(3).translation.x, 8);
    // Neither tangent is 0, and the span is not 1: x = t^3 - 2 t on 1 to 4.
    const auto both = moving(KeyInterpolation::cubic_spline, {1, 4},
                             {{9, 9, 9}, {-1, 0, 0}, {1, 0, 0}, {46, 0, 0}, {56, 0, 0}, {9, 9, 9}});
    for (const double t : {1.0, 1.5, 2.0, 3.7, 4.0})
        EXPECT_NEAR(both.parts(t).translation.x, t * t * t - 2 * t, 1e-12) << t;
}

TEST(KeyframeTrack, RotationsTakeTheShorterPathAtConstantSpeed)
{
    // 350 degrees as a quaternion with the other sign: the path is 20 degrees, not 340.
    const KeyframeTrack track({}, std::nullopt,
                              Rotations{KeyInterpolation::linear, {0, 1}, {about_z(10), -about_z(-10)}}, std::nullopt);
    for (const double u : {0.0, 0.25, 0.5, 1.0}) {
        const glm::dvec3 x = glm::dvec3(track.evaluate(u)[0]);
        EXPECT_NEAR(std::atan2(x.y, x.x), glm::radians(10 - 20 * u), 1e-12) << u;
    }
    EXPECT_NEAR(glm::length(track.parts(0.3).rotation), 1, 1e-14);
}

TEST(KeyframeTrack, SplineOfRotationsStaysARotation)
{
    const glm::dquat zero(0, 0, 0, 0);
    const KeyframeTrack track(
        {}, std::nullopt,
        Rotations{KeyInterpolation::cubic_spline, {0, 1}, {zero, about_z(0), zero, zero, about_z(90), zero}},
        std::nullopt);
    const glm::dmat4 m = track.evaluate(0.5);
    EXPECT_NEAR(glm::determinant(m), 1, 1e-12);
    EXPECT_NEAR(std::atan2(m[0].y, m[0].x), glm::radians(45.0), 1e-12);
}

TEST(KeyframeTrack, ChangingIntervalsExcludeRests)
{
    const auto track = moving(KeyInterpolation::linear, {0, 1, 2, 3, 4, 5},
                              {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {2, 0, 0}, {2, 0, 0}, {3, 0, 0}});
    const auto changing = track.changing();
    ASSERT_EQ(changing.size(), 2u);
    EXPECT_EQ(changing[0].first, 0);
    EXPECT_EQ(changing[0].last, 2);
    EXPECT_EQ(changing[1].first, 4);
    EXPECT_EQ(changing[1].last, 5);
}

TEST(KeyframeTrack, ValueIsConstantOutsideChangingIntervals)
{
    const glm::dquat turned = about_z(33.3);
    const KeyframeTrack track(
        {}, Vectors{KeyInterpolation::linear, {0, 1, 2}, {{0.1, 0.2, 0.3}, {0.7, 0.1, 1e9}, {0.7, 0.1, 1e9}}},
        Rotations{KeyInterpolation::linear, {0, 1, 2}, {about_z(1), turned, turned}},
        Vectors{KeyInterpolation::cubic_spline,
                {1, 2},
                {{0, 0, 0}, {1.1, 1.2, 1.3}, {0, 0, 0}, {0, 0, 0}, {1.1, 1.2, 1.3}, {0, 0, 0}}});
    const auto changing = track.changing();
    ASSERT_EQ(changing.size(), 1u);
    EXPECT_EQ(changing[0].last, 1);
    const glm::dmat4 at_end = track.evaluate(1);
    for (const double t : {1.1, 1.333, 1.5, 1.99, 2.0, 7.0}) {
        const glm::dmat4 m = track.evaluate(t);
        EXPECT_TRUE(same_bits(m, at_end)) << t;
    }
}

TEST(KeyframeTrack, PartsWithoutKeysKeepTheirRestPose)
{
    TransformParts rest;
    rest.scale = {2, 3, 4};
    const KeyframeTrack track(rest, Vectors{KeyInterpolation::linear, {0}, {{1, 2, 3}}}, std::nullopt, std::nullopt);
    EXPECT_EQ(track.evaluate(5), glm::dmat4(2, 0, 0, 0, 0, 3, 0, 0, 0, 0, 4, 0, 1, 2, 3, 1));
    EXPECT_TRUE(track.changing().empty());
}

TEST(KeyframeWeights, InterpolatesLinearAndSpline)
{
    const KeyframeWeights linear(KeyInterpolation::linear, {0, 1, 2}, {0, 1, 1, 0, 1, 0}, 2);
    std::vector<float> w;
    linear.evaluate(0.25, w);
    EXPECT_EQ(w, (std::vector<float>{0.25f, 0.75f}));
    ASSERT_EQ(linear.changing().size(), 1u);
    EXPECT_EQ(linear.changing()[0].last, 1);
    // Two keys of two targets: in-tangents, values, out-tangents of each. The first target is t^3 on 0 to 1.
    const KeyframeWeights spline(KeyInterpolation::cubic_spline, {0, 1}, {0, 0, 0, 5, 0, 0, 3, 0, 1, 5, 0, 0}, 2);
    spline.evaluate(0.5, w);
    EXPECT_NEAR(w[0], 0.125f, 1e-7);
    EXPECT_EQ(w[1], 5.0f);
    // One target, t^3 - 2 t on 1 to 4.
    const KeyframeWeights both(KeyInterpolation::cubic_spline, {1, 4}, {9, -1, 1, 46, 56, 9}, 1);
    both.evaluate(2, w);
    EXPECT_NEAR(w[0], 4, 1e-6);
}

}   // namespace
}   // namespace gnomon::scene
