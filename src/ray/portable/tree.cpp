// SPDX-License-Identifier: Apache-2.0
#include "ray/portable/tree.h"

#include <algorithm>
#include <cmath>

#include "base/interruption.h"
#include "base/tasks.h"

namespace gnomon::ray {

namespace {

constexpr int k_bins = 16;
constexpr float k_triangle_cost = 0.3f;   // in units of the cost of a node
constexpr std::size_t k_leaf_triangles = 8;
constexpr int k_deepest_sorted = 24;   // nodes below that are halved, so that no tree is deeper than 24 + 10 nodes
constexpr std::size_t k_interruption_step = 4096;
constexpr std::size_t k_chunk = 16384;       // items that a thread sorts into bins
constexpr std::size_t k_part_items = 8192;   // of a subtree that a thread builds, at most
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

// Items of a node: a range of a list.
struct Range {
    std::size_t begin, end;
    Box3 box;
    bool final;   // splitting it does not pay
    std::size_t size() const { return end - begin; }
};

/// Splits ranges of a list of items, and puts the items into order.
class Splitter {
 public:
    /// @param most       items of a leaf, at most
    /// @param item_cost  of testing an item, in units of the cost of a node
    /// @param tasks      share the work of large ranges; null: none do. They do not change the result
    Splitter(std::vector<TreeItem>& items, std::size_t most, float item_cost, Tasks* tasks = nullptr)
        : items_(items), most_(most), item_cost_(item_cost), tasks_(tasks)
    {
    }

    Range all() const
    {
        Range all{0, items_.size(), {}, false};
        for (const TreeItem& item : items_) all.box.add(item.box);
        return all;
    }
    std::span<const TreeItem> items_of(const Range& range) const { return {items_.data() + range.begin, range.size()}; }
    bool fits_a_leaf(const Range& range) const { return range.size() <= most_; }

    /// Splits a range into up to eight by splitting the one with the largest box again and again. @return how many
    unsigned divide(const Range& range, int depth, Range (&parts)[TreeNode::k_width])
    {
        if ((++made_ & (k_interruption_step - 1)) == 0) interruption_point();
        parts[0] = range;
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
        return count;
    }

 private:
    struct Bin {
        Box3 box;
        std::size_t count = 0;
    };
    using Bins = std::array<std::array<Bin, k_bins>, 3>;

    // Calls body(from, to, chunk) for the chunks of a range, in parallel if it is large. @return the number of chunks
    template <class Body>
    std::size_t for_chunks(const Range& range, Body&& body)
    {
        const std::size_t chunks = tasks_ && range.size() >= 2 * k_chunk ? (range.size() + k_chunk - 1) / k_chunk : 1;
        if (chunks == 1) {
            body(range.begin, range.end, 0);
        } else {
            tasks_->for_each(chunks, [&](std::size_t chunk, int) {
                const std::size_t from = range.begin + chunk * k_chunk;
                body(from, std::min(from + k_chunk, range.end), chunk);
            });
        }
        return chunks;
    }
    std::size_t most_chunks(const Range& range) const { return range.size() / k_chunk + 1; }

    Box3 bounds_of_centres(const Range& range)
    {
        std::vector<Box3> of(most_chunks(range));
        const std::size_t chunks = for_chunks(range, [&](std::size_t from, std::size_t to, std::size_t chunk) {
            for (std::size_t i = from; i < to; ++i) of[chunk].add(items_[i].box.centre());
        });
        for (std::size_t i = 1; i < chunks; ++i) of[0].add(of[i]);
        return of[0];
    }

    // Fills bins_.
    void fill_bins(const Range& range, const glm::vec3& low, const glm::vec3& scale)
    {
        const auto fill = [&](std::size_t from, std::size_t to, Bins& into) {
            for (auto& bins : into) bins.fill({});
            for (std::size_t i = from; i < to; ++i) {
                const TreeItem& item = items_[i];
                for (int axis = 0; axis < 3; ++axis) {
                    Bin& bin = into[static_cast<std::size_t>(axis)][bin_of(item, axis, low, scale)];
                    bin.box.add(item.box);
                    ++bin.count;
                }
            }
        };
        std::vector<Bins> further(most_chunks(range) - 1);
        const std::size_t chunks = for_chunks(range, [&](std::size_t from, std::size_t to, std::size_t chunk) {
            fill(from, to, chunk == 0 ? bins_ : further[chunk - 1]);
        });
        // The order of a union does not matter.
        for (std::size_t chunk = 1; chunk < chunks; ++chunk)
            for (std::size_t axis = 0; axis < 3; ++axis)
                for (std::size_t i = 0; i < k_bins; ++i) {
                    bins_[axis][i].box.add(further[chunk - 1][axis][i].box);
                    bins_[axis][i].count += further[chunk - 1][axis][i].count;
                }
    }

    // @return false if the range is to be a leaf
    bool split(const Range& range, int depth, Range& left, Range& right)
    {
        const std::size_t n = range.size();
        if (n <= 1) return false;
        const Box3 centres = bounds_of_centres(range);
        float best = k_infinity;
        int best_axis = -1, best_bin = 0;
        glm::vec3 scale(0);   // 0: the axis is not split
        for (int axis = 0; axis < 3; ++axis) {
            const float extent = centres.high[axis] - centres.low[axis];
            if (extent > 0 && std::isfinite(k_bins / extent)) scale[axis] = k_bins / extent;
        }
        if (depth < k_deepest_sorted) {
            fill_bins(range, centres.low, scale);
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
    std::size_t most_;
    float item_cost_;
    Tasks* tasks_;
    std::size_t made_ = 0;
    Bins bins_;
};

/// Builds the nodes over a range of a list of items.
/// Leaf: std::uint32_t(std::span<const TreeItem>), which stores the items and returns the leaf's code.
template <class Leaf>
class Builder {
 public:
    Builder(Splitter splitter, std::vector<TreeNode>& nodes, Leaf leaf)
        : splitter_(splitter), nodes_(nodes), leaf_(leaf)
    {
    }

    /// Appends the nodes of a range, its root first. @pre the range is not empty
    void build(const Range& range, int depth)
    {
        const auto root = add_node();
        if (splitter_.fits_a_leaf(range))
            put_leaf(root, 0, range), nodes_[root].count = 1;
        else
            fill(root, range, depth);
    }
    /// Appends the nodes of all items down to ranges of at most `most` items, and calls rest(node, child, range, depth)
    /// for those. @pre there are more
    template <class Rest>
    void build_top(const Range& range, std::size_t most, Rest&& rest)
    {
        fill_top(add_node(), range, 0, most, rest);
    }

 private:
    std::uint32_t add_node()
    {
        nodes_.emplace_back();
        return static_cast<std::uint32_t>(nodes_.size() - 1);
    }

    void put_leaf(std::uint32_t node, unsigned i, const Range& range)
    {
        const std::uint32_t code = leaf_(splitter_.items_of(range));
        put_box(nodes_[node], i, range.box);
        nodes_[node].child[i] = code;
    }

    // Adds a node below another one.
    std::uint32_t add_child(std::uint32_t node, unsigned i, const Range& range)
    {
        const std::uint32_t child = add_node();
        put_box(nodes_[node], i, range.box);
        nodes_[node].child[i] = child;
        return child;
    }

    void fill(std::uint32_t node, const Range& range, int depth)
    {
        Range parts[TreeNode::k_width];
        const unsigned count = nodes_[node].count = splitter_.divide(range, depth, parts);
        for (unsigned i = 0; i < count; ++i) {
            if (parts[i].final || parts[i].size() <= 1)
                put_leaf(node, i, parts[i]);
            else
                fill(add_child(node, i, parts[i]), parts[i], depth + 1);
        }
    }

    template <class Rest>
    void fill_top(std::uint32_t node, const Range& range, int depth, std::size_t most, Rest& rest)
    {
        Range parts[TreeNode::k_width];
        const unsigned count = nodes_[node].count = splitter_.divide(range, depth, parts);
        for (unsigned i = 0; i < count; ++i) {
            if (parts[i].final || parts[i].size() <= 1) {
                put_leaf(node, i, parts[i]);
            } else if (parts[i].size() <= most) {
                put_box(nodes_[node], i, parts[i].box);
                rest(node, i, parts[i], depth + 1);
            } else {
                fill_top(add_child(node, i, parts[i]), parts[i], depth + 1, most, rest);
            }
        }
    }

    Splitter splitter_;
    std::vector<TreeNode>& nodes_;
    Leaf leaf_;
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

namespace {

// The nodes over a range of items, and what their leaves hold, before its triangles are stored.
struct TreePart {
    Range range;
    int depth = 0;
    std::uint32_t node = 0;   // above its root, in the part above, and the child of it that the root is
    unsigned child = 0;
    std::vector<TreeNode> nodes;
    std::vector<std::span<const TreeItem>> leaves;
    std::uint32_t blocks = 0;   // of all leaves

    auto leaf()
    {
        return [this](std::span<const TreeItem> items) {
            const auto first = blocks, count = static_cast<std::uint32_t>((items.size() + 3) / 4);
            blocks += count;
            leaves.push_back(items);
            return TreeNode::leaf(first, count);
        };
    }
};

template <class Body>
void for_each(Tasks* tasks, std::size_t count, Body&& body)
{
    if (tasks && count > 1)
        tasks->for_each(count, [&](std::size_t i, int) { body(i); });
    else
        for (std::size_t i = 0; i < count; ++i) body(i);
}

}   // namespace

void TriangleTree::build(const std::deque<GeometryRecord>& records, Tasks* tasks)
{
    records_ = &records;
    nodes_.clear(), blocks_.reset(), block_count_ = 0, box_ = {};

    // Number all triangles, and find their boxes.
    std::vector<std::pair<std::uint32_t, std::uint32_t>> places;   // by item id: geometry and triangle
    for (std::uint32_t g = 0; g < records.size(); ++g)
        for (std::uint32_t t = 0; records[g].attached && t < records[g].triangles; ++t) places.emplace_back(g, t);
    std::vector<TreeItem> items(places.size());
    for_each(tasks, (items.size() + k_chunk - 1) / k_chunk, [&](std::size_t chunk) {
        const std::size_t past = std::min((chunk + 1) * k_chunk, items.size());
        for (std::size_t i = chunk * k_chunk; i < past; ++i)
            items[i] = {box_of(records[places[i].first], places[i].second), static_cast<std::uint32_t>(i)};
    });
    std::erase_if(items, [](const TreeItem& item) { return item.box.empty(); });
    if (items.empty()) return;

    // Build the top of the tree, then what lies below, each part by itself.
    const Splitter splitter(items, k_leaf_triangles, k_triangle_cost);
    const Range all = splitter.all();
    box_ = all.box;
    std::vector<TreePart> parts(1);
    parts[0].range = all;
    const bool large = items.size() > k_part_items;
    if (large) {
        TreePart top;
        Builder(Splitter(items, k_leaf_triangles, k_triangle_cost, tasks), top.nodes, top.leaf())
            .build_top(all, k_part_items, [&](std::uint32_t node, unsigned child, const Range& range, int depth) {
                parts.push_back({range, depth, node, child, {}, {}, 0});
            });
        parts[0] = std::move(top);
    }
    for_each(tasks, parts.size(), [&](std::size_t i) {
        if (i > 0 || !large) Builder(splitter, parts[i].nodes, parts[i].leaf()).build(parts[i].range, parts[i].depth);
    });

    // Put the parts together, and store their triangles.
    std::vector<std::uint32_t> first_node, first_block;
    std::uint32_t nodes = 0, blocks = 0;
    for (const TreePart& part : parts) {
        first_node.push_back(nodes), first_block.push_back(blocks);
        nodes += static_cast<std::uint32_t>(part.nodes.size()), blocks += part.blocks;
    }
    nodes_.resize(nodes);
    nodes_.shrink_to_fit();
    blocks_ = std::make_unique_for_overwrite<TriangleBlock[]>(blocks);
    block_count_ = blocks;
    for_each(tasks, parts.size(), [&](std::size_t i) {
        TreePart& part = parts[i];
        TreeNode* node = nodes_.data() + first_node[i];
        for (TreeNode& own : part.nodes) {
            for (unsigned c = 0; c < own.count; ++c)
                own.child[c] += TreeNode::is_leaf(own.child[c]) ? first_block[i] : first_node[i];
            *node++ = own;
        }
        TriangleBlock* block = blocks_.get() + first_block[i];
        for (const std::span<const TreeItem> leaf : part.leaves)
            for (std::size_t item = 0; item < leaf.size(); ++item) {
                const auto lane = static_cast<unsigned>(item % 4);
                if (lane == 0) *block++ = TriangleBlock{};
                const auto& [g, t] = places[leaf[item].id];
                fill(block[-1], lane, g, t);
            }
    });
    for (std::size_t i = 1; i < parts.size(); ++i) nodes_[parts[i].node].child[parts[i].child] = first_node[i];
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
    return nodes_.capacity() * sizeof(TreeNode) + block_count_ * sizeof(TriangleBlock);
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
    const Splitter splitter(items, 1, 1.0f);
    const Range all = splitter.all();
    Builder(splitter, nodes_, leaf).build(all, 0);
    box_ = all.box;
}

std::size_t SceneTree::bytes() const
{
    return nodes_.capacity() * sizeof(TreeNode) + instances_.capacity() * sizeof(TreeInstance);
}

}   // namespace gnomon::ray
