// SPDX-License-Identifier: Apache-2.0
#pragma once
// A batch of surface points that is shaded again in the next frames, and what it found in the cache.
//
// As long as static geometry and the view stay, the same surface points need the same cache points with the same
// weights: levels of the lattice, what separates lattice points from a surface point, and near-field points depend on
// nothing that moves. So a frame needs neither look-ups nor weights again, but sums the present light of these cache
// points, in the same order. Surface points that take light from parts are computed anew, because which parts they take
// depends on the light (interpolator.h); so are those on dynamic objects. A batch holds as long as dynamic objects
// cover the same of its lattice points, because covered ones have no weight.
//
// Pointers to cache points stay valid as long as the batch is shaded in every frame, because the table keeps the points
// of the last frame (point_table.h).
//
// Memory: some 8 KB for 32 x 32 pixels of the Cornell box at 1920 x 1080; a multiple of it where all pixels are
// computed, or have near fields.

#include <memory>
#include <span>
#include <vector>

#include "irradiance_cache/near_field/near_blend.h"
#include "irradiance_cache/points/cache_point.h"
#include "irradiance_cache/points/collector.h"
#include "irradiance_cache/points/covered_points.h"
#include "irradiance_cache/points/sparse_pixels.h"

namespace gnomon::irradiance_cache {

struct RememberedBatch {
    /// What a surface point takes from a cell of the lattice.
    struct Contribution {
        std::uint16_t point, normal;
        float weight;         // of the level
        float weight_of[4];   // of the cell's points
        float all;            // their sum
    };
    struct Cell {
        std::uint32_t at[4];   // in `cached`
        std::uint32_t end;     // of its contributions
        bool near;             // near-field points replace the near fields of the cell's points
    };
    struct Near {
        std::uint16_t point, normal;
        std::uint32_t at;
        float weight, known;   // NearFieldStep::Selected
    };
    static constexpr std::size_t k_most_points = 1u << 15;

    std::uint32_t frame = 0;            // CacheFrame::number of the last one that shaded it
    std::uint64_t static_results = 0;   // IrradianceCache::static_results_ that it belongs to
    std::size_t count = 0;              // surface points
    struct Looked {
        CoverablePoint at;
        bool covered = false;
    };
    std::vector<Looked> looked_at;   // lattice points, those that do not contribute too
    Box3 region;                     // around all that they reach
    bool any_covered = false;        // of them
    std::vector<CachePoint*> cached;
    std::vector<glm::vec3> normals;   // of surface points
    std::vector<Cell> cells;
    std::vector<Contribution> contributions;   // by cell
    RememberedPixels pixels;
    std::vector<Near> near;
    std::vector<std::uint16_t> rest;   // surface points that are computed anew
    std::vector<IndirectPoint> rest_points;

    /// Adds what the surface points take from the lattice.
    /// @param near_known  like near_share, added to: as in BatchWork
    void add_lattice(glm::vec3* irradiance, glm::vec4* near_known, float* near_share) const;
    void add_near(const glm::vec4* near_known, const float* near_share, NearBlend& scratch,
                  glm::vec3* irradiance) const;
    /// Whether dynamic objects cover the same lattice points as before.
    bool same_are_covered(const CacheFrame& now) const;
    std::size_t bytes() const;
};

/// Takes note of what a batch finds. Holds a thread's scratch memory.
class BatchRecorder {
 public:
    void begin();
    /// Begins a level of the lattice.
    void add_cells(const NearField& near_field, std::span<const CollectedCell> cells);
    /// Notes the contribution of a cell of this level to a surface point.
    /// @param k  of `light`
    void add(std::uint32_t point, std::uint32_t cell, float weight, const LatticeLight& light, std::size_t k);
    /// Notes that surface points take light from parts.
    void add_rest(std::span<const PartRequest> parts);
    void add_near(std::uint32_t point, float weight, float known, CachePoint* cached)
    {
        near_.push_back({point, weight, known, cached});
    }
    /// Makes a batch of what was noted. Its `frame` and `static_results` are left out.
    std::unique_ptr<RememberedBatch> finish(std::span<const IndirectPoint> points, const SparsePixels& pixels);

 private:
    struct Contribution {
        std::uint32_t cell;
        RememberedBatch::Contribution of;
    };
    struct Cell {
        CachePoint* point[4];
        bool near;
    };
    struct Near {
        std::uint32_t point;
        float weight, known;
        CachePoint* cached;
    };
    std::vector<Cell> cells_;
    std::size_t first_cell_ = 0;   // of this level
    std::vector<Contribution> contributions_;
    std::vector<std::uint32_t> rest_;
    std::vector<Near> near_;
    std::vector<std::uint16_t> normal_of_;   // by surface point
};

}   // namespace gnomon::irradiance_cache
