// SPDX-License-Identifier: Apache-2.0
#include "options/render_options.h"

#include "gnomon/error.h"

namespace gnomon::options {

namespace {

ToneMap tonemap_of(const std::string& name)
{
    if (name == "none") return ToneMap::none;
    if (name == "agx") return ToneMap::agx;
    return name == "aces" ? ToneMap::aces : ToneMap::neutral;
}

ShadowCulling culling_of(const std::string& name)
{
    if (name == "off") return ShadowCulling::off;
    return name == "paper" ? ShadowCulling::paper : ShadowCulling::certified;
}

ShadowTextures shadow_textures_of(const std::string& name)
{
    if (name == "per-caster") return ShadowTextures::per_caster;
    return name == "depth" ? ShadowTextures::depth : ShadowTextures::coherent;
}

Indirect indirect_of(const std::string& name)
{
    if (name == "off") return Indirect::off;
    if (name == "rsm") return Indirect::rsm;
    return name == "quadtree" ? Indirect::quadtree : Indirect::visible;
}

Overlay overlay_of(const std::string& name)
{
    if (name == "redrawn") return Overlay::redrawn;
    return name == "clusters" ? Overlay::clusters : Overlay::shadow_states;
}

}   // namespace

RenderOptions read_render_options(const OptionValues& values)
{
    RenderOptions options;
    if (values.text("renderer") == "raster") options.renderer = RenderMethod::raster;
    options.shadow_textures = shadow_textures_of(values.text("shadow-textures"));
    options.shadow_filter = values.integer("shadow-filter");
    if (values.given("size")) options.size = *parse_size(values.text("size"));
    options.camera = values.text("camera");
    if (values.given("turntable")) options.turntable_seconds = values.number("turntable");
    options.max_depth = values.integer("max-depth");
    options.shadow_culling = culling_of(values.text("shadow-culling"));
    options.indirect = indirect_of(values.text("indirect"));
    options.indirect_memory = values.integer("indirect-memory");
    if (const std::string on = values.text("indirect-on"); on != "auto")
        options.indirect_on = on == "cpu" ? IndirectOn::cpu : IndirectOn::vulkan;
    options.rsm_samples = values.integer("rsm-samples");
    options.indirect_level = values.integer("indirect-level");
    options.depth_threshold = values.number("depth-threshold");
    options.normal_threshold = values.number("normal-threshold");
    options.indirect_at_every_pixel = values.text("receivers") == "full";
    if (values.text("accelerator") == "kdtree") options.accelerator = Accelerator::kdtree;
    if (values.given("overlay")) options.overlay = overlay_of(values.text("overlay"));
    if (values.given("overlay-light")) {
        if (options.overlay != Overlay::shadow_states)
            throw UsageError("--overlay-light needs --overlay shadow-states");
        options.overlay_light = values.integer("overlay-light");
    }
    options.samples = values.integer("samples");
    if (values.text("exposure") != "auto") options.exposure = values.number("exposure");
    options.tonemap = tonemap_of(values.text("tonemap"));
    options.threads = values.integer("threads");
    return options;
}

}   // namespace gnomon::options
