// SPDX-License-Identifier: Apache-2.0
#include "io/aff/tracks.h"

#include <fmt/format.h>

#include <optional>

namespace gnomon::io {

namespace {

// The track runs between the inner two keys; one more is needed beyond each end.
constexpr std::size_t k_least_spline_keys = 4;

void read_shape(AffTokens& tokens, scene::KochanekKey& key)
{
    key.tension = tokens.number("a tension");
    key.continuity = tokens.number("a continuity");
    key.bias = tokens.number("a bias");
}

// Reads n, then n times (time, x y z, tension continuity bias).
scene::VectorSpline read_vector_spline(AffTokens& tokens)
{
    std::vector<scene::VectorKey> keys(tokens.count("the number of keys", k_least_spline_keys, 7));
    const AffToken first = tokens.peek();
    for (scene::VectorKey& key : keys) {
        key.time = tokens.number("a key time");
        for (int c = 0; c < 3; ++c) key.value[c] = tokens.number("a coordinate");
        read_shape(tokens, key);
    }
    scene::VectorSpline spline(keys);
    if (!(spline.reach() <= k_aff_largest_number)) tokens.fail(first, "the track exceeds the range of usable numbers");
    return spline;
}

// Reads n, then n times (time, axis, angle in degrees, tension continuity bias).
scene::RotationSpline read_rotation_spline(AffTokens& tokens)
{
    std::vector<scene::RotationKey> keys(tokens.count("the number of keys", k_least_spline_keys, 8));
    for (scene::RotationKey& key : keys) {
        key.time = tokens.number("a key time");
        const AffToken axis = tokens.peek();
        for (int c = 0; c < 3; ++c) key.axis[c] = tokens.number("a rotation axis");
        const double degrees = tokens.number("an angle");
        if (key.axis == glm::dvec3(0) && degrees != 0)
            tokens.fail(axis, "a rotation about an axis of length 0 by an angle other than 0");
        key.angle = glm::radians(degrees);
        read_shape(tokens, key);
    }
    return scene::RotationSpline(keys);
}

// Reads n, then n times (time, 0 or 1).
scene::VisibilityTrack read_visibility(AffTokens& tokens)
{
    const std::size_t n = tokens.count("the number of keys", 1, 2);
    scene::VisibilityTrack track;
    for (std::size_t i = 0; i < n; ++i) {
        const AffToken at = tokens.peek();
        const double time = tokens.number("a key time");
        if (!track.times.empty() && time < track.times.back())
            tokens.fail(at, "visibility keys must not go back in time");
        track.times.push_back(time);
        track.visible.push_back(tokens.integer("a visibility", 0, 1) == 1);
    }
    return track;
}

}   // namespace

AffTracks read_aff_tracks(AffTokens& tokens)
{
    const AffToken open = tokens.peek();
    tokens.expect("{");
    scene::KochanekTrack transform;
    AffTracks result;
    for (;;) {
        const AffToken kind = tokens.take();
        if (kind.text == "}") break;
        if (kind.text.empty()) tokens.fail(open, "'{' is never closed");
        bool second = false;
        if (kind.text == "transl") {
            second = transform.translation.has_value();
            transform.translation = read_vector_spline(tokens);
        } else if (kind.text == "scale") {
            second = transform.scale.has_value();
            transform.scale = read_vector_spline(tokens);
        } else if (kind.text == "rot") {
            second = transform.rotation.has_value();
            transform.rotation = read_rotation_spline(tokens);
        } else if (kind.text == "visibility") {
            second = result.visibility != nullptr;
            result.visibility = std::make_shared<scene::VisibilityTrack>(read_visibility(tokens));
        } else {
            tokens.fail(kind,
                        fmt::format("expected 'transl', 'scale', 'rot', 'visibility' or '}}', found {}", shown(kind)));
        }
        if (second) tokens.fail(kind, fmt::format("a second {} in one 'k'", shown(kind)));
    }
    if (transform.translation || transform.rotation || transform.scale)
        result.transform = std::make_shared<scene::KochanekTrack>(std::move(transform));
    return result;
}

}   // namespace gnomon::io
