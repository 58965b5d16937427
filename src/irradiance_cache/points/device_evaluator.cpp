// SPDX-License-Identifier: Apache-2.0
#include "irradiance_cache/points/device_evaluator.h"

#include <algorithm>

#include "base/check.h"

namespace gnomon::irradiance_cache {

namespace {

constexpr std::size_t k_together = 1024;   // points that the device gets at a time: bounds the memory that it needs
constexpr std::size_t k_piece = 64;        // of these, points that a thread takes at a time
constexpr std::uint64_t k_estimate = 64;   // rays of a new point, as long as its cut is unknown

}   // namespace

void PointDevice::occluded(const ray::RayQueue&, std::uint8_t*, ray::Against)
{
    fail_check(__FILE__, __LINE__, "this device traces no rays");
}

void DeviceEvaluator::begin_frame(const CacheFrame& frame)
{
    device_->begin_frame(frame.lights, frame.dynamic_bounds);
}

void DeviceEvaluator::release(const CachePoint& point)
{
    if (point.count > 0) device_->forget({point.kept, point.count});
}

OcclusionTester DeviceEvaluator::tester(const CacheFrame& frame) const
{
    return {frame.rays, device_->traces() ? device_.get() : nullptr};
}

// Points that a thread takes at a time; all of them if the device traces rays, because only one thread may use it.
std::size_t DeviceEvaluator::piece_size(std::size_t count) const
{
    return device_->traces() ? std::max<std::size_t>(count, 1) : k_piece;
}

void DeviceEvaluator::evaluate(const CacheFrame& frame, std::span<CachePoint* const> points, EvaluationScratch& scratch)
{
    for (CachePoint* point : points) {
        point->queued = false;   // left from a frame that failed
        if (!point->exists || is_near(point->key)) continue;
        const bool fresh = point->version != frame.lights.geometry_version();
        if (!fresh && point->dynamic_version == frame.dynamic_version) continue;
        scratch.queued.push_back(point);
        point->queued = true;
        if (fresh) scratch.expected_rays += k_estimate;
    }
}

void DeviceEvaluator::evaluate_queued(const CacheFrame& frame, std::span<EvaluationScratch* const> scratch,
                                      Tasks& tasks)
{
    // Sort the points of all threads: which thread claimed which depends on timing.
    std::vector<CachePoint*> all;
    for (EvaluationScratch* own : scratch) {
        all.insert(all.end(), own->queued.begin(), own->queued.end());
        own->queued.clear();
    }
    std::sort(all.begin(), all.end(), [](const auto* a, const auto* b) { return a->key < b->key; });
    for (std::size_t begin = 0; begin < all.size(); begin += k_together) {
        const std::span<CachePoint* const> some(all.data() + begin, std::min(k_together, all.size() - begin));
        find_visible_nodes(frame, some, scratch, tasks);
        sum(frame, some, scratch, tasks);
    }
    for (CachePoint* point : all) point->queued = false;
}

// Finds what new points see past static geometry.
void DeviceEvaluator::find_visible_nodes(const CacheFrame& frame, std::span<CachePoint* const> points,
                                         Scratches scratch, Tasks& tasks)
{
    // Cut the tree for the new points.
    std::vector<CachePoint*> fresh;
    std::vector<CutRequest> requests;
    for (CachePoint* point : points) {
        if (point->version == frame.lights.geometry_version()) continue;
        const CutOptions cut = cut_options(frame.options, *point);
        fresh.push_back(point);
        requests.push_back({point->origin(), cut.error, point->normal, cut.estimate});
    }
    if (fresh.empty()) return;
    PointCuts cuts;
    device_->cut(requests, frame.options.cut, cuts);

    // Trace rays to the nodes and to the sky.
    std::vector<KeptNodes> lists(fresh.size());
    const std::size_t piece = piece_size(fresh.size());
    std::vector<std::vector<SeenNode>> seen((fresh.size() + piece - 1) / piece);
    tasks.for_each(seen.size(), [&](std::size_t number, int thread) {
        EvaluationScratch& own = *scratch[static_cast<std::size_t>(thread)];
        own.visibility.clear();
        const std::size_t begin = number * piece, end = std::min(begin + piece, fresh.size());
        for (std::size_t p = begin; p < end; ++p) {
            const std::size_t first = cuts.first[p], count = cuts.first[p + 1] - first;
            own.visibility.add(frame, *fresh[p], {cuts.node.data() + first, count},
                               {cuts.weight.data() + first, count});
        }
        std::size_t p = begin;
        own.visibility.trace_nodes(
            frame, tester(frame), own.counters, [&](CachePoint& point, std::span<const SeenNode> visible) {
                std::vector<SeenNode>& all = seen[number];
                all.insert(all.end(), visible.begin(), visible.end());
                all.resize((all.size() + k_seen_step - 1) / k_seen_step * k_seen_step);
                lists[p++].count = static_cast<std::uint32_t>(visible.size());
                std::fill(point.static_light, point.static_light + 3, glm::vec3(0));   // the sky's alone
            });
        table_.resized(0, static_cast<std::size_t>(own.visibility.trace_sky(frame, tester(frame), own.counters)));
    });
    std::vector<SeenNode> all;
    for (const std::vector<SeenNode>& some : seen) all.insert(all.end(), some.begin(), some.end());
    keep(frame, fresh, all, lists);
}

// Hands the visible nodes of new points to the device.
void DeviceEvaluator::keep(const CacheFrame& frame, std::span<CachePoint* const> points, std::span<const SeenNode> seen,
                           std::span<KeptNodes> lists)
{
    for (CachePoint* point : points) {
        release(*point);
        table_.resized(point->count, 0);
        point->count = 0;
    }
    device_->keep(seen, lists);
    for (std::size_t p = 0; p < points.size(); ++p) {
        CachePoint& point = *points[p];
        table_.resized(0, lists[p].count);
        point.count = lists[p].count, point.kept = lists[p].name;
        point.version = frame.lights.geometry_version();
        point.dynamic_version = 0;
    }
}

// Sums the present light of points for which something changed.
void DeviceEvaluator::sum(const CacheFrame& frame, std::span<CachePoint* const> points, Scratches scratch, Tasks& tasks)
{
    std::vector<CachePoint*> changed;
    std::vector<SumRequest> requests;
    for (CachePoint* point : points) {
        if (point->dynamic_version == frame.dynamic_version) continue;
        changed.push_back(point);
        requests.push_back({point->origin(), {point->kept, point->count}});
    }
    PointSums sums;
    device_->sum(requests, sums);

    // Add what the device left to rays: nodes and sky behind dynamic objects, and light from dynamic objects.
    const bool corrects = !frame.dynamic_bounds.empty() || frame.lights.any_differs();
    const std::size_t piece = piece_size(changed.size());
    tasks.for_each((changed.size() + piece - 1) / piece, [&](std::size_t number, int thread) {
        EvaluationScratch& own = *scratch[static_cast<std::size_t>(thread)];
        own.present.clear();
        const std::size_t begin = number * piece, end = std::min(begin + piece, changed.size());
        auto crossed = std::lower_bound(sums.crossed.begin(), sums.crossed.end(), begin,
                                        [](const PointSums::Crossed& c, std::size_t p) { return c.point < p; });
        for (std::size_t p = begin; p < end; ++p) {
            CachePoint& point = *changed[p];
            ++own.counters.summed_points;
            point.dynamic_version = frame.dynamic_version;
            point.near = point.static_near;
            point.covered_now = false;
            for (int colour = 0; colour < 3; ++colour)
                point.light[colour] = point.static_light[colour] + point.tint[colour] * sums.light[p].of[colour];
            for (; crossed != sums.crossed.end() && crossed->point == p; ++crossed) {
                const NodeId node = seen_node(crossed->seen);
                const glm::vec3 to = frame.lights.samples().at(node) - point.origin();
                own.present.add_if_unoccluded(frame, point, node, point.tint * frame.lights.flux().at(node),
                                              to * (seen_weight(crossed->seen) / glm::length(to)));
            }
            if (!corrects) continue;
            own.present.correct_sky(frame, point);
            own.present.want_dynamic_lights(point);
        }
        own.present.finish(frame, tester(frame), own.counters);
        if (!frame.dynamic_bounds.empty())
            own.near.correct(frame, std::span(changed).subspan(begin, end - begin), own.counters);
        for (std::size_t p = begin; p < end; ++p) end_corrections(*changed[p]);
    });
}

}   // namespace gnomon::irradiance_cache
