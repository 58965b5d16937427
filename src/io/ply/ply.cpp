// SPDX-License-Identifier: Apache-2.0
// Loads PLY meshes: vertices with normals, colours and texture coordinates, faces of any number of corners, and strips.
// Polygons become a mesh as those of an OBJ do (io/obj/mesh.h), which also makes the normals that are missing.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "base/image.h"
#include "base/interruption.h"
#include "gnomon/error.h"
#include "io/file/read_file.h"
#include "io/load.h"
#include "io/obj/mesh.h"
#include "io/ply/body.h"
#include "scene/file_surfaces.h"

namespace gnomon::io {

namespace {

constexpr std::uint64_t k_largest_ply = 4ull << 30;
constexpr float k_grey = 0.6f;   // of a mesh without colours, as of an OBJ without a material
constexpr std::uint64_t k_elements_a_step = 1 << 14;

class Reader {
 public:
    Reader(std::span<const std::uint8_t> bytes, std::string file, bool strict)
        : file_(std::move(file)), strict_(strict), header_(read_ply_header(bytes, file_)), body_(bytes, header_, file_)
    {
    }

    /// The polygons, with a material number 0; colours by position.
    ObjData read(std::vector<std::string>& warnings)
    {
        data_.objects.emplace_back();
        data_.materials.emplace_back();
        for (const PlyElement& element : header_.elements) {
            body_.require_room(element);
            if (element.name == "vertex")
                vertices(element);
            else if (element.name == "face")
                faces(element);
            else if (element.name == "tristrips")
                strips(element);
            else
                for_each(element, [&] {
                    for (const PlyProperty& p : element.properties) body_.skip(p);
                });
        }
        if (data_.faces.empty() && !data_.positions.empty() && skipped_ == 0)
            throw InputError(file_, "",
                             fmt::format("is a point cloud: {} points without faces, and only meshes are read",
                                         data_.positions.size()));
        check_indices();
        color_the_rest();
        warn(warnings);
        return std::move(data_);
    }

 private:
    void warn(std::vector<std::string>& warnings) const
    {
        if (skipped_ > 0)
            warnings.push_back(fmt::format("{} {} fewer than three corners: left out", skipped_,
                                           skipped_ == 1 ? "face has" : "faces have"));
        if (not_finite_normals_ > 0)
            warnings.push_back(fmt::format("{} {} not finite: computed from faces", not_finite_normals_,
                                           not_finite_normals_ == 1 ? "normal is" : "normals are"));
        if (not_finite_values_ > 0)
            warnings.push_back(
                fmt::format("{} of texture coordinates and colours {} not finite: set to 0",
                            not_finite_values_ == 1 ? "1 value" : fmt::format("{} values", not_finite_values_),
                            not_finite_values_ == 1 ? "is" : "are"));
    }

    template <class Each>
    void for_each(const PlyElement& element, Each each)
    {
        for (std::uint64_t i = 0; i < element.count; ++i) {
            if (i % k_elements_a_step == 0) {
                interruption_point();
                report_progress("loading", 0.5 * body_.done());
            }
            each();
        }
    }

    // A part of a colour, 0 to 1; integers are fractions of the type's largest value.
    float color_part(const PlyProperty& p, double value)
    {
        if (ply_is_integer(p.type)) value /= p.type == PlyType::u8 || p.type == PlyType::i8 ? 255 : 65535;
        return std::min(std::max(repaired(value), 0.0f), 1.0f);
    }

    static glm::vec4 linear(const std::array<float, 4>& srgb)
    {
        return {linear_from_srgb(srgb[0]), linear_from_srgb(srgb[1]), linear_from_srgb(srgb[2]), srgb[3]};
    }

    float finite(double value)
    {
        const auto single = static_cast<float>(value);
        if (!std::isfinite(single)) body_.fail(fmt::format("{} is not a finite number", value));
        return single;
    }

    // A value that is safe to repair: 0 if it is not finite.
    float repaired(double value)
    {
        if (strict_ || std::isfinite(static_cast<float>(value))) return finite(value);
        ++not_finite_values_;
        return 0;
    }

    // A normal of zero is computed from the faces.
    glm::vec3 normal(const glm::vec3& n)
    {
        if (std::isfinite(n.x) && std::isfinite(n.y) && std::isfinite(n.z)) return n;
        if (strict_) body_.fail("the normal is not finite");
        ++not_finite_normals_;
        return glm::vec3(0);
    }

    static int find_first(const PlyElement& element, std::initializer_list<const char*> names)
    {
        for (const char* name : names)
            if (const int found = element.find(name); found >= 0) return found;
        return -1;
    }

    // Where an element has the parts of its colour; red, green and blue are there, or none.
    static std::array<int, 4> find_color(const PlyElement& element)
    {
        const std::array<int, 4> at = {
            find_first(element, {"red", "diffuse_red", "r"}), find_first(element, {"green", "diffuse_green", "g"}),
            find_first(element, {"blue", "diffuse_blue", "b"}), find_first(element, {"alpha", "a"})};
        return at[0] >= 0 && at[1] >= 0 && at[2] >= 0 ? at : std::array<int, 4>{-1, -1, -1, -1};
    }

    void vertices(const PlyElement& element)
    {
        if (!data_.positions.empty()) body_.fail("a second list of vertices");
        // Find the properties by their usual names.
        const auto first_of = [&](std::initializer_list<const char*> names) { return find_first(element, names); };
        enum Part { x, y, z, nx, ny, nz, red, green, blue, alpha, s, t, k_parts };
        const std::array<int, 4> color_at = find_color(element);
        const std::array<int, k_parts> at = {element.find("x"),
                                             element.find("y"),
                                             element.find("z"),
                                             element.find("nx"),
                                             element.find("ny"),
                                             element.find("nz"),
                                             color_at[0],
                                             color_at[1],
                                             color_at[2],
                                             color_at[3],
                                             first_of({"s", "u", "texture_u", "texture_s"}),
                                             first_of({"t", "v", "texture_v", "texture_t"})};
        if (at[x] < 0 || at[y] < 0 || at[z] < 0) body_.fail("vertices without x, y and z");
        has_normals_ = at[nx] >= 0 && at[ny] >= 0 && at[nz] >= 0;
        has_texcoords_ = at[s] >= 0 && at[t] >= 0;
        const bool colors = at[red] >= 0;
        std::vector<int> part_of(element.properties.size(), k_parts);
        for (int part = 0; part < k_parts; ++part)
            if (at[static_cast<std::size_t>(part)] >= 0)
                part_of[static_cast<std::size_t>(at[static_cast<std::size_t>(part)])] = part;

        data_.positions.reserve(element.count);
        std::array<float, k_parts + 1> v{};
        v[alpha] = 1;
        for_each(element, [&] {
            for (std::size_t i = 0; i < element.properties.size(); ++i) {
                const PlyProperty& p = element.properties[i];
                const int part = part_of[i];
                if (part == k_parts || p.is_list) {
                    body_.skip(p);
                    continue;
                }
                const double value = body_.value(p.type);
                float& single = v[static_cast<std::size_t>(part)];
                if (part <= z)
                    single = finite(value);
                else if (part <= nz)
                    single = static_cast<float>(value);
                else
                    single = part <= alpha ? color_part(p, value) : repaired(value);
                if (part <= z && std::abs(v[static_cast<std::size_t>(part)]) > k_largest_coordinate)
                    body_.fail(fmt::format("{} is too large for a coordinate", value));
            }
            data_.positions.emplace_back(v[x], v[y], v[z]);
            if (has_normals_) data_.normals.push_back(normal({v[nx], v[ny], v[nz]}));
            if (has_texcoords_) data_.texcoords.emplace_back(v[s], v[t]);
            if (colors) data_.colors.push_back(linear({v[red], v[green], v[blue], v[alpha]}));
        });
    }

    // Reads the list of vertex numbers of an element and its colour, and drops its other properties.
    template <class Numbers>
    void each_list(const PlyElement& element, Numbers numbers)
    {
        int list = element.find("vertex_indices", true);
        if (list < 0) list = element.find("vertex_index", true);
        if (list < 0) body_.fail(fmt::format("elements '{}' without vertex_indices", shown(element.name)));
        const std::array<int, 4> color_at = find_color(element);
        has_face_colors_ = color_at[0] >= 0;
        color_ = {0, 0, 0, 1};
        for_each(element, [&] {
            for (std::size_t i = 0; i < element.properties.size(); ++i) {
                const PlyProperty& p = element.properties[i];
                const auto part = std::ranges::find(color_at, static_cast<int>(i));
                if (has_face_colors_ && part != color_at.end() && !p.is_list) {
                    color_[static_cast<std::size_t>(part - color_at.begin())] = color_part(p, body_.value(p.type));
                    continue;
                }
                if (static_cast<int>(i) != list) {
                    body_.skip(p);
                    continue;
                }
                numbers_.clear();
                for (std::uint64_t count = body_.length(p); count > 0; --count) numbers_.push_back(body_.value(p.type));
            }
            // Colours of vertices come first.
            if (has_face_colors_ && data_.colors.empty()) add_color(linear(color_));
            numbers();
        });
    }

    // Neighbouring faces often have the same colour.
    void add_color(const glm::vec4& color)
    {
        if (data_.face_colors.empty() || data_.face_colors.back() != color) data_.face_colors.push_back(color);
    }

    ObjCorner corner(double number)
    {
        if (!(number >= 0) || number != std::floor(number) || number >= static_cast<double>(k_no_index))
            body_.fail(fmt::format("{} is not the number of a vertex", number));
        const auto i = static_cast<std::uint32_t>(number);
        return {i, i, i};   // what there is of each is known after all elements were read
    }

    void add_face(std::initializer_list<double> corners) { add_face(std::span(corners.begin(), corners.size())); }
    void add_face(std::span<const double> corners)
    {
        if (data_.corners.size() + corners.size() >= k_no_index) body_.fail("too many corners");
        data_.faces.push_back({static_cast<std::uint32_t>(data_.corners.size()),
                               static_cast<std::uint32_t>(corners.size()), 0, 0, ObjFace::k_unset,
                               has_face_colors_ && data_.colors.empty()
                                   ? static_cast<std::uint32_t>(data_.face_colors.size() - 1)
                                   : k_no_index});
        for (const double number : corners) data_.corners.push_back(corner(number));
    }

    void faces(const PlyElement& element)
    {
        data_.faces.reserve(element.count);
        each_list(element, [&] {
            if (numbers_.size() < 3)
                ++skipped_;
            else
                add_face(numbers_);
        });
    }

    // Strips of triangles, of which every second one is reversed; -1 ends a strip.
    void strips(const PlyElement& element)
    {
        each_list(element, [&] {
            std::size_t begin = 0;
            for (std::size_t i = 0; i < numbers_.size(); ++i) {
                if (numbers_[i] == -1) begin = i + 1;
                if (i < begin + 2) continue;
                const double a = numbers_[i - 2], b = numbers_[i - 1], c = numbers_[i];
                if (a == b || b == c || c == a) continue;   // joins strips
                (i - begin) % 2 == 0 ? add_face({a, b, c}) : add_face({b, a, c});
            }
        });
    }

    // Makes faces white that have no colour in a file in which others have one.
    void color_the_rest()
    {
        if (data_.face_colors.empty() || !data_.colors.empty()) return;
        const auto white = static_cast<std::uint32_t>(data_.face_colors.size());
        data_.face_colors.emplace_back(1);
        for (ObjFace& face : data_.faces)
            if (face.color == k_no_index) face.color = white;
    }

    void check_indices()
    {
        for (std::size_t f = 0; f < data_.faces.size(); ++f) {
            const ObjFace& face = data_.faces[f];
            for (std::uint32_t k = 0; k < face.corner_count; ++k) {
                ObjCorner& c = data_.corners[face.first_corner + k];
                if (c.position >= data_.positions.size())
                    throw InputError(
                        file_, fmt::format("face {}", f),
                        fmt::format("refers to vertex {}, but there are {}", c.position, data_.positions.size()));
                if (!has_normals_) c.normal = k_no_index;
                if (!has_texcoords_) c.texcoord = k_no_index;
            }
        }
    }

    std::string file_;
    bool strict_;
    PlyHeader header_;
    PlyBody body_;
    ObjData data_;
    std::vector<double> numbers_;
    std::array<float, 4> color_{};   // of the face that was read last
    bool has_face_colors_ = false;
    bool has_normals_ = false, has_texcoords_ = false;
    std::uint64_t skipped_ = 0, not_finite_normals_ = 0, not_finite_values_ = 0;
};

}   // namespace

scene::Scene load_ply(const std::filesystem::path& file, const Progress& progress, const ReadOptions& options)
{
    Interruption interruption(progress);
    const InterruptionScope scope(progress ? &interruption : Interruption::current());
    report_progress("loading", 0);
    scene::Scene scene;
    scene.name = file.stem().string();
    ObjData data;
    {
        const std::vector<std::uint8_t> bytes = read_whole_file(file, file.string(), k_largest_ply);
        data = Reader(bytes, file.string(), options.strict).read(scene.warnings);
    }
    scene::Material material;
    material.name = "default";
    material.base_color = glm::vec3(data.colors.empty() && data.face_colors.empty() ? k_grey : 1);
    material.double_sided = true;   // scanners and converters do not agree on the order of corners
    scene.materials.push_back(material);
    if (!data.faces.empty()) add_obj_meshes(scene, data, {0}, {});
    scene::leave_out_repeats(scene);
    scene.finish();
    return scene;
}

}   // namespace gnomon::io
