// SPDX-License-Identifier: Apache-2.0
#pragma once
// Occlusion tests like RayScene::occluded(), with the device's ray-tracing pipelines. (Not with ray queries, which some
// devices lack.)
//
// There is a BLAS for each rigid mesh, for each deforming object, and for each static object with a singular transform
// (which no instance can have); and one TLAS over all objects, whose instance masks separate static from dynamic
// objects as RayScene does. They are built over the vertices of GpuScene. Opaque triangles end a ray at once, masked
// ones call the any-hit shader to find holes, transparent ones are left out.
//
// Results differ from those of RayScene where a ray hits an edge within rounding, because devices intersect triangles
// and transform instances with their own arithmetic.
//
// Cost of update(): the objects that deformed, and a new TLAS if anything changed. occluded() transfers 32 bytes per
// ray to the device and 4 bytes back.

#include "gpu_scene/gpu_scene.h"
#include "ray/ray_scene.h"
#include "ray/vulkan/rays_shared.h"

namespace gnomon::ray {

class DeviceRays {
 public:
    /// Rays that are transferred at once.
    static constexpr std::uint32_t k_rays_at_once = 1u << 20;

    static bool supported(const vk::Device& device) { return device.traces_rays(); }

    /// Builds everything and waits. @pre supported(*device)
    /// @throws MissingError  too little device memory, or more objects than the device supports
    DeviceRays(const std::shared_ptr<vk::Device>& device, const gpu_scene::GpuScene& scene,
               const scene::SceneState& state);

    /// Records the builds that follow one advance() of the state. Call after GpuScene::update.
    void update(vk::Commands& commands, const gpu_scene::GpuScene& scene, const scene::SceneState& state);

    /// Sets out[i] to 1 where a surface that blocks light lies between the ends of ray i, else to 0. Submits once per
    /// k_rays_at_once rays.
    /// @param against  `one_tree` is the same as `everything`
    void occluded(vk::Commands& commands, const gpu_scene::GpuScene& scene, const ray::RayQueue& rays,
                  std::uint8_t* out, ray::Against against = ray::Against::everything);

    /// Work of the last update, or of the constructor.
    struct Work {
        std::uint64_t bottom_levels = 0, top_levels = 0, instances = 0;   // instances: placed ones
    };
    const Work& work() const { return work_; }
    std::size_t bytes() const;

 private:
    /// A run of a mesh's triangles: opaque ones, or those of one masked part.
    struct Run {
        std::uint32_t first_triangle = 0, triangles = 0;
        scene::MaterialId material = 0;
        bool opaque = true;
    };
    struct Bottom {
        scene::ObjectId object = scene::none;   // whose triangles, or whose mesh's
        std::uint32_t matrix = scene::none;     // that transforms its vertices, if any
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
    std::vector<std::uint32_t> bottom_of_mesh_, bottom_of_object_;   // `object`: a BLAS of its own
    std::vector<std::uint32_t> rigid_, deforming_;                   // indices into bottoms_
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
