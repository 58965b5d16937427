// SPDX-License-Identifier: Apache-2.0
#pragma once
// Evaluates cache points on a device: claimed points are queued, and evaluated together once a frame has collected all
// that it needs.
//
// The device cuts the light tree and sums the light of visible nodes. Rays are traced by the threads, or by the device
// if it can.

#include "irradiance_cache/points/evaluator.h"
#include "irradiance_cache/points/point_device.h"
#include "irradiance_cache/points/point_table.h"

namespace gnomon::irradiance_cache {

class DeviceEvaluator final : public PointEvaluator {
 public:
    DeviceEvaluator(PointTable& table, std::unique_ptr<PointDevice> device) : table_(table), device_(std::move(device))
    {
    }
    void begin_frame(const CacheFrame& frame) override;
    void evaluate(const CacheFrame& frame, std::span<CachePoint* const> points, EvaluationScratch& scratch) override;
    void evaluate_queued(const CacheFrame& frame, std::span<EvaluationScratch* const> scratch, Tasks& tasks) override;
    void release(const CachePoint& point) override;
    std::size_t bytes() const override { return device_->bytes(); }

 private:
    using Scratches = std::span<EvaluationScratch* const>;
    void find_visible_nodes(const CacheFrame& frame, std::span<CachePoint* const> points, Scratches scratch,
                            Tasks& tasks);
    void sum(const CacheFrame& frame, std::span<CachePoint* const> points, Scratches scratch, Tasks& tasks);
    void keep(const CacheFrame& frame, std::span<CachePoint* const> points, std::span<const SeenNode> seen,
              std::span<KeptNodes> lists);
    OcclusionTester tester(const CacheFrame& frame) const;
    std::size_t piece_size(std::size_t count) const;

    PointTable& table_;
    std::unique_ptr<PointDevice> device_;
};

}   // namespace gnomon::irradiance_cache
