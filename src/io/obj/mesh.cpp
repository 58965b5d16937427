// SPDX-License-Identifier: Apache-2.0
#include "io/obj/mesh.h"

#include <algorithm>
#include <bit>

#include "base/interruption.h"
#include "gnomon/error.h"
#include "io/obj/polygon.h"

namespace gnomon::io {

namespace {

constexpr std::uint32_t k_faces_a_step = 1 << 12;   // between interruption points

// Corners with equal keys become one vertex.
struct VertexKey {
    std::uint32_t position, texcoord;
    glm::vec3 normal;
    std::uint32_t color = k_no_index;   // of the face
    friend bool operator==(const VertexKey&, const VertexKey&) = default;
};

std::uint64_t hash(const VertexKey& key)
{
    std::uint64_t h = (static_cast<std::uint64_t>(key.position) << 32) | key.texcoord;
    for (int i = 0; i < 3; ++i) {
        h = (h ^ (h >> 29)) * 0xbf58476d1ce4e5b9ull;
        h += std::bit_cast<std::uint32_t>(key.normal[i] + 0.0f);
    }
    h = ((h ^ (h >> 32)) + (key.color + 1)) * 0x94d049bb133111ebull;
    return h ^ (h >> 31);
}

// Vertices of one mesh by key: open addressing, at most half full. It grows with the vertices, which are a quarter of
// the corners in most files.
class VertexTable {
 public:
    std::uint32_t find_or_add(const VertexKey& key)
    {
        if (2 * keys_.size() >= slots_.size()) grow();
        std::uint32_t& slot = slot_of(key);
        if (slot == k_no_index) {
            slot = static_cast<std::uint32_t>(keys_.size());
            keys_.push_back(key);
        }
        return slot;
    }
    const std::vector<VertexKey>& keys() const { return keys_; }

 private:
    // The slot of a key, or the free one where it belongs.
    std::uint32_t& slot_of(const VertexKey& key)
    {
        const std::size_t mask = slots_.size() - 1;
        std::size_t at = hash(key) & mask;
        while (slots_[at] != k_no_index && !(keys_[slots_[at]] == key)) at = (at + 1) & mask;
        return slots_[at];
    }
    void grow()
    {
        slots_.assign(2 * slots_.size(), k_no_index);
        for (std::size_t i = 0; i < keys_.size(); ++i) slot_of(keys_[i]) = static_cast<std::uint32_t>(i);
    }

    std::vector<std::uint32_t> slots_ = std::vector<std::uint32_t>(16, k_no_index);   // a power of two
    std::vector<VertexKey> keys_;
};

// Faces of one object, sorted by material in order of first use.
std::vector<std::uint32_t> by_material(const ObjData& data, std::vector<std::uint32_t> faces,
                                       std::vector<std::uint32_t>& rank)
{
    std::vector<std::uint32_t> ranked;
    for (const std::uint32_t f : faces) {
        std::uint32_t& r = rank[data.faces[f].material];
        if (r == k_no_index) r = static_cast<std::uint32_t>(ranked.size()), ranked.push_back(data.faces[f].material);
    }
    if (ranked.size() > 1)
        std::stable_sort(faces.begin(), faces.end(), [&](std::uint32_t a, std::uint32_t b) {
            return rank[data.faces[a].material] < rank[data.faces[b].material];
        });
    for (const std::uint32_t material : ranked) rank[material] = k_no_index;
    return faces;
}

}   // namespace

void add_obj_meshes(scene::Scene& scene, const ObjData& data, const std::vector<scene::MaterialId>& material_of,
                    const ObjNormalOptions& options)
{
    std::vector<std::vector<std::uint32_t>> faces_of(data.objects.size());
    for (std::size_t f = 0; f < data.faces.size(); ++f)
        faces_of[data.faces[f].object].push_back(static_cast<std::uint32_t>(f));

    std::vector<std::uint32_t> positions_used(data.positions.size(), k_no_index);
    std::vector<std::uint32_t> material_rank(data.materials.size(), k_no_index);
    std::vector<glm::vec3> points;
    std::vector<std::uint32_t> index;
    PolygonTriangulator triangulator;
    std::uint32_t faces_done = 0;
    for (std::size_t o = 0; o < data.objects.size(); ++o) {
        interruption_point();
        // Sort the object's faces by material, and compute missing normals.
        const std::vector<std::uint32_t> faces = by_material(data, std::move(faces_of[o]), material_rank);
        const std::vector<glm::vec3> normals = corner_normals(data, faces, options, positions_used);

        scene::Mesh mesh;
        mesh.name = data.objects[o];
        VertexTable vertices;
        bool any_normal = false, any_texcoord = false;
        std::size_t corner = 0;
        // Triangulate the faces.
        for (const std::uint32_t f : faces) {
            if (++faces_done % k_faces_a_step == 0) interruption_point();
            const ObjFace& face = data.faces[f];
            const ObjCorner* const corners = &data.corners[face.first_corner];
            points.clear();
            for (std::uint32_t i = 0; i < face.corner_count; ++i) points.push_back(data.positions[corners[i].position]);
            const std::vector<glm::uvec3>& triangles = triangulator.triangulate(points);

            // A flat face among smooth ones needs its own normal at each corner.
            const glm::dvec3 newell = newell_normal(points);
            const double length = glm::length(newell);
            const glm::vec3 flat = length > 0 ? glm::vec3(newell / length) : glm::vec3(0, 1, 0);
            index.clear();
            for (std::uint32_t i = 0; i < face.corner_count; ++i, ++corner) {
                const bool given = normals[corner] != glm::vec3(0);
                any_normal |= given;
                any_texcoord |= corners[i].texcoord != k_no_index;
                index.push_back(vertices.find_or_add(
                    {corners[i].position, corners[i].texcoord, given ? normals[corner] : flat, face.color}));
            }
            // Start a new part with each material.
            if (mesh.parts.empty() || mesh.parts.back().material != material_of[face.material])
                mesh.parts.push_back(
                    {material_of[face.material], static_cast<std::uint32_t>(mesh.triangles.size()), 0});
            mesh.parts.back().triangle_count += static_cast<std::uint32_t>(triangles.size());
            for (const glm::uvec3& t : triangles) mesh.triangles.emplace_back(index[t.x], index[t.y], index[t.z]);
        }

        // Convert the distinct vertices to arrays, with v flipped.
        mesh.positions.reserve(vertices.keys().size());
        for (const VertexKey& key : vertices.keys()) {
            mesh.positions.push_back(data.positions[key.position]);
            if (any_normal) mesh.normals.push_back(key.normal);
            if (key.color != k_no_index)
                mesh.colors.push_back(data.face_colors[key.color]);
            else if (!data.colors.empty())
                mesh.colors.push_back(data.colors[key.position]);
            if (!any_texcoord) continue;
            const glm::vec2 t = key.texcoord == k_no_index ? glm::vec2(0) : data.texcoords[key.texcoord];
            mesh.texcoords[0].emplace_back(t.x, 1 - t.y);
        }
        const scene::NodeId node = scene.add_node(mesh.name, scene::none);
        scene.nodes[node].mesh = static_cast<scene::MeshId>(scene.meshes.size());
        scene.meshes.push_back(std::move(mesh));
    }
    if (triangulator.exhausted())
        scene.warnings.emplace_back("too many corners in concave polygons: some may be filled wrongly");
}

}   // namespace gnomon::io
