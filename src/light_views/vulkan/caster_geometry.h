// SPDX-License-Identifier: Apache-2.0
#pragma once
// The geometry of shadow casters on the device: positions, texture coordinates for alpha tests, triangles that occlude
// light, and a world matrix per object. Attributes for shading are not included.
//
// Meshes are stored once, even if instanced; a deforming object has its own vertices. Cost per frame: the matrices of
// objects that moved, the vertices of objects that deformed.

#include <span>

#include "light_views/vulkan/caster_shared.h"
#include "scene/state.h"
#include "vk/commands.h"

namespace gnomon::light_views {

class CasterGeometry {
 public:
    /// Creates the buffers; the first update fills them.
    /// @throws MissingError  too little device memory
    CasterGeometry(const std::shared_ptr<vk::Device>& device, const scene::SceneState& state);

    /// Call after each advance() of the state.
    void update(vk::Commands& commands, const scene::SceneState& state);

    /// Triangles of one material kind.
    struct Part {
        std::uint32_t first_index = 0, index_count = 0;
        std::uint32_t material = scene::none;   // alpha-tested: index into AlphaMaterial[]
    };
    /// All opaque triangles of an object, as one part (possibly empty).
    const Part& opaque(scene::ObjectId object) const { return meshes_[scene_->objects[object].mesh].opaque; }
    std::span<const Part> masked(scene::ObjectId object) const { return meshes_[scene_->objects[object].mesh].masked; }
    std::int32_t vertex_offset(scene::ObjectId object) const { return vertex_offset_[object]; }
    VkDrawIndexedIndirectCommand draw(scene::ObjectId object, const Part& part) const
    {
        return {part.index_count, 1, part.first_index, vertex_offset_[object], object};
    }

    /// Declares everything that a pass that draws casters reads.
    vk::Pass& declare(vk::Pass& pass) const;
    /// Binds vertex and index buffers, and the bindings of caster.vert; with `alpha` also those of alpha_test.glsl.
    void bind(vk::Recorder& recorder, bool alpha) const;

    /// For shaders that test the alpha of single triangles: CasterTexcoords, CasterIndices, CasterOffsets (first vertex
    /// by object), and the buffers of alpha_test.glsl.
    vk::Pass& declare_alpha(vk::Pass& pass) const;
    void bind_alpha(vk::Recorder& recorder) const;

    std::uint64_t uploaded_bytes() const { return uploaded_bytes_; }   // by the last update

 private:
    struct MeshParts {
        Part opaque;
        std::vector<Part> masked;
    };
    std::uint32_t alpha_material(const scene::Material& material, std::vector<std::uint8_t>& texels,
                                 std::vector<shared::AlphaMaterial>& records) const;
    void fill(vk::Commands& commands, const scene::SceneState& state);

    std::shared_ptr<const scene::Scene> scene_;
    std::vector<MeshParts> meshes_;
    std::vector<std::int32_t> vertex_offset_;   // by object
    vk::Buffer positions_, texcoords_, indices_, matrices_, offsets_, alpha_materials_, alpha_texels_;
    // Kept until the first update:
    std::vector<glm::vec3> first_positions_;
    std::vector<glm::vec2> first_texcoords_;
    std::vector<std::uint32_t> first_indices_;
    std::vector<shared::AlphaMaterial> first_alpha_;
    std::vector<std::uint8_t> first_texels_;
    bool filled_ = false;
    std::uint64_t uploaded_bytes_ = 0;
};

}   // namespace gnomon::light_views
