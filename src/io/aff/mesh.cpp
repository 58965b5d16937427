// SPDX-License-Identifier: Apache-2.0
#include "io/aff/mesh.h"

#include <fmt/format.h>

#include <algorithm>
#include <tuple>

namespace gnomon::io {

namespace {

// Reads n, then n vectors of 32-bit floats.
template <class Vector>
std::vector<Vector> read_vectors(AffTokens& tokens, std::size_t n, std::string_view meaning)
{
    std::vector<Vector> values(n);
    for (Vector& value : values)
        for (int c = 0; c < Vector::length(); ++c) value[c] = static_cast<float>(tokens.number(meaning));
    return values;
}

// A triangle's corner: its position, and the file's indices of position, normal and texture coordinate.
struct Corner {
    std::uint32_t position = 0, normal = 0, texcoord = 0;
    std::uint32_t place = 0;   // index in the list of corners
    auto key() const { return std::tie(position, normal, texcoord, place); }
    bool same_vertex(const Corner& other) const
    {
        return position == other.position && normal == other.normal && texcoord == other.texcoord;
    }
};

}   // namespace

glm::vec3 usable_normal(const glm::vec3& normal, const glm::vec3& a, const glm::vec3& b, const glm::vec3& c)
{
    for (const glm::vec3& n : {normal, glm::cross(b - a, c - a)}) {
        const float length = glm::length(n);
        if (length > 0 && std::isfinite(length)) return n / length;
    }
    return {0, 1, 0};
}

AffMesh read_aff_mesh(AffTokens& tokens)
{
    AffMesh result;

    // Read the blocks.
    tokens.expect("vertices");
    const auto positions =
        read_vectors<glm::vec3>(tokens, tokens.count("the number of vertices", 0, 3), "a coordinate");
    std::vector<glm::vec3> normals;
    std::vector<glm::vec2> texcoords;
    const bool has_normals = tokens.peek().text == "normals";
    if (has_normals) {
        tokens.take();
        normals = read_vectors<glm::vec3>(tokens, tokens.count("the number of normals", 0, 3), "a normal");
    }
    const bool has_texcoords = tokens.peek().text == "texturecoords";
    if (has_texcoords) {
        tokens.take();
        const std::size_t n = tokens.count("the number of texture coordinates", 0, 2);
        result.texture = tokens.word("a texture's name");
        texcoords = read_vectors<glm::vec2>(tokens, n, "a texture coordinate");
    }
    tokens.expect("triangles");
    const std::size_t tokens_each = 3u * (1u + has_normals + has_texcoords);
    const std::size_t n = tokens.count("the number of triangles", 0, tokens_each);

    const auto index = [&](std::size_t size, std::string_view meaning) {
        const AffToken at = tokens.peek();
        if (size == 0) tokens.fail(at, fmt::format("{} {} refers to an empty list", meaning, shown(at)));
        return static_cast<std::uint32_t>(tokens.integer(meaning, 0, static_cast<std::int64_t>(size) - 1));
    };
    std::vector<Corner> corners(3 * n);
    for (std::size_t t = 0; t < n; ++t) {
        Corner* const c = &corners[3 * t];
        for (std::uint32_t i = 0; i < 3; ++i) {
            c[i].place = static_cast<std::uint32_t>(3 * t + i);
            c[i].position = index(positions.size(), "vertex index");
        }
        for (int i = 0; i < 3 && has_normals; ++i) c[i].normal = index(normals.size(), "normal index");
        for (int i = 0; i < 3 && has_texcoords; ++i)
            c[i].texcoord = index(texcoords.size(), "texture coordinate index");
    }

    // Make a vertex of each distinct combination.
    std::vector<glm::vec3> at(corners.size());   // positions of the corners in file order
    for (const Corner& corner : corners) at[corner.place] = positions[corner.position];
    std::sort(corners.begin(), corners.end(), [](const Corner& x, const Corner& y) { return x.key() < y.key(); });
    scene::Mesh& mesh = result.mesh;
    mesh.triangles.resize(n);
    for (std::size_t i = 0; i < corners.size(); ++i) {
        const Corner& corner = corners[i];
        if (i == 0 || !corner.same_vertex(corners[i - 1])) {
            mesh.positions.push_back(positions[corner.position]);
            const glm::vec3* const triangle = &at[corner.place - corner.place % 3];
            if (has_normals)
                mesh.normals.push_back(usable_normal(normals[corner.normal], triangle[0], triangle[1], triangle[2]));
            if (has_texcoords) mesh.texcoords[0].push_back(texcoords[corner.texcoord]);
        }
        mesh.triangles[corner.place / 3][static_cast<int>(corner.place % 3)] =
            static_cast<std::uint32_t>(mesh.positions.size() - 1);
    }
    return result;
}

}   // namespace gnomon::io
