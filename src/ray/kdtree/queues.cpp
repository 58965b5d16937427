// SPDX-License-Identifier: Apache-2.0
// Traces queues of rays with the counting k-d tree, ray by ray. Counts are sums of integers, so they do not depend on
// threads.
#include "ray/embree/impl.h"

namespace gnomon::ray {

void RayScene::Impl::add_to_kdtree_sums(RayClass purpose, const KdCounts& counts) const
{
    Sums& sums = kdtree_sums[static_cast<std::size_t>(purpose)];
    sums.nodes.fetch_add(counts.nodes, std::memory_order_relaxed);
    sums.tests.fetch_add(counts.tests, std::memory_order_relaxed);
}

void RayScene::Impl::closest_on_kdtree(const RayQueue& rays, std::size_t begin, std::size_t end, Hits& hits,
                                       Sides sides, Against against) const
{
    KdCounts counts;
    for (std::size_t i = begin; i < end; ++i) {
        const Hit hit =
            kdtree->closest(rays.origin(i), rays.tnear[i], rays.direction(i), rays.tfar[i], sides, counts, against);
        hits.object[i] = hit.object, hits.triangle[i] = hit.triangle;
        const glm::vec2 uv = off_edges(hit.u, hit.v);
        hits.t[i] = hit.t, hits.u[i] = uv.x, hits.v[i] = uv.y;
    }
    add_to_kdtree_sums(rays.purpose, counts);
}

void RayScene::Impl::occluded_on_kdtree(const RayQueue& rays, std::size_t begin, std::size_t end,
                                        std::uint8_t* occluded, Against against) const
{
    KdCounts counts;
    for (std::size_t i = begin; i < end; ++i)
        occluded[i - begin] =
            kdtree->occluded(rays.origin(i), rays.tnear[i], rays.direction(i), rays.tfar[i], against, counts);
    add_to_kdtree_sums(rays.purpose, counts);
}

void RayScene::trace_on_kdtree(const scene::SceneState& state)
{
    impl_->kdtree = std::make_unique<CountingKdTree>(state, *this);
}

KdCounts RayScene::kdtree_work(RayClass purpose) const
{
    const Impl::Sums& sums = impl_->kdtree_sums[static_cast<std::size_t>(purpose)];
    return {sums.nodes, sums.tests};
}

}   // namespace gnomon::ray
