// SPDX-License-Identifier: Apache-2.0
#pragma once
// One object's triangles as Embree geometries: up to three, one per surface class, which share the vertices. Only
// geometries whose materials need it have filters.

#include <array>
#include <deque>

#include "ray/embree/embree.h"
#include "ray/ray_scene.h"

namespace gnomon::ray {

struct BakedVertices;

/// The data of a geometry for filters and hits; lives as long as the geometry.
struct GeometryRecord {
    const scene::Scene* scene = nullptr;
    const scene::Mesh* mesh = nullptr;
    scene::ObjectId object = scene::none;
    std::uint32_t first_triangle = 0;   // of the mesh: the geometry's triangle 0
    bool one_sided = false;             // at least one of its materials is
    bool mirrored = false;              // the winding in the geometry's space is the reverse of the mesh's
    const BakedVertices* vertices = nullptr;
    std::uint32_t triangles = 0;
    unsigned mask = 0;                    // the rays that meet it (embree.h)
    bool masked = false, thins = false;   // its materials have holes; let light through in part
    bool attached = true;                 // false: its object has left this tree
};

/// Vertices in the space of a tree, padded for Embree's loads.
struct BakedVertices {
    std::vector<glm::vec3> positions, normals;
    std::vector<glm::vec4> tangents;
    glm::vec3 axis{0, 0, -1};   // ObjectGeometry::axis

    /// Transforms and copies arrays; normalises normals and tangents. Empty arrays stay empty.
    void bake(const std::vector<glm::vec3>& from_positions, const std::vector<glm::vec3>& from_normals,
              const std::vector<glm::vec4>& from_tangents, const glm::dmat4& matrix);
    std::size_t bytes() const;
};

/// Attaches an object's geometries to a scene; their ids are the indices of their records. Triangles keep the mesh's
/// order.
/// @param scene     null: records alone are made
/// @param vertices  must outlive the geometries and stay in place
/// @param records   one entry per geometry is appended, at the index of its geometry id
/// @param quality   RTC_BUILD_QUALITY_REFIT for deforming meshes
void attach_object(RTCDevice device, RTCScene scene, const scene::Scene& description, scene::ObjectId object,
                   const BakedVertices& vertices, bool mirrored, std::deque<GeometryRecord>& records,
                   RTCBuildQuality quality = RTC_BUILD_QUALITY_MEDIUM);

}   // namespace gnomon::ray
