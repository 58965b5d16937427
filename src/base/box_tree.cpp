// SPDX-License-Identifier: Apache-2.0
#include "base/box_tree.h"

#include <algorithm>
#include <numeric>

#include "base/check.h"

namespace gnomon {

namespace {

// The tree is rebuilt when the surface of its nodes exceeds this multiple of the surface at the last build.
constexpr double k_max_growth = 2;

double surface_of(const Box3& box)
{
    const glm::dvec3 s(box.size());
    return s.x * s.y + s.y * s.z + s.z * s.x;
}

bool same(const Box3& a, const Box3& b)
{
    return a.low == b.low && a.high == b.high;
}

}   // namespace

BoxTree::BoxTree(std::span<const Box3> boxes)
{
    build(boxes);
}

void BoxTree::build(std::span<const Box3> boxes)
{
    nodes_.clear();
    leaf_.assign(boxes.size(), k_none);
    moves_ = 0;
    built_surface_ = 0;
    if (boxes.empty()) return;
    GNOMON_CHECK(boxes.size() < k_none / 2);
    std::vector<std::uint32_t> order(boxes.size());
    std::iota(order.begin(), order.end(), 0u);
    const auto place = [&](std::uint32_t index) {   // empty and infinite boxes are placed at the origin
        const glm::vec3 centre = boxes[index].empty() ? glm::vec3(0) : boxes[index].centre();
        return is_finite(centre) ? centre : glm::vec3(0);
    };
    struct Open {
        std::uint32_t node, begin, end;
    };
    nodes_.reserve(2 * boxes.size() - 1);
    nodes_.emplace_back();
    // Split nodes top-down, with a stack of ranges of `order`.
    std::vector<Open> open{{0, 0, static_cast<std::uint32_t>(boxes.size())}};
    while (!open.empty()) {
        const Open at = open.back();
        open.pop_back();
        if (at.end - at.begin == 1) {
            const std::uint32_t index = order[at.begin];
            nodes_[at.node].box = boxes[index];
            nodes_[at.node].index = index;
            leaf_[index] = at.node;
            continue;
        }
        Box3 centres;
        for (std::uint32_t i = at.begin; i < at.end; ++i) {
            nodes_[at.node].box.add(boxes[order[i]]);
            centres.add(place(order[i]));
        }
        // Split at the median along the longest axis of the centres. Break ties by index, so that the tree is
        // deterministic.
        const glm::vec3 size = centres.size();
        const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
        const std::uint32_t middle = at.begin + (at.end - at.begin) / 2;
        std::nth_element(order.begin() + at.begin, order.begin() + middle, order.begin() + at.end,
                         [&](std::uint32_t a, std::uint32_t b) {
                             const float x = place(a)[axis], y = place(b)[axis];
                             return x != y ? x < y : a < b;
                         });
        // Store the two children next to each other.
        const auto child = static_cast<std::uint32_t>(nodes_.size());
        nodes_[at.node].child = child;
        nodes_.emplace_back().parent = at.node;
        nodes_.emplace_back().parent = at.node;
        open.push_back({child, at.begin, middle});
        open.push_back({child + 1, middle, at.end});
    }
    built_surface_ = surface();
}

double BoxTree::surface() const
{
    double sum = 0;
    for (const Node& node : nodes_)
        if (node.child != k_none) sum += surface_of(node.box);
    return sum;
}

void BoxTree::move(std::uint32_t index, const Box3& box)
{
    std::uint32_t at = leaf_[index];
    if (same(nodes_[at].box, box)) return;
    nodes_[at].box = box;
    while ((at = nodes_[at].parent) != k_none) {
        Box3 both = nodes_[nodes_[at].child].box;
        both.add(nodes_[nodes_[at].child + 1].box);
        if (same(both, nodes_[at].box)) break;
        nodes_[at].box = both;
    }
    if (++moves_ < size()) return;
    moves_ = 0;
    if (surface() <= k_max_growth * built_surface_) return;
    std::vector<Box3> boxes(size());
    for (std::uint32_t i = 0; i < boxes.size(); ++i) boxes[i] = (*this)[i];
    build(boxes);
}

}   // namespace gnomon
