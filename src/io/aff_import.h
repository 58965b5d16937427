// SPDX-License-Identifier: Apache-2.0
#pragma once
// BART's AFF into a scene: the state machine that reads statements, and what it leaves for the end of the file. Private
// to this folder; load_aff in load.h is the way in.

#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <unordered_map>

#include "gnomon/types.h"
#include "io/aff_shapes.h"
#include "io/aff_text.h"
#include "scene/kochanek_track.h"
#include "scene/scene.h"

namespace gnomon::io {

/// Bounds on what included files may add up to: includes can multiply without a cycle.
struct AffLimits {
    int include_depth = 32;
    int brace_depth = 256;
    std::size_t files = 20'000;
    std::uint64_t bytes = 512ull << 20;
    std::uint64_t texture_bytes = 2ull << 30;
};

class AffImport {
 public:
    AffImport(const std::filesystem::path& main_file, const Progress& progress);
    scene::Scene run();

    /// Files read, each once, the main file included.
    std::size_t files_read() const { return seen_files_.size(); }

 private:
    struct Track {
        std::shared_ptr<scene::KochanekTrack> transform;
        std::shared_ptr<scene::VisibilityTrack> visibility;
    };
    // Primitives without a mesh of their own: those of one kind that follow each other share one.
    struct Loose {
        scene::NodeId parent;
        scene::MaterialId material;
        bool normals, uvs;
        AffMeshBuilder builder;
    };
    struct AnimatedTriangles {
        scene::NodeId parent;
        scene::MaterialId material;
        scene::Mesh mesh;
    };

    void read_file(const std::filesystem::path& file, const std::string& shown_as);
    void statement(AffText& text, std::string_view word, std::size_t base_depth);
    void read_view(AffText& text);
    void read_light(AffText& text, bool animated);
    void read_animation(AffText& text);
    void read_nff_material(AffText& text);
    void read_material(AffText& text);
    void read_sphere(AffText& text);
    void read_cone(AffText& text);
    void read_polygon(AffText& text, bool normals);
    void read_textured(AffText& text, bool normals);
    void read_animated_triangle(AffText& text);
    void read_mesh(AffText& text);
    void read_include(AffText& text);
    void read_static_transform(AffText& text);
    void read_animated_transform(AffText& text);
    void read_track(AffText& text);
    scene::VectorSpline read_vector_keys(AffText& text, std::size_t n);
    void close_transform(AffText& text, std::size_t base_depth);

    scene::NodeId open_node() const { return stack_.empty() ? scene::none : stack_.back(); }
    scene::MaterialId material(AffText& text, scene::TextureId texture = scene::none);
    scene::TextureId texture(AffText& text, const std::string& name);
    void add_mesh(scene::Mesh mesh, scene::NodeId parent);
    AffMeshBuilder& loose(scene::MaterialId material, bool normals, bool uvs);
    void flush();
    void flush_loose();
    void flush_animated();
    void place_camera();
    void attach_tracks();
    void warn(const std::string& warning);

    std::filesystem::path main_file_, folder_, texture_folder_;
    const Progress& progress_;
    AffLimits limits_;
    AffTessellation fineness_;
    scene::Scene scene_;

    std::vector<scene::NodeId> stack_;                // open transforms
    std::vector<std::filesystem::path> open_files_;   // includes, outermost first
    std::map<std::string, int> seen_files_;
    std::uint64_t bytes_read_ = 0, texture_bytes_ = 0;
    std::size_t includes_ = 0;
    long long detail_ = 0;
    std::optional<scene::Material> material_;
    std::map<std::string, scene::MaterialId> materials_;   // by their values
    std::map<std::string, scene::TextureId> textures_;     // by name
    std::map<std::string, Track> tracks_;
    std::vector<std::pair<scene::NodeId, std::string>> animated_nodes_, animated_lights_;
    std::optional<Loose> loose_;
    std::optional<AnimatedTriangles> animated_;

    struct View {
        glm::dvec3 from{0}, at{0, 0, -1}, up{0, 1, 0};
        double angle = 40, hither = 0.01;
        Size resolution{640, 480};
    };
    std::optional<View> view_;
};

}   // namespace gnomon::io
