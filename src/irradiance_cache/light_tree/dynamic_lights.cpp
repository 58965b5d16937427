// SPDX-License-Identifier: Apache-2.0
// Lit surfaces of dynamic objects, as virtual lights beside those of the light tree (light_tree.h).
#include <algorithm>
#include <functional>
#include <unordered_map>

#include "base/morton.h"
#include "irradiance_cache/light_tree/light_tree.h"
#include "irradiance_cache/light_tree/thin_leaves.h"
#include "light_views/texel_ray.h"

namespace gnomon::irradiance_cache {

// Finds the lit surfaces of dynamic objects, in every frame in which one moves, and sums them by owner and by the
// octant that they face.
void LightTree::gather_dynamic()
{
    dynamic_.clear();
    struct Lit {
        glm::vec3 position, sample;
        std::size_t of;
    };
    std::vector<Lit> lit;
    std::unordered_map<std::uint64_t, std::size_t> found;
    ray::RayQueue queue;
    queue.purpose = ray::RayClass::indirect;
    ray::Hits hits;
    std::vector<double> measure;
    std::vector<std::uint32_t> texels;
    for (const View& view : views_) {
        // Select the texels of dynamic objects, in tree order; of large objects only every few.
        if (!view.on || view.dynamic_objects.rects.empty()) continue;
        const std::vector<std::uint32_t>& covers = view.dynamic_objects.covers;
        int step = 1;
        while (view.dynamic_objects.area / (static_cast<std::size_t>(step) * static_cast<std::size_t>(step)) >
               options_.dynamic_rays)
            step *= 2;
        texels.clear();
        const std::size_t cell = static_cast<std::size_t>(step) * static_cast<std::size_t>(step);
        for (std::size_t i = 0; i < covers.size(); i += cell) {
            if (i % k_leaves_of_block == 0 && view.dynamic_objects.in_block[i / k_leaves_of_block] == 0 &&
                cell < k_leaves_of_block) {
                i += k_leaves_of_block - cell;
                continue;
            }
            const auto begin = covers.begin() + static_cast<std::ptrdiff_t>(i);
            const auto end = covers.begin() + static_cast<std::ptrdiff_t>(std::min(i + cell, covers.size()));
            if (std::any_of(begin, end, [](std::uint32_t count) { return count > 0; }))
                texels.push_back(static_cast<std::uint32_t>(i));
        }
        if (texels.empty()) continue;
        // Cast a ray through each.
        queue.clear();
        measure.clear();
        for (const std::uint32_t i : texels) {
            const light_views::TexelRay r = light_views::texel_ray(view.projection, static_cast<int>(even_bits(i)),
                                                                   static_cast<int>(even_bits(i >> 1)));
            queue.push(r.origin, 0, r.direction, k_infinity);
            measure.push_back(r.measure * step * step);
        }
        hits.resize(texels.size());
        rays_->closest(queue, 0, texels.size(), hits, ray::Sides::both);
        const std::vector<glm::vec3> factor =
            find_thin_leaves(state_->scene(), *rays_, queue, view.behind, ray::Against::everything, hits);
        // Sum the lit surfaces by owner and octant.
        for (std::size_t i = 0; i < texels.size(); ++i) {
            if (hits.object[i] == scene::none || !state_->is_dynamic(hits.object[i])) continue;
            const Leaf leaf = leaf_at(view, queue, hits, i, measure[i], factor);
            if (!(leaf.area > 0)) continue;
            const std::uint32_t octant =
                (leaf.normal.x < 0 ? 1u : 0u) | (leaf.normal.y < 0 ? 2u : 0u) | (leaf.normal.z < 0 ? 4u : 0u);
            const std::uint32_t owner = owner_of(leaf.object);
            const auto [at, first] =
                found.try_emplace((static_cast<std::uint64_t>(owner) << 3) | octant, dynamic_.size());
            if (first) dynamic_.push_back({.owner = owner});
            DynamicVirtualLight& light = dynamic_[at->second];
            const float flux = luminance(leaf.flux);
            light.flux += leaf.flux;
            light.area += leaf.area;
            light.position += flux * leaf.position;
            light.normal += flux * leaf.normal;
            lit.push_back({leaf.position, leaf.sample, at->second});
        }
    }
    // Divide the sums, and take the surface nearest to the mean position as the sample.
    std::vector<float> nearest(dynamic_.size(), k_infinity);
    for (DynamicVirtualLight& light : dynamic_) {
        const float flux = luminance(light.flux), length = glm::length(light.normal);
        if (flux > 0) light.position /= flux;
        if (length > 0) light.normal /= length;
    }
    for (const Lit& leaf : lit) {
        const float distance = glm::length(leaf.position - dynamic_[leaf.of].position);
        if (distance < nearest[leaf.of]) nearest[leaf.of] = distance, dynamic_[leaf.of].sample = leaf.sample;
    }
    // Keep the brightest, in the order in which they were found.
    if (dynamic_.size() > options_.dynamic_lights) {
        std::vector<float> flux;
        for (const DynamicVirtualLight& light : dynamic_) flux.push_back(luminance(light.flux));
        std::nth_element(flux.begin(), flux.begin() + static_cast<std::ptrdiff_t>(options_.dynamic_lights), flux.end(),
                         std::greater<>());
        const float least = flux[options_.dynamic_lights];
        std::erase_if(dynamic_, [&](const DynamicVirtualLight& light) { return !(luminance(light.flux) > least); });
    }
    std::erase_if(dynamic_, [](const DynamicVirtualLight& light) { return light.flux == glm::vec3(0); });
}

}   // namespace gnomon::irradiance_cache
