// SPDX-License-Identifier: Apache-2.0
// Builds one tree: upper splits at bounds of groups, lower ones by the surface area heuristic over triangles.
#include <algorithm>
#include <array>
#include <chrono>
#include <utility>

#include "base/check.h"
#include "ray/kdtree/part.h"

namespace gnomon::ray {

namespace {

constexpr int k_most_bins = 64;

struct Reference {
    Box3 box;   // of the part that lies in the cell
    std::uint32_t triangle;
};

struct Split {
    int axis = -1;   // none
    float at = 0;
    float cost = k_infinity;
};

float half_area(const Box3& box)
{
    const glm::vec3 s = box.size();
    return s.x * s.y + s.y * s.z + s.z * s.x;
}

Box3 common(const Box3& a, const Box3& b)
{
    return {glm::max(a.low, b.low), glm::min(a.high, b.high)};
}

Box3 below(Box3 cell, int axis, float at)
{
    cell.high[axis] = at;
    return cell;
}

Box3 above(Box3 cell, int axis, float at)
{
    cell.low[axis] = at;
    return cell;
}

// Computes the bounds of the part of a triangle below (sign 1) or above (sign -1) a plane; empty if there is none.
Box3 bounds_beside(const glm::vec3 (&p)[3], int axis, float plane, float sign)
{
    Box3 bounds;
    for (int i = 0; i < 3; ++i) {
        const glm::vec3 &a = p[i], &b = p[i == 2 ? 0 : i + 1];
        const float da = sign * (plane - a[axis]), db = sign * (plane - b[axis]);
        if (da >= 0) bounds.add(a);
        if ((da < 0) != (db < 0)) bounds.add(a + da / (da - db) * (b - a));
    }
    return bounds;
}

// The surface area heuristic in one cell: the costs of the two halves, weighted by their fractions of its area.
class CellCost {
 public:
    CellCost(const Box3& cell, int axis, const KdBuildOptions& options)
        : low_(cell.low[axis]), high_(cell.high[axis]), test_(options.test_cost), bonus_(options.empty_bonus)
    {
        const glm::vec3 s = cell.size();
        const float b = s[(axis + 1) % 3], c = s[(axis + 2) % 3];
        const float area = half_area(cell);
        ends_ = b * c / area;
        per_length_ = (b + c) / area;
    }
    bool inside(float at) const { return at > low_ && at < high_; }
    float operator()(float at, float count_below, float count_above) const
    {
        const float share_below = ends_ + (at - low_) * per_length_;
        const float share_above = ends_ + (high_ - at) * per_length_;
        const float cost = 1 + test_ * (share_below * count_below + share_above * count_above);
        return count_below == 0 || count_above == 0 ? (1 - bonus_) * cost : cost;
    }

 private:
    float low_, high_, test_, bonus_;
    float ends_ = 0, per_length_ = 0;
};

class Builder {
 public:
    Builder(KdPart& part, const KdBuildOptions& options) : part_(part), o_(options)
    {
        const float n = static_cast<float>(part.triangles.size());
        deepest_ = std::min(k_deepest, static_cast<int>(o_.depth_base + o_.depth_slope * std::log2(n)));
    }

    void build()
    {
        part_.nodes.emplace_back();
        if (!o_.from_hierarchy || part_.groups.empty()) {
            std::vector<Reference> all;
            for (std::uint32_t t = 0; t < part_.triangles.size(); ++t) add(all, t, part_.box);
            build_triangles(0, part_.box, all, 0);
            return;
        }
        std::vector<std::uint32_t> roots;
        for (std::uint32_t g = 0; g < part_.groups.size(); ++g)
            if (part_.groups[g].parent == scene::none && part_.groups[g].triangles > 0) roots.push_back(g);
        build_groups(0, part_.box, std::move(roots), 0);
    }

 private:
    std::uint32_t make_inner(std::uint32_t node, const Split& split)
    {
        const auto first = static_cast<std::uint32_t>(part_.nodes.size());
        part_.nodes[node] = {split.at, static_cast<std::uint32_t>(split.axis), first, 0};
        part_.nodes.resize(part_.nodes.size() + 2);
        return first;
    }

    void make_leaf(std::uint32_t node, const std::vector<Reference>& inside)
    {
        part_.nodes[node] = {0, KdNode::k_leaf, static_cast<std::uint32_t>(part_.references.size()),
                             static_cast<std::uint32_t>(inside.size())};
        for (const Reference& r : inside) part_.references.push_back(r.triangle);
    }

    // Groups.

    void build_groups(std::uint32_t node, const Box3& cell, std::vector<std::uint32_t> groups, int depth)
    {
        open(groups, cell);
        const Split split = depth < deepest_ ? best_group_split(groups, cell) : Split{};
        if (split.axis < 0) {
            std::vector<Reference> inside;
            for (const std::uint32_t g : groups) gather(g, cell, inside);
            build_triangles(node, cell, inside, depth);
            return;
        }
        ++part_.group_splits;
        const std::uint32_t first = make_inner(node, split);
        std::vector<std::uint32_t> under, over;
        for (const std::uint32_t g : groups) {
            const Box3 box = common(part_.groups[g].box, cell);
            if (box.high[split.axis] > split.at) over.push_back(g);
            if (box.low[split.axis] < split.at || box.high[split.axis] <= split.at) under.push_back(g);
        }
        groups.clear();
        build_groups(first, below(cell, split.axis, split.at), std::move(under), depth + 1);
        build_groups(first + 1, above(cell, split.axis, split.at), std::move(over), depth + 1);
    }

    // Replaces the largest groups by their children until there are enough bounds [Hunt 2007, 3].
    void open(std::vector<std::uint32_t>& groups, const Box3& cell) const
    {
        const auto seen = [&](std::uint32_t g) {
            return part_.groups[g].triangles > 0 && !common(part_.groups[g].box, cell).empty();
        };
        std::erase_if(groups, [&](std::uint32_t g) { return !seen(g); });
        while (groups.size() < static_cast<std::size_t>(o_.open_groups)) {
            std::size_t largest = groups.size();
            float largest_area = -1;
            for (std::size_t i = 0; i < groups.size(); ++i) {
                if (part_.groups[groups[i]].children.empty()) continue;
                const float area = half_area(common(part_.groups[groups[i]].box, cell));
                if (area > largest_area) largest = i, largest_area = area;
            }
            if (largest == groups.size()) return;
            const std::uint32_t opened = groups[largest];
            groups.erase(groups.begin() + static_cast<std::ptrdiff_t>(largest));
            for (const std::uint32_t child : part_.groups[opened].children)
                if (seen(child)) groups.push_back(child);
        }
    }

    // The triangles of a group are assumed to be distributed evenly over its box.
    Split best_group_split(const std::vector<std::uint32_t>& groups, const Box3& cell) const
    {
        Split best;
        if (groups.size() < 2) return best;
        struct Extent {
            float low, high, triangles;
        };
        std::vector<Extent> extents;
        std::vector<float> candidates;
        float all = 0;
        for (int axis = 0; axis < 3; ++axis) {
            const CellCost cost_of(cell, axis, o_);
            extents.clear(), candidates.clear(), all = 0;
            for (const std::uint32_t g : groups) {
                const KdGroup& group = part_.groups[g];
                const Box3 inside = common(group.box, cell);
                // Of a group that extends beyond the cell, count only the fraction inside.
                const float whole = half_area(group.box);
                const float share = whole > 0 ? half_area(inside) / whole : 1;
                extents.push_back({inside.low[axis], inside.high[axis], share * static_cast<float>(group.triangles)});
                all += extents.back().triangles;
                for (const float at : {inside.low[axis], inside.high[axis]})
                    if (cost_of.inside(at)) candidates.push_back(at);
            }
            std::sort(candidates.begin(), candidates.end());
            candidates.erase(std::unique(candidates.begin(), candidates.end()), candidates.end());
            // A scene without depth may have thousands of groups at once: test only an even selection of bounds.
            const std::size_t most = 2 * static_cast<std::size_t>(o_.open_groups);
            const std::size_t stride = std::max<std::size_t>(1, candidates.size() / most);
            for (std::size_t i = 0; i < candidates.size(); i += stride) {
                const float at = candidates[i];
                float under = 0, over = 0;
                for (const Extent& e : extents) {
                    const float length = e.high - e.low;
                    const float share = e.high <= at ? 1 : e.low >= at ? 0 : (at - e.low) / length;
                    under += share * e.triangles;
                    over += (1 - share) * e.triangles;
                }
                const float cost = cost_of(at, under, over);
                if (cost < best.cost) best = {axis, at, cost};
            }
        }
        // DEVIATION(Nah 2009, 2.4): cells of fewer triangles than `groups_above` are split over triangles, not along
        // the scene graph. A small static tree (that of Robots) then has no such split; KdLayout::hierarchy has them
        // all.
        const bool pays =
            all > static_cast<float>(o_.groups_above) && best.cost <= o_.group_split_gain * o_.test_cost * all;
        return pays ? best : Split{};
    }

    void gather(std::uint32_t g, const Box3& cell, std::vector<Reference>& inside) const
    {
        const KdGroup& group = part_.groups[g];
        if (group.triangles == 0 || common(group.box, cell).empty()) return;
        for (const std::uint32_t child : group.children) gather(child, cell, inside);
        if (!group.children.empty()) return;
        for (std::uint32_t i = 0; i < group.triangles; ++i) add(inside, group.first_triangle + i, cell);
    }

    // Triangles.

    /// Adds the part of a triangle that lies in a cell.
    void add(std::vector<Reference>& to, std::uint32_t triangle, const Box3& cell) const
    {
        Box3 own;
        for (const glm::vec3& p : part_.triangles[triangle].p) own.add(p);
        own = {own.low - part_.pad, own.high + part_.pad};
        Reference r{common(own, cell), triangle};
        for (int axis = 0; axis < 3 && !r.box.empty(); ++axis) {
            if (own.low[axis] < cell.low[axis]) cut(r, axis, cell.low[axis], -1);
            if (own.high[axis] > cell.high[axis]) cut(r, axis, cell.high[axis], 1);
        }
        if (!r.box.empty()) to.push_back(r);
    }

    /// Cuts a reference to the part below (sign 1) or above (sign -1) a plane; its box may become empty.
    void cut(Reference& r, int axis, float at, float sign) const
    {
        (sign > 0 ? r.box.high : r.box.low)[axis] = at;
        if (!o_.clip) return;
        const Box3 beside = bounds_beside(part_.triangles[r.triangle].p, axis, at + sign * part_.pad, sign);
        if (beside.empty())
            r.box = beside;
        else
            r.box = common({beside.low - part_.pad, beside.high + part_.pad}, r.box);
    }

    void build_triangles(std::uint32_t node, const Box3& cell, std::vector<Reference>& inside, int depth)
    {
        Split split;
        const std::size_t n = inside.size();
        if (n > static_cast<std::size_t>(o_.leaf) && depth < deepest_)
            split =
                n <= static_cast<std::size_t>(o_.exact_below) ? exact_split(inside, cell) : binned_split(inside, cell);
        if (split.axis < 0 || split.cost >= o_.test_cost * static_cast<float>(n)) {
            make_leaf(node, inside);
            return;
        }
        const std::uint32_t first = make_inner(node, split);
        const Box3 cell_below = below(cell, split.axis, split.at), cell_above = above(cell, split.axis, split.at);
        std::vector<Reference> under, over;
        under.reserve(n), over.reserve(n);
        for (Reference& r : inside) {
            const float low = r.box.low[split.axis], high = r.box.high[split.axis];
            const bool is_over = high > split.at, is_under = low < split.at || !is_over;
            if (!is_over) {
                under.push_back(r);
                continue;
            }
            if (is_under) {
                Reference part = r;
                cut(part, split.axis, split.at, 1);
                if (!part.box.empty()) under.push_back(part);
                cut(r, split.axis, split.at, -1);
                if (r.box.empty()) continue;
            }
            over.push_back(r);
        }
        std::vector<Reference>().swap(inside);   // free memory before the recursion goes deeper
        build_triangles(first, cell_below, under, depth + 1);
        build_triangles(first + 1, cell_above, over, depth + 1);
    }

    // Tests splits at every bound of every triangle.
    Split exact_split(const std::vector<Reference>& inside, const Box3& cell)
    {
        Split best;
        const std::size_t n = inside.size();
        for (int axis = 0; axis < 3; ++axis) {
            const CellCost cost_of(cell, axis, o_);
            lows_.clear(), highs_.clear();
            for (const Reference& r : inside) lows_.push_back(r.box.low[axis]), highs_.push_back(r.box.high[axis]);
            std::sort(lows_.begin(), lows_.end());
            std::sort(highs_.begin(), highs_.end());
            // Triangles that begin before a plane are below; those that do not end before or at it are above.
            std::size_t begun = 0, ended = 0;
            while (begun < n || ended < n) {
                const float at = begun < n ? std::min(lows_[begun], highs_[ended]) : highs_[ended];
                const std::size_t under = begun;
                while (ended < n && highs_[ended] <= at) ++ended;
                while (begun < n && lows_[begun] <= at) ++begun;
                if (!cost_of.inside(at)) continue;
                const float cost = cost_of(at, static_cast<float>(under), static_cast<float>(n - ended));
                if (cost < best.cost) best = {axis, at, cost};
            }
        }
        return best;
    }

    // Tests splits between equal bins.
    Split binned_split(const std::vector<Reference>& inside, const Box3& cell) const
    {
        Split best;
        const int bins = std::clamp(o_.bins, 2, k_most_bins);
        const glm::vec3 size = cell.size();
        const glm::vec3 scale = static_cast<float>(bins) / size;
        std::array<std::array<std::uint32_t, k_most_bins>, 3> begin{}, end{};
        for (const Reference& r : inside)
            for (int axis = 0; axis < 3; ++axis) {
                const auto bin = [&](float x) {
                    return static_cast<std::size_t>(
                        std::clamp(static_cast<int>((x - cell.low[axis]) * scale[axis]), 0, bins - 1));
                };
                if (!(size[axis] > 0)) continue;
                ++begin[static_cast<std::size_t>(axis)][bin(r.box.low[axis])];
                ++end[static_cast<std::size_t>(axis)][bin(r.box.high[axis])];
            }
        for (int axis = 0; axis < 3; ++axis) {
            const CellCost cost_of(cell, axis, o_);
            std::size_t under = 0, over = inside.size();
            for (int i = 0; i + 1 < bins; ++i) {
                under += begin[static_cast<std::size_t>(axis)][static_cast<std::size_t>(i)];
                over -= end[static_cast<std::size_t>(axis)][static_cast<std::size_t>(i)];
                const float at = cell.low[axis] + static_cast<float>(i + 1) * size[axis] / static_cast<float>(bins);
                if (!cost_of.inside(at)) continue;
                const float cost = cost_of(at, static_cast<float>(under), static_cast<float>(over));
                if (cost < best.cost) best = {axis, at, cost};
            }
        }
        return best;
    }

    KdPart& part_;
    const KdBuildOptions& o_;
    int deepest_ = 0;
    std::vector<float> lows_, highs_;   // scratch
};

}   // namespace

void KdPart::build(const KdBuildOptions& options)
{
    const auto start = std::chrono::steady_clock::now();
    nodes.clear(), references.clear();
    group_splits = 0;
    if (!triangles.empty()) Builder(*this, options).build();
    ++builds;
    build_ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

}   // namespace gnomon::ray
