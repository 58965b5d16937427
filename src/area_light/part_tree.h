// SPDX-License-Identifier: Apache-2.0
#pragma once
// Remembers what is known of the light between a light that rests and parts of static triangles.
//
// A triangle is divided into quarters, and these again, as long as smaller parts know more. How far depends on the
// geometry alone, not on the view, and so does what is remembered; a point's answer is therefore the same in whatever
// order points are asked, and whatever has been forgotten. A part is judged when a point in it is asked for the first
// time. How it is judged is up to the kind of light (area_shadows.h, cluster_shadows.h).
//
// Cost: a look-up per point. Memory: 16 bytes for each static triangle, 128 for each divided part, 4 for each listed
// triangle.

#include <atomic>
#include <memory>
#include <mutex>
#include <vector>

#include "base/micro_triangles.h"
#include "visibility/static_triangles.h"

namespace gnomon::area_light {

enum class PartState : std::uint8_t { unlit, lit, dark, listed, open };

struct AreaCounters {
    std::uint64_t parts = 0;        // judged
    std::uint64_t states[5] = {};   // of these, by PartState; divided ones count as none
    std::uint64_t listed_triangles = 0;
    void add(const AreaCounters& other);
};

/// The answer for a part.
struct Part {
    PartState state = PartState::open;
    const std::vector<visibility::TriangleId>* list = nullptr;   // of a listed part
};

/// A part of a static triangle, seen from one side.
struct Piece {
    glm::dvec3 corner[3];
    glm::dvec3 normal{0};   // unit, on the side where rays start; 0: the triangle has no area
    double distance = 0;    // of the plane: dot(normal, x) + distance is the height over it
    double lift = 0;        // height of ray origins over the plane
    double size = 0;        // the longest edge

    Piece(const visibility::StaticTriangle& triangle, bool front, const MicroTriangle& part, std::uint32_t level);
    bool has_area() const { return normal != glm::dvec3(0); }
    glm::dvec3 centre() const { return (corner[0] + corner[1] + corner[2]) / 3.0; }
};

class PartTree {
 public:
    /// @param triangles    kept by reference
    /// @param most_levels  of division
    PartTree(const visibility::StaticTriangles& triangles, int most_levels);
    virtual ~PartTree();

    /// A part that was found, which most often contains the next point as well.
    struct LastPart {
        const PartTree* owner = nullptr;
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

 protected:
    struct Verdict {
        bool divides = false;
        PartState state = PartState::open;
        std::vector<visibility::TriangleId>
            list;   // of a listed part; of a divided one, all that its quarters may meet
    };
    /// Judges one part, from the geometry alone.
    /// @param from  triangles that contain all that may matter to it; null: all static triangles
    virtual Verdict judge(visibility::TriangleId triangle, bool front, const MicroTriangle& part, std::uint32_t level,
                          const std::vector<visibility::TriangleId>* from) const = 0;

    const visibility::StaticTriangles& triangles_;

 private:
    struct Node;
    struct Shard;
    Node* judge_node(std::size_t record, Node* node, visibility::TriangleId triangle, bool front,
                     const MicroTriangle& part, std::uint32_t level, const std::vector<visibility::TriangleId>* from);

    std::uint32_t finest_level_;
    std::unique_ptr<std::atomic<Node*>[]> roots_;   // by triangle and side; null: nothing was asked
    std::unique_ptr<Shard[]> shards_;
};

}   // namespace gnomon::area_light
