// SPDX-License-Identifier: Apache-2.0
#pragma once
// Where a camera stands that sees all of a clip: the nearest place, in a given direction, from which every vertex lies
// within the image at every time that is looked at.
//
// Cost: the vertices once, those of what moves once for each of `looks` times.

#include "scene/scene.h"

namespace gnomon::scene {

struct FramingOptions {
    glm::dvec3 back{0, 0, 1};   // unit, from the scene to the camera; not upright
    double vertical_fov = 0.7;
    double narrowest_aspect = 4.0 / 3.0;   // wider images show more at the sides
    double margin = 1.08;
    int looks = 17;   // times of the clip
    float widest_clip =
        2.5;   // things that go farther than so many diagonals of the first frame are framed there alone
};

struct Framed {
    glm::dvec3 eye{0};
    double size = 0;   // diagonal of all that is framed
};

/// A scene without a vertex is taken for a sphere of radius 1. Call after finish().
Framed frame_clip(const Scene& scene, const FramingOptions& options);

}   // namespace gnomon::scene
