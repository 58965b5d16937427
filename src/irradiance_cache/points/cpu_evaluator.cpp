// SPDX-License-Identifier: Apache-2.0
#include "irradiance_cache/points/cpu_evaluator.h"

#include <algorithm>

#include "base/interruption.h"

namespace gnomon::irradiance_cache {

void CpuEvaluator::evaluate(const CacheFrame& frame, std::span<CachePoint* const> points, EvaluationScratch& scratch)
{
    find_visible_nodes(frame, points, scratch);
    sum(frame, points, scratch);
}

// Finds what new points see past static geometry.
void CpuEvaluator::find_visible_nodes(const CacheFrame& frame, std::span<CachePoint* const> points,
                                      EvaluationScratch& scratch)
{
    const LightTree& tree = frame.lights;
    const std::uint32_t version = tree.geometry_version();
    const OcclusionTester tester{frame.rays};
    std::size_t next = 0;
    while (next < points.size()) {
        // Cut the tree for some points at a time, so that their rays fill packets and stay in the cache.
        constexpr std::size_t k_rays = 2048;
        StaticVisibility& visibility = scratch.visibility;
        visibility.clear();
        for (; next < points.size() && visibility.rays() < k_rays; ++next) {
            CachePoint& point = *points[next];
            if (!point.exists || point.version == version || is_near(point.key)) continue;
            interruption_point();   // every point is either complete or untouched here
            cut_tree(tree, cut_options(frame.options, point), point.origin(), point.normal, scratch.cut,
                     scratch.weights, scratch.cut_memory);
            visibility.add(frame, point, scratch.cut, scratch.weights);
        }
        interruption_point();
        // Keep the nodes that are visible, and sum their light without dynamic objects.
        visibility.trace_nodes(frame, tester, scratch.counters, [&](CachePoint& point, std::span<const SeenNode> seen) {
            const std::size_t padded = (seen.size() + k_seen_step - 1) / k_seen_step * k_seen_step;
            auto kept = std::make_unique<SeenNode[]>(padded);
            // Nodes over patches come last.
            const auto over_patch = [&](SeenNode node) { return seen_node(node) >= tree.first_patch(); };
            SeenNode* const patches = std::remove_copy_if(seen.begin(), seen.end(), kept.get(), over_patch);
            std::copy_if(seen.begin(), seen.end(), patches, over_patch);
            point.patches = static_cast<std::uint32_t>(patches - kept.get()) / k_seen_step * k_seen_step;
            table_.resized(point.count, seen.size());
            point.count = static_cast<std::uint32_t>(seen.size());
            point.seen = std::move(kept);
            sum_seen(tree, point.seen.get(), static_cast<std::uint32_t>(padded), point.origin(), point.static_light);
            for (int colour = 0; colour < 3; ++colour) point.static_light[colour] *= point.tint[colour];
            point.version = version;
            point.dynamic_version = 0;
        });
        table_.resized(0, static_cast<std::size_t>(visibility.trace_sky(frame, tester, scratch.counters)));
    }
}

// Sums the present light of points for which something changed.
void CpuEvaluator::sum(const CacheFrame& frame, std::span<CachePoint* const> points, EvaluationScratch& scratch) const
{
    constexpr std::size_t k_points = 256;   // at a time, so that an interruption does not wait for all
    std::size_t next = 0;
    while (next < points.size()) {
        interruption_point();   // every point is either complete or untouched here
        scratch.present.clear();
        scratch.points.clear();
        for (; next < points.size() && scratch.points.size() < k_points; ++next) {
            CachePoint& point = *points[next];
            if (!point.exists || point.dynamic_version == frame.dynamic_version || is_near(point.key)) continue;
            scratch.points.push_back(&point);
            ++scratch.counters.summed_points;
            point.dynamic_version = frame.dynamic_version;
            std::copy(point.static_light, point.static_light + 3, point.light);
            point.near = point.static_near;
            point.covered_now = false;
            if (frame.lights.any_patch_differs()) add_patch_difference(frame.lights, point);
            if (!frame.dynamic_bounds.empty() || frame.lights.any_differs()) correct(frame, point, scratch);
        }
        scratch.present.finish(frame, {frame.rays}, scratch.counters);
        if (!frame.dynamic_bounds.empty()) scratch.near.correct(frame, scratch.points, scratch.counters);
        for (CachePoint* point : scratch.points) end_corrections(*point);
    }
}

// Adds what dynamic objects change of the light of patches, which is something at most patches.
void CpuEvaluator::add_patch_difference(const LightTree& tree, CachePoint& point)
{
    if (point.patches >= point.count) return;
    const std::uint32_t padded = (point.count + k_seen_step - 1) / k_seen_step * k_seen_step;
    glm::vec3 light[3];
    sum_seen_difference(tree, point.seen.get() + point.patches, padded - point.patches, point.origin(), light);
    for (int colour = 0; colour < 3; ++colour) point.light[colour] += point.tint[colour] * light[colour];
}

// Corrects the static light of a point by what dynamic objects change.
void CpuEvaluator::correct(const CacheFrame& frame, CachePoint& point, EvaluationScratch& scratch) const
{
    const LightTree& tree = frame.lights;
    scratch.changed.clear();
    find_changed(tree, point.seen.get(), point.count, point.origin(), frame.dynamic_bounds, scratch.changed);
    for (const ChangedNode& changed : scratch.changed) {
        const SeenNode seen = point.seen[changed.place];
        const NodeId node = seen_node(seen);
        const glm::vec3 to = tree.samples().at(node) - point.origin();
        const glm::vec3 direction = to * (seen_weight(seen) / glm::length(to));
        const glm::vec3 now = point.tint * tree.flux().at(node);
        const glm::vec3 before = node < tree.first_patch() ? point.tint * tree.static_flux().at(node) : now;
        if (!changed.crossed) {
            point.add_light(now - before, direction);
            continue;
        }
        // Take the light away, and add it again if no dynamic object occludes it.
        point.add_light(-before, direction);
        if (now != glm::vec3(0)) scratch.present.add_if_unoccluded(frame, point, node, now, direction);
    }
    scratch.present.correct_sky(frame, point);
    scratch.present.want_dynamic_lights(point);
}

}   // namespace gnomon::irradiance_cache
