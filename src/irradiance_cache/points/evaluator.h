// SPDX-License-Identifier: Apache-2.0
#pragma once
// Step 2 of the irradiance cache, evaluate: brings claimed cache points up to the current frame.
//
// A new point gets its cut through the light tree, and keeps the nodes of the cut that are visible past static
// geometry. A known point starts from what those bring without dynamic objects, and is corrected: for nodes whose flux
// changed, nodes and sky behind a dynamic object, and light from dynamic objects. The CPU evaluates points at once
// (cpu_evaluator.h); a device collects them and evaluates many together (device_evaluator.h).

#include <memory>
#include <span>

#include "base/tasks.h"
#include "irradiance_cache/points/point_light.h"

namespace gnomon::irradiance_cache {

/// A thread's scratch memory for evaluations.
struct EvaluationScratch {
    CacheCounters counters;
    StaticVisibility visibility;
    PresentLight present;
    NearOfPoints near;
    std::vector<CachePoint*> points;
    std::vector<CachePoint*> queued;   // for the device
    std::uint64_t expected_rays = 0;   // that it will cast for new ones among them, about; counts up
    std::vector<NodeId> cut;
    CutScratch cut_memory;
    std::vector<float> weights;
    std::vector<ChangedNode> changed;
};

/// Lattice points light many pixels, and are cut finely; points on dynamic objects are cut again in every frame.
inline CutOptions cut_options(const CacheOptions& options, const CachePoint& point)
{
    CutOptions cut = options.cut;
    if (point.owner != k_no_owner)
        cut.error = options.moving_error, cut.estimate = options.moving_estimate;
    else if (!is_lattice(point.key))
        cut.error = options.part_error, cut.estimate = options.part_estimate;
    return cut;
}

class PointEvaluator {
 public:
    virtual ~PointEvaluator() = default;
    /// After the light tree and the bounds of dynamic objects followed the scene.
    virtual void begin_frame(const CacheFrame& frame) = 0;
    /// Evaluates points that are placed, near-field points aside; or queues them for evaluate_queued() and marks them
    /// as queued. Thread-safe for different points and scratch.
    virtual void evaluate(const CacheFrame& frame, std::span<CachePoint* const> points, EvaluationScratch& scratch) = 0;
    /// Evaluates all queued points.
    /// @param scratch  one for each thread of `tasks`
    virtual void evaluate_queued(const CacheFrame& frame, std::span<EvaluationScratch* const> scratch,
                                 Tasks& tasks) = 0;
    /// Frees what the evaluator keeps for a point that is dropped.
    virtual void release(const CachePoint& point) = 0;
    virtual std::size_t bytes() const = 0;
};

}   // namespace gnomon::irradiance_cache
