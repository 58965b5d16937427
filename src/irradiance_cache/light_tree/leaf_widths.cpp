// SPDX-License-Identifier: Apache-2.0
// How wide the leaves of the light tree are, on which the radius of the near field depends.
#include <algorithm>
#include <cmath>

#include "irradiance_cache/light_tree/light_tree.h"

namespace gnomon::irradiance_cache {

float LightTree::leaf_spacing() const
{
    // Of the light of a ground that reaches to the horizon, hardly any comes near what stands on it.
    const patches::DetailRegion* region = patches_ ? &patches_->patches().region() : nullptr;
    double logarithms = 0, all = 0;
    for (const View& view : views_) {
        if (!view.on) continue;
        const NodeId leaves = first_of_level(view, view.levels);
        for (NodeId id = leaves; id < leaves + static_cast<NodeId>(view.side * view.side); ++id) {
            const VirtualLightQuad& quad = quads_[id / 4];
            auto flux = static_cast<double>(quad.flux[id % 4]);
            if (!(flux > 0)) continue;
            if (region) flux *= static_cast<double>(region->weight({quad.x[id % 4], quad.y[id % 4], quad.z[id % 4]}));
            logarithms += flux * std::log(static_cast<double>(leaf_width(id)));
            all += flux;
        }
    }
    return all > 0 ? static_cast<float>(std::exp(logarithms / all)) : 0.0f;
}

float LightTree::leaf_width(NodeId id) const
{
    const NodeId leaf = samples_.leaves[id];
    return std::sqrt(quads_[leaf / 4].area[leaf % 4]);
}

float LightTree::leaf_width(scene::LightId light, const glm::vec3& position, float cosine) const
{
    if (light >= views_of_.size()) return k_infinity;
    const auto [first, last] = views_of_[light];
    for (std::size_t v = first; v < last; ++v) {
        const View& view = views_[v];
        if (!view.on) continue;
        const glm::vec4 clip = view.projection.clip_from_world * glm::vec4(position, 1);
        if (!(clip.w > 0) || std::max(std::abs(clip.x), std::abs(clip.y)) > clip.w) continue;
        // Multiply a texel's area in the plane of the projection by how much wider it is at the place. Its solid angle
        // falls with the cube of its cosine to the axis.
        const light_views::ViewProjection& projection = view.projection;
        float area = 4 * glm::length(projection.across) * glm::length(projection.down) /
                     static_cast<float>(view.side * view.side);
        if (projection.perspective) area *= clip.w * clip.w * clip.w / glm::length(position - projection.origin);
        return std::sqrt(area / std::max(cosine, options_.least_cosine));
    }
    return k_infinity;
}

}   // namespace gnomon::irradiance_cache
