// SPDX-License-Identifier: Apache-2.0
#pragma once
// The light of cells of directions (direction_cells.h) at a surface: its irradiance by normal, all of it or the part
// from visible cells, and what a glossy lobe sees of it.
//
// Irradiance is the sum of the flux of each visible cell times the cosine of its mean direction. For all cells, it is a
// table over normals; for some, either what is missing is subtracted, or what is visible is added, whichever has fewer
// terms. Terms are whole numbers of a small unit, so that a sum does not depend on the order of its terms: what was
// proven and what was found by rays may be added separately.
//
// A lobe that is wider than cells sees the mean of their radiance, weighted by the lobe as it is seen from this very
// direction: long at a slant. A narrower one sees blurred images from tables (lobe_tables.h); in between, both are
// blended. How much of it is visible is the ratio of visible weights to all weights, over cells; a lobe that
// cells cannot resolve is widened for that.
//
// Cost: a table look-up (bilinear) where all cells above the surface are visible; else some 3 ns for each cell that is
// hidden, or visible. The table over normals takes some 10 ms (2 cores with AVX-512).

#include <array>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "base/direction_table.h"
#include "environment_light/cell_sums.h"
#include "environment_light/direction_cells.h"
#include "environment_light/lobe_tables.h"

namespace gnomon::environment_light {

struct CellLightOptions {
    int normals = 96;               // a side, of the table over normals
    float least_roughness = 0.4f;   // of the lobe that visibility is weighted by
    // Of lobes: up to the first from tables, from the second on by cells. And likewise, what rays of lobes show that
    // leave the scene: cells leave out what is below the horizon, which tables do not.
    float by_tables = 0.45f, by_cells = 0.6f, open_by_tables = 0.3f, open_by_cells = 0.45f;
};

/// What arrives at a surface from visible cells.
struct FromCells {
    glm::vec3 irradiance{0};
    float hidden = 0;   // share of the hemisphere, by cosine, that surfaces fill
};

/// A lobe at a point of a surface; all directions are unit.
struct Lobe {
    glm::vec3 to_viewer{0};
    glm::vec3 mirrored{0};             // the direction that a mirror shows
    glm::vec3 normal{0}, horizon{0};   // what lies below the plane of either has no weight
    float roughness = 1;               // perceptual
    float f0 = 1, f90 = 1;             // reflectance where it faces the viewer, and at grazing angles
    bool round = false;                // seen as along the normal, which needs fewer tables: for previews
};

/// What a lobe sees of the environment; radiance.
struct SeenByLobe {
    glm::vec3 light{0};   // of visible cells, as a mean over all of the lobe
    float share = 0;      // how much of the light of all of the lobe that is, by luminance
    glm::vec3 open{0};    // the mean where the lobe sees the environment: what its rays show that meet nothing
};

class CellLight {
 public:
    /// @param cells        kept by reference
    /// @param environment  of the cells, for lobes; kept by reference. Null: no lobes
    CellLight(const DirectionCells& cells, const scene::Environment* environment, const CellLightOptions& options = {});
    ~CellLight();

    /// On a surface with this unit normal that sees everything above it.
    glm::vec3 irradiance(const glm::vec3& normal) const;
    /// The same from visible cells alone.
    /// @param seen     a bit for each leaf
    /// @param partial  cells of which a share is visible, whatever their bit
    glm::vec3 irradiance(const glm::vec3& normal, std::span<const std::uint64_t> seen,
                         std::span<const PartialCell> partial = {}) const
    {
        return from_cells(normal, seen, partial).irradiance;
    }
    /// The same, and how much of the hemisphere that is.
    FromCells from_cells(const glm::vec3& normal, std::span<const std::uint64_t> seen,
                         std::span<const PartialCell> partial = {}) const;

    /// The mean radiance that a lobe around a mirror direction sees, viewed along the normal. @param roughness
    /// perceptual
    glm::vec3 blurred(const glm::vec3& direction, float roughness) const;
    /// What a lobe sees.
    /// @param seen     a bit for each leaf
    /// @param partial  cells of which a share is visible, whatever their bit
    SeenByLobe seen_by(const Lobe& lobe, std::span<const std::uint64_t> seen,
                       std::span<const PartialCell> partial = {}) const;
    std::size_t bytes() const;

 private:
    LobeTables& lobes() const;
    CosineSums sum(const glm::vec3& normal, std::span<const std::uint64_t> mask, std::uint64_t flip) const;

    const DirectionCells& cells_;
    const scene::Environment* environment_;
    CellLightOptions options_;
    std::array<std::vector<float>, 3> mean_, flux_;   // by axis and colour, padded to whole words
    std::vector<float> angle_;                        // solid; as long
    std::array<std::vector<float>, 3> units_;         // flux in units of the sums
    std::vector<float> angle_units_;                  // likewise, of solid angles
    glm::vec3 unit_{0};
    std::vector<std::uint64_t> exists_;   // leaves
    DirectionTable normals_;
    mutable std::once_flag lobes_made_;
    mutable std::unique_ptr<LobeTables> lobes_;
};

}   // namespace gnomon::environment_light
