// SPDX-License-Identifier: Apache-2.0
#pragma once
// Remembered shadows of a planar light that rests: what static geometry hides of it, for parts of static triangles.
//
//   unlit     the part, or the light, lies behind the other
//   lit       no static triangle meets the shaft from the part to the light: all of it is visible
//   dark      one closed patch of static triangles lies between them (dark_proof.h): nothing of it is visible
//   listed    the static triangles that meet the shaft are remembered; what each point sees follows from them alone
//   open      there are too many of them: rays decide
//
// Parts, and what is remembered of them: part_tree.h.
//
// Masked triangles (with holes by alpha) are listed like others; only rays know their holes. Dynamic objects are not
// regarded here.
// Cost: a look-up per point; for a listed part, the triangles of its list (blocked_places.h); some microseconds for
// each part that is judged.

#include "area_light/area_shaft.h"
#include "area_light/blocked_places.h"
#include "area_light/dark_proof.h"
#include "area_light/part_tree.h"

namespace gnomon::area_light {

struct AreaOptions {
    ShaftRules shaft;
    DarkOptions dark;
    double coarse = 0.125;   // parts are divided down to this fraction of the light's diameter,
    double fine = 0.125;     // and where more than `short_list` triangles meet the shaft, down to this one
    std::size_t short_list = 24;
    std::size_t hopeless = 96;         // with more, a part that can be divided is divided at once
    std::size_t longest_list = 2048;   // of a listed part
    int most_levels = 9;
    // Of a cluster: nothing is proven for parts whose longest edge is below this fraction of the extent of all static
    // triangles. So few points lie on them that rays cost less than proofs.
    double least_part = 0.02;
    std::size_t most_bytes = 256u << 20;   // of all lights' parts; with more, everything is forgotten (AreaVisibility)
};

class AreaShadows final : public PartTree {
 public:
    /// @param triangles  kept by reference
    AreaShadows(const visibility::StaticTriangles& triangles, const FlatLight& light, const AreaOptions& options = {});

    const LightPlaces& places() const { return places_; }

 private:
    Verdict judge(visibility::TriangleId triangle, bool front, const MicroTriangle& part, std::uint32_t level,
                  const std::vector<visibility::TriangleId>* from) const override;

    LightPlaces places_;
    AreaOptions options_;
    double diameter_ = 0;
};

}   // namespace gnomon::area_light
