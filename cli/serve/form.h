// SPDX-License-Identifier: Apache-2.0
#pragma once
// The fields of a request for rendering, as Drake's glTF Render Client-Server API names them.

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "gnomon/scene_parts.h"

namespace gnomon::cli {

enum class ServedImage : std::uint8_t { color, depth, label };

struct RenderForm {
    ServedImage image = ServedImage::color;
    Size size;
    Intrinsics lens;                       // pixels; (0, 0) is the upper left corner of the image
    double near = 0, far = 0;              // metres along the axis: nothing else is shown
    double min_depth = 0, max_depth = 0;   // metres; of ServedImage::depth
};

/// Reads and checks the fields.
/// @param field    the value of a field; none if the request lacks it
/// @param largest  size of images
/// @throws UsageError  a field is missing, is no number or is out of range
RenderForm read_form(const std::function<std::optional<std::string>(const char* name)>& field, Size largest);

}   // namespace gnomon::cli
