// SPDX-License-Identifier: Apache-2.0
#include "irradiance_cache/points/remembered_batch.h"

#include <algorithm>
#include <cmath>

#include "irradiance_cache/points/lattice_kernels.h"

namespace gnomon::irradiance_cache {

namespace {

constexpr std::uint16_t k_none = 0xffff;

// The mean of the normals of a cell's cache points, by weight.
glm::vec3 mean_normal(const CachePoint* const (&from)[4], const RememberedBatch::Contribution& c)
{
    const glm::vec3 sum = (c.weight_of[0] * from[0]->normal + c.weight_of[1] * from[1]->normal) +
                          (c.weight_of[2] * from[2]->normal + c.weight_of[3] * from[3]->normal);
    return sum / std::sqrt(sum.x * sum.x + sum.y * sum.y + sum.z * sum.z);
}

}   // namespace

// In the order of operations of interpolate_cell(), so that the light is the same to the bit.
void RememberedBatch::add_lattice(glm::vec3* irradiance, glm::vec4* near_known, float* near_share) const
{
    std::uint32_t next = 0;
    for (const Cell& cell : cells) {
        const CachePoint* const from[4] = {cached[cell.at[0]], cached[cell.at[1]], cached[cell.at[2]],
                                           cached[cell.at[3]]};
        // Surface points of a plane have one normal.
        const bool one_normal = have_one_normal(from);
        glm::vec3 arrives[4] = {};
        std::size_t normal = normals.size();
        for (; next < cell.end; ++next) {
            const Contribution& c = contributions[next];
            if (!one_normal) {
                const glm::vec3 mean = mean_normal(from, c);
                for (int i = 0; i < 4; ++i)
                    arrives[i] = from[i]->irradiance(halfway_normal(from[i]->normal, mean, normals[c.normal]));
            } else if (c.normal != normal) {
                normal = c.normal;
                for (int i = 0; i < 4; ++i) arrives[i] = from[i]->irradiance(normals[normal]);
            }
            const glm::vec3 sum = (c.weight_of[0] * arrives[0] + c.weight_of[1] * arrives[1]) +
                                  (c.weight_of[2] * arrives[2] + c.weight_of[3] * arrives[3]);
            irradiance[c.point] += c.weight * (sum / c.all);
            if (!cell.near) continue;
            if (const glm::vec4 fields = near_between(from, c.weight_of, c.all); fields.w > 0)
                near_known[c.point] += c.weight * fields, near_share[c.point] += c.weight;
        }
    }
}

bool RememberedBatch::same_are_covered(const CacheFrame& now) const
{
    if (looked_at.empty()) return true;
    const glm::vec3 half = 0.5f * region.size();
    const bool any_near = now.dynamic_bounds.any(
        [&](const Sphere& sphere) {
            const glm::vec3 off = glm::max(glm::abs(sphere.centre - region.centre()) - half, glm::vec3(0));
            return glm::dot(off, off) <= sphere.radius * sphere.radius;
        },
        [](const Sphere&, const MovingBox&) { return true; });
    if (!any_near) return !any_covered;
    return std::ranges::all_of(looked_at,
                               [&](const Looked& point) { return point.covered == is_covered(now, point.at); });
}

void RememberedBatch::add_near(const glm::vec4* near_known, const float* near_share, NearBlend& scratch,
                               glm::vec3* irradiance) const
{
    scratch.begin(count);
    for (const Near& n : near) scratch.add(n.point, n.weight, n.known, *cached[n.at], normals[n.normal]);
    scratch.finish(near_known, near_share, irradiance);
}

std::size_t RememberedBatch::bytes() const
{
    return sizeof(RememberedBatch) + cached.capacity() * sizeof(CachePoint*) + normals.capacity() * sizeof(glm::vec3) +
           cells.capacity() * sizeof(Cell) + contributions.capacity() * sizeof(Contribution) + pixels.bytes() +
           near.capacity() * sizeof(Near) + rest.capacity() * sizeof(std::uint16_t) +
           rest_points.capacity() * sizeof(IndirectPoint) + looked_at.capacity() * sizeof(Looked);
}

void BatchRecorder::begin()
{
    cells_.clear(), contributions_.clear(), rest_.clear(), near_.clear();
    first_cell_ = 0;
}

void BatchRecorder::add_cells(const NearField& near_field, std::span<const CollectedCell> cells)
{
    first_cell_ = cells_.size();
    for (const CollectedCell& cell : cells)
        cells_.push_back({{cell.point[0], cell.point[1], cell.point[2], cell.point[3]},
                          near_field.applies_at(spacing_of(cell.level))});
}

void BatchRecorder::add(std::uint32_t point, std::uint32_t cell, float weight, const LatticeLight& light, std::size_t k)
{
    if (weight == 0 || !(light.weight[k] > 0)) return;   // no light
    RememberedBatch::Contribution of{static_cast<std::uint16_t>(point), 0, weight, {}, light.weight[k]};
    for (int i = 0; i < 4; ++i) of.weight_of[i] = light.weight_of[i][k];
    contributions_.push_back({static_cast<std::uint32_t>(first_cell_) + cell, of});
}

void BatchRecorder::add_rest(std::span<const PartRequest> parts)
{
    for (const PartRequest& part : parts) rest_.push_back(part.point);
    std::ranges::sort(rest_);
    rest_.erase(std::unique(rest_.begin(), rest_.end()), rest_.end());
}

std::unique_ptr<RememberedBatch> BatchRecorder::finish(std::span<const IndirectPoint> points,
                                                       const SparsePixels& pixels)
{
    auto result = std::make_unique<RememberedBatch>();
    RememberedBatch& to = *result;
    to.count = points.size();
    to.pixels = pixels.remembered();
    std::vector<const CachePoint*> looked_at;
    for (const Cell& cell : cells_) looked_at.insert(looked_at.end(), std::begin(cell.point), std::end(cell.point));
    std::ranges::sort(looked_at);
    looked_at.erase(std::unique(looked_at.begin(), looked_at.end()), looked_at.end());
    std::erase_if(looked_at, [](const CachePoint* point) { return !point->exists; });
    to.looked_at.reserve(looked_at.size());
    for (const CachePoint* const point : looked_at) {
        const CoverablePoint at(*point);
        to.looked_at.push_back({at, point->covered_now});
        to.any_covered = to.any_covered || point->covered_now;
        to.region.add(Box3{at.origin - at.reach, at.origin + at.reach});
    }
    // Leave out what is computed anew.
    std::erase_if(contributions_,
                  [&](const Contribution& c) { return std::ranges::binary_search(rest_, std::uint32_t{c.of.point}); });
    to.rest.reserve(rest_.size()), to.rest_points.reserve(rest_.size());
    for (const std::uint32_t p : rest_) {
        to.rest.push_back(static_cast<std::uint16_t>(p));
        to.rest_points.push_back(points[p]);
    }

    // List each cache point once.
    for (const Contribution& c : contributions_)
        for (CachePoint* const point : cells_[c.cell].point) to.cached.push_back(point);
    for (const Near& n : near_) to.cached.push_back(n.cached);
    std::ranges::sort(to.cached);
    to.cached.erase(std::unique(to.cached.begin(), to.cached.end()), to.cached.end());
    to.cached.shrink_to_fit();
    const auto number = [&](const CachePoint* point) {
        return static_cast<std::uint32_t>(std::ranges::lower_bound(to.cached, point) - to.cached.begin());
    };
    normal_of_.assign(points.size(), k_none);
    const auto normal_of = [&](std::uint32_t point) {
        const glm::vec3& normal = points[point].normal;
        if (normal_of_[point] == k_none) {
            if (to.normals.empty() || to.normals.back() != normal) to.normals.push_back(normal);
            normal_of_[point] = static_cast<std::uint16_t>(to.normals.size() - 1);
        }
        return normal_of_[point];
    };

    to.contributions.reserve(contributions_.size());
    for (std::size_t c = 0; c < contributions_.size(); ++c) {
        if (c == 0 || contributions_[c].cell != contributions_[c - 1].cell) {
            RememberedBatch::Cell& cell = to.cells.emplace_back();
            for (int i = 0; i < 4; ++i) cell.at[i] = number(cells_[contributions_[c].cell].point[i]);
            cell.near = cells_[contributions_[c].cell].near;
        }
        to.contributions.push_back(contributions_[c].of);
        to.contributions.back().normal = normal_of(contributions_[c].of.point);
        to.cells.back().end = static_cast<std::uint32_t>(c + 1);
    }
    to.near.reserve(near_.size());
    for (const Near& n : near_)
        to.near.push_back(
            {static_cast<std::uint16_t>(n.point), normal_of(n.point), number(n.cached), n.weight, n.known});
    to.cells.shrink_to_fit(), to.normals.shrink_to_fit();
    return result;
}

}   // namespace gnomon::irradiance_cache
