// SPDX-License-Identifier: Apache-2.0
#include "io/aff/aff.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string_view>
#include <tuple>
#include <unordered_map>
#include <utility>

#include "base/interruption.h"
#include "gnomon/error.h"
#include "io/aff/mesh.h"
#include "io/file/read_file.h"
#include "io/load.h"

namespace gnomon::io {

namespace fs = std::filesystem;
using scene::none;

namespace {

constexpr double k_least_near = 0.0001;   // a `hither` below this is replaced by k_default_near
constexpr double k_default_near = 1;
constexpr double k_least_ior = 0.01;   // an index of refraction below this is replaced by k_default_ior
constexpr double k_default_ior = 1;
constexpr int k_statements_a_report = 64;   // between two reports of progress

struct File {
    AffText text;
    std::string name;    // as written in the including file
    bool open = false;   // currently being read
};

class Reader {
 public:
    Reader(const fs::path& file, const AffOptions& options);
    scene::Scene read(AffReport* report);

 private:
    using Statement = void (Reader::*)(AffTokens&);
    static const std::unordered_map<std::string_view, Statement>& statements();

    File& file_at(const fs::path& path, const std::string& name);
    void read_file(File& file);
    void report_progress();
    fs::path resolve(AffTokens& tokens, const AffToken& name, const fs::path& folder);
    scene::TextureId texture(AffTokens& tokens, const AffToken& name);

    static glm::dvec3 vector(AffTokens& tokens, std::string_view meaning);
    static glm::vec3 color(AffTokens& tokens) { return glm::vec3(vector(tokens, "a colour")); }
    static AffCorner corner(AffTokens& tokens, bool normal, bool texcoord);
    void finish_material(AffTokens& tokens, scene::Material material);
    void read_polygon(AffTokens& tokens, bool normals);
    void read_triangle(AffTokens& tokens, bool normals);
    void read_light(AffTokens& tokens, const std::string& track_name);

    void statement_v(AffTokens&);
    void statement_l(AffTokens& tokens) { read_light(tokens, {}); }
    void statement_la(AffTokens& tokens) { read_light(tokens, std::string(tokens.word("a track's name").text)); }
    void statement_b(AffTokens& tokens) { builder_.scene().background.color = color(tokens); }
    void statement_am(AffTokens& tokens) { builder_.scene().ambient = color(tokens); }
    void statement_a(AffTokens&);
    void statement_f(AffTokens&);
    void statement_fm(AffTokens&);
    void statement_s(AffTokens&);
    void statement_c(AffTokens&);
    void statement_p(AffTokens& tokens) { read_polygon(tokens, false); }
    void statement_pp(AffTokens& tokens) { read_polygon(tokens, true); }
    void statement_tt(AffTokens& tokens) { read_triangle(tokens, false); }
    void statement_ttp(AffTokens& tokens) { read_triangle(tokens, true); }
    void statement_tpa(AffTokens&);
    void statement_m(AffTokens&);
    void statement_i(AffTokens&);
    void statement_d(AffTokens& tokens)
    {
        detail_level_ = tokens.integer("a detail level", -k_largest_level, k_largest_level);
    }
    void statement_xs(AffTokens&);
    void statement_x(AffTokens&);
    void statement_k(AffTokens&);

    static constexpr std::int64_t k_largest_level = 1'000'000;

    fs::path main_file_, folder_, texture_folder_;   // the folders are canonical
    AffOptions options_;
    AffBuilder builder_;

    std::map<fs::path, std::unique_ptr<File>> files_;
    std::map<fs::path, scene::TextureId> textures_;
    File* file_ = nullptr;   // the file being read
    std::size_t include_depth_ = 0, includes_ = 0;
    std::uint64_t parsed_bytes_ = 0, texture_bytes_ = 0;
    std::int64_t detail_level_ = 0;
    std::vector<AffToken> open_braces_;   // of the file being read

    // A part that is included again with the same material is the same mesh. Its key: file, position in it, and
    // material.
    struct Known {
        scene::MeshId mesh = none;
        std::size_t end = 0;   // offset behind the statement
    };
    std::map<std::tuple<const File*, std::size_t, std::uint32_t>, Known> known_meshes_;

    const AffTokens* main_tokens_ = nullptr;
    int statements_to_report_ = 0;
};

// --- Files

Reader::Reader(const fs::path& file, const AffOptions& options)
    : main_file_(file), options_(options), builder_(options.scene, options.shapes, options.memory)
{
    std::error_code error;
    folder_ = fs::canonical(file.has_parent_path() ? file.parent_path() : fs::path("."), error);
    if (error) throw InputError(file.string(), "", "does not exist");
    texture_folder_ = folder_.parent_path() / "TextureFiles";
    builder_.scene().name = file.stem().string();
    builder_.scene().ambient = glm::vec3(1);   // the format's default
}

File& Reader::file_at(const fs::path& path, const std::string& name)
{
    std::unique_ptr<File>& file = files_[path];
    if (!file) {
        file = std::make_unique<File>();
        file->name = name;
        file->text.shown_as = (main_file_.parent_path() / name).string();
        const auto bytes = read_whole_file(path, file->text.shown_as, options_.max_file_bytes);
        file->text.bytes.assign(bytes.begin(), bytes.end());
    }
    return *file;
}

// Names of other files must be plain, without a folder. Links are followed and must end in the scene's folders, too.
fs::path Reader::resolve(AffTokens& tokens, const AffToken& name, const fs::path& folder)
{
    const std::string text(name.text);
    if (text.find_first_of("/\\") != std::string::npos || text == "." || text == "..")
        tokens.fail(name, fmt::format("expected a file name without a path, found {}", shown(name)));
    std::string why;
    fs::path found = resolve_inside(folder, text, {folder_, texture_folder_}, why);
    if (found.empty()) tokens.fail(name, fmt::format("{} {}", shown(name), why));
    return found;
}

scene::TextureId Reader::texture(AffTokens& tokens, const AffToken& name)
{
    const fs::path path = resolve(tokens, name, texture_folder_);
    const auto [place, is_new] = textures_.try_emplace(path, none);
    if (!is_new) return place->second;

    const std::string shown_as = (main_file_.parent_path() / ".." / "TextureFiles" / std::string(name.text)).string();
    const auto bytes = read_whole_file(path, shown_as, options_.max_texture_bytes - texture_bytes_);
    texture_bytes_ += bytes.size();
    if (bytes.size() < 2 || bytes[0] != 'P' || bytes[1] != '6')
        throw InputError(shown_as, "", "not a binary PPM image");
    place->second = builder_.add_texture(utf8_from_latin1(name.text), bytes, shown_as);
    return place->second;
}

void Reader::report_progress()
{
    const double size = static_cast<double>(std::max<std::size_t>(1, main_tokens_->text().bytes.size()));
    const double left = static_cast<double>(main_tokens_->bytes_left());
    gnomon::report_progress("loading", 1 - left / size);
}

scene::Scene Reader::read(AffReport* report)
{
    const std::string name = main_file_.filename().string();
    std::error_code error;
    const fs::path path = fs::canonical(main_file_, error);
    if (error) throw InputError(main_file_.string(), "", "does not exist");
    File& file = file_at(path, name);
    read_file(file);
    if (report) {
        report->files = files_.size();
        report->deepest_nesting = builder_.deepest();
        report->tracks = builder_.tracks();
    }
    scene::Scene scene = builder_.finish();
    gnomon::report_progress("loading", 1);
    return scene;
}

void Reader::read_file(File& file)
{
    AffTokens tokens(file.text);
    if (!main_tokens_) main_tokens_ = &tokens;
    parsed_bytes_ += file.text.bytes.size();
    File* const including = std::exchange(file_, &file);
    std::vector<AffToken> braces_of_including = std::exchange(open_braces_, {});
    file.open = true;

    while (!tokens.at_end()) {
        if (--statements_to_report_ <= 0) {
            statements_to_report_ = k_statements_a_report;
            report_progress();
        }
        const AffToken keyword = tokens.take();
        if (keyword.text == "}") {
            if (open_braces_.empty()) tokens.fail(keyword, "'}' without a '{' in this file");
            builder_.flush();
            builder_.close();
            open_braces_.pop_back();
            continue;
        }
        const auto found = statements().find(keyword.text);
        if (found == statements().end()) tokens.fail(keyword, fmt::format("unknown statement {}", shown(keyword)));

        // Only flat primitives are merged with those before them.
        const bool flat = keyword.text[0] == 'p' || keyword.text[0] == 't';
        if (!flat) builder_.flush();
        (this->*found->second)(tokens);
        if (const std::string why = builder_.limit_exceeded(); !why.empty()) tokens.fail(keyword, why);
    }
    builder_.flush();
    if (!open_braces_.empty()) tokens.fail(open_braces_.back(), "'{' is never closed in this file");

    file.open = false;
    open_braces_ = std::move(braces_of_including);
    file_ = including;
}

const std::unordered_map<std::string_view, Reader::Statement>& Reader::statements()
{
    static const std::unordered_map<std::string_view, Statement> table{
        {"v", &Reader::statement_v},   {"l", &Reader::statement_l},     {"la", &Reader::statement_la},
        {"b", &Reader::statement_b},   {"am", &Reader::statement_am},   {"a", &Reader::statement_a},
        {"f", &Reader::statement_f},   {"fm", &Reader::statement_fm},   {"s", &Reader::statement_s},
        {"c", &Reader::statement_c},   {"p", &Reader::statement_p},     {"pp", &Reader::statement_pp},
        {"tt", &Reader::statement_tt}, {"ttp", &Reader::statement_ttp}, {"tpa", &Reader::statement_tpa},
        {"m", &Reader::statement_m},   {"i", &Reader::statement_i},     {"d", &Reader::statement_d},
        {"xs", &Reader::statement_xs}, {"x", &Reader::statement_x},     {"k", &Reader::statement_k},
    };
    return table;
}

// --- Camera, lights, time

glm::dvec3 Reader::vector(AffTokens& tokens, std::string_view meaning)
{
    glm::dvec3 v;
    for (int c = 0; c < 3; ++c) v[c] = tokens.number(meaning);
    return v;
}

void Reader::statement_v(AffTokens& tokens)
{
    scene::Camera camera;
    tokens.expect("from");
    const glm::dvec3 eye = vector(tokens, "an eye point");
    const AffToken at_keyword = tokens.peek();
    tokens.expect("at");
    const glm::dvec3 target = vector(tokens, "a target point");
    tokens.expect("up");
    const glm::dvec3 up = vector(tokens, "an upward vector");
    tokens.expect("angle");
    const AffToken angle_token = tokens.peek();
    const double angle = tokens.number("a field of view");
    if (!(angle > 0 && angle < 180)) tokens.fail(angle_token, "the field of view must lie between 0 and 180 degrees");
    tokens.expect("hither");
    const double hither = tokens.number("a near distance");
    tokens.expect("resolution");
    const AffToken width_token = tokens.peek();
    const std::int64_t width = tokens.integer("a width", 1, options_.max_resolution);
    const std::int64_t height = tokens.integer("a height", 1, options_.max_resolution);
    if (width * height > options_.max_pixels)
        tokens.fail(width_token,
                    fmt::format("expected at most {} pixels, found {} x {}", options_.max_pixels, width, height));
    camera.resolution = {static_cast<int>(width), static_cast<int>(height)};
    camera.vertical_fov = glm::radians(angle);
    camera.near = hither < k_least_near ? k_default_near : hither;

    // Turn -Z towards the target and +Y upwards.
    const double distance = glm::length(target - eye);
    if (!(distance > 0)) tokens.fail(at_keyword, "the camera's target equals its eye point");
    const glm::dvec3 back = (eye - target) / distance;
    glm::dvec3 right = glm::cross(up, back);
    if (!(glm::length(right) > 0)) {
        builder_.scene().warnings.emplace_back(
            "the camera's upward vector is parallel to its direction; another one is used");
        right = glm::cross(std::abs(back.y) < 0.9 ? glm::dvec3(0, 1, 0) : glm::dvec3(0, 0, -1), back);
    }
    right = glm::normalize(right);
    const glm::dmat3 axes(right, glm::cross(back, right), back);
    builder_.set_camera(camera, {eye, glm::normalize(glm::quat_cast(axes)), glm::dvec3(1)});
}

void Reader::read_light(AffTokens& tokens, const std::string& track_name)
{
    const glm::dvec3 position = vector(tokens, "a light's position");
    const glm::vec3 light_color = tokens.number_follows() ? color(tokens) : glm::vec3(1);
    builder_.add_light(position, light_color, track_name);
}

void Reader::statement_a(AffTokens& tokens)
{
    scene::Timeline timeline;
    timeline.own_frames = true;
    timeline.start = tokens.number("a start time");
    const AffToken end = tokens.peek();
    timeline.end = tokens.number("an end time");
    timeline.frames = static_cast<int>(tokens.integer("the number of frames", 1, options_.max_frames));
    if (timeline.end < timeline.start) tokens.fail(end, "the end time lies before the start time");
    if (timeline.frames > 1 && !(timeline.end > timeline.start))
        tokens.fail(end, "several frames, but the start and end times are equal");
    if (timeline.frames > 1) timeline.fps = (timeline.frames - 1) / (timeline.end - timeline.start);
    if (!std::isfinite(timeline.fps))
        tokens.fail(end, "the time between start and end is too short for several frames");
    builder_.scene().timeline = timeline;
}

// --- Materials

void Reader::finish_material(AffTokens& tokens, scene::Material material)
{
    const auto value = [&](std::string_view meaning) { return static_cast<float>(tokens.number(meaning)); };
    material.model = scene::ShadingModel::whitted;
    material.shine = std::max(0.0f, value("a shine"));
    const AffToken transmittance = tokens.peek();
    material.transmittance = value("a transmittance");
    if (material.transmittance < 0) tokens.fail(transmittance, "a transmittance below 0");
    material.transmittance = std::min(1.0f, material.transmittance);
    material.ior = value("an index of refraction");
    if (material.ior < k_least_ior) material.ior = static_cast<float>(k_default_ior);
    builder_.set_material(material);
}

void Reader::statement_f(AffTokens& tokens)
{
    // The file gives neither the highlight's tint nor the ambient colour: use white, and the diffuse colour.
    scene::Material material;
    const glm::vec3 rgb = color(tokens);
    material.base_color = material.ambient = rgb * static_cast<float>(tokens.number("a diffuse strength"));
    material.specular = glm::vec3(static_cast<float>(tokens.number("a specular strength")));
    finish_material(tokens, material);
}

void Reader::statement_fm(AffTokens& tokens)
{
    scene::Material material;
    material.ambient = color(tokens);
    material.base_color = color(tokens);
    material.specular = color(tokens);
    finish_material(tokens, material);
}

// --- Geometry

void Reader::statement_s(AffTokens& tokens)
{
    const glm::dvec3 centre = vector(tokens, "a centre");
    const AffToken at = tokens.peek();
    const double radius = tokens.number("a radius");
    if (radius == 0) tokens.fail(at, "a sphere of radius 0");
    builder_.add_sphere(centre, std::abs(radius), radius < 0);
}

void Reader::statement_c(AffTokens& tokens)
{
    const AffToken at = tokens.peek();
    const glm::dvec3 base = vector(tokens, "a base point");
    const double base_radius = tokens.number("a base radius");
    const glm::dvec3 apex = vector(tokens, "an apex");
    const double apex_radius = tokens.number("an apex radius");
    if (!(glm::length(apex - base) > 0)) tokens.fail(at, "a cone of height 0");
    if (base_radius == 0 && apex_radius == 0) tokens.fail(at, "a cone of radius 0");
    const bool inside = base_radius < 0 || apex_radius < 0;
    if (inside && (base_radius > 0 || apex_radius > 0)) tokens.fail(at, "a cone's radii must have the same sign");
    builder_.add_cone(base, std::abs(base_radius), apex, std::abs(apex_radius), inside);
}

AffCorner Reader::corner(AffTokens& tokens, bool normal, bool texcoord)
{
    AffCorner result;
    result.position = glm::vec3(vector(tokens, "a coordinate"));
    if (normal) result.normal = glm::vec3(vector(tokens, "a normal"));
    if (texcoord)
        for (int c = 0; c < 2; ++c) result.texcoord[c] = static_cast<float>(tokens.number("a texture coordinate"));
    return result;
}

void Reader::read_polygon(AffTokens& tokens, bool normals)
{
    std::vector<AffCorner> corners(tokens.count("the number of corners", 3, normals ? 6 : 3));
    for (AffCorner& c : corners) c = corner(tokens, normals, false);
    builder_.add_polygon(corners, none, normals);
}

void Reader::read_triangle(AffTokens& tokens, bool normals)
{
    const AffToken name = tokens.word("a texture's name");
    std::vector<AffCorner> corners(3);
    for (AffCorner& c : corners) c = corner(tokens, normals, true);
    builder_.add_polygon(corners, texture(tokens, name), normals);
}

void Reader::statement_tpa(AffTokens& tokens)
{
    const std::size_t n = tokens.count("the number of keys", 1, 19);
    std::vector<double> times;
    std::vector<std::array<AffCorner, 3>> corners;
    for (std::size_t k = 0; k < n; ++k) {
        const AffToken at = tokens.peek();
        times.push_back(tokens.number("a key time"));
        if (k > 0 && times[k] < times[k - 1]) tokens.fail(at, "keys must not go back in time");
        for (AffCorner& c : corners.emplace_back()) c = corner(tokens, true, false);
    }
    builder_.add_keyed_triangle(times, corners);
}

void Reader::statement_m(AffTokens& tokens)
{
    const auto key = std::tuple(file_, tokens.offset(), builder_.current_material());
    if (const auto found = known_meshes_.find(key); found != known_meshes_.end()) {
        tokens.move_to(found->second.end);
        builder_.add_instance(found->second.mesh);
        return;
    }
    AffMesh read = read_aff_mesh(tokens);
    read.mesh.name = fmt::format("{} {}", fs::path(file_->name).stem().string(), known_meshes_.size());
    const scene::TextureId image = read.texture.text.empty() ? none : texture(tokens, read.texture);
    const scene::MeshId mesh = builder_.add_mesh(std::move(read.mesh), image);
    known_meshes_[key] = {mesh, tokens.offset()};
    builder_.add_instance(mesh);
}

// --- Structure

void Reader::statement_i(AffTokens& tokens)
{
    const std::int64_t level = tokens.integer("a detail level", -k_largest_level, k_largest_level);
    const AffToken name = tokens.word("a file's name");
    if (level > detail_level_) return;

    if (++includes_ > options_.max_includes)
        tokens.fail(name, fmt::format("more than {} includes", options_.max_includes));
    if (include_depth_ >= options_.max_include_depth)
        tokens.fail(name, fmt::format("includes are nested more than {} deep", options_.max_include_depth));
    const fs::path path = resolve(tokens, name, folder_);
    File& file = file_at(path, std::string(name.text));
    if (file.open) tokens.fail(name, fmt::format("{} includes itself", shown(name)));
    if (parsed_bytes_ + file.text.bytes.size() > options_.max_parsed_bytes)
        tokens.fail(name, fmt::format("more than {} bytes of includes", options_.max_parsed_bytes));
    ++include_depth_;
    read_file(file);
    --include_depth_;
}

void Reader::statement_xs(AffTokens& tokens)
{
    const glm::dvec3 scale = vector(tokens, "a scale");
    const AffToken axis_token = tokens.peek();
    const glm::dvec3 axis = vector(tokens, "a rotation axis");
    const double angle = glm::radians(tokens.number("an angle"));
    const glm::dvec3 translation = vector(tokens, "a translation");
    const double length = glm::length(axis);
    if (!(length > 0) && angle != 0)
        tokens.fail(axis_token, "a rotation about an axis of length 0 by an angle other than 0");
    open_braces_.push_back(tokens.peek());
    tokens.expect("{");

    const glm::dquat rotation = length > 0 ? glm::angleAxis(angle, axis / length) : glm::dquat(1, 0, 0, 0);
    const double largest_scale = std::max({std::abs(scale.x), std::abs(scale.y), std::abs(scale.z)});
    builder_.open_static(scene::TransformParts{translation, rotation, scale}.matrix(), largest_scale);
}

void Reader::statement_x(AffTokens& tokens)
{
    const AffToken name = tokens.word("a name");
    open_braces_.push_back(tokens.peek());
    tokens.expect("{");
    builder_.open_animated(std::string(name.text));
}

void Reader::statement_k(AffTokens& tokens)
{
    const std::string name(tokens.word("a name").text);
    builder_.set_tracks(name, read_aff_tracks(tokens));
}

}   // namespace

scene::Scene load_aff(const fs::path& file, const Progress& progress, const AffOptions& options, AffReport* report)
{
    Interruption interruption(progress);
    const InterruptionScope scope(progress ? &interruption : Interruption::current());
    return Reader(file, options).read(report);
}

scene::Scene load_aff(const fs::path& file, const Progress& progress, const ReadOptions& options)
{
    AffOptions own;
    own.memory = options.memory;
    return load_aff(file, progress, own);
}

}   // namespace gnomon::io
