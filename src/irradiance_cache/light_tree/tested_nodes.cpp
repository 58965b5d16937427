// SPDX-License-Identifier: Apache-2.0
#include "irradiance_cache/light_tree/tested_nodes.h"

#include <algorithm>

namespace gnomon::irradiance_cache {

void TestedNodes::choose(const LightTree& tree, const FacingPoint& point, std::span<const NodeId> cut,
                         std::span<const float> weights, std::size_t count)
{
    constexpr double k_by_form_factor = 0.25;   // fraction of all chances
    nodes_ = cut, weights_ = weights;
    if (cut.size() <= count) return;
    // Find what each node brings; one below the horizon brings nothing.
    shares_.clear();
    double light = 0, form_factor = 0;
    for (std::size_t k = 0; k < cut.size(); ++k) {
        const VirtualLightQuad& quad = tree.quad(cut[k] / 4);
        const std::size_t lane = cut[k] % 4;
        const glm::vec3 to = glm::vec3(quad.x[lane], quad.y[lane], quad.z[lane]) - point.origin;
        const bool above = glm::dot(to, point.horizon) > 0 && glm::dot(to, point.normal) > 0;
        const float weight = above ? weights[k] : 0;
        shares_.push_back({weight * quad.flux[lane], weight * quad.area[lane]});
        light += shares_.back().light, form_factor += shares_.back().form_factor;
    }
    // Take a node each time that the sum of chances passes a whole number.
    const double all = static_cast<double>(count);
    const float by_light = light > 0 ? static_cast<float>(all * (1 - k_by_form_factor) / light) : 0;
    const float by_form_factor = form_factor > 0 ? static_cast<float>(all * k_by_form_factor / form_factor) : 0;
    chosen_.clear();
    chosen_weights_.clear();
    float sum = 0.5f;
    for (std::size_t k = 0; k < cut.size(); ++k) {
        const float chance = by_light * shares_[k].light + by_form_factor * shares_[k].form_factor;
        if (!(chance > 0)) continue;
        if (chance < 1) {
            sum += chance;
            if (sum < 1) continue;
            sum -= 1;
        }
        chosen_.push_back(cut[k]);
        chosen_weights_.push_back(weights[k] / std::min(chance, 1.0f));
    }
    nodes_ = chosen_, weights_ = chosen_weights_;
}

}   // namespace gnomon::irradiance_cache
