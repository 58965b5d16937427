// SPDX-License-Identifier: Apache-2.0
#pragma once
// Cuts the light tree for cache points and sums their visible nodes in compute shaders: the PointDevice on Vulkan.
//
// The tree, its flux and the visible nodes of each point are kept on the device. A frame sends the flux of changed
// nodes and the spheres around dynamic objects. A batch of points sends 32 bytes per new point and 20 per summed point,
// and reads back the cuts, and 36 bytes per sum. Sums are made in a fixed order, so they are repeatable on one device;
// they equal those of the CPU up to rounding (tests/crosscheck/gpu_points_test.cpp).

#include <memory>

#include "irradiance_cache/points/point_device.h"
#include "irradiance_cache/vulkan/points_shared.h"
#include "ray/vulkan/device_rays.h"
#include "vk/commands.h"

namespace gnomon::irradiance_cache {

class GpuPoints : public PointDevice {
 public:
    /// @throws MissingError  if the device has too little memory; so do the other functions
    explicit GpuPoints(const std::shared_ptr<vk::Device>& device);

    void begin_frame(const LightTree& tree, const MovingSpheres& dynamic_bounds) override;
    void cut(std::span<const CutRequest> points, const CutOptions& options, PointCuts& cuts) override;
    void keep(std::span<const SeenNode> seen, std::span<KeptNodes> lists) override;
    void forget(const KeptNodes& list) override;
    void sum(std::span<const SumRequest> points, PointSums& sums) override;
    /// Including rays().
    std::size_t bytes() const override;

    /// Traces rays from now on. Both must follow the scene, with their commands completed, before rays are traced.
    void trace_with(std::unique_ptr<ray::DeviceRays> rays, const gpu_scene::GpuScene& scene);
    ray::DeviceRays* rays() { return rays_.get(); }
    bool traces() const override { return rays_ != nullptr; }
    void occluded(const ray::RayQueue& rays, std::uint8_t* occluded, ray::Against against) override;

    /// Number of cuts so far that were too long for the device, and made by the CPU.
    std::uint64_t long_cuts() const { return long_cuts_; }

 private:
    void send_tree(const LightTree& tree);
    void send_flux(const LightTree& tree);
    void send_spheres(const MovingSpheres& dynamic_bounds);
    vk::Buffer& fitting(vk::Buffer& buffer, const char* name, std::size_t bytes);
    void dispatch_sum(std::uint32_t points);
    std::uint32_t take(std::uint32_t count);

    std::shared_ptr<vk::Device> device_;
    vk::Commands commands_;
    vk::Pipeline cut_, sum_, flux_pipeline_;
    const LightTree* tree_ = nullptr;
    std::uint32_t geometry_version_ = 0;   // of the tree on the device
    std::uint32_t roots_count_ = 0, spheres_count_ = 0;
    std::vector<shared::GpuMovingSphere> spheres_host_;
    vk::Buffer quads_, children_, roots_, places_, flux_, spheres_, changed_;
    vk::Buffer requests_, cuts_, count_, nodes_, own_nodes_, lights_, crossed_;
    // Lists of visible nodes. Free places are kept by length in steps; everything from `end_` on is free.
    vk::Buffer store_;
    std::uint32_t end_ = 0;
    std::vector<std::vector<std::uint32_t>> free_;
    std::uint64_t long_cuts_ = 0;
    std::unique_ptr<ray::DeviceRays> rays_;   // null: the device traces none
    const gpu_scene::GpuScene* scene_ = nullptr;
};

}   // namespace gnomon::irradiance_cache
