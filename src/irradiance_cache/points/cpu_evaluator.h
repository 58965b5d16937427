// SPDX-License-Identifier: Apache-2.0
#pragma once
// Evaluates cache points at once, on the thread that claimed them.

#include "irradiance_cache/points/evaluator.h"
#include "irradiance_cache/points/point_table.h"

namespace gnomon::irradiance_cache {

class CpuEvaluator final : public PointEvaluator {
 public:
    explicit CpuEvaluator(PointTable& table) : table_(table) {}
    void begin_frame(const CacheFrame&) override {}
    void evaluate(const CacheFrame& frame, std::span<CachePoint* const> points, EvaluationScratch& scratch) override;
    void evaluate_queued(const CacheFrame&, std::span<EvaluationScratch* const>, Tasks&) override {}
    void release(const CachePoint&) override {}
    std::size_t bytes() const override { return 0; }

 private:
    void find_visible_nodes(const CacheFrame& frame, std::span<CachePoint* const> points, EvaluationScratch& scratch);
    void sum(const CacheFrame& frame, std::span<CachePoint* const> points, EvaluationScratch& scratch) const;
    static void add_patch_difference(const LightTree& tree, CachePoint& point);
    void correct(const CacheFrame& frame, CachePoint& point, EvaluationScratch& scratch) const;

    PointTable& table_;
};

}   // namespace gnomon::irradiance_cache
