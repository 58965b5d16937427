// SPDX-License-Identifier: Apache-2.0
#pragma once
// Is something in the way? As RayScene::occluded() answers, by the device's own tracing of rays: ray-tracing pipelines,
// not ray queries, since there are devices without these.
//
// A bottom level for each mesh that is instanced, for each deforming object, and for what stands still squeezed flat
// (which no instance can be); one top level over all objects, whose masks tell what moves from what stands still, by
// the split of RayScene. They are built over GpuScene's own vertices: opaque triangles stop a ray at once, masked ones
// ask the any-hit shader for holes, transparent ones are left out.
//
// Against RayScene, answers differ where a ray meets an edge within rounding: devices test triangles and place
// instances by arithmetic of their own.
//
// update() costs what deformed, and a new top level if anything moved. occluded() takes 32 bytes to the device a ray
// and 4 back.

#include "gpu_scene/gpu_scene.h"
#include "ray/ray_scene.h"
#include "ray/vulkan/rays_shared.h"

namespace gnomon::ray {

class DeviceRays {
 public:
    /// Rays that are sent at once.
    static constexpr std::uint32_t k_rays_at_once = 1u << 20;

    static bool supported(const vk::Device& device) { return device.traces_rays(); }

    /// Builds everything and waits. @pre supported(*device)
    /// @throws MissingError  too little device memory, or more objects than the device takes
    DeviceRays(const std::shared_ptr<vk::Device>& device, const gpu_scene::GpuScene& scene,
               const scene::SceneState& state);

    /// Records what follows one advance() of the state. Call after GpuScene::update.
    void update(vk::Commands& commands, const gpu_scene::GpuScene& scene, const scene::SceneState& state);

    /// out[i] = 1 where something that blocks light lies between the ends of ray i, else 0. Submits, once for
    /// k_rays_at_once rays.
    /// @param against  `one_tree` is `everything`: it is one tree
    void occluded(vk::Commands& commands, const gpu_scene::GpuScene& scene, const ray::RayQueue& rays,
                  std::uint8_t* out, ray::Against against = ray::Against::everything);

    /// Built by the last update, or by the constructor.
    struct Work {
        std::uint64_t bottom_levels = 0, top_levels = 0, instances = 0;   // instances: that were placed
    };
    const Work& work() const { return work_; }
    std::size_t bytes() const;

 private:
    /// Triangles of a mesh that are alike: opaque ones, or those of one masked part.
    struct Run {
        std::uint32_t first_triangle = 0, triangles = 0;
        scene::MaterialId material = 0;
        bool opaque = true;
    };
    struct Bottom {
        scene::ObjectId object = scene::none;   // whose triangles, or those of its mesh
        std::uint32_t matrix = scene::none;     // that its vertices are moved by, if any
        bool deforming = false;
        vk::AccelerationStructure structure{};
        VkDeviceSize scratch = 0;
    };
    void find_runs();
    void make_bottoms(const gpu_scene::GpuScene& scene, const scene::SceneState& state);
    void make_top(const scene::SceneState& state);
    vk::StructureDesc describe(const gpu_scene::GpuScene& scene, const Bottom& bottom) const;
    vk::StructureDesc describe_top() const;
    void place(const scene::SceneState& state, scene::ObjectId object);
    void build_bottoms(vk::Commands& commands, const gpu_scene::GpuScene& scene, std::span<const std::uint32_t> which,
                       const vk::Buffer& storage, const vk::Buffer& scratch);
    void build_top(vk::Commands& commands, const vk::Buffer& scratch);
    bool broken(const scene::SceneState& state, scene::ObjectId object) const;
    vk::Buffer make_scratch(std::span<const std::uint32_t> for_bottoms) const;
    void make_room(std::uint32_t rays);

    std::shared_ptr<vk::Device> device_;
    std::shared_ptr<const scene::Scene> scene_;
    std::vector<std::vector<Run>> runs_;          // by mesh
    std::vector<std::uint32_t> first_geometry_;   // by mesh, in geometries_
    std::vector<Bottom> bottoms_;
    std::vector<std::uint32_t> bottom_of_mesh_, bottom_of_object_;   // of its own
    std::vector<std::uint32_t> rigid_, deforming_;                   // numbers of bottoms
    std::vector<VkAccelerationStructureInstanceKHR> instances_host_;
    std::vector<VkTransformMatrixKHR> matrices_host_;
    vk::AccelerationStructure top_;
    VkDeviceSize top_scratch_ = 0;

    std::shared_ptr<const vk::Buffer> rigid_storage_, deforming_storage_;   // null where there are none
    vk::Buffer instances_, matrices_, scratch_, first_geometries_, geometries_;
    vk::Buffer rays_, answers_, answers_host_;
    std::uint32_t room_ = 0;   // for rays
    vk::Pipeline pipeline_;
    Work work_;
};

}   // namespace gnomon::ray
