// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/check.h"
#include "io/gltf/build.h"
#include "scene/mesh_repairs.h"

namespace gnomon::io::gltf {

namespace {

constexpr int k_triangles = 4, k_strip = 5, k_fan = 6;
constexpr int k_joint_sets = 2;   // eight joints per vertex

// Vertices and triangles of one primitive, before it is merged into its mesh.
struct Piece {
    std::vector<glm::vec3> positions, normals;
    std::vector<glm::vec4> tangents, colors;
    std::vector<glm::vec2> texcoords[2];
    std::vector<glm::u16vec4> joints[k_joint_sets];
    std::vector<glm::vec4> weights[k_joint_sets];
    std::vector<scene::MorphTarget> targets;
    std::vector<glm::uvec3> triangles;
};

template <class T>
void spread(std::vector<T>& values, const std::vector<glm::uvec3>& triangles)
{
    if (values.empty()) return;
    std::vector<T> out;
    out.reserve(triangles.size() * 3);
    for (const glm::uvec3& t : triangles)
        for (int k = 0; k < 3; ++k) out.push_back(values[t[k]]);
    values = std::move(out);
}

// Gives each triangle its own vertices with its normal, as glTF requires where normals are missing.
void make_flat(Piece& p)
{
    spread(p.positions, p.triangles);
    spread(p.colors, p.triangles);
    for (int set = 0; set < 2; ++set) {
        spread(p.texcoords[set], p.triangles);
        spread(p.joints[set], p.triangles);
        spread(p.weights[set], p.triangles);
    }
    for (scene::MorphTarget& target : p.targets) spread(target.positions, p.triangles);
    p.tangents.clear();
    p.normals.clear();
    for (std::uint32_t t = 0; t < p.triangles.size(); ++t) {
        p.triangles[t] = {3 * t, 3 * t + 1, 3 * t + 2};
        const glm::vec3 n =
            glm::cross(p.positions[3 * t + 1] - p.positions[3 * t], p.positions[3 * t + 2] - p.positions[3 * t]);
        const float length = glm::length(n);
        const bool proper = length > 0 && std::isfinite(length);
        p.normals.insert(p.normals.end(), 3, proper ? n / length : glm::vec3(0, 0, 1));
    }
}

class PieceReader {
 public:
    PieceReader(const Model& model, const Data& data, std::uint64_t& bytes_left, Context& context)
        : model_(model), data_(data), bytes_left_(bytes_left), context_(context)
    {
    }

    Piece read(const Primitive& p, const std::string& here)
    {
        Piece piece;
        const std::string attributes = at(here, "attributes");
        piece.positions = vec3(p.find("POSITION"), at(attributes, "POSITION"));
        if (p.has("NORMAL")) {
            piece.normals = vec3(p.find("NORMAL"), at(attributes, "NORMAL"));
            for (glm::vec3& n : piece.normals) n = scene::unit_or(n, glm::vec3(0));
        }
        if (p.has("TANGENT") && p.has("NORMAL")) {
            piece.tangents = vec4(p.find("TANGENT"), at(attributes, "TANGENT"), 1);
            for (std::size_t i = 0; i < piece.tangents.size(); ++i) {
                glm::vec4& t = piece.tangents[i];
                const glm::vec3 across =
                    i < piece.normals.size() ? scene::perpendicular_to(piece.normals[i]) : glm::vec3(1, 0, 0);
                t = glm::vec4(scene::unit_or(glm::vec3(t), across), t.w < 0 ? -1 : 1);
            }
        }
        for (int set = 0; set < 2; ++set) {
            const std::string name = fmt::format("TEXCOORD_{}", set);
            if (p.has(name.c_str())) piece.texcoords[set] = vec2(p.find(name), at(attributes, name));
        }
        if (p.has("COLOR_0")) piece.colors = colors(p, at(attributes, "COLOR_0"));
        read_influences(p, attributes, piece);
        for (std::size_t t = 0; t < p.targets.size(); ++t) {
            const std::string place = at(at(here, "targets"), t);
            scene::MorphTarget target;
            const auto part = [&](const char* name) {
                const auto found = p.targets[t].find(name);
                return found == p.targets[t].end() ? std::vector<glm::vec3>() : vec3(found->second, at(place, name));
            };
            target.positions = part("POSITION");
            if (!piece.normals.empty()) target.normals = part("NORMAL");
            if (!piece.tangents.empty()) target.tangents = part("TANGENT");
            piece.targets.push_back(std::move(target));
        }
        read_triangles(p, here, piece);
        scene::fill_normals(piece.positions, piece.triangles, piece.normals);
        return piece;
    }

 private:
    // Subtracts the memory that an accessor will need from the limit.
    const Accessor& open(Index index, const std::string& pointer)
    {
        const Accessor& accessor = model_.accessors[index];
        if (const std::string reason = data_.unreachable(accessor); !reason.empty())
            context_.fail(pointer, fmt::format("accessor {} {}", index, reason));
        spend(accessor.count, 4 * static_cast<std::uint64_t>(accessor.components()), pointer);
        if (!data_.has_bytes(accessor))
            context_.warn(pointer, fmt::format("accessor {} has no data: zeros are used", index));
        return accessor;
    }
    void spend(std::uint64_t count, std::uint64_t each, const std::string& pointer)
    {
        if (count > bytes_left_ / each)
            context_.fail(pointer, fmt::format("{} elements are far more than the size of the file allows", count));
        bytes_left_ -= count * each;
    }

    // Some exporters leave colours zero, opacity included, where nobody painted a surface; on an opaque one they would
    // show black. Where opacity is zero beside any other colour, it means nothing. Strictly, all count as they are.
    std::vector<glm::vec4> colors(const Primitive& p, const std::string& pointer)
    {
        std::vector<glm::vec4> result = vec4(p.find("COLOR_0"), pointer, 1);
        const bool opaque = p.material == k_absent || model_.materials[p.material].alpha_mode == "OPAQUE";
        const auto is_sound = [](const glm::vec4& color) { return color.w > 0 || color == glm::vec4(0); };
        if (context_.strict() || !opaque || !std::ranges::all_of(result, is_sound)) return result;
        for (glm::vec4& color : result) {
            if (color != glm::vec4(0)) continue;
            context_.repair(Fault::empty_colors, pointer, [] { return std::string(); });
            color = glm::vec4(1);
        }
        return result;
    }

    const std::vector<float>& floats(Index index, const std::string& pointer)
    {
        const Accessor& accessor = open(index, pointer);
        data_.read(accessor, floats_);
        return floats_;
    }
    std::vector<glm::vec2> vec2(Index index, const std::string& pointer)
    {
        const std::vector<float>& f = floats(index, pointer);
        std::vector<glm::vec2> out(f.size() / 2);
        for (std::size_t i = 0; i < out.size(); ++i) out[i] = {f[2 * i], f[2 * i + 1]};
        return out;
    }
    std::vector<glm::vec3> vec3(Index index, const std::string& pointer)
    {
        const std::vector<float>& f = floats(index, pointer);
        std::vector<glm::vec3> out(f.size() / 3);
        for (std::size_t i = 0; i < out.size(); ++i) out[i] = {f[3 * i], f[3 * i + 1], f[3 * i + 2]};
        return out;
    }
    // Three components (colours) are extended by `last`.
    std::vector<glm::vec4> vec4(Index index, const std::string& pointer, float last)
    {
        const std::vector<float>& f = floats(index, pointer);
        const bool four = model_.accessors[index].shape == Shape::vec4;
        const std::size_t stride = four ? 4 : 3;
        std::vector<glm::vec4> out(f.size() / stride);
        for (std::size_t i = 0; i < out.size(); ++i)
            out[i] = {f[stride * i], f[stride * i + 1], f[stride * i + 2], four ? f[stride * i + 3] : last};
        return out;
    }

    void read_influences(const Primitive& p, const std::string& attributes, Piece& piece)
    {
        if (p.has("JOINTS_2")) context_.warn(attributes, "more than eight joints per vertex: the others are ignored");
        for (int set = 0; set < k_joint_sets; ++set) {
            const std::string name = fmt::format("JOINTS_{}", set);
            if (!p.has(name.c_str())) break;
            data_.read(open(p.find(name), at(attributes, name)), integers_);
            piece.joints[set].resize(integers_.size() / 4);
            for (std::size_t i = 0; i < piece.joints[set].size(); ++i)
                for (int k = 0; k < 4; ++k)
                    piece.joints[set][i][k] =
                        static_cast<std::uint16_t>(integers_[4 * i + static_cast<std::size_t>(k)]);
            const std::string other = fmt::format("WEIGHTS_{}", set);
            piece.weights[set] = vec4(p.find(other), at(attributes, other), 0);
        }
        scene::normalize_weights(piece.weights, -1);
    }

    void read_triangles(const Primitive& p, const std::string& here, Piece& piece)
    {
        const std::uint64_t vertices = piece.positions.size();
        if (p.indices != k_absent) {
            const std::string pointer = at(here, "indices");
            data_.read(open(p.indices, pointer), integers_);
            for (const std::uint32_t i : integers_)
                if (i >= vertices)
                    context_.fail(pointer, fmt::format("refers to vertex {}, but there are {}", i, vertices));
        } else {
            spend(vertices, 4, here);
            integers_.resize(vertices);
            for (std::uint32_t i = 0; i < vertices; ++i) integers_[i] = i;
        }
        const std::vector<std::uint32_t>& v = integers_;
        const bool whole = p.mode == k_triangles ? v.size() % 3 == 0 : v.size() >= 3;
        if (!whole) context_.warn(here, fmt::format("{} vertices are not a multiple of whole triangles", v.size()));
        if (v.size() < 3) return;
        // Count the vertices that triangles without normals will get.
        constexpr std::uint64_t own_vertex_bytes = 32;
        spend(v.size(), sizeof(glm::uvec3) + (p.has("NORMAL") ? 0 : own_vertex_bytes), here);
        if (p.mode == k_triangles)
            for (std::size_t i = 0; i + 2 < v.size(); i += 3) piece.triangles.emplace_back(v[i], v[i + 1], v[i + 2]);
        // [glTF 2.0, 3.7.2.1]: every second triangle of a strip is reversed. Triangles that join strips have no area.
        const auto add = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
            if (a != b && b != c && c != a) piece.triangles.emplace_back(a, b, c);
        };
        if (p.mode == k_strip)
            for (std::size_t i = 0; i + 2 < v.size(); ++i) add(v[i], v[i + 1 + i % 2], v[i + 2 - i % 2]);
        if (p.mode == k_fan)
            for (std::size_t i = 1; i + 1 < v.size(); ++i) add(v[i], v[i + 1], v[0]);
    }

    const Model& model_;
    const Data& data_;
    std::uint64_t& bytes_left_;
    Context& context_;
    std::vector<float> floats_;
    std::vector<std::uint32_t> integers_;
};

// Appends one array of a piece to the mesh's. Pieces without this array are filled with `fill`.
template <class T>
void append(std::vector<T>& out, const std::vector<T>& in, bool any, std::size_t before, std::size_t count,
            const T& fill)
{
    if (!any) return;
    GNOMON_CHECK_EQ(out.size(), before);
    if (in.empty())
        out.resize(before + count, fill);
    else
        out.insert(out.end(), in.begin(), in.end());
}

}   // namespace

Meshes::Meshes(const Model& model, const Data& data, Materials& materials, scene::Scene& out, Context& context)
    : model_(model), data_(data), materials_(materials), out_(out), context_(context)
{
    bytes_left_ = context.limits.geometry_bytes + context.limits.geometry_bytes_per_byte * data.total_bytes();
}

scene::MeshId Meshes::get(Index index)
{
    if (const auto made = made_.find(index); made != made_.end()) return made->second;
    scene::Mesh mesh = build(index);
    scene::MeshId id = scene::none;
    if (!mesh.triangles.empty()) {
        id = static_cast<scene::MeshId>(out_.meshes.size());
        out_.meshes.push_back(std::move(mesh));
    }
    return made_[index] = id;
}

scene::Mesh Meshes::build(Index index)
{
    const Mesh& source = model_.meshes[index];
    const std::string here = at("/meshes", index);
    scene::Mesh mesh;
    mesh.name = source.name;

    // Read the primitives that are made of triangles.
    std::vector<Piece> pieces;
    std::vector<Index> materials;
    std::vector<std::array<bool, 2>> has_texcoords;
    PieceReader reader(model_, data_, bytes_left_, context_);
    for (std::size_t i = 0; i < source.primitives.size(); ++i) {
        const Primitive& p = source.primitives[i];
        const std::string place = at(at(here, "primitives"), i);
        if (!p.has("POSITION")) continue;
        if (p.mode < k_triangles || p.mode > k_fan) {
            context_.warn(at(place, "mode"), "points and lines are not drawn");
            continue;
        }
        pieces.push_back(reader.read(p, place));
        materials.push_back(p.material);
        has_texcoords.push_back({p.has("TEXCOORD_0"), p.has("TEXCOORD_1")});
    }

    // Fill in arrays that only some primitives have, and compute missing normals.
    const auto any = [&](const auto& has) { return std::any_of(pieces.begin(), pieces.end(), has); };
    const auto all = [&](const auto& has) { return std::all_of(pieces.begin(), pieces.end(), has); };
    const bool normals = any([](const Piece& p) { return !p.normals.empty(); });
    if (normals)
        for (Piece& p : pieces)
            if (p.normals.empty()) make_flat(p);
    const bool tangents = all([](const Piece& p) { return !p.tangents.empty(); });
    const bool colors = any([](const Piece& p) { return !p.colors.empty(); });
    bool texcoords[2], joints[2];
    for (int set = 0; set < 2; ++set) {
        texcoords[set] = any([&](const Piece& p) { return !p.texcoords[set].empty(); });
        joints[set] = any([&](const Piece& p) { return !p.joints[set].empty(); });
    }
    if (joints[0]) mesh.skin.emplace();
    mesh.morph_targets.resize(pieces.empty() ? 0 : pieces.front().targets.size());
    struct Present {
        bool positions, normals, tangents;
    };
    std::vector<Present> present;
    for (std::size_t t = 0; t < mesh.morph_targets.size(); ++t) {
        const auto some = [&](auto member) {
            return any([&](const Piece& p) { return !(p.targets[t].*member).empty(); });
        };
        present.push_back({some(&scene::MorphTarget::positions), normals && some(&scene::MorphTarget::normals),
                           tangents && some(&scene::MorphTarget::tangents)});
    }

    for (std::size_t i = 0; i < pieces.size(); ++i) {
        Piece& p = pieces[i];
        const std::size_t before = mesh.positions.size(), count = p.positions.size();
        if (before + count > std::numeric_limits<std::uint32_t>::max()) context_.fail(here, "has too many vertices");
        mesh.positions.insert(mesh.positions.end(), p.positions.begin(), p.positions.end());
        append(mesh.normals, p.normals, normals, before, count, glm::vec3(0, 0, 1));
        append(mesh.tangents, p.tangents, tangents, before, count, glm::vec4(1, 0, 0, 1));
        append(mesh.colors, p.colors, colors, before, count, glm::vec4(1));
        for (int set = 0; set < 2; ++set) {
            append(mesh.texcoords[set], p.texcoords[set], texcoords[set], before, count, glm::vec2(0));
            if (!joints[set]) continue;
            append(mesh.skin->joints[set], p.joints[set], true, before, count, glm::u16vec4(0));
            append(mesh.skin->weights[set], p.weights[set], true, before, count, glm::vec4(set == 0 ? 1 : 0, 0, 0, 0));
        }
        for (std::size_t t = 0; t < mesh.morph_targets.size(); ++t) {
            scene::MorphTarget& target = mesh.morph_targets[t];
            const scene::MorphTarget& from = p.targets[t];
            append(target.positions, from.positions, present[t].positions, before, count, glm::vec3(0));
            append(target.normals, from.normals, present[t].normals, before, count, glm::vec3(0));
            append(target.tangents, from.tangents, present[t].tangents, before, count, glm::vec3(0));
        }
        if (p.triangles.empty()) continue;
        mesh.parts.push_back({materials_.get(materials[i], has_texcoords[i]),
                              static_cast<std::uint32_t>(mesh.triangles.size()),
                              static_cast<std::uint32_t>(p.triangles.size())});
        for (const glm::uvec3& t : p.triangles) mesh.triangles.push_back(t + static_cast<std::uint32_t>(before));
        p = {};   // frees its memory
    }
    if (!mesh.morph_targets.empty()) {
        mesh.morph_weights = source.weights.value_or(std::vector<float>());
        mesh.morph_weights.resize(mesh.morph_targets.size());
    }
    return mesh;
}

}   // namespace gnomon::io::gltf
