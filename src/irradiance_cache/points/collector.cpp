// SPDX-License-Identifier: Apache-2.0
#include "irradiance_cache/points/collector.h"

#include <algorithm>

#include "irradiance_cache/points/parts.h"

namespace gnomon::irradiance_cache {

namespace {

constexpr std::size_t k_least_slots = 64;
// At the very foot of a wall, lattice points on both sides of it are within a pixel's reach, and those on the viewer's
// side are the right ones. So a surface point is moved towards the viewer, along the surface, by this fraction of the
// spacing. That exceeds what free distances may lack (interpolator.cpp) if the viewer is at least some ten degrees off
// the wall's plane.
constexpr float k_towards_viewer = 0.04f;

}   // namespace

void PointCollector::begin(const CacheFrame& frame, std::span<const IndirectPoint> points,
                           std::span<const std::uint32_t> chosen, BatchWork& work)
{
    work.queued = false;
    work.lattice.clear();
    work.parts.clear();
    work.near_weight.assign(points.size(), 1);
    work.near_known.assign(points.size(), glm::vec4(0));
    work.near_share.assign(points.size(), 0);
    work.deferred.assign(frame.budget.limited() ? points.size() : 0, 0);
    work.near_parts.clear();
    for (const std::uint32_t i : chosen) {
        if (work.dynamic[i])
            work.parts.push_back({i, 1, 0, nullptr, glm::vec3(0)});
        else
            work.lattice.push_back({i, detail_of(frame.options.widest * points[i].width).level, 0, 1, glm::vec3(0)});
    }
}

void PointCollector::collect_cells(const CacheFrame& frame, std::span<const IndirectPoint> points, PointClaims& claims,
                                   BatchWork& work)
{
    claims.begin(frame.number);
    work.cells.clear();
    found_.clear();
    std::size_t slots = k_least_slots;
    while (slots < 2 * work.lattice.size()) slots *= 2;
    slots_.assign(slots, 0);
    LatticeCursor cursor;
    std::uint32_t current = 0;
    for (LatticeRequest request : work.lattice) {
        const LatticeCursor::Step step = cursor.go(points[request.point], request.level);
        if (step == LatticeCursor::Step::outside) {
            work.parts.push_back({request.point, request.weight, 0, nullptr, glm::vec3(0)});
            continue;
        }
        const LatticeCell& cell = cursor.cell();
        if (step == LatticeCursor::Step::other) current = find_or_add_cell(cell, request.level, claims, work);
        ++work.cells[current].end;
        request.cell = current;
        found_.push_back({request, cell.x, cell.y});
    }
    order_by_cell(points, work);
}

// The number of a cell among those of this batch. Collects its points if it is new.
std::uint32_t PointCollector::find_or_add_cell(const LatticeCell& cell, int level, PointClaims& claims, BatchWork& work)
{
    const std::uint64_t mixed = (cell.key[0] ^ (cell.key[3] << 1)) * 0x9e3779b97f4a7c15ull;
    const std::size_t mask = slots_.size() - 1;
    std::size_t slot = (mixed >> 32) & mask;
    for (; slots_[slot] != 0; slot = (slot + 1) & mask) {
        const CollectedCell& other = work.cells[slots_[slot] - 1];
        if (std::equal(cell.key, cell.key + 4, other.key)) return slots_[slot] - 1;
    }
    CollectedCell& made = work.cells.emplace_back();
    std::copy(cell.key, cell.key + 4, made.key);
    made.anchors.axis = lattice_axis(cell.key[0]);
    made.level = level;
    made.first = made.end = 0;
    for (int c = 0; c < 4; ++c) made.point[c] = claims.find_or_create(cell.key[c]);
    slots_[slot] = static_cast<std::uint32_t>(work.cells.size());
    return slots_[slot] - 1;
}

// Counting sort of the found requests by cell; `end` of each cell is the number of its requests.
void PointCollector::order_by_cell(std::span<const IndirectPoint> points, BatchWork& work) const
{
    std::size_t end = 0;
    for (CollectedCell& cell : work.cells) {
        cell.first = end;
        end += cell.end;
        cell.end = cell.first;
    }
    work.lattice.resize(end);
    work.lattice_points.resize(end);
    LatticePoints& lattice = work.lattice_points;
    for (const Found& found : found_) {
        const std::size_t k = work.cells[found.request.cell].end++;
        work.lattice[k] = found.request;
        const IndirectPoint& p = points[found.request.point];
        const glm::vec3 aside = p.to_viewer - glm::dot(p.to_viewer, p.geometric_normal) * p.geometric_normal;
        const glm::vec3 at = p.position + k_towards_viewer * spacing_of(found.request.level) * aside;
        lattice.x[k] = at.x, lattice.y[k] = at.y, lattice.z[k] = at.z;
        lattice.gx[k] = p.geometric_normal.x, lattice.gy[k] = p.geometric_normal.y,
        lattice.gz[k] = p.geometric_normal.z;
        lattice.nx[k] = p.normal.x, lattice.ny[k] = p.normal.y, lattice.nz[k] = p.normal.z;
        lattice.fx[k] = found.x, lattice.fy[k] = found.y;
    }
}

void PointCollector::select_parts(const CacheFrame& frame, std::span<const IndirectPoint> points, BatchWork& work)
{
    whole_.swap(work.parts);
    work.parts.clear();
    for (const PartRequest& whole : whole_) {
        const IndirectPoint& point = points[whole.point];
        // Where pixels are wide, the parts have near fields (Interpolator::blend_parts).
        if (!work.dynamic[whole.point])
            work.near_weight[whole.point] -= whole.weight * frame.near_by_parts(point.width);
        const PartWeights parts = select_far_parts(frame, point);
        for (int i = 0; i < parts.count; ++i)
            work.parts.push_back({whole.point, whole.weight * parts.weight[i], parts.key[i], nullptr, whole.fallback});
    }
}

void PointCollector::collect_parts(const CacheFrame& frame, PointClaims& claims, BatchWork& work)
{
    claims.begin(frame.number);
    for (PartRequest& part : work.parts) part.part = claims.find_or_create(part.key);
}

}   // namespace gnomon::irradiance_cache
