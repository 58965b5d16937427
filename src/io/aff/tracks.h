// SPDX-License-Identifier: Apache-2.0
#pragma once
// The `k` statement of AFF [BART AFF]: key frames of an animated transform, a light or the camera.
//
//   k name { transl n ...  scale n ...  rot n ...  visibility n ... }     each at most once, in any order

#include <memory>

#include "io/aff/tokens.h"
#include "scene/kochanek_track.h"

namespace gnomon::io {

/// The tracks of one name; null for each kind without keys.
struct AffTracks {
    std::shared_ptr<const scene::KochanekTrack> transform;
    std::shared_ptr<const scene::VisibilityTrack> visibility;
};

/// Reads from the opening brace to the closing one.
/// @throws InputError
AffTracks read_aff_tracks(AffTokens& tokens);

}   // namespace gnomon::io
