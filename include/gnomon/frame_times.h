// SPDX-License-Identifier: Apache-2.0
#pragma once
// Where a frame's time went.

#include <array>
#include <cstddef>

namespace gnomon {

/// Milliseconds of a traced frame by stage. What several threads do at once counts as if they shared it evenly, so the
/// sum is the frame's time less what threads waited for each other. All zero for a rasterised frame.
struct FrameTimes {
    enum Stage {
        scene,               // what moved, and the trees of rays
        light_maps,          // what lights see, and what changed there
        rays,                // camera rays, mirrored and refracted ones
        surfaces,            // what they hit, and its shading
        shadows,             // which lights reach it
        indirect,            // light of one bounce at what is seen
        indirect_mirrored,   // the same at what is seen in mirrors and through glass
        proofs,              // of shadows, for the frames to come
        image,               // exposure, layers
        k_stages
    };
    static constexpr std::array<const char*, k_stages> k_names{
        "scene", "light_maps", "rays", "surfaces", "shadows", "indirect", "indirect_mirrored", "proofs", "picture"};
    std::array<double, k_stages> ms{};
};

}   // namespace gnomon
