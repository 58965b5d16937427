// SPDX-License-Identifier: Apache-2.0
#pragma once
// Boxes that move, in a tree: which of them does something meet?
//
// A binary tree, split in the middle along its longest axis, kept while boxes move: a moved leaf widens or narrows the
// nodes above it. Once as many boxes moved as there are and the nodes have grown to twice their surface, it is built
// afresh. A node's box is the union of those below, to the bit: whatever a monotone test finds of all boxes asked one
// by one, it finds here.
//
// Cost: build n log n; a move log n, at most, the builds it leads to included; a query what lies near, log n above it.

#include <cstdint>
#include <span>
#include <vector>

#include "base/math.h"

namespace gnomon {

class BoxTree {
 public:
    BoxTree() = default;
    /// By index. Empty boxes are never met.
    explicit BoxTree(std::span<const Box3> boxes);

    std::size_t size() const { return leaf_.size(); }
    const Box3& operator[](std::uint32_t index) const { return nodes_[leaf_[index]].box; }
    void move(std::uint32_t index, const Box3& box);

    /// Calls found(index) for each box that is not empty and for which meets(box) holds; in no particular order.
    /// @param meets  true for a box only if true for every larger box around it
    /// @return how many boxes were looked at
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
        std::uint32_t child = k_none;   // the first of two neighbours; none: a leaf
        std::uint32_t index = k_none;   // of a leaf's box
    };
    void build(std::span<const Box3> boxes);
    double surface() const;

    std::vector<Node> nodes_;           // children after their parents
    std::vector<std::uint32_t> leaf_;   // by index
    std::size_t moves_ = 0;             // since it was built or last measured
    double built_surface_ = 0;
};

}   // namespace gnomon
