// SPDX-License-Identifier: Apache-2.0
#pragma once
// Light that bounces between patches: the radiosity equation, solved by Jacobi iteration [Goral et al. 1984].
//
// A sweep sends the light of the last one through all links and reflects it: one further bounce. The order of all sums
// is fixed, and nothing of earlier frames is used.
// Cost: 32 additions a patch and sweep.

#include "patches/patch_links.h"

namespace gnomon::patches {

struct BounceOptions {
    int sweeps = 64;       // at most: further bounces
    double stop = 1e-3;    // a sweep that adds less than this fraction of all light is the last,
    bool endless = true;   // and what all others would add is estimated from the last two
};

/// What is known of the patches: by patch.
struct PatchSurfaces {
    std::span<const glm::vec3> albedo;
    std::span<const float> area;   // times Patch::weight
};

/// The radiant flux of some radiant exitance, luminance. Surfaces that matter less count for less: of the light of a
/// ground that reaches to the horizon, bounces between what stands on it are a small part.
double total_flux(const PatchSurfaces& surfaces, std::span<const glm::vec3> exitance);

/// Radiant exitance by light that has bounced between patches at least once, by patch.
/// @param direct  radiant exitance without; may be a difference, and negative
/// @param all     the flux that BounceOptions::stop is a fraction of; 0: the direct light's and what has been added
/// @param blocked  links that bring nothing, or less
std::vector<glm::vec3> bounce(const PatchLinks& links, const PatchSurfaces& surfaces, std::span<const glm::vec3> direct,
                              double all, const BounceOptions& options, Tasks& tasks,
                              std::span<const BlockedLink> blocked = {});

}   // namespace gnomon::patches
