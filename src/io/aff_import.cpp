// SPDX-License-Identifier: Apache-2.0
// AFF: files, transforms, tracks, camera. The statements that make geometry and materials are in aff_geometry.cpp.
#include "io/aff_import.h"

#include <fmt/format.h>

#include <algorithm>
#include <glm/gtc/matrix_transform.hpp>

#include "gnomon/error.h"
#include "io/load.h"
#include "io/read_file.h"

namespace gnomon::io {

namespace {

namespace fs = std::filesystem;

constexpr long long k_most_frames = 10'000'000;
constexpr long long k_most_pixels = 32768;

// The part of a track that an animated light uses.
class TranslationOnly : public scene::TransformTrack {
 public:
    explicit TranslationOnly(std::shared_ptr<const scene::KochanekTrack> track) : track_(std::move(track)) {}
    glm::dmat4 evaluate(double time) const override
    {
        glm::dmat4 m(1);
        if (!track_->translation.keys.empty()) m[3] = glm::dvec4(track_->translation.evaluate(time), 1);
        return m;
    }
    std::vector<scene::Interval> changing() const override
    {
        std::vector<scene::Interval> intervals;
        track_->translation.add_changes(intervals);
        return scene::merged(std::move(intervals));
    }

 private:
    std::shared_ptr<const scene::KochanekTrack> track_;
};

// The track `camera` replaces the view part by part: its translation is the eye, its rotation the direction.
class CameraTrack : public scene::TransformTrack {
 public:
    CameraTrack(std::shared_ptr<const scene::KochanekTrack> track, const glm::dmat4& view)
        : track_(std::move(track)), view_(view)
    {
    }
    glm::dmat4 evaluate(double time) const override
    {
        glm::dmat4 m = view_;
        if (!track_->rotation.empty()) {
            m = glm::dmat4(track_->rotation.evaluate(time));
            m[3] = view_[3];
        }
        if (!track_->translation.keys.empty()) m[3] = glm::dvec4(track_->translation.evaluate(time), 1);
        return m;
    }
    std::vector<scene::Interval> changing() const override
    {
        std::vector<scene::Interval> intervals;
        track_->translation.add_changes(intervals);
        track_->rotation.add_changes(intervals);
        return scene::merged(std::move(intervals));
    }

 private:
    std::shared_ptr<const scene::KochanekTrack> track_;
    glm::dmat4 view_;
};

}   // namespace

AffImport::AffImport(const fs::path& main_file, const Progress& progress) : main_file_(main_file), progress_(progress)
{
    std::error_code error;
    const fs::path real = fs::canonical(main_file, error);
    if (error) throw InputError(main_file.string(), "", error.message());
    folder_ = real.parent_path();
    texture_folder_ = fs::canonical(folder_.parent_path() / "TextureFiles", error);
    if (error) texture_folder_.clear();
    scene_.name = main_file.filename().string();
    scene_.ambient = glm::vec3(1);
}

scene::Scene AffImport::run()
{
    read_file(main_file_, main_file_.string());
    flush();
    attach_tracks();
    place_camera();
    scene_.finish();
    return std::move(scene_);
}

void AffImport::read_file(const fs::path& file, const std::string& shown_as)
{
    AffText text(read_whole_file(file, shown_as, limits_.bytes), shown_as);
    std::error_code error;
    bytes_read_ += fs::file_size(file, error);
    if (bytes_read_ > limits_.bytes || ++includes_ > limits_.files)
        throw InputError(shown_as, "", "included files add up to more than is allowed");
    ++seen_files_[fs::canonical(file, error).string()];
    open_files_.push_back(fs::canonical(file, error));
    if (progress_ && !progress_({"loading", 0})) throw InterruptedError("interrupted");

    const std::size_t base_depth = stack_.size();
    for (std::string_view word = text.next(); !word.empty(); word = text.next()) statement(text, word, base_depth);
    if (stack_.size() != base_depth)
        text.fail(fmt::format("the file ends inside {} open '{{'", stack_.size() - base_depth));
    open_files_.pop_back();
}

void AffImport::statement(AffText& text, std::string_view word, std::size_t base_depth)
{
    if (word == "m") return read_mesh(text);
    if (word == "xs") return read_static_transform(text);
    if (word == "x") return read_animated_transform(text);
    if (word == "}") return close_transform(text, base_depth);
    if (word == "i") return read_include(text);
    if (word == "fm") return read_material(text);
    if (word == "f") return read_nff_material(text);
    if (word == "k") return read_track(text);
    if (word == "v") return read_view(text);
    if (word == "l") return read_light(text, false);
    if (word == "la") return read_light(text, true);
    if (word == "s") return read_sphere(text);
    if (word == "c") return read_cone(text);
    if (word == "p") return read_polygon(text, false);
    if (word == "pp") return read_polygon(text, true);
    if (word == "tt") return read_textured(text, false);
    if (word == "ttp") return read_textured(text, true);
    if (word == "tpa") return read_animated_triangle(text);
    if (word == "a") return read_animation(text);
    if (word == "b") {
        scene_.background.color = glm::vec3(text.vector("background colour"));
        return;
    }
    if (word == "am") {
        scene_.ambient = glm::vec3(text.vector("ambient light"));
        return;
    }
    if (word == "d") {
        detail_ = text.integer("detail level", 0, std::numeric_limits<int>::max());
        return;
    }
    if (word == "{") text.fail("'{' without a transform before it");
    text.fail(fmt::format("unknown statement '{}'", word.substr(0, 40)));
}

// --- Files and transforms

void AffImport::read_include(AffText& text)
{
    const long long level = text.integer("detail level of an include", 0, std::numeric_limits<int>::max());
    const std::string name = text.name("the name of a file to include");
    if (level > detail_) return;
    if (name.find_first_of("/\\") != std::string::npos || name == "." || name == "..")
        text.fail(fmt::format("the name of an included file has no path: '{}'", name));
    std::string why;
    const fs::path file = resolve_inside(folder_, name, {folder_}, why);
    if (file.empty()) text.fail(fmt::format("included file '{}' {}", name, why));
    if (std::find(open_files_.begin(), open_files_.end(), file) != open_files_.end())
        text.fail(fmt::format("'{}' includes itself", name));
    if (open_files_.size() >= static_cast<std::size_t>(limits_.include_depth))
        text.fail(fmt::format("includes are nested more than {} deep", limits_.include_depth));
    read_file(file, (fs::path(main_file_).parent_path() / name).string());
}

void AffImport::read_static_transform(AffText& text)
{
    const glm::dvec3 scale = text.vector("scale");
    const glm::dvec3 axis = text.vector("rotation axis");
    const double angle = text.number("rotation angle");
    const double length = glm::length(axis);
    if (length == 0 && angle != 0) text.fail("a rotation needs an axis");
    const glm::dvec3 translation = text.vector("translation");
    text.expect("{");
    flush();
    if (stack_.size() >= static_cast<std::size_t>(limits_.brace_depth))
        text.fail(fmt::format("transforms are nested more than {} deep", limits_.brace_depth));
    scene::TransformParts parts;
    parts.translation = translation;
    parts.scale = scale;
    if (length > 0) parts.rotation = glm::angleAxis(angle * k_pi / 180, axis / length);
    stack_.push_back(scene_.add_node("", open_node(), parts.matrix()));
}

void AffImport::read_animated_transform(AffText& text)
{
    std::string name = text.name("the name of an animated transform");
    text.expect("{");
    flush();
    if (stack_.size() >= static_cast<std::size_t>(limits_.brace_depth))
        text.fail(fmt::format("transforms are nested more than {} deep", limits_.brace_depth));
    const scene::NodeId node = scene_.add_node(name, open_node());
    scene_.nodes[node].animated = true;   // with or without keys
    animated_nodes_.emplace_back(node, std::move(name));
    stack_.push_back(node);
}

void AffImport::close_transform(AffText& text, std::size_t base_depth)
{
    if (stack_.size() <= base_depth) text.fail("'}' without its '{'");
    flush();
    stack_.pop_back();
}

// --- Camera, lights, time

void AffImport::read_view(AffText& text)
{
    View view;
    text.expect("from");
    view.from = text.vector("eye");
    text.expect("at");
    view.at = text.vector("target");
    text.expect("up");
    view.up = text.vector("up direction");
    text.expect("angle");
    view.angle = text.number("field of view");
    if (!(view.angle > 0 && view.angle < 180)) text.fail("the field of view is not between 0 and 180 degrees");
    text.expect("hither");
    view.hither = text.number("near distance");
    constexpr double least_hither = 1e-4;
    if (view.hither < least_hither) view.hither = 1;
    text.expect("resolution");
    view.resolution.width = static_cast<int>(text.integer("width", 1, k_most_pixels));
    view.resolution.height = static_cast<int>(text.integer("height", 1, k_most_pixels));
    view_ = view;
}

void AffImport::read_light(AffText& text, bool animated)
{
    std::string name;
    if (animated) name = text.name("the name of an animated light");
    const glm::dvec3 position = text.vector("light position");
    scene::Light light;
    light.falloff = scene::Falloff::constant;
    light.name = name;
    if (text.number_next()) light.color = glm::vec3(text.vector("light colour"));
    // The format leaves open whether a track replaces the position or adds to it: it adds.
    scene::NodeId parent = open_node();
    if (animated) {
        parent = scene_.add_node(name, parent);
        animated_lights_.emplace_back(parent, name);
    }
    light.node = scene_.add_node(name, parent, glm::translate(glm::dmat4(1), position));
    scene_.lights.push_back(light);
}

void AffImport::read_animation(AffText& text)
{
    scene::Timeline& timeline = scene_.timeline;
    timeline.start = text.number("start time");
    timeline.end = text.number("end time");
    timeline.frames = static_cast<int>(text.integer("number of frames", 1, k_most_frames));
    timeline.own_frames = true;
    if (timeline.frames > 1) {
        if (!(timeline.end > timeline.start)) text.fail("the animation ends before it starts");
        timeline.fps = (timeline.frames - 1) / (timeline.end - timeline.start);
    }
}

void AffImport::read_track(AffText& text)
{
    const std::string name = text.name("the name of a track");
    text.expect("{");
    Track track;
    track.transform = std::make_shared<scene::KochanekTrack>();
    constexpr std::size_t least_spline = 4;
    for (std::string_view kind = text.next(); kind != "}"; kind = text.next()) {
        if (kind == "transl") {
            if (!track.transform->translation.keys.empty()) text.fail("a second 'transl' in one track");
            track.transform->translation = read_vector_keys(text, text.count("number of keys", least_spline, 14));
        } else if (kind == "scale") {
            if (!track.transform->scale.keys.empty()) text.fail("a second 'scale' in one track");
            track.transform->scale = read_vector_keys(text, text.count("number of keys", least_spline, 14));
        } else if (kind == "rot") {
            if (!track.transform->rotation.empty()) text.fail("a second 'rot' in one track");
            std::vector<scene::RotationSpline::Key> keys(text.count("number of keys", least_spline, 16));
            for (auto& key : keys) {
                key.time = text.number("key time");
                key.axis = text.vector("rotation axis");
                key.angle = text.number("rotation angle");
                if (key.axis == glm::dvec3(0) && key.angle != 0) text.fail("a rotation needs an axis");
                key.tension = text.number("tension");
                key.continuity = text.number("continuity");
                key.bias = text.number("bias");
            }
            track.transform->rotation = scene::RotationSpline(std::move(keys));
        } else if (kind == "visibility") {
            if (track.visibility) text.fail("a second 'visibility' in one track");
            track.visibility = std::make_shared<scene::VisibilityTrack>();
            const std::size_t n = text.count("number of keys", 1, 4);
            for (std::size_t i = 0; i < n; ++i) {
                const double time = text.number("key time");
                if (i > 0 && time < track.visibility->times.back()) text.fail("visibility keys go back in time");
                track.visibility->times.push_back(time);
                track.visibility->visible.push_back(text.integer("visibility", 0, 1) == 1);
            }
        } else if (kind.empty()) {
            text.fail(fmt::format("the file ends inside the track '{}'", name));
        } else {
            text.fail(fmt::format("unknown kind of track '{}'", kind.substr(0, 40)));
        }
    }
    tracks_[name] = std::move(track);   // a second one replaces the first
}

scene::VectorSpline AffImport::read_vector_keys(AffText& text, std::size_t n)
{
    scene::VectorSpline spline;
    spline.keys.resize(n);
    spline.values.resize(n);
    for (std::size_t i = 0; i < n; ++i) {
        spline.keys[i].time = text.number("key time");
        spline.values[i] = text.vector("key value");
        spline.keys[i].tension = text.number("tension");
        spline.keys[i].continuity = text.number("continuity");
        spline.keys[i].bias = text.number("bias");
    }
    return spline;
}

// --- At the end of all files: tracks may stand before or after what they move.

void AffImport::attach_tracks()
{
    for (const auto& [node, name] : animated_nodes_) {
        const auto track = tracks_.find(name);
        if (track == tracks_.end()) continue;   // identity
        scene_.nodes[node].transform = track->second.transform;
        scene_.nodes[node].visibility = track->second.visibility;
    }
    for (const auto& [node, name] : animated_lights_) {
        const auto track = tracks_.find(name);
        if (track == tracks_.end()) continue;
        scene_.nodes[node].transform = std::make_shared<TranslationOnly>(track->second.transform);
        scene_.nodes[node].visibility = track->second.visibility;
    }
}

void AffImport::place_camera()
{
    const auto track = tracks_.find("camera");
    if (!view_ && track == tracks_.end()) return;
    const View view = view_.value_or(View{});
    const glm::dvec3 forward = view.at - view.from;
    glm::dmat4 placed(1);
    if (glm::length(forward) > 0) {
        // An up direction along the view, or none, is replaced by the axis furthest from it.
        glm::dvec3 up = view.up;
        if (!(glm::length(glm::cross(forward, up)) > 1e-9 * glm::length(forward) * std::max(glm::length(up), 1e-30)))
            up = std::abs(forward.y) < 0.9 * glm::length(forward) ? glm::dvec3(0, 1, 0) : glm::dvec3(0, 0, -1);
        placed = glm::inverse(glm::lookAt(view.from, view.at, up));
    }
    placed[3] = glm::dvec4(view.from, 1);
    scene::Camera camera;
    camera.name = "camera";
    camera.node = scene_.add_node("camera", scene::none, placed);
    if (track != tracks_.end())
        scene_.nodes[camera.node].transform = std::make_shared<CameraTrack>(track->second.transform, placed);
    camera.vertical_fov = view.angle * k_pi / 180;
    camera.near = view.hither;
    camera.resolution = view.resolution;
    scene_.cameras.push_back(camera);
}

void AffImport::warn(const std::string& warning)
{
    if (std::find(scene_.warnings.begin(), scene_.warnings.end(), warning) == scene_.warnings.end())
        scene_.warnings.push_back(warning);
}

scene::Scene load_aff(const fs::path& file, const Progress& progress)
{
    return AffImport(file, progress).run();
}

}   // namespace gnomon::io
