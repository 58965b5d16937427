// SPDX-License-Identifier: Apache-2.0
// The visible scheme with an engine: points are placed where they are met, wait, and get their light together.
#include <algorithm>

#include "base/check.h"
#include "irradiance_cache/irradiance_cache.h"

namespace gnomon::irradiance_cache {

namespace {

constexpr std::size_t k_together = 2048;   // points that go to the engine at a time: bounds what it holds for them
constexpr std::size_t k_piece = 64;        // and of these, that a thread takes at a time
constexpr std::uint64_t k_reckoned = 64;   // rays of a new point, before it is known how many

// Pieces of `count` points for threads to take; one, where an engine answers rays: it serves one thread.
std::size_t piece_size(std::size_t count, bool traces)
{
    return traces ? std::max<std::size_t>(count, 1) : k_piece;
}

}   // namespace

void PointEngine::occluded(const ray::RayQueue&, std::uint8_t*, ray::Against)
{
    fail_check(__FILE__, __LINE__, "an engine that answers no rays was asked for some");
}

void VisibleLight::set_engine(std::unique_ptr<PointEngine> engine)
{
    GNOMON_CHECK(frame_ == 0);
    engine_ = std::move(engine);
}

// Puts what was claimed, and has no light of this frame, on the engine's list.
void VisibleLight::wait(Batch& batch)
{
    see_near(batch);
    const std::uint32_t version = emitters_.geometry_version();
    for (RememberedPoint* point : batch.claimed) {
        point->waits = false;   // of a frame that failed
        if (!point->exists) point->version = version;
        if (!point->exists || is_near(point->key)) continue;
        const bool fresh = point->version != version;
        if (!fresh && point->dynamic_version == dynamic_version_) continue;
        point->waits = true;
        batch.waiting.push_back(point);
        if (fresh) spent_rays_ += k_reckoned;
    }
}

void VisibleLight::light_waiting(std::span<const std::unique_ptr<Batch>> batches, Tasks& tasks)
{
    std::vector<RememberedPoint*> all;
    for (const auto& batch : batches) {
        all.insert(all.end(), batch->waiting.begin(), batch->waiting.end());
        batch->waiting.clear();
    }
    // Which thread met which is chance.
    std::sort(all.begin(), all.end(), [](const auto* a, const auto* b) { return a->key < b->key; });
    for (std::size_t begin = 0; begin < all.size(); begin += k_together)
        light_some({all.data() + begin, std::min(k_together, all.size() - begin)}, batches, tasks);
    for (RememberedPoint* point : all) point->waits = false;
}

void VisibleLight::light_some(std::span<RememberedPoint* const> points, std::span<const std::unique_ptr<Batch>> batches,
                              Tasks& tasks)
{
    // What do those see that are new?
    const std::uint32_t version = emitters_.geometry_version();
    std::vector<RememberedPoint*> some;
    for (RememberedPoint* point : points)
        if (point->version != version) some.push_back(point);
    see_waiting(some, batches, tasks);

    // What of it arrives now?
    some.clear();
    std::vector<SumRequest> wanted;
    for (RememberedPoint* point : points) {
        if (point->dynamic_version == dynamic_version_) continue;
        some.push_back(point);
        wanted.push_back({point->origin(), {point->kept, point->count}});
    }
    PointSums sums;
    engine_->sum(wanted, sums);

    // And past what moves, from the sky, and from what moves itself?
    const std::size_t piece = piece_size(some.size(), engine_->traces());
    tasks.for_each((some.size() + piece - 1) / piece, [&](std::size_t number, int thread) {
        Batch& batch = *batches[static_cast<std::size_t>(thread)];
        batch.rays.clear();
        batch.shares.clear();
        batch.bounce_rays.clear();
        batch.bounces.clear();
        const std::size_t begin = number * piece, end = std::min(begin + piece, some.size());
        auto crossed = std::lower_bound(sums.crossed.begin(), sums.crossed.end(), begin,
                                        [](const PointSums::Crossed& c, std::size_t p) { return c.point < p; });
        for (std::size_t p = begin; p < end; ++p) {
            RememberedPoint& point = *some[p];
            ++batch.counters.summed_points;
            point.dynamic_version = dynamic_version_;
            for (int colour = 0; colour < 3; ++colour)
                point.light[colour] = point.still[colour] + sums.light[p].of[colour];
            for (; crossed != sums.crossed.end() && crossed->point == p; ++crossed) {
                const NodeId node = seen_node(crossed->seen);
                const glm::vec3 to = emitters_.samples().at(node) - point.origin();
                batch.rays.push(point.origin(), 0, to, options_.emitters.ray_end);
                batch.shares.push_back(
                    {&point, emitters_.flux().at(node), to * (seen_weight(crossed->seen) / glm::length(to))});
            }
            if (dynamic_.empty() && !emitters_.any_differs()) continue;
            if (sky_.any()) shade_sky(batch, point);
            bounce_off_dynamic(batch, point);
        }
        add_what_arrives(batch, batch.rays, batch.shares, ray::Against::dynamic_only);
        add_what_arrives(batch, batch.bounce_rays, batch.bounces, ray::Against::everything);
        for (std::size_t p = begin; p < end; ++p) end_sum(*some[p]);
    });
}

// As see(): cuts by the engine, and what is seen of them given to it to keep. `still` is the sky's light alone.
void VisibleLight::see_waiting(std::span<RememberedPoint* const> points,
                               std::span<const std::unique_ptr<Batch>> batches, Tasks& tasks)
{
    if (points.empty()) return;
    std::vector<CutRequest> wanted;
    for (RememberedPoint* point : points) {
        const CutOptions cut = cut_options(*point);
        wanted.push_back({point->origin(), cut.error, point->normal, cut.estimate});
        if (point->count > 0) engine_->forget({point->kept, point->count});
    }
    PointCuts cuts;
    engine_->cut(wanted, options_.cut, cuts);

    std::vector<KeptNodes> lists(points.size());
    const std::size_t piece = piece_size(points.size(), engine_->traces());
    std::vector<std::vector<SeenNode>> seen((points.size() + piece - 1) / piece);
    tasks.for_each(seen.size(), [&](std::size_t number, int thread) {
        Batch& batch = *batches[static_cast<std::size_t>(thread)];
        batch.rays.clear();
        batch.entries.clear();
        batch.entry_weight.clear();
        batch.fresh.clear();
        const std::size_t begin = number * piece, end = std::min(begin + piece, points.size());
        for (std::size_t p = begin; p < end; ++p) {
            const std::size_t first = cuts.first[p], count = cuts.first[p + 1] - first;
            batch.fresh.push_back({points[p], batch.entries.size()});
            push_ways(batch, *points[p], {cuts.node.data() + first, count}, {cuts.weight.data() + first, count});
        }
        ask(batch, batch.rays, ray::Against::static_only);
        for (std::size_t p = begin; p < end; ++p) {
            const std::size_t first = batch.fresh[p - begin].first;
            const std::size_t last = p + 1 < end ? batch.fresh[p + 1 - begin].first : batch.entries.size();
            for (std::size_t e = first; e < last; ++e) {
                if (batch.occluded[e]) continue;
                seen[number].push_back(pack_seen(batch.entries[e], batch.entry_weight[e]));
                ++lists[p].count;
            }
            seen[number].resize((seen[number].size() + k_seen_step - 1) / k_seen_step * k_seen_step);
            RememberedPoint& point = *points[p];
            std::fill(point.still, point.still + 3, glm::vec3(0));
            point.version = emitters_.geometry_version();
            point.dynamic_version = 0;
            ++batch.counters.new_points;
            batch.counters.nodes += lists[p].count;
        }
        if (sky_.any()) see_sky(batch);
    });
    std::vector<SeenNode> all;
    for (const std::vector<SeenNode>& some : seen) all.insert(all.end(), some.begin(), some.end());
    engine_->keep(all, lists);
    for (std::size_t p = 0; p < points.size(); ++p) {
        points_.resized(points[p]->count, lists[p].count);
        points[p]->count = lists[p].count, points[p]->kept = lists[p].name;
    }
}

}   // namespace gnomon::irradiance_cache
