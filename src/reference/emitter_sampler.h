// SPDX-License-Identifier: Apache-2.0
#pragma once
// Samples points of emissive surfaces, for the path-traced reference.
//
// A triangle is chosen in proportion to its area times its mean emission, or for a surface point by a tree over all of
// them (source_tree.h), and a point of it uniformly. A triangle whose
// emission is textured counts with at least a small part of what its factor promises, and one whose texture is black
// where it was looked up may still shine elsewhere; so this is to be combined with cosine sampling, which reaches every
// surface, by the balance heuristic [Veach and Guibas 1995].
//
// Surfaces with back faces emit on both sides, others on the front. Unlit surfaces show a colour and emit nothing.
//
// Cost: one pass over the emissive triangles, and their tree; a sample is a binary search, or a way down the tree.

#include <unordered_map>
#include <vector>

#include "ray/ray_scene.h"
#include "reference/source_tree.h"
#include "shading/surface.h"

namespace gnomon::reference {

/// A point of an emissive triangle.
struct EmitterPoint {
    scene::ObjectId object = scene::none;
    std::uint32_t triangle = 0;   // of the object's mesh
    float u = 0, v = 0;           // of the triangle
    glm::vec3 position{0};
    float density = 0;   // per unit of area
};

class EmitterSampler {
 public:
    /// Collects the emissive triangles of visible objects.
    EmitterSampler(const scene::SceneState& state, const ray::RayScene& rays);

    bool empty() const { return sums_.empty(); }
    /// u, v, w in [0, 1). Not when empty().
    EmitterPoint sample(float u, float v, float w) const;
    /// The density per unit of area with which sample() returns a point of this triangle; 0 if it never does.
    float density(scene::ObjectId object, std::uint32_t triangle) const;

    /// The same for what may light a surface point. A density of 0: nothing does.
    /// @param normal  unit
    EmitterPoint sample_for(const glm::vec3& position, const glm::vec3& normal, double u, float v, float w) const;
    float density_for(const glm::vec3& position, const glm::vec3& normal, scene::ObjectId object,
                      std::uint32_t triangle) const;

    /// The sum over all triangles of area times mean luminance.
    double total() const { return sums_.empty() ? 0 : sums_.back(); }

    /// The radiance that a surface emits towards the viewer.
    static glm::vec3 emission(const shading::SurfacePoint& surface, const scene::Material& material);

 private:
    struct Triangle {
        scene::ObjectId object;
        std::uint32_t triangle;
        glm::vec3 corners[3];
        float density;   // per unit of area
        float area;
    };
    static EmitterPoint point_of(const Triangle& triangle, float v, float w);
    std::uint32_t number_of(scene::ObjectId object, std::uint32_t triangle) const;

    static constexpr std::uint32_t k_none = ~0u;
    std::vector<Triangle> triangles_;
    std::vector<double> sums_;   // of areas times luminances, up to and with each triangle
    std::unordered_map<scene::ObjectId, std::vector<std::uint32_t>> numbers_;   // by triangle of the mesh; k_none
    SourceTree tree_{std::span<const Source>{}};
};

}   // namespace gnomon::reference
