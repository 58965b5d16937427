// SPDX-License-Identifier: Apache-2.0
#include "area_light/part_tree.h"

#include <algorithm>
#include <array>
#include <deque>

#include "ray/origin.h"

namespace gnomon::area_light {

namespace {

using visibility::StaticTriangle;
using visibility::StaticTriangles;
using visibility::TriangleId;

constexpr std::size_t k_shards = 256;
// Of a divided part, a list up to this length is kept for its quarters; longer ones are found in the tree again.
constexpr std::size_t k_handed_down = 2048;

// Which quarter of a part another one is, in the order of children_of().
std::size_t quarter_of(const MicroTriangle& part, const MicroTriangle& next)
{
    if (next.upper != part.upper) return 3;
    const std::size_t i = next.i & 1, j = next.j & 1;
    return next.upper ? (1 - i) + 2 * (1 - j) : i + 2 * j;
}

}   // namespace

struct PartTree::Node {
    enum class Kind : std::uint8_t { unknown, divided, decided };
    std::atomic<Kind> kind = Kind::unknown;   // the rest is constant once it is known
    PartState state = PartState::open;
    Node* quarters = nullptr;   // four; of a divided part
    std::unique_ptr<std::vector<TriangleId>> list;
};

struct PartTree::Shard {
    std::mutex mutex;
    std::deque<std::array<Node, 4>> nodes;
    AreaCounters counters;
    std::size_t list_bytes = 0;

    void keep(Node& node, std::vector<TriangleId>&& list)
    {
        list_bytes += sizeof list + list.capacity() * sizeof(TriangleId);
        node.list = std::make_unique<std::vector<TriangleId>>(std::move(list));
    }
};

Piece::Piece(const StaticTriangle& triangle, bool front, const MicroTriangle& part, std::uint32_t level)
{
    const glm::dvec3 a(triangle.p[0]), ab = glm::dvec3(triangle.p[1]) - a, ac = glm::dvec3(triangle.p[2]) - a;
    normal = glm::cross(ab, ac);
    const double length = glm::length(normal);
    if (!(length > 0)) {
        normal = glm::dvec3(0);
        return;
    }
    normal *= (front ? 1 : -1) / length;
    distance = -glm::dot(normal, a);
    glm::dvec2 uv[3];
    corners_of(part, level, uv);
    for (int c = 0; c < 3; ++c) corner[c] = a + uv[c].x * ab + uv[c].y * ac;
    for (int c = 0; c < 3; ++c) size = std::max(size, glm::length(corner[(c + 1) % 3] - corner[c]));
    lift = static_cast<double>(ray::origin_lift(triangle.p));
}

void AreaCounters::add(const AreaCounters& other)
{
    parts += other.parts, listed_triangles += other.listed_triangles;
    for (std::size_t k = 0; k < std::size(states); ++k) states[k] += other.states[k];
}

PartTree::PartTree(const StaticTriangles& triangles, int most_levels)
    : triangles_(triangles),
      finest_level_(static_cast<std::uint32_t>(most_levels)),
      roots_(std::make_unique<std::atomic<Node*>[]>(2 * triangles.size())),
      shards_(std::make_unique<Shard[]>(k_shards))
{
}

PartTree::~PartTree() = default;

Part PartTree::part_at(TriangleId triangle, bool front, float u, float v, LastPart& last)
{
    const std::size_t record = 2 * std::size_t{triangle} + (front ? 1 : 0);
    const MicroTriangle finest = micro_part_at(u, v, finest_level_);   // those of all levels follow from it
    if (last.owner == this && last.record == record && ancestor_of(finest, finest_level_ - last.level) == last.place)
        return last.part;
    Node* node = roots_[record].load(std::memory_order_acquire);
    const std::vector<TriangleId>* from = nullptr;
    MicroTriangle here = ancestor_of(finest, finest_level_);
    for (std::uint32_t level = 0;; ++level) {
        Node::Kind kind = node ? node->kind.load(std::memory_order_acquire) : Node::Kind::unknown;
        if (kind == Node::Kind::unknown) {
            node = judge_node(record, node, triangle, front, here, level, from);
            kind = node->kind.load(std::memory_order_acquire);
        }
        if (kind == Node::Kind::decided) {
            last = {this, record, level, here, {node->state, node->list.get()}};
            return last.part;
        }
        if (node->list) from = node->list.get();
        const MicroTriangle next = ancestor_of(finest, finest_level_ - level - 1);
        node = node->quarters + quarter_of(here, next);
        here = next;
    }
}

// Judges a part that is unknown, unless another thread has just done so.
// @param node  null: the whole triangle's, which is made
PartTree::Node* PartTree::judge_node(std::size_t record, Node* node, TriangleId triangle, bool front,
                                     const MicroTriangle& part, std::uint32_t level,
                                     const std::vector<TriangleId>* from)
{
    // Several threads may judge the same part: all with the same result, of which one is kept.
    Verdict verdict = judge(triangle, front, part, level, from);
    verdict.list.shrink_to_fit();
    Shard& shard = shards_[(record * 0x9e3779b97f4a7c15ull) >> 56];
    const std::lock_guard lock(shard.mutex);
    if (!node) {
        node = roots_[record].load(std::memory_order_relaxed);
        if (!node) {
            node = &shard.nodes.emplace_back()[0];
            roots_[record].store(node, std::memory_order_release);
        }
    }
    if (node->kind.load(std::memory_order_relaxed) != Node::Kind::unknown) return node;
    ++shard.counters.parts;
    if (verdict.divides) {
        node->quarters = shard.nodes.emplace_back().data();
        if (verdict.list.size() <= k_handed_down) shard.keep(*node, std::move(verdict.list));
        node->kind.store(Node::Kind::divided, std::memory_order_release);
        return node;
    }
    node->state = verdict.state;
    ++shard.counters.states[static_cast<std::size_t>(verdict.state)];
    if (verdict.state == PartState::listed) {
        shard.counters.listed_triangles += verdict.list.size();
        shard.keep(*node, std::move(verdict.list));
    }
    node->kind.store(Node::Kind::decided, std::memory_order_release);
    return node;
}

Part PartTree::judged_anew(TriangleId triangle, bool front, float u, float v, std::vector<TriangleId>& list) const
{
    const MicroTriangle finest = micro_part_at(u, v, finest_level_);
    std::vector<TriangleId> from;
    bool handed_down = false;
    for (std::uint32_t level = 0;; ++level) {
        Verdict verdict =
            judge(triangle, front, ancestor_of(finest, finest_level_ - level), level, handed_down ? &from : nullptr);
        if (!verdict.divides) {
            list = std::move(verdict.list);
            return {verdict.state, verdict.state == PartState::listed ? &list : nullptr};
        }
        if (verdict.list.size() > k_handed_down) continue;
        from = std::move(verdict.list);
        handed_down = true;
    }
}

AreaCounters PartTree::counters() const
{
    AreaCounters sum;
    for (std::size_t s = 0; s < k_shards; ++s) {
        const std::lock_guard lock(shards_[s].mutex);
        sum.add(shards_[s].counters);
    }
    return sum;
}

std::size_t PartTree::bytes() const
{
    std::size_t bytes = 2 * triangles_.size() * sizeof(roots_[0]);
    for (std::size_t s = 0; s < k_shards; ++s) {
        const std::lock_guard lock(shards_[s].mutex);
        bytes += shards_[s].nodes.size() * sizeof(std::array<Node, 4>) + shards_[s].list_bytes;
    }
    return bytes;
}

}   // namespace gnomon::area_light
