// SPDX-License-Identifier: Apache-2.0
#include "environment_light/cell_proofs.h"

#include <algorithm>
#include <array>
#include <bit>
#include <deque>
#include <unordered_map>

#include "ray/origin.h"

namespace gnomon::environment_light {

namespace {

using visibility::StaticTriangle;
using visibility::StaticTriangles;
using visibility::TriangleId;

constexpr std::size_t k_shards = 64;
constexpr std::uint32_t k_triangle = 0x80000000u;   // marks an item that is a triangle, not a node
// A leaf whose direction is steeper than this sine above the surface is judged by its direction alone.
constexpr double k_clear_of_horizon = 2e-3;
constexpr double k_below_horizon = 1e-6;

bool has(const std::vector<std::uint64_t>& mask, std::size_t leaf)
{
    return (mask[leaf / 64] >> (leaf % 64) & 1) != 0;
}
void set(std::vector<std::uint64_t>& mask, std::size_t leaf)
{
    mask[leaf / 64] |= std::uint64_t{1} << (leaf % 64);
}
void clear(std::vector<std::uint64_t>& mask, std::size_t leaf)
{
    mask[leaf / 64] &= ~(std::uint64_t{1} << (leaf % 64));
}
std::uint64_t count(const std::vector<std::uint64_t>& mask)
{
    std::uint64_t sum = 0;
    for (const std::uint64_t word : mask) sum += static_cast<std::uint64_t>(std::popcount(word));
    return sum;
}

}   // namespace

struct CellProofs::Node {
    std::atomic<std::uint32_t> asks{0};
    std::atomic<bool> growing{false};               // somebody judges or divides it
    std::atomic<const PartMasks*> masks{nullptr};   // null: not judged
    std::atomic<std::array<Node, 4>*> quarters{nullptr};
    std::atomic<bool> final{false};    // smaller parts would not know more
    std::atomic<bool> shares{false};   // leaves are judged as a whole
    std::unique_ptr<PartMasks> own;
};

struct CellProofs::Shard {
    std::mutex mutex;
    std::deque<std::array<Node, 4>> nodes;
    ProofCounters counters;
};

CellProofs::CellProofs(const StaticTriangles& triangles, const DirectionCells& cells, const ProofOptions& options)
    : triangles_(triangles),
      cells_(cells),
      options_(options),
      roots_(std::make_unique<std::atomic<Node*>[]>(2 * triangles.size())),
      shards_(std::make_unique<Shard[]>(k_shards))
{
    nothing_.free.assign(cells.words(), 0);
    nothing_.open.assign(cells.words(), 0);
    nothing_.whole.assign(cells.words(), 0);
    for (std::size_t leaf = 0; leaf < cells.leaves(); ++leaf) set(nothing_.open, leaf);
}

CellProofs::~CellProofs() = default;

// Judges the cells of one part.
class CellProofs::Judge {
 public:
    Judge(const CellProofs& owner, TriangleId receiver, const glm::dvec3 (&corner)[3], const glm::dvec3& normal,
          double lift, bool whole, PartMasks& masks)
        : triangles_(owner.triangles_),
          cells_(owner.cells_),
          options_(owner.options_),
          receiver_(receiver),
          corner_{corner[0], corner[1], corner[2]},
          normal_(normal),
          lift_(lift),
          whole_(whole),
          masks_(masks)
    {
        for (const glm::dvec3& c : corner) centre_ += c / 3.0;
        centre_ += lift * normal;
        const Box3& box = triangles_.bounds();
        far_ = 2 * (glm::length(glm::dvec3(box.high) - glm::dvec3(box.low)) +
                    glm::length(centre_ - glm::dvec3(box.centre())));
    }

    void run()
    {
        if (!triangles_.tree().empty()) items_.push_back(0);
        for (std::uint32_t r = 0; r < cells_.roots(); ++r) judge(r, 0, triangles_.tree().empty() ? 0 : 1);
    }

 private:
    bool leaves_out(ProofCheck check) const { return options_.left_out == check; }

    // Decides a cell, or its parts.
    // @param begin, end  of the items that may meet it
    void judge(std::uint32_t at, std::size_t begin, std::size_t end)
    {
        const DirectionNode& node = cells_.nodes()[at];
        const bool leaf = node.children == 0;
        if (wants(node) && (!leaf || whole_)) judge(node, false, begin, end);
        if (leaf && has(masks_.open, node.first_leaf)) judge(node, true, begin, end);
    }

    // @param thin  a leaf's own direction alone
    void judge(const DirectionNode& node, bool thin, std::size_t begin, std::size_t end)
    {
        const bool leaf = node.children == 0;
        std::array<glm::dvec3, 4> direction = node.corner;
        int directions = node.corners;
        glm::dvec3 steepest = direction[0];
        for (int c = 1; c < directions; ++c) {
            const glm::dvec3& d = direction[static_cast<std::size_t>(c)];
            if (glm::dot(d, normal_) > glm::dot(steepest, normal_)) steepest = d;
        }
        if (glm::dot(steepest, normal_) < -k_below_horizon) return decide(node, false, true);
        glm::dvec3 middle(node.axis);
        if (thin) {
            const glm::dvec3 own(cells_.direction(node.first_leaf));
            if (glm::dot(own, normal_) > k_clear_of_horizon) direction[0] = middle = own, directions = 1;
        }
        if (leaves_out(ProofCheck::whole_cell)) direction[0] = middle, directions = 1;
        if (tests_ > options_.most_tests) return;
        const glm::dvec3 one[3] = {corner_[0], corner_[0], corner_[0]};
        const EndlessPrism prism(leaves_out(ProofCheck::whole_part) ? one : corner_, normal_,
                                 {direction.data(), static_cast<std::size_t>(directions)}, lift_, options_.prism);

        // Keep what may meet it, and open nodes as long as there are few.
        const std::size_t kept = items_.size();
        int may_open = leaf ? options_.opened_at_leaf : options_.opened;
        bool triangles_only = true;
        for (std::size_t i = begin; i < end; ++i) take(items_[i], prism, may_open, triangles_only);
        if (items_.size() == kept) return decide(node, true, !thin);
        if (triangles_only) {
            ClippedTriangle inside;
            items_.erase(std::remove_if(items_.begin() + static_cast<std::ptrdiff_t>(kept), items_.end(),
                                        [&](std::uint32_t item) {
                                            ++tests_;
                                            return !prism.clip(triangles_[item & ~k_triangle], inside);
                                        }),
                         items_.end());
            if (items_.size() == kept) return decide(node, true, !thin);
        }
        // The ray that counts crossings must lie in the prism.
        if (glm::dot(middle, normal_) <= k_clear_of_horizon) middle = steepest;
        if (glm::dot(middle, normal_) > k_clear_of_horizon && is_blocked(prism, middle)) {
            items_.resize(kept);
            return decide(node, false, !thin);
        }
        if (!leaf) {
            const std::size_t last = items_.size();
            for (std::uint32_t q = 0; q < node.count; ++q) judge(node.children + q, kept, last);
        }
        items_.resize(kept);
    }

    bool wants(const DirectionNode& node) const
    {
        for (std::size_t leaf = node.first_leaf; leaf < node.first_leaf + node.leaves; ++leaf)
            if (has(masks_.open, leaf) || (whole_ && !has(masks_.whole, leaf))) return true;
        return false;
    }
    void decide(const DirectionNode& node, bool is_free, bool whole)
    {
        for (std::size_t leaf = node.first_leaf; leaf < node.first_leaf + node.leaves; ++leaf) {
            if (whole) set(masks_.whole, leaf);
            if (!has(masks_.open, leaf)) continue;
            clear(masks_.open, leaf);
            if (is_free) set(masks_.free, leaf);
        }
    }

    void take(std::uint32_t item, const EndlessPrism& prism, int& may_open, bool& triangles_only)
    {
        ++tests_;
        if (item & k_triangle) {
            if (prism.may_meet(triangles_[item & ~k_triangle])) items_.push_back(item);
            return;
        }
        const StaticTriangles::Node& node = triangles_.tree()[item];
        if (!prism.may_meet(node.low, node.high)) return;
        if (may_open <= 0) {
            items_.push_back(item);
            triangles_only = false;
            return;
        }
        --may_open;
        if (node.count == 0) {
            take(node.first, prism, may_open, triangles_only);
            take(node.first + 1, prism, may_open, triangles_only);
        }
        for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
            const TriangleId id = triangles_.in_leaf(i);
            if (id != visibility::no_triangle && id != receiver_)
                take(id | k_triangle, prism, may_open, triangles_only);
        }
    }

    bool is_blocked(const EndlessPrism& prism, const glm::dvec3& middle)
    {
        const glm::dvec3 to = centre_ + far_ * middle;
        constexpr std::size_t k_tries = 2;
        found_.clear();
        triangles_.along(centre_, to - centre_, k_tries, found_);
        const auto is_clear = [&](const StaticTriangle& t, double coordinate) {
            ClippedTriangle inside;
            if (leaves_out(ProofCheck::clear_of_part) || !prism.clip(t, inside)) return true;
            const double clear_of = options_.clearance * prism.lift_for(coordinate);
            for (int c = 0; c < inside.count; ++c)
                if (prism.height(inside.corner[static_cast<std::size_t>(c)]) < clear_of) return false;
            return true;
        };
        const visibility::PatchOptions patch{options_.most_triangles, !leaves_out(ProofCheck::no_open_edge),
                                             !leaves_out(ProofCheck::signs), !leaves_out(ProofCheck::crosses)};
        tests_ += 30 * static_cast<int>(found_.size());
        return std::ranges::any_of(found_, [&](TriangleId id) {
            return id != receiver_ && visibility::closes(triangles_, prism, is_clear, id, centre_, to, patch);
        });
    }

    const StaticTriangles& triangles_;
    const DirectionCells& cells_;
    const ProofOptions& options_;
    TriangleId receiver_;
    glm::dvec3 corner_[3], normal_, centre_{0};
    double lift_, far_ = 0;
    bool whole_;
    PartMasks& masks_;
    std::vector<std::uint32_t> items_;   // of all cells that are being judged, one above the other
    std::vector<TriangleId> found_;
    int tests_ = 0;
};

PartMasks CellProofs::judge(TriangleId triangle, bool front, const MicroTriangle& part, std::uint32_t level,
                            const PartMasks* from, bool whole) const
{
    PartMasks masks = from ? *from : nothing_;
    const StaticTriangle& receiver = triangles_[triangle];
    const glm::dvec3 a(receiver.p[0]), ab = glm::dvec3(receiver.p[1]) - a, ac = glm::dvec3(receiver.p[2]) - a;
    glm::dvec3 normal = glm::cross(ab, ac);
    const double length = glm::length(normal);
    if (!(length > 0)) return masks;
    normal *= (front ? 1 : -1) / length;
    glm::dvec2 uv[3];
    corners_of(part, level, uv);
    glm::dvec3 corner[3];
    for (int c = 0; c < 3; ++c) corner[c] = a + uv[c].x * ab + uv[c].y * ac;
    Judge(*this, triangle, corner, normal, static_cast<double>(ray::origin_lift(receiver.p)), whole, masks).run();
    return masks;
}

CellProofs::Node* CellProofs::root(std::size_t record)
{
    Node* node = roots_[record].load(std::memory_order_acquire);
    if (node) return node;
    Shard& shard = shards_[record % k_shards];
    const std::lock_guard lock(shard.mutex);
    node = roots_[record].load(std::memory_order_relaxed);
    if (!node) {
        node = &shard.nodes.emplace_back()[0];
        roots_[record].store(node, std::memory_order_release);
    }
    return node;
}

const PartMasks& CellProofs::part_at(TriangleId triangle, bool front, float u, float v)
{
    const std::size_t record = 2 * std::size_t{triangle} + (front ? 1 : 0);
    Node* node = root(record);
    const PartMasks* known = &nothing_;
    const MicroPath path(u, v, options_.most_levels);
    for (std::uint32_t level = 0;; ++level) {
        if (const PartMasks* own = node->masks.load(std::memory_order_acquire)) known = own;
        if (std::array<Node, 4>* quarters = node->quarters.load(std::memory_order_acquire)) {
            node = &(*quarters)[path.quarter(level)];
            continue;
        }
        if (node->final.load(std::memory_order_relaxed)) return *known;
        const bool judged = node->masks.load(std::memory_order_relaxed) != nullptr;
        const auto due = static_cast<std::uint32_t>(judged ? options_.more_asks : options_.first_asks);
        if (node->asks.fetch_add(1, std::memory_order_relaxed) + 1 < due || node->growing.exchange(true)) return *known;
        grow(record, *node, triangle, front, path.at[level], level, *known);
        const PartMasks* own = node->masks.load(std::memory_order_acquire);
        return own ? *own : *known;
    }
}

void CellProofs::ask_for_shares(TriangleId triangle, bool front, float u, float v, std::uint32_t asks)
{
    Node* node = root(2 * std::size_t{triangle} + (front ? 1 : 0));
    const MicroPath path(u, v, options_.most_levels);
    int level = 0;
    while (std::array<Node, 4>* quarters = node->quarters.load(std::memory_order_acquire))
        node = &(*quarters)[path.quarter(static_cast<std::uint32_t>(level++))];
    // One that was judged without it may gain from quarters that are judged with it.
    if (!node->shares.exchange(true, std::memory_order_relaxed) && level < options_.most_levels) node->final = false;
    node->asks.fetch_add(asks, std::memory_order_relaxed);
}

// Judges a node that is not judged, or divides it.
void CellProofs::grow(std::size_t record, Node& node, TriangleId triangle, bool front, const MicroTriangle& part,
                      std::uint32_t level, const PartMasks& from)
{
    Shard& shard = shards_[record % k_shards];
    if (!node.masks.load(std::memory_order_relaxed)) {
        const bool shares = node.shares;
        auto made = std::make_unique<PartMasks>(judge(triangle, front, part, level, &from, shares));
        const std::uint64_t open = count(made->open), free = count(made->free);
        const std::uint64_t unknown = shares ? cells_.leaves() - count(made->whole) : open,
                            before = shares ? cells_.leaves() - count(from.whole) : count(from.open);
        const bool gained =
            level == 0 || static_cast<double>(before - unknown) >= options_.least_gain * static_cast<double>(before);
        const std::lock_guard lock(shard.mutex);
        ++shard.counters.parts;
        shard.counters.open += open, shard.counters.free += free;
        shard.counters.blocked += cells_.leaves() - open - free;
        node.own = std::move(made);
        node.final = unknown == 0 || !gained || static_cast<int>(level) >= options_.most_levels;
        node.asks = 0;
        node.masks.store(node.own.get(), std::memory_order_release);
        node.growing = false;
        return;
    }
    const std::lock_guard lock(shard.mutex);
    std::array<Node, 4>& quarters = shard.nodes.emplace_back();
    for (Node& quarter : quarters) quarter.shares = node.shares.load();
    node.quarters.store(&quarters, std::memory_order_release);
}

void CellProofs::take_over(const CellProofs& other)
{
    // Find for each leaf the cell of the other set at the same place.
    std::unordered_map<std::uint64_t, std::uint32_t> there;
    for (std::uint32_t n = 0; n < other.cells_.nodes().size(); ++n) there.emplace(other.cells_.nodes()[n].place, n);
    std::vector<const DirectionNode*> same(cells_.leaves(), nullptr);
    for (std::size_t leaf = 0; leaf < cells_.leaves(); ++leaf)
        if (const auto at = there.find(cells_.nodes()[cells_.node_of(leaf)].place); at != there.end())
            same[leaf] = &other.cells_.nodes()[at->second];
    const auto translated = [&](const PartMasks& from) {
        PartMasks masks = nothing_;
        for (std::size_t leaf = 0; leaf < same.size(); ++leaf) {
            if (!same[leaf]) continue;
            std::size_t free = 0, open = 0;
            for (std::size_t l = same[leaf]->first_leaf; l < same[leaf]->first_leaf + same[leaf]->leaves; ++l)
                free += has(from.free, l), open += has(from.open, l);
            // Of a cell that was divided, its leaves' directions were judged, not those between them.
            if (open > 0 || same[leaf]->leaves > 1) continue;
            clear(masks.open, leaf);
            if (free > 0) set(masks.free, leaf);
            if (has(from.whole, same[leaf]->first_leaf)) set(masks.whole, leaf);
        }
        return masks;
    };
    const auto copy = [&](const auto& self, const Node& from, Node& to, Shard& shard) -> void {
        if (from.own) {
            to.own = std::make_unique<PartMasks>(translated(*from.own));
            to.masks = to.own.get();
            to.final = from.final.load() && count(to.own->open) <= count(from.own->open);
        }
        const std::array<Node, 4>* quarters = from.quarters.load();
        if (!quarters) return;
        std::array<Node, 4>& four = shard.nodes.emplace_back();
        to.quarters = &four;
        for (std::size_t q = 0; q < 4; ++q) self(self, (*quarters)[q], four[q], shard);
    };
    for (std::size_t record = 0; record < 2 * triangles_.size(); ++record)
        if (const Node* from = other.roots_[record].load())
            copy(copy, *from, *root(record), shards_[record % k_shards]);
}

ProofCounters CellProofs::counters() const
{
    ProofCounters sum;
    for (std::size_t s = 0; s < k_shards; ++s) {
        const std::lock_guard lock(shards_[s].mutex);
        const ProofCounters& c = shards_[s].counters;
        sum.parts += c.parts, sum.free += c.free, sum.blocked += c.blocked, sum.open += c.open;
    }
    return sum;
}

std::size_t CellProofs::bytes() const
{
    std::size_t bytes = 2 * triangles_.size() * sizeof(roots_[0]);
    for (std::size_t s = 0; s < k_shards; ++s) {
        const std::lock_guard lock(shards_[s].mutex);
        bytes += shards_[s].nodes.size() * sizeof(std::array<Node, 4>);
        for (const auto& four : shards_[s].nodes)
            for (const Node& node : four)
                if (node.masks.load(std::memory_order_acquire))
                    bytes += sizeof(PartMasks) + 3 * cells_.words() * sizeof(std::uint64_t);
    }
    return bytes;
}

}   // namespace gnomon::environment_light
