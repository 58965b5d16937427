// SPDX-License-Identifier: Apache-2.0
#pragma once
// The outline of an object in an image: the borders between the pixels that show it and those that do not.

#include <cstdint>
#include <vector>

#include "base/math.h"
#include "gnomon/frame.h"

namespace gnomon::viewer {

/// A level or upright border, from one corner of a pixel to another, in pixels from the image's upper left corner.
struct OutlineEdge {
    glm::ivec2 from{0}, to{0};
    friend bool operator==(const OutlineEdge&, const OutlineEdge&) = default;
};

/// The borders of what the layer "id" shows of an object, level ones first. Borders in one line are one edge. The image
/// ends beside the pixels of its rim, so that an object which is cut off there is outlined there, too.
/// @param object  as the layer has it; 0: none, without an outline
std::vector<OutlineEdge> outline_of(const Layer& ids, std::uint32_t object);

}   // namespace gnomon::viewer
