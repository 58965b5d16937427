// SPDX-License-Identifier: Apache-2.0
#pragma once
// A bounding volume hierarchy over boxes that move, for queries by any monotone test.
//
// The tree is binary and split at the median along its longest axis. A moved leaf refits the nodes above it. After as
// many moves as there are boxes, the tree is rebuilt if its nodes have doubled in surface. A node's box is exactly the
// union of the boxes below it, so a query finds the same boxes as testing each box in turn.
//
// Cost: build O(n log n); a move at most O(log n) amortised, rebuilds included; a query O(log n) per box found.

#include <cstdint>
#include <span>
#include <vector>

#include "base/math.h"

namespace gnomon {

class BoxTree {
 public:
    BoxTree() = default;
    /// One box per index. Empty boxes are never found.
    explicit BoxTree(std::span<const Box3> boxes);

    std::size_t size() const { return leaf_.size(); }
    const Box3& operator[](std::uint32_t index) const { return nodes_[leaf_[index]].box; }
    void move(std::uint32_t index, const Box3& box);

    /// Calls found(index) for each box that is not empty and for which meets(box) holds, in no particular order.
    /// @param meets  if true for a box, it must be true for every box that contains it
    /// @return the number of boxes tested
    template <class Meets, class Found>
    std::size_t find(const Meets& meets, const Found& found) const
    {
        if (nodes_.empty()) return 0;
        std::uint32_t stack[k_deepest + 1];
        int waiting = 0;
        std::size_t looked_at = 0;
        stack[waiting++] = 0;
        while (waiting > 0) {
            const Node& node = nodes_[stack[--waiting]];
            ++looked_at;
            if (node.box.empty() || !meets(node.box)) continue;
            if (node.child == k_none) {
                found(node.index);
                continue;
            }
            stack[waiting++] = node.child;
            stack[waiting++] = node.child + 1;
        }
        return looked_at;
    }

 private:
    static constexpr std::uint32_t k_none = 0xffffffffu;
    static constexpr int k_deepest = 33;   // halves of 2^32 boxes
    struct Node {
        Box3 box;
        std::uint32_t parent = k_none;
        std::uint32_t child = k_none;   // the first of two adjacent nodes; none: a leaf
        std::uint32_t index = k_none;   // a leaf's box
    };
    void build(std::span<const Box3> boxes);
    double surface() const;

    std::vector<Node> nodes_;           // children after their parents
    std::vector<std::uint32_t> leaf_;   // by index
    std::size_t moves_ = 0;             // since the tree was built or its surface last measured
    double built_surface_ = 0;
};

}   // namespace gnomon
