// SPDX-License-Identifier: Apache-2.0
#pragma once
// Emissive polygons that lie in one plane and touch, put together: a disc of thin triangles is one light, not thirty.
//
// Cost: a look-up per corner. More than 4,096 faces are left as they are.

#include <vector>

#include "scene/sized_face.h"

namespace gnomon::scene {

/// Faces of one object that form a flat figure of one radiance, and a rectangle around it.
struct FlatFigure {
    std::vector<std::size_t> faces;   // indices, ascending
    SizedFace outline;                // three or four corners; of one face, the face itself
};

/// Divides faces into figures. A face is by itself if none touches it in its plane, if its emission varies over it, or
/// if the figure would fill too little of its rectangle.
/// @param faces  those that do not vary have their radiance
/// @return       in the order of their first faces
std::vector<FlatFigure> flat_figures(const std::vector<SourceFace>& faces);

}   // namespace gnomon::scene
