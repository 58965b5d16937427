// SPDX-License-Identifier: Apache-2.0
#include "irradiance_cache/light_tree/tested_nodes.h"

#include <algorithm>
#include <numeric>

namespace gnomon::irradiance_cache {

// Sorts the nodes of a cut by their numbers: a device finds the same cut in another order. Cost: linear.
void TestedNodes::sort(std::span<const NodeId> cut, std::span<const float> weights)
{
    constexpr std::uint32_t k_digit = 11;   // bits
    constexpr std::size_t k_digits = std::size_t{1} << k_digit;
    static_assert(2 * k_digit >= k_node_bits);
    sorted_.resize(cut.size());
    half_sorted_.resize(cut.size());
    for (std::size_t k = 0; k < cut.size(); ++k) sorted_[k] = {cut[k], weights[k], {}};
    for (const std::uint32_t shift : {0u, k_digit}) {
        const auto digit = [&](const Node& node) { return (node.id >> shift) % k_digits; };
        places_.assign(k_digits, 0);
        for (const Node& node : sorted_) ++places_[digit(node)];
        std::exclusive_scan(places_.begin(), places_.end(), places_.begin(), 0u);
        for (const Node& node : sorted_) half_sorted_[places_[digit(node)]++] = node;
        sorted_.swap(half_sorted_);
    }
}

void TestedNodes::choose(const LightTree& tree, const FacingPoint& point, std::span<const NodeId> cut,
                         std::span<const float> weights, std::size_t count)
{
    constexpr double k_by_form_factor = 0.25;   // fraction of all chances
    nodes_ = cut, weights_ = weights;
    if (cut.size() <= count) return;
    sort(cut, weights);
    // Find what each node brings; one below the horizon brings nothing.
    double light = 0, form_factor = 0;
    for (Node& node : sorted_) {
        const VirtualLightQuad& quad = tree.quad(node.id / 4);
        const std::size_t lane = node.id % 4;
        const glm::vec3 to = glm::vec3(quad.x[lane], quad.y[lane], quad.z[lane]) - point.origin;
        const bool above = glm::dot(to, point.horizon) > 0 && glm::dot(to, point.normal) > 0;
        const float weight = above ? node.weight : 0;
        node.share = {weight * quad.flux[lane], weight * quad.area[lane]};
        light += node.share.light, form_factor += node.share.form_factor;
    }
    // Take a node each time that the sum of chances passes a whole number.
    const double all = static_cast<double>(count);
    const float by_light = light > 0 ? static_cast<float>(all * (1 - k_by_form_factor) / light) : 0;
    const float by_form_factor = form_factor > 0 ? static_cast<float>(all * k_by_form_factor / form_factor) : 0;
    chosen_.clear();
    chosen_weights_.clear();
    float sum = 0.5f;
    for (const Node& node : sorted_) {
        const float chance = by_light * node.share.light + by_form_factor * node.share.form_factor;
        if (!(chance > 0)) continue;
        if (chance < 1) {
            sum += chance;
            if (sum < 1) continue;
            sum -= 1;
        }
        chosen_.push_back(node.id);
        chosen_weights_.push_back(node.weight / std::min(chance, 1.0f));
    }
    nodes_ = chosen_, weights_ = chosen_weights_;
}

}   // namespace gnomon::irradiance_cache
