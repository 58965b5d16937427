// SPDX-License-Identifier: Apache-2.0
#pragma once
// The near field at the pixels of a batch: finds the pixels with surfaces close by, collects their near-field points,
// and adds those points' irradiance.

#include "irradiance_cache/near_field/near_blend.h"
#include "irradiance_cache/points/collector.h"
#include "irradiance_cache/points/parts.h"

namespace gnomon::irradiance_cache {

/// Holds a thread's scratch memory.
class NearFieldStep {
 public:
    NearFieldStep() { rays_.purpose = ray::RayClass::indirect; }
    /// Selects the near-field points of all pixels that have surfaces close by.
    /// @return  whether there are any
    bool select(const CacheFrame& frame, std::span<const IndirectPoint> points, const BatchWork& work,
                const FrameFailure& failure, CacheCounters& counters);
    /// Selects the near-field points of parts that have near fields of their own.
    /// @return  whether there are any
    bool select_of_parts(const BatchWork& work);
    /// Finds or creates the selected points.
    void collect(const CacheFrame& frame, PointClaims& claims);
    /// Replaces selected points that their pixel does not see by others close to the pixel.
    /// @return  whether there are any: they must be collected and evaluated, too
    bool replace_hidden(const CacheFrame& frame, std::span<const IndirectPoint> points, CacheCounters& counters);
    /// Adds the selected points' irradiance, in place of what the lattice knows of it.
    void blend(std::span<const IndirectPoint> points, const BatchWork& work, glm::vec3* irradiance);

    /// A near-field point of a pixel.
    struct Selected {
        std::uint32_t point;
        float weight, known;   // of its light, and of what the lattice knows of it (BatchWork::near_known)
        AnchorKey key;
        CachePoint* part;
    };
    std::span<const Selected> selected() const { return selected_; }

 private:
    struct NearPixel {
        std::uint32_t point;
        NearHints::Cell cell;
        bool known;   // surfaces are close by; else another thread finds out
    };
    void find_near_pixels(const CacheFrame& frame, std::span<const IndirectPoint> points, const BatchWork& work,
                          const FrameFailure& failure, CacheCounters& counters);
    NearHints::State claim_cell(const CacheFrame& frame, const NearHints::Claim& claim);
    void replace(const CacheFrame& frame, const IndirectPoint& point, std::size_t selected);

    std::vector<NearPixel> pixels_;
    std::vector<NearHints::Claim> claimed_;
    std::vector<NearHints::Cell> awaited_;
    NearHints::Scratch hints_;
    std::vector<Selected> selected_;
    NearBlend blend_;
    std::vector<std::uint32_t> doubted_;   // selected points that their pixel may not see
    ray::RayQueue rays_;
    std::vector<std::uint8_t> occluded_;
};

}   // namespace gnomon::irradiance_cache
