// SPDX-License-Identifier: Apache-2.0
#pragma once
// Places a camera that sees all of a clip: at the nearest position, in a given direction, from which every vertex is in
// view at every sampled time.
//
// Cost: all vertices once, and the vertices of dynamic objects once for each sampled time.

#include <memory>
#include <vector>

#include "scene/camera_fit.h"
#include "scene/state.h"

namespace gnomon::scene {

struct FramingOptions {
    glm::dvec3 back{0, 0, 1};   // unit, from the scene to the camera; not upright
    double vertical_fov = 0.7;
    double margin = 1.12;
    int looks = 17;   // number of sampled times, at least
    // More of them, up to one for each frame of the clip, as long as they take no more vertices than this.
    std::size_t vertices = 4'000'000;
    float widest_clip =
        2.5;   // objects that travel farther than this many diagonals of the first frame are framed at its time only
    std::vector<char> left_out{};   // by object: 1 for those that need not be in view; empty: all are framed
};

struct Framed {
    std::shared_ptr<const CameraFit> fit;   // in the camera's axes
    glm::dmat3 axes{1};                     // right, up and back in the world
    double size = 0;                        // diagonal of everything framed
    Box3 box;                               // of everything framed

    glm::dvec3 eye(double aspect) const { return axes * fit->eye(aspect); }
};

/// The objects that need not be in view because they are the surroundings of the others: those that cast no shadow and
/// are far larger than the rest, like the dome of a sky, and flat floors that are several times as wide as what stands
/// on them. Empty if there are none.
std::vector<char> surrounding_objects(const SceneState& state);

/// All objects but the largest and those near it; empty if that leaves out none.
std::vector<char> all_but_largest_group(const SceneState& state);

/// Frames a scene without vertices like a sphere of radius 1. Call after finish().
Framed frame_clip(const Scene& scene, const FramingOptions& options);

/// The box and the size alone, of all that frame_clip() frames with default options.
Framed box_of_clip(const Scene& scene);

/// Right, up and back of a camera that looks along -back.
glm::dmat3 camera_axes(const glm::dvec3& back);

}   // namespace gnomon::scene
