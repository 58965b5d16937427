// SPDX-License-Identifier: Apache-2.0
#pragma once
// Builds a scene from AFF statements: the open transforms, the current material, and references by name.
//
// Each `m`, `s` or `c` is one object. Consecutive flat primitives (p, pp, tt, ttp, and tpa with the same key times)
// with one material below one transform become one mesh. Each transform (`xs`, `x`) is a node, and so is every mesh but
// the first below it.

#include <array>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <tuple>
#include <vector>

#include "io/aff/shapes.h"
#include "io/aff/tracks.h"
#include "scene/memory_budget.h"
#include "scene/scene.h"

namespace gnomon::io {

/// Limits on the memory of one scene.
struct AffSceneLimits {
    std::uint64_t max_triangles = 1ull << 25;         // instances counted
    std::uint64_t max_shape_triangles = 1ull << 22;   // of cones, which give many triangles for a few bytes
    std::size_t max_nodes = 1u << 20;
    std::size_t max_nesting = 256;             // open transforms
    double max_scale = k_aff_largest_number;   // product of all open transforms
};

/// One vertex of a flat primitive.
struct AffCorner {
    glm::vec3 position{0};
    glm::vec3 normal{0};
    glm::vec2 texcoord{0};
};

class AffBuilder {
 public:
    /// @param memory  bytes of textures
    AffBuilder(const AffSceneLimits& limits, const AffShapeOptions& shapes,
               std::uint64_t memory = scene::MemoryBudget::k_usual)
        : limits_(limits), shapes_(shapes), memory_(memory)
    {
    }

    /// Why the scene is too large, or empty. Call after every statement.
    std::string limit_exceeded() const;

    void set_material(const scene::Material& material);
    /// A number that is equal for equal materials, ignoring textures.
    std::uint32_t current_material();
    /// Adds the texture of an image file.
    /// @param shown_as  the file's name in messages
    scene::TextureId add_texture(const std::string& name, std::span<const std::uint8_t> file,
                                 const std::string& shown_as);

    /// @param shape  the matrix; `largest_scale`: the largest factor by which it can lengthen a vector
    void open_static(const glm::dmat4& shape, double largest_scale);
    void open_animated(const std::string& name);
    void close();
    std::size_t depth() const { return open_.size(); }
    std::size_t deepest() const { return deepest_; }

    /// Adds a flat primitive; `texture` may be none. Corners: counter-clockwise, at least three (a convex fan).
    void add_polygon(const std::vector<AffCorner>& corners, scene::TextureId texture, bool with_normals);
    /// Adds a triangle with three corners at each key time.
    void add_keyed_triangle(const std::vector<double>& times, const std::vector<std::array<AffCorner, 3>>& corners);
    /// Ends the current run of flat primitives. Call before any other statement.
    void flush();

    void add_sphere(const glm::dvec3& centre, double radius, bool inside);
    void add_cone(const glm::dvec3& base, double base_radius, const glm::dvec3& apex, double apex_radius, bool inside);
    /// @param mesh  without parts: all of it has the current material and this texture
    scene::MeshId add_mesh(scene::Mesh mesh, scene::TextureId texture);
    void add_instance(scene::MeshId mesh);

    void add_light(const glm::dvec3& position, const glm::vec3& color, const std::string& track_name);
    void set_camera(const scene::Camera& camera, const scene::TransformParts& place);
    void set_tracks(const std::string& name, AffTracks tracks) { tracks_[name] = std::move(tracks); }
    const std::map<std::string, AffTracks>& tracks() const { return tracks_; }

    /// The unfinished scene, for its plain values (background, ambient, timeline).
    scene::Scene& scene() { return scene_; }
    /// Resolves names of tracks, and finishes the scene.
    scene::Scene finish();

 private:
    struct Open {
        scene::NodeId node = scene::none;
        double scale = 1;
    };
    struct Run {
        scene::MaterialId material = scene::none;
        bool normals = false, texcoords = false;
        std::vector<double> times;
        scene::Mesh mesh;
    };
    struct Named {
        scene::NodeId node = scene::none;
        std::string name;
    };

    /// The current material with a texture, or with none.
    scene::MaterialId material(scene::TextureId texture);
    scene::NodeId parent() const { return open_.empty() ? scene::none : open_.back().node; }
    void open(std::string name, const glm::dmat4& matrix, double largest_scale);
    Run& run_of(scene::MaterialId material, bool normals, bool texcoords, const std::vector<double>& times);
    void place_tracks();
    void place_camera();

    AffSceneLimits limits_;
    AffShapeOptions shapes_;
    scene::MemoryBudget memory_;
    scene::Scene scene_;
    std::vector<Open> open_;
    std::size_t deepest_ = 0;
    double largest_scale_ = 1;
    std::uint64_t triangles_ = 0, shape_triangles_ = 0;
    std::uint32_t current_ = scene::none;   // index in plain_
    std::vector<scene::Material> plain_;    // distinct materials without their textures
    std::map<std::array<float, 12>, std::uint32_t> plain_by_values_;
    std::map<std::pair<std::uint32_t, scene::TextureId>, scene::MaterialId> materials_;
    // By mesh, transform, centre and radius: spheres in one place.
    std::map<std::tuple<scene::MeshId, scene::NodeId, std::array<double, 4>>, std::uint32_t> in_place_;
    std::size_t repeats_ = 0;                                               // spheres that were left out
    std::map<std::pair<scene::MaterialId, bool>, scene::MeshId> spheres_;   // by material, and whether seen from inside
    std::optional<Run> run_;
    std::vector<Named> animated_, animated_lights_;
    std::map<std::string, AffTracks> tracks_;
    std::optional<scene::Camera> camera_;
    scene::TransformParts camera_place_;
};

}   // namespace gnomon::io
