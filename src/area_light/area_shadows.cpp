// SPDX-License-Identifier: Apache-2.0
#include "area_light/area_shadows.h"

#include <algorithm>
#include <array>
#include <deque>

#include "base/micro_triangles.h"
#include "ray/origin.h"

namespace gnomon::area_light {

namespace {

using visibility::StaticTriangle;
using visibility::StaticTriangles;
using visibility::TriangleId;

constexpr std::size_t k_shards = 256;
// Of a divided part, a list up to this length is kept for its quarters; longer ones are found in the tree again.
constexpr std::size_t k_handed_down = 2048;

double diameter_of(const LightPolygon& light)
{
    double most = 0;
    for (int a = 0; a < light.corners; ++a)
        for (int b = 0; b < a; ++b)
            most = std::max(most, static_cast<double>(glm::length(light.corner[static_cast<std::size_t>(a)] -
                                                                  light.corner[static_cast<std::size_t>(b)])));
    return most;
}

// The finest part that contains a point, from which those of all levels follow.
MicroTriangle finest_part(float u, float v, int levels)
{
    const auto level = static_cast<std::uint32_t>(levels);
    return micro_at(micro_index_at(u, v, level), level);
}

// A point in the middle of what of a part lies before the light. A segment that began behind the light would tell
// nothing about those from before it.
glm::dvec3 centre_before(const AreaShaft& shaft, const glm::dvec3 (&corner)[3])
{
    glm::dvec3 sum(0);
    int count = 0;
    for (int c = 0; c < 3; ++c) {
        const glm::dvec3 &a = corner[c], &b = corner[(c + 1) % 3];
        const double at_a = shaft.light_height(a), at_b = shaft.light_height(b);
        if (at_a > 0) sum += a, ++count;
        if ((at_a > 0) != (at_b > 0)) sum += a + at_a / (at_a - at_b) * (b - a), ++count;
    }
    return sum / static_cast<double>(std::max(count, 1));
}

// Which quarter of a part another one is, in the order of children_of().
std::size_t quarter_of(const MicroTriangle& part, const MicroTriangle& next)
{
    if (next.upper != part.upper) return 3;
    const std::size_t i = next.i & 1, j = next.j & 1;
    return next.upper ? (1 - i) + 2 * (1 - j) : i + 2 * j;
}

}   // namespace

struct AreaShadows::Node {
    enum class Kind : std::uint8_t { unknown, divided, decided };
    std::atomic<Kind> kind = Kind::unknown;   // the rest is constant once it is known
    PartState state = PartState::open;
    Node* quarters = nullptr;   // four; of a divided part
    std::unique_ptr<std::vector<TriangleId>> list;
};

struct AreaShadows::Shard {
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

AreaShadows::AreaShadows(const StaticTriangles& triangles, const FlatLight& light, const AreaOptions& options)
    : triangles_(triangles),
      places_(light),
      options_(options),
      diameter_(diameter_of(light.outline)),
      roots_(std::make_unique<std::atomic<Node*>[]>(2 * triangles.size())),
      shards_(std::make_unique<Shard[]>(k_shards))
{
}

AreaShadows::~AreaShadows() = default;

// Judges one part.
// @param from  triangles that contain all that meet its shaft; null: all static triangles
AreaShadows::Verdict AreaShadows::judge(TriangleId triangle, bool front, const MicroTriangle& part, std::uint32_t level,
                                        const std::vector<TriangleId>* from) const
{
    Verdict verdict;
    const StaticTriangle& receiver = triangles_[triangle];
    const glm::dvec3 a(receiver.p[0]), ab = glm::dvec3(receiver.p[1]) - a, ac = glm::dvec3(receiver.p[2]) - a;
    glm::dvec3 normal = glm::cross(ab, ac);
    const double length = glm::length(normal);
    if (!(length > 0)) return verdict;
    normal *= (front ? 1 : -1) / length;
    const double distance = -glm::dot(normal, a);

    // What lies behind needs no proof. Near the horizon, within rounding, rays decide.
    const LightPolygon& light = places_.polygon();
    const ClippedLight above = clip_light(light, normal, distance);
    if (above.count == 0) {
        verdict.state = PartState::unlit;
        return verdict;
    }
    glm::dvec2 uv[3];
    corners_of(part, level, uv);
    glm::dvec3 corner[3];
    for (int c = 0; c < 3; ++c) corner[c] = a + uv[c].x * ab + uv[c].y * ac;
    const double lift = static_cast<double>(ray::origin_lift(receiver.p));
    const AreaShaft shaft(corner, normal, above, glm::dvec3(light.normal), lift, options_.shaft);
    if (!shaft.faces_light()) {
        verdict.state = PartState::unlit;
        return verdict;
    }

    // Find what may meet the shaft.
    const auto take = [&](TriangleId id) {
        const StaticTriangles::Role role = triangles_.role(id);
        if (id == triangle || role == StaticTriangles::Role::transparent) return;
        if (shaft.may_meet(triangles_[id])) verdict.list.push_back(id);
    };
    if (from)
        for (const TriangleId id : *from) take(id);
    else
        triangles_.visit([&](const glm::vec3& low, const glm::vec3& high) { return shaft.may_meet(low, high); }, take);

    // Among very many triangles, nothing is proven for a part that could be smaller.
    double size = 0;
    for (int c = 0; c < 3; ++c) size = std::max(size, glm::length(corner[(c + 1) % 3] - corner[c]));
    const auto divides = [&] {
        const bool many = verdict.list.size() > options_.short_list;
        return static_cast<int>(level) < options_.most_levels &&
               size > (many ? options_.fine : options_.coarse) * diameter_;
    };
    if (verdict.list.size() > options_.hopeless && divides()) {
        verdict.divides = true;
        return verdict;
    }
    const auto outside = [&](TriangleId id) {
        ClippedTriangle inside;
        return !shaft.clip(triangles_[id], inside);
    };
    // One triangle inside is enough to know that it is not lit. Few others are outside.
    const bool smaller = divides();
    if (std::all_of(verdict.list.begin(), verdict.list.end(), outside)) verdict.list.clear();
    if (verdict.list.empty()) {
        verdict.state = PartState::lit;
        return verdict;
    }
    std::sort(verdict.list.begin(), verdict.list.end());

    // Try to prove that all of it is hidden.
    glm::dvec3 centre = centre_before(shaft, corner) + lift * normal, target(0);
    for (int k = 0; k < above.count; ++k) target += above.corner[static_cast<std::size_t>(k)] / double(above.count);
    target = centre + static_cast<double>(ray::k_shadow_ray_end) * (target - centre);
    int tried = 0;
    for (const TriangleId id : verdict.list) {
        if (crossing(triangles_[id], centre, target) == 0) continue;
        if (proves_dark(triangles_, shaft, id, centre, target, options_.dark)) {
            verdict.state = PartState::dark;
            verdict.list.clear();
            return verdict;
        }
        constexpr int k_tries = 2;
        if (++tried == k_tries) break;
    }

    // Divide it if smaller parts may know more.
    if (smaller) {
        verdict.divides = true;
        return verdict;
    }
    verdict.state = verdict.list.size() > options_.longest_list ? PartState::open : PartState::listed;
    if (verdict.state == PartState::open) verdict.list.clear();
    return verdict;
}

Part AreaShadows::part_at(TriangleId triangle, bool front, float u, float v, LastPart& last)
{
    const std::size_t record = 2 * std::size_t{triangle} + (front ? 1 : 0);
    Node* node = roots_[record].load(std::memory_order_acquire);
    if (node && node->kind.load(std::memory_order_acquire) == Node::Kind::decided)
        return {node->state, node->list.get()};
    const auto finest_level = static_cast<std::uint32_t>(options_.most_levels);
    const MicroTriangle finest = finest_part(u, v, options_.most_levels);
    if (last.owner == this && last.record == record && ancestor_of(finest, finest_level - last.level) == last.place)
        return last.part;
    const std::vector<TriangleId>* from = nullptr;
    MicroTriangle here = ancestor_of(finest, finest_level);
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
        const MicroTriangle next = ancestor_of(finest, finest_level - level - 1);
        node = node->quarters + quarter_of(here, next);
        here = next;
    }
}

// Judges a part that is unknown, unless another thread has just done so.
// @param node  null: the whole triangle's, which is made
AreaShadows::Node* AreaShadows::judge_node(std::size_t record, Node* node, TriangleId triangle, bool front,
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

Part AreaShadows::judged_anew(TriangleId triangle, bool front, float u, float v, std::vector<TriangleId>& list) const
{
    const auto finest_level = static_cast<std::uint32_t>(options_.most_levels);
    const MicroTriangle finest = finest_part(u, v, options_.most_levels);
    std::vector<TriangleId> from;
    bool handed_down = false;
    for (std::uint32_t level = 0;; ++level) {
        Verdict verdict =
            judge(triangle, front, ancestor_of(finest, finest_level - level), level, handed_down ? &from : nullptr);
        if (!verdict.divides) {
            list = std::move(verdict.list);
            return {verdict.state, verdict.state == PartState::listed ? &list : nullptr};
        }
        if (verdict.list.size() > k_handed_down) continue;
        from = std::move(verdict.list);
        handed_down = true;
    }
}

AreaCounters AreaShadows::counters() const
{
    AreaCounters sum;
    for (std::size_t s = 0; s < k_shards; ++s) {
        const std::lock_guard lock(shards_[s].mutex);
        const AreaCounters& c = shards_[s].counters;
        sum.parts += c.parts, sum.listed_triangles += c.listed_triangles;
        for (std::size_t k = 0; k < std::size(sum.states); ++k) sum.states[k] += c.states[k];
    }
    return sum;
}

std::size_t AreaShadows::bytes() const
{
    std::size_t bytes = 2 * triangles_.size() * sizeof(roots_[0]);
    for (std::size_t s = 0; s < k_shards; ++s) {
        const std::lock_guard lock(shards_[s].mutex);
        bytes += shards_[s].nodes.size() * sizeof(std::array<Node, 4>) + shards_[s].list_bytes;
    }
    return bytes;
}

}   // namespace gnomon::area_light
