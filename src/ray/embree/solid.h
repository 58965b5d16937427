// SPDX-License-Identifier: Apache-2.0
#pragma once
// One object's triangles as Embree geometries: up to three, one a surface class, which share the vertices; with filters
// only where a material asks for them.

#include <array>
#include <deque>

#include "ray/embree/embree.h"
#include "ray/ray_scene.h"

namespace gnomon::ray {

/// What a filter must know of a geometry; lives as long as the geometry does.
struct GeometryRecord {
    const scene::Scene* scene = nullptr;
    const scene::Mesh* mesh = nullptr;
    scene::ObjectId object = scene::none;
    std::uint32_t first_triangle = 0;   // of the mesh; the geometry's triangle 0
    bool one_sided = false;             // some of its materials are
    bool mirrored = false;              // relative to the mesh's own winding, in the space the geometry is in
};

/// glTF's alpha mask: whether a masked surface has a hole at (1-u-v) p0 + u p1 + v p2. A hit counts where texture,
/// factor and vertex colour together reach the cutoff.
bool cut_away(const scene::Scene& scene, const scene::Mesh& mesh, const scene::Material& material,
              std::uint32_t triangle, float u, float v);

/// Vertices in the space of a tree, padded as Embree's loads need it.
struct BakedVertices {
    std::vector<glm::vec3> positions, normals;
    std::vector<glm::vec4> tangents;

    /// Copies arrays through a matrix; normals and tangents become unit. Empty arrays stay empty.
    void bake(const std::vector<glm::vec3>& from_positions, const std::vector<glm::vec3>& from_normals,
              const std::vector<glm::vec4>& from_tangents, const glm::dmat4& matrix);
    std::size_t bytes() const;
};

/// Attaches an object's geometries to a scene under ids that follow the records. Triangles keep the mesh's numbers.
/// @param vertices  must outlive the geometries and stay in place
/// @param records   gets one entry a geometry, at the index of its geometry id
/// @param quality   RTC_BUILD_QUALITY_REFIT for deforming meshes
void attach_object(RTCDevice device, RTCScene scene, const scene::Scene& description, scene::ObjectId object,
                   const BakedVertices& vertices, bool mirrored, std::deque<GeometryRecord>& records,
                   RTCBuildQuality quality = RTC_BUILD_QUALITY_MEDIUM);

}   // namespace gnomon::ray
