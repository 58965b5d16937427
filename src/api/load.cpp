// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "api/scene_access.h"
#include "base/interruption.h"
#include "base/one_line.h"
#include "gnomon/error.h"
#include "gnomon/scene.h"
#include "io/load.h"
#include "scene/builtin/builtin.h"
#include "scene/defaults/default_view.h"
#include "scene/defaults/emissive_lights.h"
#include "scene/defaults/surroundings.h"
#include "scene/near_origin.h"

namespace gnomon {

namespace {

io::ReadOptions read_options(const LoadOptions& options)
{
    if (options.memory < 1) throw UsageError(fmt::format("{} MB for a scene: expected at least 1", options.memory));
    return {options.strict, options.animation, options.variant, static_cast<std::uint64_t>(options.memory) << 20};
}

}   // namespace

Scene load(const std::string& what, const LoadOptions& options)
{
    Interruption interruption(options.progress);
    const InterruptionScope scope(&interruption);
    report_progress("loading", 0);
    constexpr std::string_view builtin = "builtin:";
    const bool is_builtin = what.starts_with(builtin);
    scene::Scene loaded = is_builtin ? scene::make_builtin(std::string_view(what).substr(builtin.size()))
                                     : io::load_scene(what, {}, read_options(options));
    if (loaded.clips.empty() && !options.animation.empty() && options.animation != "all")
        throw UsageError(fmt::format("no animation '{}': the scene has none", shown_name(options.animation)));
    if (loaded.variants.empty() && !options.variant.empty())
        throw UsageError(fmt::format("no variant '{}': the scene has none", shown_name(options.variant)));
    if (std::ranges::all_of(loaded.objects,
                            [&](const scene::Object& object) { return loaded.meshes[object.mesh].triangles.empty(); }))
        loaded.warnings.emplace_back("no surface in the scene: its images show the background alone");
    const glm::dvec3 origin = is_builtin ? glm::dvec3(0) : scene::bring_near(loaded);
    scene::add_emitter_lights(loaded);
    // Built-in scenes and AFF files are complete: what they leave dark is meant so.
    if (is_builtin || loaded.timeline.own_frames) {
        scene::add_default_light(loaded);
        scene::add_default_camera(loaded);
        if (options.ground.value_or(false)) scene::add_ground(loaded, scene::k_wanted_ground);
    } else {
        if (!options.strict) scene::judge_cameras(loaded);
        scene::Survey survey;
        scene::add_default_camera(loaded, survey);
        scene::SurroundingsOptions surroundings;
        surroundings.ground = options.ground;
        if (options.strict) surroundings.fill = 0;
        scene::add_surroundings(loaded, surroundings, survey);
    }
    interruption_point();
    api::SceneStamps stamps(loaded);
    stamps.origin = origin;
    return api::SceneAccess::make(std::make_shared<const scene::Scene>(std::move(loaded)), std::move(stamps));
}

}   // namespace gnomon
