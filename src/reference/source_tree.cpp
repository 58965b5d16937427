// SPDX-License-Identifier: Apache-2.0
#include "reference/source_tree.h"

#include <algorithm>
#include <numeric>

#include "base/check.h"
#include "base/interruption.h"

namespace gnomon::reference {

namespace {

constexpr auto k_float_pi = static_cast<float>(k_pi);

// Directions around an axis.
struct Cone {
    glm::vec3 axis{0};
    float spread = -1;   // negative: none
};

float angle_between(const glm::vec3& a, const glm::vec3& b)
{
    return std::acos(std::clamp(glm::dot(a, b), -1.0f, 1.0f));
}

// The smallest cone around two [Conty Estevez and Kulla 2018, Algorithm 1].
Cone united(Cone a, Cone b)
{
    if (a.spread < b.spread) std::swap(a, b);
    if (b.spread < 0) return a;
    const float apart = angle_between(a.axis, b.axis);
    if (std::min(apart + b.spread, k_float_pi) <= a.spread) return a;
    const float spread = 0.5f * (a.spread + apart + b.spread);
    const glm::vec3 turn = glm::cross(a.axis, b.axis);
    if (spread >= k_float_pi || !(glm::dot(turn, turn) > 0)) return {a.axis, k_float_pi};
    // Turn the wider cone's axis towards the other.
    const glm::vec3 across = glm::normalize(glm::cross(turn, a.axis));
    const float by = spread - a.spread;
    return {glm::normalize(std::cos(by) * a.axis + std::sin(by) * across), spread};
}

// What a node would hold.
struct Bounds {
    Box3 box;
    Cone cone;
    float reach = 0, power = 0, steady_power = 0;
    bool two_sided = false;

    void add(const Source& s)
    {
        box.add(s.bounds);
        cone = united(cone, {s.axis, s.spread});
        reach = std::max(reach, s.reach);
        two_sided = two_sided || s.two_sided;
        (s.steady ? steady_power : power) += s.power;
    }
    // How wide a node is, in places and in directions, times its power: the cost of a division is the sum of both
    // parts' [the surface area orientation heuristic, with the square of the diagonal as area].
    float cost() const
    {
        constexpr float k_least = 1e-3f;   // for nodes in a plane, whose directions would count for nothing
        const float all = std::min(cone.spread + reach, k_float_pi);
        const float diagonal = box.diagonal();
        return (power + steady_power) * (diagonal * diagonal + k_float_min) * (1 - std::cos(all) + k_least);
    }
    static constexpr float k_float_min = 1e-20f;
};

// max(0, a - b) for angles from 0 to pi: its cosine, and in `sine` its sine.
float cosine_of_rest(float cos_a, float sin_a, float cos_b, float sin_b, float& sine)
{
    if (cos_a >= cos_b) {
        sine = 0;
        return 1;
    }
    sine = sin_a * cos_b - cos_a * sin_b;
    return cos_a * cos_b + sin_a * sin_b;
}

float sine_of(float cosine)
{
    return std::sqrt(std::max(0.0f, 1 - cosine * cosine));
}

}   // namespace

SourceTree::SourceTree(std::span<const Source> sources) : leaf_(sources.size(), k_none)
{
    std::vector<std::uint32_t> order;
    for (std::uint32_t s = 0; s < sources.size(); ++s)
        if (sources[s].power > 0 && std::isfinite(sources[s].power)) order.push_back(s);
    if (order.empty()) return;
    nodes_.reserve(2 * order.size());
    build(sources, order, k_none);
}

std::uint32_t SourceTree::build(std::span<const Source> sources, std::span<std::uint32_t> order, std::uint32_t parent)
{
    const auto number = static_cast<std::uint32_t>(nodes_.size());
    nodes_.emplace_back();
    Bounds all;
    Box3 middles;
    for (const std::uint32_t s : order) all.add(sources[s]), middles.add(sources[s].bounds.centre());
    Node node;
    node.parent = parent;
    node.middle = all.box.centre(), node.radius = 0.5f * all.box.diagonal();
    node.axis = all.cone.axis;
    node.cos_spread = std::cos(all.cone.spread), node.sin_spread = std::sin(all.cone.spread);
    node.cos_reach = std::cos(std::min(all.reach, 0.5f * k_float_pi));
    node.power = all.power, node.steady_power = all.steady_power, node.two_sided = all.two_sided;
    if (order.size() == 1) {
        node.source = order[0];
        leaf_[order[0]] = number;
        nodes_[number] = node;
        return number;
    }
    // Divide at the middle of an axis, or by the side that sources face, where that costs least.
    const auto is_first = [&](std::uint32_t s, int way) {
        return way < 3 ? sources[s].bounds.centre()[way] < middles.centre()[way] : sources[s].axis[way - 3] < 0;
    };
    int best = -1;
    float least = k_infinity;
    for (int way = 0; way < 6; ++way) {
        Bounds part[2];
        std::size_t count = 0;
        for (const std::uint32_t s : order) {
            const bool first = is_first(s, way);
            part[first ? 0 : 1].add(sources[s]), count += first;
        }
        if (count == 0 || count == order.size()) continue;
        const float cost = part[0].cost() + part[1].cost();
        if (cost < least) least = cost, best = way;
    }
    auto half = order.begin() + static_cast<std::ptrdiff_t>(order.size() / 2);
    if (best >= 0)
        half = std::stable_partition(order.begin(), order.end(), [&](std::uint32_t s) { return is_first(s, best); });
    const auto count = static_cast<std::size_t>(half - order.begin());
    if (order.size() > 4096) interruption_point();
    nodes_[number] = node;
    build(sources, order.first(count), number);
    const std::uint32_t second = build(sources, order.subspan(count), number);
    nodes_[number].second = second;
    return number;
}

// What a node's sources may send to a point, at most as much as its bounds allow [Conty Estevez and Kulla 2018,
// Section 3.2].
float SourceTree::importance(const Node& node, const glm::vec3& position, const glm::vec3& normal)
{
    const glm::vec3 to = node.middle - position;
    const float square = glm::dot(to, to), radius_square = node.radius * node.radius;
    const float bounded = std::max(square, radius_square);   // from within the bounds, as from their surface
    if (!(bounded > 0)) return node.power + node.steady_power;
    const float all = node.power / bounded + node.steady_power;
    if (square <= radius_square) return all;

    const float distance = std::sqrt(square);
    // The angle under which the node is seen from the point.
    const float sin_seen = std::min(node.radius / distance, 1.0f), cos_seen = sine_of(sin_seen);
    float sine;
    const float cos_normal = glm::dot(normal, to) / distance;
    const float receives = cosine_of_rest(cos_normal, sine_of(cos_normal), cos_seen, sin_seen, sine);
    if (!(receives > 0)) return 0;
    float cos_axis = -glm::dot(node.axis, to) / distance;
    if (node.two_sided) cos_axis = std::abs(cos_axis);
    const float off = cosine_of_rest(cos_axis, sine_of(cos_axis), node.cos_spread, node.sin_spread, sine);
    float rest;
    const float emits = cosine_of_rest(off, sine, cos_seen, sin_seen, rest);
    if (emits < node.cos_reach || !(emits > 0)) return 0;
    return all * receives * emits;
}

SourceTree::Choice SourceTree::choose(const glm::vec3& position, const glm::vec3& normal, double number) const
{
    if (empty() || !(importance(nodes_[0], position, normal) > 0)) return {};
    float chance = 1;
    std::uint32_t at = 0;
    while (nodes_[at].second != k_none) {
        const std::uint32_t child[2] = {at + 1, nodes_[at].second};
        const float first = importance(nodes_[child[0]], position, normal),
                    second = importance(nodes_[child[1]], position, normal);
        const float sum = first + second;
        if (!(sum > 0)) return {};
        // Use what is left of the number for the next choice.
        const double share = static_cast<double>(first) / static_cast<double>(sum);
        const bool is_first = number < share || !(second > 0);
        number = std::min(is_first ? number / share : (number - share) / (1 - share), 1 - 0x1p-53);
        chance *= (is_first ? first : second) / sum;
        at = child[is_first ? 0 : 1];
    }
    return {nodes_[at].source, chance};
}

float SourceTree::chance(std::uint32_t source, const glm::vec3& position, const glm::vec3& normal) const
{
    std::uint32_t at = leaf_[source];
    if (at == k_none) return 0;
    float chance = 1;
    while (nodes_[at].parent != k_none && chance > 0) {
        const std::uint32_t parent = nodes_[at].parent;
        const float first = importance(nodes_[parent + 1], position, normal),
                    second = importance(nodes_[nodes_[parent].second], position, normal);
        const float sum = first + second;
        if (!(sum > 0)) return 0;
        chance *= at == parent + 1 ? first / sum : second / sum;
        at = parent;
    }
    return importance(nodes_[0], position, normal) > 0 ? chance : 0;
}

}   // namespace gnomon::reference
