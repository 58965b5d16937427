// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <charconv>

#include "api/environment.h"
#include "api/scene_access.h"
#include "base/check.h"
#include "base/one_line.h"
#include "gnomon/scene.h"
#include "io/image/float_image.h"
#include "scene/builtin/studio.h"
#include "scene/environment.h"
#include "scene/near_origin.h"
#include "scene/scene.h"

namespace gnomon {

namespace {
constexpr double k_highest_fps = 1000;
constexpr double k_longest_clip = 1e6;        // frames
constexpr float k_widest_half_angle = 90;     // degrees
constexpr std::size_t k_longest_shown = 20;   // characters of what is no number

std::vector<std::string> words_of(const std::string& text)
{
    std::vector<std::string> words;
    for (std::size_t at = 0; (at = text.find_first_not_of(" \t,", at)) != std::string::npos;) {
        const std::size_t end = std::min(text.find_first_of(" \t,", at), text.size());
        words.push_back(text.substr(at, end - at));
        at = end;
    }
    return words;
}

// Parses "spot X Y Z DX DY DZ HALF_ANGLE_DEG R G B" or "point X Y Z R G B".
scene::Light light_of(const std::string& spec, glm::dvec3& position, glm::dvec3& direction)
{
    const auto refuse = [&](const std::string& why) {
        throw UsageError(
            fmt::format("light '{}': {}; expected \"spot X Y Z DX DY DZ HALF_ANGLE_DEG R G B\" or \"point X Y "
                        "Z R G B\"",
                        shown_name(spec), why));
    };
    const std::vector<std::string> words = words_of(spec);
    if (words.empty() || (words[0] != "spot" && words[0] != "point")) refuse("unknown kind");
    const bool spot = words[0] == "spot";
    const std::size_t expected = spot ? 10 : 6;
    if (words.size() != expected + 1) refuse(fmt::format("{} numbers instead of {}", words.size() - 1, expected));
    std::vector<double> v;
    for (std::size_t i = 1; i < words.size(); ++i) {
        double value = 0;
        const char* end = words[i].data() + words[i].size();
        const auto [stop, error] = std::from_chars(words[i].data(), end, value);
        if (error != std::errc() || stop != end || !std::isfinite(static_cast<float>(value)))
            refuse(words[i].size() <= k_longest_shown ? fmt::format("'{}' is no number", shown_name(words[i]))
                                                      : fmt::format("number {} is none", i));
        v.push_back(value);
    }

    scene::Light light;
    light.falloff = scene::Falloff::inverse_square;
    light.color = {v[expected - 3], v[expected - 2], v[expected - 1]};
    if (light.color.x < 0 || light.color.y < 0 || light.color.z < 0) refuse("negative colour");
    position = {v[0], v[1], v[2]};
    direction = {0, 0, -1};
    if (!spot) return light;
    light.type = scene::LightType::spot;
    light.profile = scene::SpotProfile::cosine;
    direction = {v[3], v[4], v[5]};
    if (!(glm::length(direction) > 0)) refuse("the direction has no length");
    direction = glm::normalize(direction);
    if (!(v[6] > 0 && v[6] <= k_widest_half_angle)) refuse("the half-angle must be above 0 and at most 90");
    light.outer_angle = static_cast<float>(v[6] * k_pi / 180);
    return light;
}

// A copy to be changed. Its parts keep their ids.
struct Changed {
    std::shared_ptr<scene::Scene> scene;
    api::SceneStamps stamps;

    explicit Changed(const Scene::Impl& impl) : scene(std::make_shared<scene::Scene>(*impl.scene)), stamps(impl.stamps)
    {
    }
    scene::Scene* operator->() const { return scene.get(); }
    Scene finished()
    {
        while (stamps.nodes.size() < scene->nodes.size()) stamps.nodes.renew(stamps.nodes.size());
        return api::SceneAccess::make(std::move(scene), std::move(stamps));
    }
};
}   // namespace

int Scene::frame_count() const
{
    return impl_->scene->timeline.frames;
}

double Scene::time_of(int frame) const
{
    return impl_->scene->timeline.time_of(frame);
}

double Scene::fps() const
{
    return impl_->scene->timeline.fps;
}

SceneInfo Scene::info() const
{
    const scene::Scene& scene = *impl_->scene;
    const scene::Statistics counts = scene.statistics();
    SceneInfo info;
    info.name = scene.name;
    info.triangles = counts.triangles, info.triangles_dynamic = counts.triangles_dynamic;
    info.objects = counts.objects, info.objects_dynamic = counts.objects_dynamic;
    info.meshes = scene.meshes.size(), info.materials = scene.materials.size(), info.textures = scene.textures.size();
    for (const scene::Light& light : scene.lights) info.lights.push_back(light.name);
    for (const scene::Camera& camera : scene.cameras) info.cameras.push_back(camera.name);
    info.frames = scene.timeline.frames;
    info.fps = scene.timeline.fps;
    info.start = scene.timeline.start, info.end = scene.timeline.end;
    const Box3 box = scene.bounds(scene.timeline.start);
    for (int axis = 0; axis < 3 && !box.empty(); ++axis) {
        info.bounds_low[axis] = static_cast<float>(box.low[axis] + impl_->stamps.origin[axis]);
        info.bounds_high[axis] = static_cast<float>(box.high[axis] + impl_->stamps.origin[axis]);
    }
    if (!scene.cameras.empty()) info.resolution = scene.cameras.front().resolution;
    for (const scene::Clip& clip : scene.clips)
        info.animations.push_back(
            {clip.name, clip.start, clip.end, scene::Timeline::frames_in(clip.end - clip.start, info.fps), clip.plays});
    info.variants = scene.variants;
    info.warnings = scene.warnings;
    return info;
}

Scene Scene::at_rate(double fps) const
{
    if (!(fps > 0 && fps <= k_highest_fps))
        throw UsageError(fmt::format("a rate of {} frames a second: expected above 0, at most {}", fps, k_highest_fps));
    const double seconds = impl_->scene->timeline.end - impl_->scene->timeline.start;
    if (!impl_->scene->timeline.own_frames && seconds * fps >= scene::k_most_frames)
        throw UsageError(fmt::format("a rate of {} frames a second: {} s of it are more than {} frames", fps, seconds,
                                     scene::k_most_frames));
    Changed changed(*impl_);
    changed->timeline = impl_->scene->timeline.at_rate(fps);
    return changed.finished();
}

Scene Scene::lasting(double seconds) const
{
    const double frames = std::round(seconds * fps());
    if (!(seconds > 0 && frames <= k_longest_clip))
        throw UsageError(fmt::format("a clip of {} s: expected above 0 s, at most {} frames", seconds, k_longest_clip));
    if (frame_count() > 1) return *this;
    Changed changed(*impl_);
    changed->timeline.frames = std::max(1, static_cast<int>(frames));
    changed->timeline.end = changed->timeline.start + (changed->timeline.frames - 1) / fps();
    return changed.finished();
}

Scene Scene::with_lights(int count) const
{
    if (count < 0) throw UsageError(fmt::format("{} lights: expected 0 or more", count));
    if (static_cast<std::size_t>(count) >= impl_->scene->lights.size()) return *this;
    Changed changed(*impl_);
    // Emissive surfaces keep the lights that approximate them.
    std::size_t kept = 0;
    for (std::size_t l = 0; l < changed->lights.size();) {
        const scene::Light& light = changed->lights[l];
        const bool of_studio = light.by_default && light.of_environment;
        if (light.of_surface || of_studio || kept++ < static_cast<std::size_t>(count)) {
            ++l;
            continue;
        }
        changed->lights.erase(changed->lights.begin() + static_cast<std::ptrdiff_t>(l));
        changed.stamps.lights.erase(l);
    }
    return changed.finished();
}

Scene Scene::with_light_specs(const std::vector<std::string>& specs) const
{
    Changed changed(*impl_);
    // Emissive surfaces keep the lights that approximate them, after the others.
    std::vector<scene::Light> kept = std::move(changed->lights);
    std::erase_if(kept, [](const scene::Light& light) { return !light.of_surface; });
    changed->lights.clear();
    api::forget_default_light(*changed.scene);
    for (const std::string& spec : specs) {
        glm::dvec3 position, direction;
        scene::Light light = light_of(spec, position, direction);
        light.name = fmt::format("light {}", changed->lights.size());
        light.node =
            api::add_root(*changed.scene, light.name, api::looking_matrix(position - changed.stamps.origin, direction));
        changed->lights.push_back(std::move(light));
    }
    changed->lights.insert(changed->lights.end(), kept.begin(), kept.end());
    changed.stamps.lights = api::StampList(changed->lights.size());
    return changed.finished();
}

Scene Scene::with_environment(const std::filesystem::path& file, int lights) const
{
    api::check_environment_lights(lights);
    auto environment = file == "builtin:studio"
                           ? scene::studio_environment()
                           : std::make_shared<const scene::Environment>(io::read_float_image(file));
    Changed changed(*impl_);
    api::set_environment(
        *changed.scene, changed.stamps, std::move(environment), lights,
        [&](const std::string& name, const glm::dmat4& local) { return api::add_root(*changed.scene, name, local); });
    return changed.finished();
}

}   // namespace gnomon
