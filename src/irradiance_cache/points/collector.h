// SPDX-License-Identifier: Apache-2.0
#pragma once
// Step 1 of the irradiance cache, collect: finds or creates the cache points that a batch of surface points needs.
//
// Each surface point on static geometry first requests the four lattice points around it at the widest spacing; the
// interpolation (interpolator.h) leaves requests for finer levels where that is not enough, and in the end requests for
// parts of triangles. Requests with the same lattice cell are put side by side, so that a cell is looked up once and
// its points are interpolated together.

#include <span>
#include <vector>

#include "irradiance_cache/cache_frame.h"
#include "irradiance_cache/points/lattice_kernels.h"
#include "irradiance_cache/points/point_claims.h"

namespace gnomon::irradiance_cache {

/// Irradiance, and the form factor of the surfaces that it comes from.
struct Arriving {
    glm::vec3 light{0};
    float form_factor = 0;
};

/// What a surface point still needs from a level of the lattice.
struct LatticeRequest {
    std::uint32_t point;   // index of the surface point
    int level;
    std::uint32_t cell;
    float weight;        // fraction of the point's irradiance that this level and finer ones provide
    Arriving fallback;   // by the level before, if this one has only begun to fade in
    Arriving known{};    // by coarser levels, if rays are limited
};

/// What a surface point still needs from parts of triangles.
struct PartRequest {
    std::uint32_t point;
    float weight;
    AnchorKey key;
    const CachePoint* part;
    Arriving fallback;   // by the lattice, whatever its weight
};

/// A part whose irradiance at a surface point lacks the near field, because pixels are too wide for one of their own.
struct NearPartRequest {
    std::uint32_t point;
    float weight;
    AnchorKey key;   // of the part
};

/// The four lattice points around some surface points.
struct CollectedCell {
    AnchorKey key[4];
    CachePoint* point[4];
    int level;
    std::size_t first, end;   // of the requests
    CellAnchors anchors;      // the points' values, once they are evaluated
};

/// The open requests of a batch of surface points.
struct BatchWork {
    std::vector<std::uint8_t> dynamic;    // by surface point: it is on a dynamic object, or its pixel has no width
    std::vector<float> near_weight;       // by surface point: fraction of its irradiance that lacks the near field,
    std::vector<glm::vec4> near_known;    // or has that of lattice points: near_between(), weighted
    std::vector<float> near_share;        // and the weight of those levels that have any near field
    std::vector<float> form_factor;       // by surface point: of the surfaces that light it
    std::vector<std::uint8_t> deferred;   // by surface point: it lacks cache points, because rays are limited
    std::vector<LatticeRequest> lattice;
    std::vector<CollectedCell> cells;
    LatticePoints lattice_points;   // of `lattice`
    std::vector<PartRequest> parts;
    std::vector<NearPartRequest> near_parts;
    bool queued = false;   // some of the cache points wait for a device
};

/// Holds a thread's scratch memory.
class PointCollector {
 public:
    /// Starts a batch: requests the widest lattice level, or a part, for each of the chosen surface points.
    /// @param chosen  indices of surface points
    void begin(const CacheFrame& frame, std::span<const IndirectPoint> points, std::span<const std::uint32_t> chosen,
               BatchWork& work);
    /// Finds or creates the lattice points of all requests, and orders the requests by cell. Surface points beyond the
    /// lattice request parts instead.
    void collect_cells(const CacheFrame& frame, std::span<const IndirectPoint> points, PointClaims& claims,
                       BatchWork& work);
    /// Replaces each request for parts by one for each part with a weight.
    void select_parts(const CacheFrame& frame, std::span<const IndirectPoint> points, BatchWork& work);
    /// Finds or creates the parts of all requests.
    void collect_parts(const CacheFrame& frame, PointClaims& claims, BatchWork& work);

 private:
    struct Found {
        LatticeRequest request;
        float x, y;   // place in its cell
    };
    std::uint32_t find_or_add_cell(const LatticeCell& cell, int level, PointClaims& claims, BatchWork& work);
    void order_by_cell(std::span<const IndirectPoint> points, BatchWork& work) const;

    std::vector<std::uint32_t> slots_;   // cells by their keys: number + 1; open addressing, a power of two
    std::vector<Found> found_;
    std::vector<PartRequest> whole_;
};

}   // namespace gnomon::irradiance_cache
