// SPDX-License-Identifier: Apache-2.0
#pragma once
// Proves that a part of a surface gets no light from a planar light: one patch of connected static triangles lies
// between them.
//
// visibility/closed_patch.h has the proof; here, segments end at a light, and the patch must keep clear of it as well.
//
// Cost: some tenths of a microsecond for each triangle of the patch.

#include "area_light/area_shaft.h"
#include "visibility/closed_patch.h"

namespace gnomon::area_light {

/// The checks that the proof rests on, one by one, so that tests can leave one out and see the errors.
enum class DarkCheck : std::uint8_t {
    none,           // all are made
    no_open_edge,   // every edge in the shaft leads on
    clear_of_part,
    clear_of_light,
    crosses,   // the net number of crossings is not 0
    signs,     // crossings are counted with signs
};

struct DarkOptions {
    int most_triangles = 128;               // of a patch
    double clearance = 4;                   // least distance of the patch from the part and from the light, in lifts
    DarkCheck left_out = DarkCheck::none;   // for tests
};

/// @param occluder  an opaque static triangle that the segment crosses
/// @param from, to  a segment from the part, at the height of ray origins, to the light
bool proves_dark(const visibility::StaticTriangles& triangles, const AreaShaft& shaft, visibility::TriangleId occluder,
                 const glm::dvec3& from, const glm::dvec3& to, const DarkOptions& options = {});

}   // namespace gnomon::area_light
