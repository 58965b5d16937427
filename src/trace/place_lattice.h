// SPDX-License-Identifier: Apache-2.0
#pragma once
// Places between which the visibility of an environment is interpolated for points that mirrors and glass show.
//
// Paths through glass meet many more surfaces than there are pixels, and each shows little of its surface. Each large
// triangle therefore has a lattice of places, some pixels of the mirrored image apart, and a point takes the mean of
// the three places around it. The lattice ends just inside the triangle, because its edges often lie in other surfaces.
// Small triangles have none, and neither have points that would be almost alone between their places.
//
// The places of a point are a function of the point, its cone and the triangle alone. Cost: a place for 10 or more
// points.

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "trace/point_batch.h"

namespace gnomon::trace {

struct LatticeOptions {
    float step = 6;             // between places at most, in widths of the cone through which a point is seen
    int least_level = 2;        // of the lattice: a triangle has 4^level parts
    std::uint32_t uses = 120;   // of the three places around a point together, by points of the batch, at least
    float inset = 0.01f;        // of the lattice from the edges, as a fraction of the way to the triangle's middle
    float alike = 1.0f / 16;    // how much the light at places around a point may differ, as a fraction
};

class PlaceLattice {
 public:
    explicit PlaceLattice(const ray::RayScene& rays, const LatticeOptions& options = {})
        : rays_(rays), options_(options)
    {
    }

    /// The places around a point, with weights that sum to 1; without any, all weights are 0.
    struct Around {
        std::array<std::uint32_t, 3> place{};
        std::array<float, 3> weight{};
        bool any() const { return weight[0] + weight[1] + weight[2] > 0; }
    };
    /// Finds the places around the points of a batch. Primary hits, and what one of many rays of a lobe meets
    /// (shared_places.h), have none.
    /// @param asked  indices of points
    void find(const PointBatch& batch, std::span<const std::uint32_t> asked);
    /// All of them, each once.
    std::span<const visibility::ShadowPoint> places() const { return places_; }
    /// By asked point.
    std::span<const Around> around() const { return around_; }
    const LatticeOptions& options() const { return options_; }

 private:
    struct Key {
        std::uint64_t triangle = 0, place = 0;
        friend bool operator==(const Key&, const Key&) = default;
    };
    struct Entry {
        Key key;
        std::uint32_t place = 0xffffffff;
    };
    bool has_lattice(const PointBatch& batch, std::uint32_t point) const;
    void find_around(const PointBatch& batch, std::uint32_t point, Around& around);
    void leave_rare();
    std::uint32_t place_at(const visibility::ShadowPoint& at, const glm::vec3 (&p)[3], std::uint32_t level,
                           std::uint32_t column, std::uint32_t row);

    const ray::RayScene& rays_;
    LatticeOptions options_;
    std::vector<visibility::ShadowPoint> places_;
    std::vector<Around> around_;
    std::vector<Entry> table_;                 // a power of two
    std::vector<std::uint32_t> uses_, kept_;   // by place: points around which it lies; its number if it is kept
};

}   // namespace gnomon::trace
