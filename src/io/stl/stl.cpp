// SPDX-License-Identifier: Apache-2.0
// Loads STL meshes, as text or binary (always little-endian). Corners at the same place become one vertex, so that the
// mesh is shaded smoothly where its facets meet at less than the crease angle (io/obj/normals.h). The normals in the
// file are those of the facets, often wrong, and not read.
#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <numeric>
#include <tuple>

#include "base/interruption.h"
#include "gnomon/error.h"
#include "io/file/read_file.h"
#include "io/load.h"
#include "io/obj/mesh.h"
#include "scene/file_surfaces.h"

namespace gnomon::io {

namespace {

constexpr std::uint64_t k_largest_stl = 4ull << 30;
constexpr std::size_t k_header = 84, k_facet = 50;   // bytes; the header ends with the number of facets
constexpr float k_grey = 0.6f;
constexpr std::uint32_t k_most_facets = k_no_index / 3;
constexpr std::size_t k_most_lines = 1000;   // that are ignored before the first facet
constexpr std::uint32_t k_facets_a_step = 1 << 14;

std::uint32_t u32_at(const std::uint8_t* p)
{
    return p[0] | std::uint32_t{p[1]} << 8 | std::uint32_t{p[2]} << 16 | std::uint32_t{p[3]} << 24;
}

// Three corners and the object of each facet; corners are not yet shared.
struct Facets {
    std::vector<glm::vec3> corners;
    std::vector<std::uint32_t> object;
    std::vector<std::string> names;
};

// What was repaired or left out.
struct Repairs {
    bool allowed = true;
    std::size_t not_finite = 0;   // facets
    std::size_t lines = 0;        // between facets
    std::uint32_t first_line = 0;

    void warn(std::vector<std::string>& warnings) const
    {
        if (not_finite > 0)
            warnings.push_back(
                fmt::format("{} corners that are not finite: left out",
                            not_finite == 1 ? "1 facet has" : fmt::format("{} facets have", not_finite)));
        if (lines > 0)
            warnings.push_back(fmt::format("line {}: {} neither a facet nor the end of a solid: ignored", first_line,
                                           lines == 1 ? "1 line is" : fmt::format("{} lines are", lines)));
    }
};

Facets read_binary(std::span<const std::uint8_t> bytes, const std::string& file, std::uint64_t count, Repairs& repairs)
{
    Facets facets;
    facets.names.emplace_back();
    if (count > k_most_facets) throw InputError(file, "byte 80", fmt::format("{} facets are too many", count));
    facets.corners.reserve(3 * count);
    for (std::size_t f = 0; f < count; ++f) {
        if (f % k_facets_a_step == 0) interruption_point();
        const std::size_t begin = k_header + k_facet * f;
        const std::uint8_t* at = bytes.data() + begin + 12;   // behind the normal
        glm::vec3 p[3];
        bool finite = true;
        for (glm::vec3& corner : p) {
            for (int k = 0; k < 3; ++k, at += 4) {
                corner[k] = std::bit_cast<float>(u32_at(at));
                if (repairs.allowed && !std::isfinite(corner[k]))
                    finite = false;
                else if (!(std::abs(corner[k]) <= k_largest_coordinate))
                    throw InputError(file, fmt::format("byte {}", at - bytes.data()),
                                     fmt::format("{} is not a coordinate", corner[k]));
            }
        }
        if (!finite) {
            ++repairs.not_finite;
            continue;
        }
        facets.corners.insert(facets.corners.end(), std::begin(p), std::end(p));
        facets.object.push_back(0);
    }
    return facets;
}

class TextReader {
 public:
    TextReader(ObjText& text, Repairs& repairs) : text_(text), repairs_(repairs) {}

    Facets read()
    {
        for (std::string_view keyword = next(); !keyword.empty(); keyword = next()) {
            if (facets_.object.size() % k_facets_a_step == 0) interruption_point();
            if (keyword == "solid")
                facets_.names.push_back(text_.rest());
            else if (keyword == "facet")
                facet();
            else if (keyword != "endsolid")
                ignore();
        }
        if (facets_.names.empty()) facets_.names.emplace_back();
        return std::move(facets_);
    }

 private:
    std::string_view next()
    {
        keyword_ = text_.next_statement();
        std::transform(keyword_.begin(), keyword_.end(), keyword_.begin(),
                       [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
        return keyword_;
    }
    // Some programs write comments between facets. A file of nothing else is none.
    void ignore()
    {
        if (!repairs_.allowed || (facets_.object.empty() && repairs_.lines == k_most_lines))
            text_.fail(fmt::format("expected a facet, found '{}'", shown(keyword_)));
        if (repairs_.lines++ == 0) repairs_.first_line = text_.line();
    }
    void expect(const char* keyword)
    {
        if (next() != keyword) text_.fail(fmt::format("expected '{}', found '{}'", keyword, shown(keyword_)));
    }

    void facet()
    {
        if (facets_.names.empty()) facets_.names.emplace_back();
        if (facets_.object.size() == k_most_facets) text_.fail("too many facets");
        expect("outer");   // loop
        glm::vec3 p[3];
        bool finite = true;
        for (glm::vec3& corner : p) {
            expect("vertex");
            for (int k = 0; k < 3; ++k) {
                if (repairs_.allowed && text_.skip_not_finite()) {
                    finite = false;
                    continue;
                }
                corner[k] = text_.number("a coordinate");
                if (std::abs(corner[k]) > k_largest_coordinate) text_.fail("coordinate is out of range");
            }
        }
        expect("endloop");
        expect("endfacet");
        if (!finite) {
            ++repairs_.not_finite;
            return;
        }
        facets_.corners.insert(facets_.corners.end(), std::begin(p), std::end(p));
        facets_.object.push_back(static_cast<std::uint32_t>(facets_.names.size() - 1));
    }

    ObjText& text_;
    Repairs& repairs_;
    std::string keyword_;
    Facets facets_;
};

// Gives corners at the same place one number.
ObjData shared_corners(Facets facets)
{
    const std::vector<glm::vec3>& p = facets.corners;
    for (glm::vec3& corner : facets.corners) corner += glm::vec3(0);   // -0 is 0
    std::vector<std::uint32_t> order(p.size());
    std::iota(order.begin(), order.end(), 0u);
    std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
        return std::tie(p[a].x, p[a].y, p[a].z, a) < std::tie(p[b].x, p[b].y, p[b].z, b);
    });
    ObjData data;
    std::vector<std::uint32_t> number(p.size());
    for (std::size_t i = 0; i < order.size(); ++i) {
        if (i == 0 || p[order[i]] != p[order[i - 1]]) data.positions.push_back(p[order[i]]);
        number[order[i]] = static_cast<std::uint32_t>(data.positions.size() - 1);
    }
    data.corners.resize(p.size());
    for (std::size_t i = 0; i < p.size(); ++i) data.corners[i].position = number[i];
    for (std::uint32_t f = 0; f < facets.object.size(); ++f)
        data.faces.push_back({3 * f, 3, facets.object[f], 0, ObjFace::k_unset});
    data.materials.emplace_back();
    data.objects = std::move(facets.names);
    return data;
}

Facets read_facets(std::span<const std::uint8_t> bytes, const std::string& file, Repairs& repairs,
                   std::vector<std::string>& warnings)
{
    // Binary files may begin with "solid", too: the length decides.
    const bool has_header = bytes.size() >= k_header;
    const std::uint64_t claimed =
        has_header ? k_header + std::uint64_t{k_facet} * u32_at(bytes.data() + k_header - 4) : 0;
    const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    const std::size_t mark = text.starts_with("\xef\xbb\xbf") ? 3 : 0;   // a byte order mark
    const std::size_t first = std::min(text.find_first_not_of(" \t\r\n", mark), text.size());
    std::string word(text.substr(first, 5));
    std::transform(word.begin(), word.end(), word.begin(),
                   [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
    const std::uint32_t declared = has_header ? u32_at(bytes.data() + k_header - 4) : 0;
    if (has_header && claimed == bytes.size()) return read_binary(bytes, file, declared, repairs);
    if (word == "solid") {
        ObjText source(file, text, repairs.allowed);
        Facets facets = TextReader(source, repairs).read();
        if (std::string commas = source.comma_warning(); !commas.empty()) warnings.push_back(std::move(commas));
        return facets;
    }
    if (!has_header) throw InputError(file, "byte 0", "is neither text that begins with 'solid' nor a binary STL");
    // Programs that write while they compute do not know the number of facets, and leave 0 or the largest one.
    constexpr std::uint32_t k_unknown = 0xffffffff;
    if ((declared == 0 || declared == k_unknown) && bytes.size() > k_header &&
        (bytes.size() - k_header) % k_facet == 0) {
        warnings.push_back(fmt::format("declares {} facets: {} are read, as many as the file holds", declared,
                                       (bytes.size() - k_header) / k_facet));
        return read_binary(bytes, file, (bytes.size() - k_header) / k_facet, repairs);
    }
    if (claimed > bytes.size())
        throw InputError(
            file, "byte 80",
            fmt::format("declares {} facets in {} bytes, but the file has {}", declared, claimed, bytes.size()));
    warnings.push_back(fmt::format("{} bytes behind the last facet are ignored", bytes.size() - claimed));
    return read_binary(bytes, file, declared, repairs);
}

}   // namespace

scene::Scene load_stl(const std::filesystem::path& file, const Progress& progress, const ReadOptions& options)
{
    Interruption interruption(progress);
    const InterruptionScope scope(progress ? &interruption : Interruption::current());
    report_progress("loading", 0);
    scene::Scene scene;
    scene.name = file.stem().string();
    ObjData data;
    {
        const std::vector<std::uint8_t> bytes = read_whole_file(file, file.string(), k_largest_stl);
        Repairs repairs{.allowed = !options.strict};
        data = shared_corners(read_facets(bytes, file.string(), repairs, scene.warnings));
        repairs.warn(scene.warnings);
    }
    scene::Material material;
    material.name = "default";
    material.base_color = glm::vec3(k_grey);
    material.double_sided = true;   // many files have facets that are turned inside out
    scene.materials.push_back(material);
    // Objects without facets make no meshes.
    std::vector<char> used(data.objects.size(), 0);
    for (const ObjFace& face : data.faces) used[face.object] = 1;
    std::vector<std::uint32_t> kept(data.objects.size(), 0);
    std::vector<std::string> names;
    for (std::size_t i = 0; i < used.size(); ++i) {
        kept[i] = static_cast<std::uint32_t>(names.size());
        if (used[i]) names.push_back(std::move(data.objects[i]));
    }
    for (ObjFace& face : data.faces) face.object = kept[face.object];
    data.objects = std::move(names);
    add_obj_meshes(scene, data, {0}, {});
    scene::leave_out_repeats(scene);
    scene.finish();
    return scene;
}

}   // namespace gnomon::io
