// SPDX-License-Identifier: Apache-2.0
#pragma once
// The content of an OBJ file, statement by statement [Wavefront, Advanced Visualizer, appendix B1, polygonal part]:
// checked, but not yet triangulated. Memory is bounded by the size of the text, because every element takes at least
// two bytes of it.

#include <string>
#include <vector>

#include "base/math.h"
#include "gnomon/types.h"
#include "io/obj/text.h"

namespace gnomon::io {

inline constexpr std::uint32_t k_no_index = 0xffffffffu;

/// Indices from 0 into the file's positions, texture coordinates and normals.
struct ObjCorner {
    std::uint32_t position = k_no_index, texcoord = k_no_index, normal = k_no_index;
};

struct ObjFace {
    std::uint32_t first_corner = 0;
    std::uint32_t corner_count = 0;   // 3 or more
    std::uint32_t object = 0;
    std::uint32_t material = 0;
    std::uint32_t smoothing = 0;        // group; 0: off; k_unset: not given
    std::uint32_t color = k_no_index;   // in ObjData::face_colors; none: the positions have theirs
    static constexpr std::uint32_t k_unset = 0xffffffffu;
};

struct ObjData {
    std::vector<glm::vec3> positions;
    std::vector<glm::vec4> colors;        // linear RGBA, by position; empty: none
    std::vector<glm::vec4> face_colors;   // likewise
    std::vector<glm::vec2> texcoords;     // as in the file: v = 0 is the bottom row
    std::vector<glm::vec3> normals;       // as in the file: of any length, also zero
    std::vector<ObjCorner> corners;
    std::vector<ObjFace> faces;
    std::vector<std::string> objects;     // names; faces refer to them
    std::vector<std::string> materials;   // names in `usemtl`; the first is empty: no material set
    std::vector<std::string> libraries;   // names in `mtllib`, one entry per line
};

/// Positions beyond this are rejected: the square of a triangle's area must fit into a float.
inline constexpr float k_largest_coordinate = 1e9f;

/// @param strict    refuses normals and texture coordinates that are not finite instead of repairing them
/// @param warnings  one for each kind of statement that was ignored or repaired
/// @throws InputError, InterruptedError
ObjData parse_obj(ObjText& text, bool strict, std::vector<std::string>& warnings);

}   // namespace gnomon::io
