// SPDX-License-Identifier: Apache-2.0
#include "ray/portable/tree.h"

#include <algorithm>
#include <cmath>

#include "base/interruption.h"

namespace gnomon::ray {

namespace {

constexpr int k_bins = 16;
constexpr float k_triangle_cost = 0.3f;   // in units of the cost of a node
constexpr std::size_t k_leaf_triangles = 8;
constexpr int k_deepest_sorted = 24;   // nodes below that are halved, so that no tree is deeper than 24 + 10 nodes
constexpr std::size_t k_interruption_step = 4096;
// Triangles with larger coordinates are no part of a tree, as in Embree.
constexpr float k_largest_met = 1e18f;

float largest(const glm::vec3& v)
{
    const glm::vec3 a = glm::abs(v);
    return std::max({a.x, a.y, a.z});
}

Box3 with_margin(const Box3& box)
{
    const float margin = k_box_margin * std::max(largest(box.low), largest(box.high));
    return {box.low - margin, box.high + margin};
}

float half_area(const Box3& box)
{
    const glm::vec3 s = box.high - box.low;
    return box.empty() ? 0 : s.x * s.y + s.y * s.z + s.z * s.x;
}

void put_box(TreeNode& node, unsigned i, const Box3& box)
{
    for (int axis = 0; axis < 3; ++axis) {
        node.low[axis][i] = box.low[axis];
        node.high[axis][i] = box.high[axis];
    }
}

Box3 box_of(const TreeNode& node)
{
    Box3 result;
    for (unsigned i = 0; i < node.count; ++i)
        result.add(Box3{{node.low[0][i], node.low[1][i], node.low[2][i]},
                        {node.high[0][i], node.high[1][i], node.high[2][i]}});
    return result;
}

/// Builds the nodes over a list of items.
/// Leaf: std::uint32_t(std::span<const TreeItem>), which stores the items and returns the leaf's code.
template <class Leaf>
class Builder {
 public:
    Builder(std::vector<TreeItem>& items, std::vector<TreeNode>& nodes, std::size_t most, float item_cost, Leaf leaf)
        : items_(items), nodes_(nodes), most_(most), item_cost_(item_cost), leaf_(leaf)
    {
    }

    /// Makes the root, node 0. @pre there are items
    Box3 build()
    {
        nodes_.clear();
        Range all{0, items_.size(), {}, false};
        for (const TreeItem& item : items_) all.box.add(item.box);
        nodes_.emplace_back();
        if (all.size() <= most_)
            put_leaf(0, 0, all), nodes_[0].count = 1;
        else
            fill(0, all, 0);
        return all.box;
    }

 private:
    struct Range {
        std::size_t begin, end;
        Box3 box;
        bool final;   // splitting it does not pay
        std::size_t size() const { return end - begin; }
    };

    void put_leaf(std::uint32_t node, unsigned i, const Range& range)
    {
        const std::uint32_t code = leaf_(std::span<const TreeItem>(items_.data() + range.begin, range.size()));
        put_box(nodes_[node], i, range.box);
        nodes_[node].child[i] = code;
    }

    // Splits a range into up to eight by splitting the one with the largest box again and again.
    void fill(std::uint32_t node, const Range& range, int depth)
    {
        if ((++made_ & (k_interruption_step - 1)) == 0) interruption_point();
        Range parts[TreeNode::k_width] = {range};
        unsigned count = 1;
        while (count < TreeNode::k_width) {
            unsigned which = TreeNode::k_width;
            float area = -1;
            for (unsigned i = 0; i < count; ++i)
                if (!parts[i].final && half_area(parts[i].box) > area) which = i, area = half_area(parts[i].box);
            if (which == TreeNode::k_width) break;
            Range left, right;
            if (split(parts[which], depth, left, right))
                parts[which] = left, parts[count++] = right;
            else
                parts[which].final = true;
        }
        // The largest first, because rays that look for any hit most likely find it there.
        std::stable_sort(parts, parts + count,
                         [](const Range& a, const Range& b) { return half_area(a.box) > half_area(b.box); });
        nodes_[node].count = count;
        for (unsigned i = 0; i < count; ++i) {
            if (parts[i].final || parts[i].size() <= 1) {
                put_leaf(node, i, parts[i]);
                continue;
            }
            const auto child = static_cast<std::uint32_t>(nodes_.size());
            nodes_.emplace_back();
            put_box(nodes_[node], i, parts[i].box);
            nodes_[node].child[i] = child;
            fill(child, parts[i], depth + 1);
        }
    }

    struct Bin {
        Box3 box;
        std::size_t count = 0;
    };

    // @return false if the range is to be a leaf
    bool split(const Range& range, int depth, Range& left, Range& right)
    {
        const std::size_t n = range.size();
        if (n <= 1) return false;
        Box3 centres;
        for (std::size_t i = range.begin; i < range.end; ++i) centres.add(items_[i].box.centre());
        float best = k_infinity;
        int best_axis = -1, best_bin = 0;
        glm::vec3 scale(0);   // 0: the axis is not split
        for (int axis = 0; axis < 3; ++axis) {
            const float extent = centres.high[axis] - centres.low[axis];
            if (extent > 0 && std::isfinite(k_bins / extent)) scale[axis] = k_bins / extent;
        }
        if (depth < k_deepest_sorted) {
            for (auto& bins : bins_) bins.fill({});
            for (std::size_t i = range.begin; i < range.end; ++i) {
                const TreeItem& item = items_[i];
                for (int axis = 0; axis < 3; ++axis) {
                    Bin& bin = bins_[static_cast<std::size_t>(axis)][bin_of(item, axis, centres.low, scale)];
                    bin.box.add(item.box);
                    ++bin.count;
                }
            }
            for (int axis = 0; axis < 3; ++axis) {
                if (!(scale[axis] > 0)) continue;
                const auto& bins = bins_[static_cast<std::size_t>(axis)];
                std::array<float, k_bins> after;
                Box3 box;
                std::size_t count = 0;
                for (std::size_t i = k_bins - 1; i > 0; --i) {
                    box.add(bins[i].box), count += bins[i].count;
                    after[i] = count > 0 ? half_area(box) * static_cast<float>(count) : k_infinity;
                }
                box = {}, count = 0;
                for (std::size_t i = 1; i < k_bins; ++i) {
                    box.add(bins[i - 1].box), count += bins[i - 1].count;
                    if (count == 0) continue;
                    const float cost = half_area(box) * static_cast<float>(count) + after[i];
                    if (cost < best) best = cost, best_axis = axis, best_bin = static_cast<int>(i);
                }
            }
        }
        const float area = half_area(range.box);
        if (n <= most_ && !(area + item_cost_ * best < item_cost_ * area * static_cast<float>(n))) return false;
        left = {range.begin, (range.begin + range.end) / 2, {}, false}, right = {0, range.end, {}, false};
        if (best_axis >= 0) {
            const auto begin = items_.begin() + static_cast<std::ptrdiff_t>(range.begin);
            const auto past = std::partition(
                begin, items_.begin() + static_cast<std::ptrdiff_t>(range.end), [&](const TreeItem& item) {
                    return bin_of(item, best_axis, centres.low, scale) < static_cast<std::size_t>(best_bin);
                });
            left.end = static_cast<std::size_t>(past - items_.begin());
            const auto& bins = bins_[static_cast<std::size_t>(best_axis)];
            for (std::size_t i = 0; i < k_bins; ++i)
                (i < static_cast<std::size_t>(best_bin) ? left : right).box.add(bins[i].box);
        }
        right.begin = left.end;
        if (best_axis < 0)
            for (Range* part : {&left, &right})
                for (std::size_t i = part->begin; i < part->end; ++i) part->box.add(items_[i].box);
        return true;
    }

    static std::size_t bin_of(const TreeItem& item, int axis, const glm::vec3& low, const glm::vec3& scale)
    {
        const float place = (item.box.centre()[axis] - low[axis]) * scale[axis];
        return static_cast<std::size_t>(std::clamp(static_cast<int>(place), 0, k_bins - 1));
    }

    std::vector<TreeItem>& items_;
    std::vector<TreeNode>& nodes_;
    std::size_t most_;
    float item_cost_;
    Leaf leaf_;
    std::size_t made_ = 0;
    std::array<std::array<Bin, k_bins>, 3> bins_;
};

// The box of one triangle, with the margin; empty if it cannot be met.
Box3 box_of(const GeometryRecord& record, std::uint32_t triangle)
{
    const glm::uvec3 index = record.mesh->triangles[record.first_triangle + triangle];
    Box3 box;
    for (int c = 0; c < 3; ++c) {
        const glm::vec3& p = record.vertices->positions[index[c]];
        if (!(largest(p) < k_largest_met)) return {};
        box.add(p);
    }
    return with_margin(box);
}

}   // namespace

// Whether the rounding of a triangle's normal may put its plane farther off, at its far end, than a fraction of the
// height at which rays start.
static bool is_narrow(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c)
{
    constexpr float k_narrow = 0.25f;   // four units of rounding (2^-23) over ray::k_lift_per_coordinate
    float largest = 0;
    for (const glm::vec3* p : {&a, &b, &c})
        largest = std::max({largest, std::abs(p->x), std::abs(p->y), std::abs(p->z)});
    const float longest = std::max({glm::distance(a, b), glm::distance(b, c), glm::distance(c, a)});
    return glm::length(glm::cross(b - a, c - a)) * largest < k_narrow * longest * longest * longest;
}

void TriangleTree::fill(TriangleBlock& block, unsigned lane, std::uint32_t geometry, std::uint32_t triangle) const
{
    const GeometryRecord& r = (*records_)[geometry];
    const glm::uvec3 index = r.mesh->triangles[r.first_triangle + triangle];
    for (int c = 0; c < 3; ++c)
        for (int axis = 0; axis < 3; ++axis) block.corner[c][axis][lane] = r.vertices->positions[index[c]][axis];
    block.geometry[lane] = geometry, block.triangle[lane] = triangle;
    block.mask[lane] = static_cast<std::uint8_t>(r.mask);
    block.judged_closest[lane] = r.masked;
    const auto bit = static_cast<std::uint8_t>(1u << lane);
    for (std::uint8_t& side : block.unmet) side &= static_cast<std::uint8_t>(~bit);
    if (r.one_sided && r.scene->materials[r.mesh->part_of(r.first_triangle + triangle).material].one_sided())
        block.unmet[r.mirrored ? 0 : 1] |= bit;
    block.judged_any[lane] = r.masked || r.thins ? TriangleBlock::k_by_material : 0;
    if (is_narrow(r.vertices->positions[index[0]], r.vertices->positions[index[1]], r.vertices->positions[index[2]]))
        block.judged_any[lane] |= TriangleBlock::k_by_distance;
}

void TriangleTree::build(const std::deque<GeometryRecord>& records)
{
    records_ = &records;
    nodes_.clear(), blocks_.clear(), box_ = {};
    std::vector<TreeItem> items;
    std::vector<std::pair<std::uint32_t, std::uint32_t>> places;   // by item id: geometry and triangle
    for (std::uint32_t g = 0; g < records.size(); ++g) {
        if (!records[g].attached) continue;
        for (std::uint32_t t = 0; t < records[g].triangles; ++t) {
            const Box3 box = box_of(records[g], t);
            if (box.empty()) continue;
            items.push_back({box, static_cast<std::uint32_t>(places.size())});
            places.emplace_back(g, t);
        }
    }
    if (items.empty()) return;
    blocks_.reserve(items.size() / 3);
    const auto leaf = [&](std::span<const TreeItem> range) {
        const auto first = static_cast<std::uint32_t>(blocks_.size());
        for (std::size_t i = 0; i < range.size(); ++i) {
            if (i % 4 == 0) blocks_.push_back(TriangleBlock{});
            const auto& [g, t] = places[range[i].id];
            fill(blocks_.back(), static_cast<unsigned>(i % 4), g, t);
        }
        return TreeNode::leaf(first, static_cast<std::uint32_t>(blocks_.size()) - first);
    };
    Builder builder(items, nodes_, k_leaf_triangles, k_triangle_cost, leaf);
    box_ = builder.build();
    nodes_.shrink_to_fit(), blocks_.shrink_to_fit();
}

void TriangleTree::refit()
{
    box_ = {};
    // Children follow their parents.
    for (std::size_t n = nodes_.size(); n-- > 0;) {
        TreeNode& node = nodes_[n];
        for (unsigned i = 0; i < node.count; ++i) {
            Box3 box;
            if (!TreeNode::is_leaf(node.child[i])) {
                box = box_of(nodes_[node.child[i]]);
            } else {
                const std::uint32_t first = TreeNode::first_of(node.child[i]);
                for (std::uint32_t b = first; b < first + TreeNode::items_of(node.child[i]); ++b) {
                    TriangleBlock& block = blocks_[b];
                    for (unsigned lane = 0; lane < 4 && block.mask[lane] != 0; ++lane) {
                        fill(block, lane, block.geometry[lane], block.triangle[lane]);
                        const Box3 own = box_of((*records_)[block.geometry[lane]], block.triangle[lane]);
                        if (!own.empty()) box.add(own);
                    }
                }
            }
            // A box that holds nothing is a point that no ray meets by chance.
            if (box.empty()) box = {glm::vec3(k_largest_met), glm::vec3(k_largest_met)};
            put_box(node, i, box);
            if (n == 0) box_.add(box);
        }
    }
}

std::size_t TriangleTree::bytes() const
{
    return nodes_.capacity() * sizeof(TreeNode) + blocks_.capacity() * sizeof(TriangleBlock);
}

void SceneTree::clear()
{
    instances_.clear(), nodes_.clear();
    box_ = {};
}

void SceneTree::add(const TriangleTree& tree)
{
    if (tree.empty()) return;
    TreeInstance instance;
    instance.tree = &tree, instance.box = tree.box();
    instances_.push_back(instance);
}

void SceneTree::add(const TriangleTree& tree, unsigned id, scene::ObjectId object, const glm::mat4& to_world)
{
    if (tree.empty()) return;
    TreeInstance instance;
    instance.tree = &tree, instance.id = id, instance.object = object;
    instance.identity = to_world == glm::mat4(1);
    const glm::dmat4 inverse = glm::inverse(glm::dmat4(to_world));
    for (int column = 0; column < 4; ++column)
        for (int row = 0; row < 3; ++row)
            instance.to_object[3 * static_cast<std::size_t>(column) + static_cast<std::size_t>(row)] =
                static_cast<float>(inverse[column][row]);
    Box3 box;
    const Box3& own = tree.box();
    for (int corner = 0; corner < 8; ++corner)
        box.add(transform_point(to_world,
                                glm::vec3(corner & 1 ? own.high.x : own.low.x, corner & 2 ? own.high.y : own.low.y,
                                          corner & 4 ? own.high.z : own.low.z)));
    // Rays are rounded in the space of the instance.
    const float margin =
        4 * k_box_margin * std::max({largest(box.low), largest(box.high), largest(glm::vec3(to_world[3]))});
    instance.box = {box.low - margin, box.high + margin};
    if (is_finite(instance.box.low) && is_finite(instance.box.high)) instances_.push_back(instance);
}

void SceneTree::add(const SceneTree& other)
{
    instances_.insert(instances_.end(), other.instances_.begin(), other.instances_.end());
}

void SceneTree::build()
{
    nodes_.clear();
    box_ = {};
    if (instances_.empty()) return;
    std::vector<TreeItem> items;
    for (std::uint32_t i = 0; i < instances_.size(); ++i) items.push_back({instances_[i].box, i});
    const auto leaf = [](std::span<const TreeItem> range) { return TreeNode::leaf(range.front().id, 1); };
    Builder builder(items, nodes_, 1, 1.0f, leaf);
    box_ = builder.build();
}

std::size_t SceneTree::bytes() const
{
    return nodes_.capacity() * sizeof(TreeNode) + instances_.capacity() * sizeof(TreeInstance);
}

}   // namespace gnomon::ray
