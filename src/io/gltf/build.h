// SPDX-License-Identifier: Apache-2.0
#pragma once
// Builds a scene from a checked document: meshes, materials with their textures, nodes with their attachments,
// animations. Only what the default scene references is built. The memory of geometry and images is bounded by the size
// of the file (see Limits), because an accessor or an image may be used often, and accessors without data need no bytes
// at all.

#include <array>
#include <map>
#include <span>
#include <tuple>
#include <vector>

#include "io/gltf/check.h"
#include "scene/scene.h"

namespace gnomon::io::gltf {

/// Converts materials of the document with their textures, each on first use.
class Materials {
 public:
    Materials(const Model& model, Data& data, scene::Scene& out, Context& context);
    /// @param material       or k_absent: the specification's default material
    /// @param has_texcoords  whether the primitive has TEXCOORD_0 and TEXCOORD_1; textures that need others are left
    /// out
    scene::MaterialId get(Index material, const std::array<bool, 2>& has_texcoords);

    /// What a material of the document became: one material, more if primitives lack some texture coordinates, or none.
    struct Made {
        scene::MaterialId id = scene::none;
        bool emits_nowhere = false;   // the texture that says where it emits is missing
    };
    std::vector<Made> made_of(Index material) const;

    /// Checks the headers of images that are not used.
    void check_unused();

 private:
    struct DecodedImage {
        bool read = false;   // without pixels after that: there is no such file, or its format is not known
        int width = 0, height = 0, channels = 0;
        Image8 image;   // empty where it was released
        bool usable() const { return width > 0; }
    };
    /// The image of a texture, whose pixels may have been released; null, with a warning, if it is left out.
    const DecodedImage* known_image_for(const TextureInfo& info, const std::string& pointer);
    /// The same with its pixels; valid until release_images().
    const Image8* image_for(const TextureInfo& info, const std::string& pointer);
    scene::Sampler sampler_for(const TextureInfo& info) const;
    scene::TextureUse use(const TextureInfo& info, bool srgb, bool alpha, const std::string& pointer);
    void use_layers(const Material& material, const std::string& pointer, scene::Material& out);
    void use_glossiness(const Glossiness& glossiness, bool alpha, const std::string& pointer, scene::Material& out);
    Index first_of(Index image);
    std::optional<std::vector<std::uint8_t>> bytes_of(Index image);   // nothing, with a warning, if it is remote
    DecodedImage& known_image(Index image);
    const Image8& decoded_image(Index image);
    void decode(Index image, std::span<const std::uint8_t> bytes, std::uint64_t most_pixels);
    bool is_at_hand(Index image) const;
    void decode_ahead(Index image, std::span<const std::uint8_t> bytes, std::uint64_t needed);
    void release_images();
    void make_room(std::uint64_t bytes, const std::string& pointer, const char* what);
    scene::TextureId add_texture(std::string name, const Image8& image, bool srgb, const scene::Sampler& sampler,
                                 bool without_alpha, std::uint64_t bytes, const std::string& pointer);

    const Model& model_;
    Data& data_;
    scene::Scene& out_;
    Context& context_;
    std::uint64_t pixels_left_ = 0, view_bytes_left_ = 0;
    // The id is scene::none until the material is made.
    std::map<std::pair<Index, std::array<bool, 2>>, Made> made_;   // by material and sets of textures left out
    scene::MaterialId default_ = scene::none;
    std::map<std::string, Index> by_source_;   // the first image with each source (a file or a range of a buffer)
    std::vector<Index> first_;                 // by image, filled on first use
    std::map<Index, DecodedImage> images_;     // by first image, like the textures
    std::uint64_t decoded_bytes_ = 0;          // of images_
    std::map<Index, Image8> ahead_;            // images that no material has asked for yet
    std::uint64_t ahead_bytes_ = 0;            // of these
    std::size_t next_ahead_ = 0;               // material whose images are looked at next for that
    std::map<std::tuple<Index, int, int, int, int, bool, bool>, scene::TextureId> textures_;
};

/// Converts meshes of the document, each on first use.
class Meshes {
 public:
    Meshes(const Model& model, const Data& data, Materials& materials, scene::Scene& out, Context& context);
    /// scene::none if no primitive of the mesh has triangles.
    scene::MeshId get(Index mesh);

 private:
    scene::Mesh build(Index mesh);

    const Model& model_;
    const Data& data_;
    Materials& materials_;
    scene::Scene& out_;
    Context& context_;
    std::uint64_t bytes_left_ = 0;
    std::map<Index, scene::MeshId> made_;
};

/// Adds the nodes of the default scene with meshes, skins, cameras and lights, then the animations.
/// @param animation  see ReadOptions
void build_scene(const Model& model, const Data& data, const std::vector<Index>& parent, Meshes& meshes,
                 const Materials& materials, const std::string& animation, scene::Scene& out, Context& context);

/// What nodes, lights and cameras of the document became in the scene.
struct PartIds {
    std::vector<scene::NodeId> nodes;                    // scene::none: not in the scene
    std::vector<std::vector<scene::LightId>> lights;     // one for each node with the light
    std::vector<std::vector<scene::CameraId>> cameras;   // likewise
};

/// @param chosen  the clip that plays, see ReadOptions::animation
/// @throws UsageError  there is no such clip
void build_animations(const Model& model, const Data& data, const PartIds& ids, const Materials& materials,
                      const std::string& chosen, scene::Scene& out, Context& context);

/// Translation, rotation and scale of a node; the identity for a node with a matrix.
scene::TransformParts rest_parts(const Node& node);

}   // namespace gnomon::io::gltf
