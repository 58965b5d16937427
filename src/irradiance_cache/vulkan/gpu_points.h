// SPDX-License-Identifier: Apache-2.0
#pragma once
// Cuts and sums of surface points in compute shaders: the device's PointDevice.
//
// The tree, its flux and what each point sees lie on the device. A frame sends the flux of nodes that changed, and the
// spheres about what moves; a batch of points sends 32 bytes a new point and 20 a summed one, and brings back cuts, and
// 36 bytes a sum. Sums are made in one order: the same every time on one device, and the processor's up to rounding
// (tests/crosscheck/gpu_points_test.cpp).

#include <memory>

#include "irradiance_cache/points/point_device.h"
#include "irradiance_cache/vulkan/points_shared.h"
#include "ray/vulkan/device_rays.h"
#include "vk/commands.h"

namespace gnomon::irradiance_cache {

class GpuPoints : public PointDevice {
 public:
    /// @throws MissingError  too little device memory; so do the others
    explicit GpuPoints(const std::shared_ptr<vk::Device>& device);

    void begin_frame(const LightTree& tree, const MovingSpheres& dynamic_objects) override;
    void cut(std::span<const CutRequest> points, const CutOptions& options, PointCuts& cuts) override;
    void keep(std::span<const SeenNode> seen, std::span<KeptNodes> lists) override;
    void forget(const KeptNodes& list) override;
    void sum(std::span<const SumRequest> points, PointSums& sums) override;
    /// Of rays() as well.
    std::size_t bytes() const override;

    /// From now on it answers rays; both must follow the scene, with their commands done, whenever it is asked.
    void trace_with(std::unique_ptr<ray::DeviceRays> rays, const gpu_scene::GpuScene& scene);
    ray::DeviceRays* rays() { return rays_.get(); }
    bool traces() const override { return rays_ != nullptr; }
    void occluded(const ray::RayQueue& rays, std::uint8_t* occluded, ray::Against against) override;

    /// Cuts longer than the device had room for, which the processor made, so far.
    std::uint64_t long_cuts() const { return long_cuts_; }

 private:
    void send_tree(const LightTree& tree);
    void send_flux(const LightTree& tree);
    void send_spheres(const MovingSpheres& dynamic_objects);
    vk::Buffer& fitting(vk::Buffer& buffer, const char* name, std::size_t bytes);
    void dispatch_sum(std::uint32_t points);
    std::uint32_t take(std::uint32_t count);

    std::shared_ptr<vk::Device> device_;
    vk::Commands commands_;
    vk::Pipeline cut_, sum_, flux_pipeline_;
    const LightTree* tree_ = nullptr;
    std::uint32_t geometry_version_ = 0;   // of the tree that the device has
    std::uint32_t roots_count_ = 0, spheres_count_ = 0;
    std::vector<shared::GpuMovingSphere> spheres_host_;
    vk::Buffer quads_, children_, roots_, places_, flux_, spheres_, changed_;
    vk::Buffer requests_, cuts_, count_, nodes_, lights_, crossed_;
    // Lists by their lengths in steps; of each length the places that are free again, and beyond `end_` all.
    vk::Buffer store_;
    std::uint32_t end_ = 0;
    std::vector<std::vector<std::uint32_t>> free_;
    std::uint64_t long_cuts_ = 0;
    std::unique_ptr<ray::DeviceRays> rays_;   // null: it answers none
    const gpu_scene::GpuScene* scene_ = nullptr;
};

}   // namespace gnomon::irradiance_cache
