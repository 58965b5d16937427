// SPDX-License-Identifier: Apache-2.0
#pragma once
// What moves while a frame's shutter is open, and where its lens is sharp.

#include <algorithm>
#include <functional>
#include <optional>

#include "frame/host_values.h"
#include "gnomon/renderer.h"
#include "ray/ray_scene.h"
#include "scene/view.h"
#include "trace/blur.h"

namespace gnomon::frame {

/// When a frame's shutter is open. Its middle is the frame's time.
struct Shutter {
    static constexpr double k_middle = 0.5;   // fraction of the opening at which the image without blur is

    double open = 0, close = 0;   // seconds; equal: nothing moves
    double middle = 0;            // as the frame has it
    /// What moves stands still before and after.
    double first = -k_infinity, last = k_infinity;
    /// The frame's view at a fraction of the opening, at which the state is.
    std::function<scene::View(const scene::SceneState&, double fraction)> view_at{};
    const HostValues* host = nullptr;   // of the frame

    /// The fraction of the middle of one of several parts of equal length.
    static double fraction(int part, int parts) { return (part + 0.5) / parts; }
    /// The time at a fraction of the opening.
    double at(double fraction) const { return std::clamp(open + (close - open) * fraction, first, last); }
};

/// Where a view's rays through a grid of places in the image end: points of the scene, and the depths of those in the
/// middle third of the image.
struct SeenPlaces {
    std::vector<glm::dvec3> points;
    std::vector<float> middle_depths;   // ascending; infinite where a ray left the scene
};
SeenPlaces see_places(const ray::RayScene& rays, const scene::View& view);

/// Finds what moves, from the poses of a second state that is made from the base scene of the first. Objects move
/// evenly between 9 times; what they do between two of these is not seen.
trace::BlurMotion find_motion(const scene::SceneState& state, const scene::View& view, const Shutter& shutter,
                              const SeenPlaces& places);

/// The lens of a view, from the options.
scene::Lens find_lens(const scene::View& view, const RenderOptions& options, const SeenPlaces& places);

}   // namespace gnomon::frame
