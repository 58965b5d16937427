// SPDX-License-Identifier: Apache-2.0
#pragma once
// The time that a frame took, by stage.

#include <array>
#include <cstddef>

namespace gnomon {

/// Milliseconds of a traced frame by stage. Time that several threads spend at once is divided evenly among them, so
/// the sum is the frame's time minus the time that threads waited for each other. All zero for a rasterised frame.
struct FrameTimes {
    /// The stages, in the order of `ms`.
    enum Stage {
        scene,               // changes of the scene, and updates of the ray-tracing acceleration structures
        light_maps,          // light maps and light trees
        rays,                // camera rays, reflected and refracted rays
        surfaces,            // hit points and their shading
        shadows,             // visibility of the lights
        indirect,            // one-bounce light at directly visible surfaces
        indirect_mirrored,   // the same at surfaces seen in mirrors and through glass
        proofs,              // certificates of visibility for later frames
        image,               // exposure, layers; where samples are added, and their filter
        k_stages
    };
    /// The names of the stages, as in the JSON of `gnomon render`.
    static constexpr std::array<const char*, k_stages> k_names{
        "scene", "light_maps", "rays", "surfaces", "shadows", "indirect", "indirect_mirrored", "proofs", "picture"};
    std::array<double, k_stages> ms{};
};

}   // namespace gnomon
