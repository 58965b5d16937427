// SPDX-License-Identifier: Apache-2.0
#pragma once
// From a checked document to a scene: meshes, materials with their textures, nodes with what hangs on them, animations.
// Only what the default scene reaches is built. What is built of geometry and images is bounded by the bytes that the
// file has (see Limits): an accessor or an image may be used often, and zeros need no bytes at all.

#include <map>
#include <tuple>
#include <vector>

#include "io/gltf/check.h"
#include "scene/scene.h"

namespace gnomon::io::gltf {

/// Materials of the document as those of the scene, with textures. Each is made when first asked for.
class Materials {
 public:
    Materials(const Model& model, Data& data, scene::Scene& out, Context& context);
    /// @param material  or k_absent: the specification's default
    scene::MaterialId get(Index material);

    /// Images that nothing uses are looked at all the same, as far as their headers go.
    void check_unused();

 private:
    struct DecodedImage {
        bool read = false;
        Image8 image;
    };
    scene::TextureUse use(const TextureInfo& info, bool srgb, bool alpha, const std::string& pointer);
    Index first_of(Index image);
    std::vector<std::uint8_t> bytes_of(Index image);
    const Image8& decoded_image(Index image);

    const Model& model_;
    Data& data_;
    scene::Scene& out_;
    Context& context_;
    std::uint64_t pixels_left_ = 0, view_bytes_left_ = 0;
    std::vector<scene::MaterialId> made_;
    scene::MaterialId default_ = scene::none;
    std::map<std::string, Index> by_source_;   // the first image of a file or a place in a buffer
    std::vector<Index> first_;                 // by image, once asked for
    std::map<Index, DecodedImage> images_;     // by first image, as textures are
    std::map<std::tuple<Index, int, int, int, int, bool, bool>, scene::TextureId> textures_;
};

/// Meshes of the document as those of the scene, each when first asked for.
class Meshes {
 public:
    Meshes(const Model& model, const Data& data, Materials& materials, scene::Scene& out, Context& context);
    /// scene::none if nothing of it is made of triangles.
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

/// Nodes of the default scene with meshes, skins, cameras and lights; then the animations.
void build_scene(const Model& model, const Data& data, const std::vector<Index>& parent, Meshes& meshes,
                 scene::Scene& out, Context& context);
/// @param node_ids  of the scene, by node of the document; scene::none: not in the scene
void build_animations(const Model& model, const Data& data, const std::vector<scene::NodeId>& node_ids,
                      scene::Scene& out, Context& context);

/// T R S of a node; of a matrix nothing.
scene::TransformParts rest_parts(const Node& node);

}   // namespace gnomon::io::gltf
