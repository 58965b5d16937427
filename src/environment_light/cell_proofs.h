// SPDX-License-Identifier: Apache-2.0
#pragma once
// What is proven of the directions in which parts of static triangles see past static geometry: for each cell of
// directions (direction_cells.h), free, blocked, or open.
//
//   free      no static triangle meets the prism from the part in the directions of the cell (endless_prism.h)
//   blocked   one closed patch of static triangles closes the prism (visibility/closed_patch.h)
//   open      neither was shown: rays decide, point by point
//
// Cells are judged from the coarsest down: what holds for a cell holds for those within it. A leaf has one direction,
// and its prism is thin; where points ask for shares of cells (ask_for_shares()), leaves are judged as a whole, too. A
// list of tree nodes that may meet a cell is handed down to the cells within it.
//
// A proof says what a ray would say, so it never changes an answer: whether and when a part is judged is a matter of
// cost alone. A triangle is judged when a number of points on it have asked, and divided into quarters that are judged
// anew when many more have. What was proven of it holds for its quarters.
//
// Cost: some tenths of a millisecond for a part that is judged; a look-up per point. Memory: two bits a leaf for each
// part.

#include <atomic>
#include <memory>
#include <mutex>
#include <vector>

#include "base/micro_triangles.h"
#include "environment_light/direction_cells.h"
#include "environment_light/endless_prism.h"
#include "visibility/closed_patch.h"

namespace gnomon::environment_light {

/// The checks that proofs rest on, one by one, so that tests can leave one out and see the errors.
enum class ProofCheck : std::uint8_t {
    none,            // all are made
    whole_part,      // a prism starts at all of the part, not at one corner alone
    whole_cell,      // it has all directions of the cell, not the middle one alone
    no_open_edge,    // every edge of a patch in the prism leads on
    clear_of_part,   // a patch keeps clear of the ray origins
    crosses,         // a patch is crossed, in sum
    signs,           // by the sides' signs
};

struct ProofOptions {
    PrismRules prism;
    int most_triangles = 128;   // of a closed patch
    double clearance = 4;       // least distance of it from the part, in lifts
    int first_asks = 200;       // points on a triangle that are answered by rays before it is judged
    int more_asks = 400;        // points before a judged part is divided
    int most_levels = 6;
    int opened = 24;            // nodes of the tree of triangles that are opened for one cell,
    int opened_at_leaf = 128;   // and for a leaf
    int most_tests = 40'000;    // of nodes and triangles for one part; what is left is open
    double least_gain = 0.15;   // of the open cells: a part whose quarter gained less is divided no further
    ProofCheck left_out = ProofCheck::none;   // for tests
};

/// What is known of a part, by leaf. What is neither free nor open is blocked.
struct PartMasks {
    std::vector<std::uint64_t> free, open;
    std::vector<std::uint64_t> whole;   // what is known holds for all directions of the cell
};

struct ProofCounters {
    std::uint64_t parts = 0;                         // judged
    std::uint64_t free = 0, blocked = 0, open = 0;   // leaves, over all of them
};

class CellProofs {
 public:
    /// @param triangles, cells  kept by reference
    CellProofs(const visibility::StaticTriangles& triangles, const DirectionCells& cells,
               const ProofOptions& options = {});
    ~CellProofs();

    /// What is known of the part of a static triangle that contains (u, v), on one side; counts the question, and
    /// judges if it is time. Thread-safe. What it returns stays valid.
    /// @param front  the side that the triangle's corners run around counter-clockwise
    const PartMasks& part_at(visibility::TriangleId triangle, bool front, float u, float v);
    /// Counts further questions about the part that contains (u, v), and lets leaves be judged as a whole in what is
    /// judged of it from now on. Thread-safe.
    void ask_for_shares(visibility::TriangleId triangle, bool front, float u, float v, std::uint32_t asks);
    /// Judges a part anew; remembers nothing. Proofs hold for every point of it.
    /// @param from   of a part that contains it: what is not open there is kept
    /// @param whole  also judge whether leaves are known as a whole
    PartMasks judge(visibility::TriangleId triangle, bool front, const MicroTriangle& part, std::uint32_t level,
                    const PartMasks* from = nullptr, bool whole = false) const;
    /// Takes over what was proven of the same triangles for other cells, where both have the same leaves. Call before
    /// the first question.
    void take_over(const CellProofs& other);

    ProofCounters counters() const;
    std::size_t bytes() const;

 private:
    struct Node;
    struct Shard;
    class Judge;
    Node* root(std::size_t record);
    void grow(std::size_t record, Node& node, visibility::TriangleId triangle, bool front, const MicroTriangle& part,
              std::uint32_t level, const PartMasks& from);

    const visibility::StaticTriangles& triangles_;
    const DirectionCells& cells_;
    ProofOptions options_;
    PartMasks nothing_;                             // all is open
    std::unique_ptr<std::atomic<Node*>[]> roots_;   // by triangle and side
    std::unique_ptr<Shard[]> shards_;
};

}   // namespace gnomon::environment_light
