// SPDX-License-Identifier: Apache-2.0
#include "options/render_options.h"

#include <algorithm>
#include <string_view>
#include <utility>

#include "gnomon/error.h"
#include "gnomon/ranges.h"

namespace gnomon::options {

namespace {

// Reads "transparent", "environment", "#rgb", "#rrggbb" or a name.
void read_background(const std::string& text, RenderOptions& options)
{
    options.background = BackgroundKind::environment;
    if (text == "environment") return;
    options.background = BackgroundKind::transparent;
    if (text == "transparent") return;
    options.background = BackgroundKind::color;
    constexpr std::pair<std::string_view, std::string_view> k_names[] = {
        {"black", "000"}, {"white", "fff"},    {"grey", "808080"}, {"gray", "808080"},
        {"red", "f00"},   {"green", "008000"}, {"blue", "00f"}};
    std::string digits = text.starts_with('#') ? text.substr(1) : std::string();
    for (const auto& [name, value] : k_names)
        if (text == name) digits = value;
    const bool hex = digits.find_first_not_of("0123456789abcdefABCDEF") == std::string::npos;
    if (!hex || (digits.size() != 3 && digits.size() != 6))
        throw UsageError(
            "--background: expected transparent, environment, #rgb, #rrggbb, black, white, grey, red, green "
            "or blue");
    const std::size_t width = digits.size() / 3;
    for (std::size_t c = 0; c < 3; ++c) {
        const int value = std::stoi(digits.substr(c * width, width), nullptr, 16);
        options.background_color[c] = static_cast<float>(value) / (width == 1 ? 15.0f : 255.0f);
    }
}

// Reads an f-number, or a diameter that ends in mm.
void read_aperture(const std::string& text, RenderOptions& options)
{
    const bool is_length = text.ends_with("mm");
    std::string number = is_length ? text.substr(0, text.size() - 2) : text;
    if (!is_length && number.starts_with("f/")) number.erase(0, 2);
    const std::optional<double> value = parse_number(number);
    const Range range = is_length ? ranges::aperture : ranges::f_number;
    if (!value || !range.contains(*value))
        throw UsageError("--aperture: expected an f-number such as 2.8, or a diameter such as 12mm");
    (is_length ? options.aperture : options.f_number) = *value;
}

}   // namespace

std::optional<bool> read_ground(const OptionValues& values)
{
    if (!values.given("ground")) return {};
    const std::string text = values.text("ground");
    if (text != "on" && text != "off") throw UsageError("--ground: expected on or off");
    return text == "on";
}

RenderOptions read_render_options(const OptionValues& values)
{
    RenderOptions options;
    options.renderer = values.choice<RenderMethod>("renderer");
    options.shadow_textures = values.choice<ShadowTextures>("shadow-textures");
    options.shadow_filter = values.integer("shadow-filter");
    if (values.given("size")) options.size = *parse_size(values.text("size"));
    options.camera = values.text("camera");
    if (values.given("turntable")) options.turntable_seconds = values.number("turntable");
    options.max_depth = values.integer("max-depth");
    options.shadow_culling = values.choice<ShadowCulling>("shadow-culling");
    options.sun_size = values.number("sun-size");
    options.indirect = values.choice<Indirect>("indirect");
    // A reference without a bounce is direct light alone, and so is the image without indirect light.
    options.bounces = std::max(values.integer("bounces"), static_cast<int>(ranges::bounces.low));
    if (values.integer("bounces") == 0 && options.indirect == Indirect::visible) options.indirect = Indirect::off;
    options.indirect_memory = values.integer("indirect-memory");
    options.indirect_on = values.choice<IndirectOn>("indirect-on");
    options.rsm_samples = values.integer("rsm-samples");
    options.indirect_level = values.integer("indirect-level");
    options.depth_threshold = values.number("depth-threshold");
    options.normal_threshold = values.number("normal-threshold");
    options.validity_margin = values.number("validity-margin");
    options.separate_trees = values.flag("separate-trees");
    options.cluster_shadows = values.flag("cluster-shadows");
    options.indirect_at_every_pixel = values.text("receivers") == "full";
    options.accelerator = values.choice<Accelerator>("accelerator");
    options.arithmetic = values.choice<Arithmetic>("isa");
    if (values.given("overlay")) options.overlay = values.choice<Overlay>("overlay");
    if (values.given("overlay-light")) {
        if (options.overlay != Overlay::shadow_states)
            throw UsageError("--overlay-light needs --overlay shadow-states");
        options.overlay_light = values.integer("overlay-light");
    }
    options.samples = values.text("samples") == "auto" ? k_adaptive_samples : values.integer("samples");
    options.filter = values.choice<PixelFilter>("filter");
    options.shutter = values.number("shutter");
    if (values.given("aperture")) read_aperture(values.text("aperture"), options);
    if (values.given("focus") && !values.given("aperture")) throw UsageError("--focus needs --aperture");
    if (values.given("focus") && values.text("focus") != "auto") options.focus = values.number("focus");
    if (!values.text("exposure").starts_with("auto")) options.exposure = values.number("exposure");
    options.tonemap = values.choice<ToneMap>("tonemap");
    read_background(values.text("background"), options);
    options.memory = values.integer("memory");
    options.threads = values.integer("threads");
    return options;
}

}   // namespace gnomon::options
