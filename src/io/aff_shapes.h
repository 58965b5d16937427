// SPDX-License-Identifier: Apache-2.0
#pragma once
// Meshes from AFF's primitives: corners with their own indices become vertices, curved things become triangles.

#include <cstdint>
#include <unordered_map>

#include "scene/mesh.h"

namespace gnomon::io {

/// How finely spheres and cones are cut.
struct AffTessellation {
    int around = 48;   // segments of a circle
    int rings = 24;    // of a sphere, pole to pole
};

/// Collects triangles of one material; equal corners become one vertex.
class AffMeshBuilder {
 public:
    struct Corner {
        glm::vec3 position{0}, normal{0};
        glm::vec2 uv{0};
    };
    AffMeshBuilder(bool normals, bool uvs) : normals_(normals), uvs_(uvs) {}

    void add_triangle(const Corner (&corner)[3]);
    /// A convex polygon, as a fan.
    void add_polygon(const std::vector<Corner>& corners);
    std::size_t triangles() const { return mesh_.triangles.size(); }
    scene::Mesh take(scene::MaterialId material);

 private:
    std::uint32_t vertex(const Corner& corner);
    bool normals_, uvs_;
    scene::Mesh mesh_;
    std::unordered_map<std::string, std::uint32_t> known_;
};

/// Negative radius: only the inside is seen.
scene::Mesh aff_sphere(const glm::dvec3& centre, double radius, const AffTessellation& fineness);
/// Open at both ends. Both radii negative: only the inside is seen.
scene::Mesh aff_cone(const glm::dvec3& base, double base_radius, const glm::dvec3& apex, double apex_radius,
                     const AffTessellation& fineness);

}   // namespace gnomon::io
