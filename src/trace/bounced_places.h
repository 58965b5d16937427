// SPDX-License-Identifier: Apache-2.0
#pragma once
// Bounced light at places that samples meet, which later samples of the same frame share.
//
// Mirrors show surfaces from viewpoints of their own. Nearly every further sample (refinement.h, blur.h) therefore
// meets places that lie between those of earlier samples, each of which would need new points of the irradiance cache.
// Irradiance changes slowly over a surface, so a place takes that of the nearest known places on its surface, where
// these agree.
//
// Places are kept in a hash grid, in cells that grow with the width of the path's pixel there. They are added between
// passes over the image, tile by tile, so that what a pass finds depends neither on threads nor on the order of tiles.
//
// Cost: adding and finding: a few cells each. Memory: 56 bytes a place, 14 places a cell at most.

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "base/math.h"

namespace gnomon::trace {

/// A place on a surface, and what arrives there by bounces.
struct BouncedPlace {
    glm::vec3 position{0};   // in the world; of an object that moves, on its mesh
    std::uint32_t object = 0;
    glm::vec3 normal{0};   // of shading, in the world
    float width = 0;       // of the path's pixel there, in the units of the position
    glm::vec3 plane{0};    // normal of the triangle, where the position is; of find() alone
    glm::vec3 irradiance{0};
};

struct BouncedPlacesOptions {
    float reach = 64;           // in widths: places at most so far apart share light
    float same_normal = 0.9f;   // cosine between normals of places that share light
    float off_plane = 0.1f;     // distance from the plane of a place, in reaches
    float thinned = 0.25f;      // likewise, of a known place that makes another one needless
    float lone = 0.5f;          // distance, in reaches, of a place that is the only one
};

class BouncedPlaces {
 public:
    /// Forgets all places.
    /// @param moving  objects that move before the next call
    void begin(std::span<const std::uint32_t> moving);
    bool moves(std::uint32_t object) const { return object < moving_.size() && moving_[object] != 0; }
    /// Adds places that are not next to known ones.
    void add(std::span<const BouncedPlace> places);

    /// The irradiance of the places around one.
    struct Found {
        glm::vec3 mean{0}, low{0}, high{0};
    };
    /// @param at  its irradiance is not read
    std::optional<Found> find(const BouncedPlace& at) const;

    bool empty() const { return places_.empty(); }
    std::size_t bytes() const;

 private:
    static constexpr int k_most = 14;   // places of a cell
    struct Cell {
        std::uint64_t key = 0;
        std::uint32_t count = 0;
        std::uint32_t places[k_most];
    };
    const Cell* cell(std::uint64_t key) const;
    Cell& cell_for(std::uint64_t key);
    void grow();
    BouncedPlacesOptions options_;
    std::vector<BouncedPlace> places_;
    std::vector<Cell> cells_;   // open addressing; a power of two
    std::size_t used_ = 0;
    std::vector<char> moving_;   // by object
};

}   // namespace gnomon::trace
