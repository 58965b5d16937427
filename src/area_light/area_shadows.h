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
// A triangle is divided into quarters, and these again, where the light is partly hidden and smaller parts know more.
// How far depends on the geometry alone, not on the view, and so does what is remembered; a point's answer is therefore
// the same in whatever order points are asked, and whatever has been forgotten. A part is judged when a point in it is
// asked for the first time.
//
// Masked triangles (with holes by alpha) are listed like others; only rays know their holes. Dynamic objects are not
// regarded here.
// Cost: a look-up per point; for a listed part, the triangles of its list (blocked_places.h); some microseconds for
// each part that is judged. Memory: 16 bytes for each static triangle, 128 for each divided part,
// 4 for each listed triangle.

#include <atomic>
#include <memory>
#include <mutex>
#include <vector>

#include "area_light/area_shaft.h"
#include "area_light/blocked_places.h"
#include "area_light/dark_proof.h"
#include "base/micro_triangles.h"

namespace gnomon::area_light {

enum class PartState : std::uint8_t { unlit, lit, dark, listed, open };

struct AreaOptions {
    ShaftRules shaft;
    DarkOptions dark;
    double coarse = 0.125;   // parts are divided down to this fraction of the light's diameter,
    double fine = 0.125;     // and where more than `short_list` triangles meet the shaft, down to this one
    std::size_t short_list = 24;
    std::size_t hopeless = 96;         // with more, a part that can be divided is divided at once
    std::size_t longest_list = 2048;   // of a listed part
    int most_levels = 9;
    std::size_t most_bytes = 256u << 20;   // of all lights' parts; with more, everything is forgotten (AreaVisibility)
};

struct AreaCounters {
    std::uint64_t parts = 0;        // judged
    std::uint64_t states[5] = {};   // of these, by PartState; divided ones count as none
    std::uint64_t listed_triangles = 0;
};

/// The answer for a part.
struct Part {
    PartState state = PartState::open;
    const std::vector<visibility::TriangleId>* list = nullptr;   // of a listed part
};

class AreaShadows {
 public:
    /// @param triangles  kept by reference
    AreaShadows(const visibility::StaticTriangles& triangles, const FlatLight& light, const AreaOptions& options = {});
    ~AreaShadows();

    const LightPlaces& places() const { return places_; }
    /// A part that was found, which most often contains the next point as well.
    struct LastPart {
        const AreaShadows* owner = nullptr;
        std::size_t record = 0;
        std::uint32_t level = 0;
        MicroTriangle place;
        Part part;
    };
    /// The part of a static triangle that contains (u, v), on one side. Thread-safe. What it returns stays valid.
    /// @param front  the side that the triangle's corners run around counter-clockwise
    /// @param last   of the call before; one per thread
    Part part_at(visibility::TriangleId triangle, bool front, float u, float v, LastPart& last);
    Part part_at(visibility::TriangleId triangle, bool front, float u, float v)
    {
        LastPart last;
        return part_at(triangle, front, u, v, last);
    }
    /// The same, judged anew: remembers nothing. The reference.
    Part judged_anew(visibility::TriangleId triangle, bool front, float u, float v,
                     std::vector<visibility::TriangleId>& list) const;

    /// Sums over everything that was judged.
    AreaCounters counters() const;
    std::size_t bytes() const;

 private:
    struct Node;
    struct Shard;
    struct Verdict {
        bool divides = false;
        PartState state = PartState::open;
        std::vector<visibility::TriangleId> list;
    };
    Verdict judge(visibility::TriangleId triangle, bool front, const MicroTriangle& part, std::uint32_t level,
                  const std::vector<visibility::TriangleId>* from) const;

    Node* judge_node(std::size_t record, Node* node, visibility::TriangleId triangle, bool front,
                     const MicroTriangle& part, std::uint32_t level, const std::vector<visibility::TriangleId>* from);

    const visibility::StaticTriangles& triangles_;
    LightPlaces places_;
    AreaOptions options_;
    double diameter_ = 0;
    std::unique_ptr<std::atomic<Node*>[]> roots_;   // by triangle and side; null: nothing was asked
    std::unique_ptr<Shard[]> shards_;
};

}   // namespace gnomon::area_light
