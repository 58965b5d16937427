// SPDX-License-Identifier: Apache-2.0
#include "viewer/settings.h"

#include "gnomon/error.h"
#include "options/render_options.h"

namespace gnomon::viewer {

namespace {

// The options of a frame; throws if the overlay of redrawn areas has no light views to show.
RenderOptions shown_options(const options::OptionValues& values)
{
    RenderOptions options = options::read_render_options(values);
    if (options.overlay == Overlay::redrawn) check_options(options);
    return options;
}

}   // namespace

std::string ViewSettings::set(const options::Option& option, const std::string& text)
{
    try {
        options::OptionValues changed = values_;
        if (text.empty())
            changed.unset(option);
        else
            changed.set(option, {text});
        shown_options(changed);
        values_ = std::move(changed);
        return {};
    } catch (const UsageError& error) {
        return error.what();
    }
}

RenderOptions ViewSettings::motion_options() const
{
    RenderOptions options = shown_options(values_);
    options.shutter = options.f_number = options.aperture = 0;
    options.focus.reset();
    return options;
}

RenderOptions ViewSettings::render_options() const
{
    RenderOptions options = shown_options(values_);
    if (blurs(options) && !values_.given("samples")) options.samples = k_adaptive_samples;
    return options;
}

bool blurs(const RenderOptions& options)
{
    const bool asked = options.shutter > 0 || options.f_number > 0 || options.aperture > 0;
    return asked && options.overlay == Overlay::none && options.shadow_culling != ShadowCulling::paper;
}

SceneRecipe ViewSettings::recipe(const std::string& scene) const
{
    SceneRecipe recipe;
    recipe.what = scene;
    if (values_.given("fps")) recipe.fps = values_.number("fps");
    if (values_.given("lights")) recipe.lights = values_.integer("lights");
    if (values_.given("light")) recipe.light_specs = values_.all("light");
    if (values_.given("environment")) recipe.environment = values_.text("environment");
    recipe.ground = options::read_ground(values_);
    recipe.strict = values_.flag("strict");
    if (const int memory = values_.integer("memory"); memory > 0) recipe.memory = memory;
    if (values_.given("animation")) recipe.animation = values_.text("animation");
    if (values_.given("variant")) recipe.variant = values_.text("variant");
    return recipe;
}

}   // namespace gnomon::viewer
