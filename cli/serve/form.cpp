// SPDX-License-Identifier: Apache-2.0
#include "cli/serve/form.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>

#include "base/one_line.h"
#include "gnomon/error.h"

namespace gnomon::cli {

RenderForm read_form(const std::function<std::optional<std::string>(const char* name)>& field, Size largest)
{
    const auto text = [&](const char* name) {
        std::optional<std::string> value = field(name);
        if (!value) throw UsageError(fmt::format("the field {} is missing", name));
        return *value;
    };
    const auto number = [&](const char* name, double low, double high) {
        const std::string value = text(name);
        double parsed = 0;
        const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), parsed);
        if (error != std::errc() || end != value.data() + value.size() || !(parsed >= low && parsed <= high))
            throw UsageError(fmt::format("the field {} is '{}'; expected a number from {} to {}", name,
                                         shown_name(value), low, high));
        return parsed;
    };
    const auto side = [&](const char* name, int most) {
        const double value = number(name, 1, most);
        if (value != std::floor(value)) throw UsageError(fmt::format("the field {} must be a whole number", name));
        return static_cast<int>(value);
    };
    constexpr double k_far = 1e9, k_least = 1e-9;

    RenderForm form;
    const std::string image = text("image_type");
    if (image != "color" && image != "depth" && image != "label")
        throw UsageError(
            fmt::format("the field image_type is '{}'; expected color, depth or label", shown_name(image)));
    form.image = image == "color" ? ServedImage::color : image == "depth" ? ServedImage::depth : ServedImage::label;
    form.size = {side("width", largest.width), side("height", largest.height)};
    form.lens.fx = number("focal_x", k_least, k_far), form.lens.fy = number("focal_y", k_least, k_far);
    form.lens.cx = number("center_x", -k_far, k_far), form.lens.cy = number("center_y", -k_far, k_far);
    form.near = number("near", k_least, k_far), form.far = number("far", form.near, k_far);
    if (form.far <= form.near) throw UsageError("the field far must be more than near");
    if (form.image == ServedImage::depth) {
        form.min_depth = number("min_depth", 0, k_far);
        form.max_depth = number("max_depth", form.min_depth, k_far);
    }
    return form;
}

}   // namespace gnomon::cli
