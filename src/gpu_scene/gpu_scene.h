// SPDX-License-Identifier: Apache-2.0
#pragma once
// The scene on the device: vertices, textures, materials, lights, objects, and one indirect draw for each part of each
// object, created once.
//
// update() follows one advance() of the state. It uploads the matrices of objects that moved, the vertices of objects
// that deformed, and the lights and materials that changed; static objects cost nothing (`touched` counts the updates).
// Culling runs on the device. Draws are sorted by pipeline state and then by object. The order is fixed, except that
// draws are sorted again when an object's matrix becomes mirrored or no longer is.

#include <memory>
#include <vector>

#include "gpu_scene/gpu_scene_shared.h"
#include "scene/state.h"
#include "vk/commands.h"

namespace gnomon::gpu_scene {

/// A range of draws with the same pipeline state.
struct DrawGroup {
    scene::SurfaceClass surface{};
    VkCullModeFlags cull = VK_CULL_MODE_NONE;   // of one-sided surfaces: the invisible side
    std::uint32_t first = 0, count = 0;
};

struct GpuSceneCounts {
    std::uint64_t touched = 0;          // objects and lights updated by the last update
    std::uint64_t bytes_uploaded = 0;   // by the last update
    std::uint64_t bytes = 0;            // on the device, in total
};

class GpuScene {
 public:
    /// Uploads everything and waits.
    /// @throws MissingError  the device has too little memory for it
    GpuScene(const std::shared_ptr<vk::Device>& device, const scene::SceneState& state);

    /// Records uploads of everything that the last advance() changed. Call once after every advance().
    void update(vk::Commands& commands, const scene::SceneState& state);

    /// Records the culling of all draws for a view; `commands_buffer` then holds one indirect draw for each.
    /// @param planes  six, with normals pointing inwards
    void cull(vk::Commands& commands, const glm::vec4 (&planes)[6]) const;

    const std::vector<DrawGroup>& groups() const { return groups_; }
    std::uint32_t draw_count() const { return static_cast<std::uint32_t>(draws_host_.size()); }
    bool has_transparent() const;
    /// The draws of one object: indices of GpuDraw and of indirect commands.
    const std::vector<std::uint32_t>& draws_of(scene::ObjectId object) const { return draws_of_[object]; }
    const shared::GpuDraw& draw(std::uint32_t number) const { return draws_host_[number]; }
    const shared::GpuObject& object(scene::ObjectId object) const { return objects_host_[object]; }
    const GpuSceneCounts& counts() const { return counts_; }
    const vk::Pipeline& cull_pipeline() const { return cull_; }

    // One vec3 per vertex, meshes concatenated (GpuObject::positions); each mesh's indices start at 0.
    vk::Buffer positions, normals, tangents, texcoords, colors, indices;
    vk::Buffer objects, draws, materials, layers, textures, texels, lights;
    vk::Buffer commands_buffer;   // VkDrawIndexedIndirectCommand by draw
    vk::Buffer counts_buffer;     // of the last culling: draws, triangles

    static constexpr VkFormat k_texel_format = VK_FORMAT_R16G16B16A16_SFLOAT;

 private:
    void lay_out(const scene::SceneState& state, std::vector<vk::Upload>& uploads);
    void place(const scene::SceneState& state, scene::ObjectId object);
    void sort_draws();
    void set_bounds(const scene::SceneState& state, scene::ObjectId object);

    std::shared_ptr<vk::Device> device_;
    std::shared_ptr<const scene::Scene> scene_;
    vk::Pipeline cull_;
    std::vector<shared::GpuObject> objects_host_;
    std::vector<shared::GpuDraw> draws_host_;
    std::vector<VkDrawIndexedIndirectCommand> commands_host_;
    std::vector<shared::GpuLight> lights_host_;
    std::vector<std::vector<std::uint32_t>> draws_of_;
    std::vector<DrawGroup> groups_;
    GpuSceneCounts counts_;
};

}   // namespace gnomon::gpu_scene
