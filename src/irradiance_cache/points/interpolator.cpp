// SPDX-License-Identifier: Apache-2.0
#include "irradiance_cache/points/interpolator.h"

#include <algorithm>
#include <cmath>

#include "irradiance_cache/points/parts.h"
#include "ray/smooth_surface.h"

namespace gnomon::irradiance_cache {

namespace {

// A cache point contributes to surfaces with normals above this cosine, within k_plane_distance.
constexpr float k_facing = 0.7f;
// Where no other point is left, it contributes within this many spacings.
constexpr float k_plane_around = 2.0f;
// A free distance may end this fraction of the spacing short of a surface point. That is less than a pixel. Without it,
// the foot of a wall would take its light from the dark points inside the wall, and would be a dark line.
constexpr float k_room = 0.005f;
// A level contributes nothing below the first bilinear weight, and fully from the second on.
constexpr float k_least_weight = 0.02f, k_full_weight = 0.15f;
// A surface point that lies deeper than this fraction of the spacing below the plane of a cache point takes its light
// only if it sees it: what lies in a joint or between tiles has not the light of what is above.
constexpr float k_deep = 0.06f;
// On triangles lower than the spacing, a level contributes less if one of its cache points is farther from the surface
// point's plane than the first fraction of the spacing, and nothing from the second on: between roof tiles, in folds of
// a curtain or along the mouldings of a cornice, light changes as often as the surface rises and falls, and what is
// seen are the crests.
constexpr float k_even = 0.01f, k_uneven = 0.02f;
// Where a surface curves evenly, its light is that between its cache points as long as their normals turn little from
// the surface point's: up to the first cosine. Beyond the second, a level contributes nothing, and finer ones follow,
// unless so little of the bilinear weight contributes that these would lack cache points, too.
constexpr float k_turns_little = 0.95f, k_turns = 0.9f, k_together = 0.6f, k_apart = 0.4f;
// The mean of their normals turns less, or there are cache points on one side only, and light is extrapolated.
constexpr float k_beside_little = 0.995f, k_beside = 0.98f;
// The sky's light of a level's cache points differs: by how much each differs from their mean at the surface point, on
// average and as a fraction of all light there. The next finer level begins to take the place of this one beyond the
// first, and has it from the second on.
constexpr float k_similar = 0.1f, k_different = 0.3f;
// Fraction of a point's irradiance that may come from a level that is slightly too coarse.
constexpr float k_least_rest = 0.02f;

// How far a part is from representing its surface point, 0 to 1: by the ratio of its light to that of the lattice
// around, whichever is larger. It begins below the first ratio, and is complete at the second.
constexpr float k_alike = 0.8f, k_unlike = 0.5f;
// A part is dark below this fraction of the light of the lattice around.
constexpr float k_dark = 0.08f;

float unlike(float part, float around)
{
    const float larger = std::max(part, around);
    if (!(larger > 0)) return 0;
    const float t = std::clamp((k_alike - std::min(part, around) / larger) / (k_alike - k_unlike), 0.0f, 1.0f);
    return t * t * (3 - 2 * t);
}

LatticeReach reach_of(const CollectedCell& cell)
{
    return {k_plane_distance * spacing_of(cell.level), k_facing, true};
}

}   // namespace

void Interpolator::blend_level(const CacheFrame& frame, std::span<const IndirectPoint> points, BatchWork& work,
                               glm::vec3* irradiance, CacheCounters& counters, BatchRecorder* recorder)
{
    // Interpolate the four points of each cell.
    gather_anchors(work);
    light_.resize(work.lattice.size());
    around_.resize(work.lattice.size());
    for (const CollectedCell& cell : work.cells)
        interpolate_cell(cell.anchors, reach_of(cell), work.lattice_points, cell.first, cell.end - cell.first, light_);
    leave_out_hidden(frame, points, work, counters);
    find_steep(work);
    if (recorder) recorder->add_cells(frame.near_field, work.cells);
    std::size_t kept = 0;
    for (std::size_t k = 0; k < work.lattice.size(); ++k) {
        LatticeRequest request = work.lattice[k];
        const IndirectPoint& point = points[request.point];
        const glm::vec3 between(light_.r[k], light_.g[k], light_.b[k]);
        const float spacing = spacing_of(request.level);
        if (frame.budget.limited()) {
            if (light_.weight[k] > k_least_weight) request.known = {between, light_.form_factor[k]};
            if (any_deferred(work.cells[request.cell])) {
                finish_deferred(frame, point, request, work, irradiance);
                continue;
            }
        }
        // Fade the widest level in and the finest one out.
        const Unevenness uneven = unevenness(frame, work.cells[request.cell], point, k);
        const CacheOptions& options = frame.options;
        const float narrowest =
            (options.narrowest + uneven.curves * (options.narrowest_of_curve - options.narrowest)) * point.width;
        const float finest = frame.fade_in(2 * spacing / narrowest - 1);
        float weight = frame.fade_in(frame.options.widest * point.width / spacing - 1) * finest;
        weight *= std::clamp((light_.weight[k] - k_least_weight) / (k_full_weight - k_least_weight), 0.0f, 1.0f);
        weight = request.weight * weight;
        // Leave to the next level, if there is one, what comes from points whose light changes too much within a
        // spacing.
        weight *= 1 - steep_[k];
        // Leave to the next level, too, what lacks cache points because they lie on something above it, and what is
        // less even than the spacing can show.
        weight *= 1 - lacks_below(work.cells[request.cell], point, work.lattice_points, k);
        weight *= 1 - uneven.fraction;
        // Leave to the next level of the lattice, if there is one, what differs too much between the points of this
        // one.
        weight *= 1 - difference(work.cells[request.cell], light_, k) * frame.fade_in(spacing / narrowest - 1);
        // Let this level provide an invisible rest, too; all weights still sum to 1.
        if (const float rest = request.weight - weight; rest < 2 * k_least_rest)
            weight = std::min(request.weight, request.weight - 2 * std::max(rest - k_least_rest, 0.0f));
        irradiance[request.point] += weight * between;
        if (recorder) recorder->add(request.point, request.cell, weight, light_, k);
        work.form_factor[request.point] += weight * light_.form_factor[k];
        if (!frame.near_field.applies_at(spacing))
            work.near_weight[request.point] -= weight;
        else if (const glm::vec4 near = near_at(work.cells[request.cell], light_, k); near.w > 0)
            work.near_known[request.point] += weight * near, work.near_share[request.point] += weight;
        request.weight -= weight;
        if (!(request.weight > 0)) continue;
        // Request the next level, or parts after the finest.
        if (spacing > narrowest) {
            if (frame.fade_in(spacing / narrowest - 1) < 1) request.fallback = fallback(work, k);
            --request.level;
            work.lattice[kept++] = request;
            continue;
        }
        work.parts.push_back({request.point, finest * request.weight, 0, nullptr, fallback(work, k)});
        if (finest < 1)
            work.parts.push_back({request.point, (1 - finest) * request.weight, 0, nullptr, request.fallback});
    }
    work.lattice.resize(kept);
}

// Whether points of a cell were left to a later frame.
bool Interpolator::any_deferred(const CollectedCell& cell)
{
    return std::any_of(std::begin(cell.point), std::end(cell.point),
                       [](const CachePoint* point) { return point->version == 0 && !point->queued; });
}

// Shows what is known of a request's light: finer levels would lack points, too.
void Interpolator::finish_deferred(const CacheFrame& frame, const IndirectPoint& point, const LatticeRequest& request,
                                   BatchWork& work, glm::vec3* irradiance)
{
    const Arriving& known = request.known;
    const bool any = known.light != glm::vec3(0);
    work.deferred[request.point] = 1;
    irradiance[request.point] += request.weight * (any ? known.light : frame.rough.at(point.position, point.normal));
    work.form_factor[request.point] += request.weight * known.form_factor;
    work.near_weight[request.point] -= request.weight;
}

// What takes the place of a part without light. One that is left to a later frame needs something even where the
// lattice has nothing.
Arriving Interpolator::around_part(const CacheFrame& frame, const IndirectPoint& point, const PartRequest& request,
                                   BatchWork& work)
{
    const bool deferred = request.part->version == 0;
    if (deferred && !work.deferred.empty()) work.deferred[request.point] = 1;
    if (!deferred || request.fallback.light != glm::vec3(0)) return request.fallback;
    return {frame.rough.at(point.position, point.normal), 0};
}

// How much of the bilinear weight at a surface point a cell lacks because its cache points lie on something close above
// the surface, such as a leaf or a plinth: what is below that is not lit like what is around it.
float Interpolator::lacks_below(const CollectedCell& cell, const IndirectPoint& point, const LatticePoints& at,
                                std::size_t k) const
{
    constexpr float k_above = 0.02f, k_below = 1;   // spacings
    if (!(light_.weight[k] < 1)) return 0;
    const float spacing = spacing_of(cell.level), x = at.fx[k], y = at.fy[k];
    const CellAnchors& anchors = cell.anchors;
    const glm::vec3 &p = point.position, &n = point.geometric_normal;
    float lacks = 0;
    for (int i = 0; i < 4; ++i) {
        if (light_.weight_of[i][k] > 0) continue;
        const float height = (anchors.x[i] - p.x) * n.x + (anchors.y[i] - p.y) * n.y + (anchors.z[i] - p.z) * n.z;
        if (!(height > k_above * spacing && height < k_below * spacing)) continue;
        lacks += (i & 1 ? x : 1 - x) * (i >> 1 ? y : 1 - y);
    }
    return lacks;
}

// How much of a surface point's light a cell cannot show, 0 to 1, because the surface rises and falls in between.
Interpolator::Unevenness Interpolator::unevenness(const CacheFrame& frame, const CollectedCell& cell,
                                                  const IndirectPoint& point, std::size_t k) const
{
    const float spacing = spacing_of(cell.level);
    const CellAnchors& anchors = cell.anchors;
    const glm::vec3 &p = point.position, &n = point.geometric_normal;
    const auto fraction = [&](float height) {
        return std::clamp((height / spacing - k_even) / (k_uneven - k_even), 0.0f, 1.0f);
    };
    float height[4], most = 0;
    for (int i = 0; i < 4; ++i) {
        height[i] = std::abs((anchors.x[i] - p.x) * n.x + (anchors.y[i] - p.y) * n.y + (anchors.z[i] - p.z) * n.z);
        const glm::vec3 normal(anchors.nx[i], anchors.ny[i], anchors.nz[i]);
        if (!(height[i] < k_plane_distance * spacing && glm::dot(normal, point.normal) > k_facing)) height[i] = 0;
        most = std::max(most, height[i]);
    }
    if (!(fraction(most) > 0)) return {};
    const ray::ObjectGeometry& geometry = frame.rays->geometry(point.object);
    glm::vec3 corner[3];
    geometry.corners(point.triangle, corner);
    const float longest = std::max(
        {glm::length(corner[1] - corner[0]), glm::length(corner[2] - corner[1]), glm::length(corner[0] - corner[2])});
    const float low = glm::length(glm::cross(corner[1] - corner[0], corner[2] - corner[0])) / longest;
    if (!(low < spacing)) return {};
    // A surface that curves evenly rises as far as its normals turn: a chord is at right angles to their mean.
    const glm::vec3 smooth = ray::smooth_normal(geometry, point.triangle, 1 - point.u - point.v, point.u, point.v, n);
    glm::vec3 between(0);
    for (int i = 0; i < 4; ++i)
        between += light_.weight_of[i][k] * glm::vec3(anchors.nx[i], anchors.ny[i], anchors.nz[i]);
    const float length = glm::length(between);
    const auto beyond = [](float cosine, float from, float to) {
        return std::clamp((from - cosine) / (from - to), 0.0f, 1.0f);
    };
    const float turns = length > 0 ? beyond(glm::dot(smooth, between) / length, k_beside_little, k_beside) : 1.0f;
    float rises = 0, most_from_curve = 0;
    for (int i = 0; i < 4; ++i) {
        if (!(height[i] > 0)) continue;
        const glm::vec3 normal(anchors.nx[i], anchors.ny[i], anchors.nz[i]), mean = smooth + normal;
        const glm::vec3 chord = glm::vec3(anchors.x[i], anchors.y[i], anchors.z[i]) - p;
        const float from_curve = std::min(std::abs(glm::dot(chord, mean)) / glm::length(mean), height[i]);
        const float own = std::max(turns, beyond(glm::dot(smooth, normal), k_turns_little, k_turns));
        most_from_curve = std::max(most_from_curve, from_curve);
        rises = std::max(rises, from_curve + own * (height[i] - from_curve));
    }
    const float uneven = fraction(rises) * frame.fade_in(spacing / low - 1);
    const float curves = std::max(1 - 4 * fraction(most_from_curve), 0.0f);
    return {uneven, uneven * curves * (1 - beyond(light_.weight[k], k_together, k_apart))};
}

// How much the sky's light of a cell's points differs at a surface point, 0 to 1. It is that without dynamic objects,
// because weights are remembered while these move.
float Interpolator::difference(const CollectedCell& cell, const LatticeLight& light, std::size_t k)
{
    float all = 0, sky = 0, differs = 0;
    for (int i = 0; i < 4; ++i) {
        all += light.weight_of[i][k] * cell.point[i]->brightness;
        sky += light.weight_of[i][k] * cell.point[i]->sky_light;
    }
    if (!(all > 0)) return 0;
    const float mean = sky / light.weight[k];
    for (int i = 0; i < 4; ++i) differs += light.weight_of[i][k] * std::abs(cell.point[i]->sky_light - mean);
    const float t = std::clamp((differs / all - k_similar) / (k_different - k_similar), 0.0f, 1.0f);
    return t * t * (3 - 2 * t);
}

// Interpolates again where a surface point lies deep below cache points of its cell: without those that geometry hides
// from it.
void Interpolator::leave_out_hidden(const CacheFrame& frame, std::span<const IndirectPoint> points,
                                    const BatchWork& work, CacheCounters& counters)
{
    // Both ends of a ray are raised by this part of the depth, so that a surface that curves does not hide its points.
    constexpr float k_lift = 0.25f, k_end = 0.999f;
    rays_.clear();
    doubted_.clear();
    for (const CollectedCell& cell : work.cells) {
        const CellAnchors& anchors = cell.anchors;
        const float spacing = spacing_of(cell.level), deep = k_deep * spacing;
        for (std::size_t k = cell.first; k < cell.end; ++k) {
            if (!(light_.weight[k] > 0)) continue;
            const IndirectPoint& point = points[work.lattice[k].point];
            const glm::vec3 &p = point.position, &n = point.geometric_normal;
            for (int i = 0; i < 4; ++i) {
                const float depth =
                    (anchors.x[i] - p.x) * n.x + (anchors.y[i] - p.y) * n.y + (anchors.z[i] - p.z) * n.z;
                if (!(depth > deep && depth < k_plane_distance * spacing)) continue;
                const CachePoint& anchor = *cell.point[i];
                if (!(glm::dot(anchor.normal, point.normal) > k_facing)) continue;
                const glm::vec3 from = p + (anchor.lift + k_lift * depth) * n;
                rays_.push(from, 0, anchor.origin() + k_lift * depth * anchor.geometric_normal - from, k_end);
                doubted_.push_back({k, i});
            }
        }
    }
    if (doubted_.empty()) return;
    occluded_.resize(rays_.size() + ray::k_packet_pad);
    frame.rays->occluded(rays_, 0, rays_.size(), occluded_.data(), ray::Against::static_only);
    counters.rays += rays_.size();
    for (std::size_t d = 0; d < doubted_.size();) {
        const std::size_t k = doubted_[d].request;
        const CollectedCell& cell = work.cells[work.lattice[k].cell];
        CellAnchors seen = cell.anchors;
        bool any = false;
        for (; d < doubted_.size() && doubted_[d].request == k; ++d) {
            if (!occluded_[d]) continue;
            seen.x[doubted_[d].anchor] = seen.low_b[doubted_[d].anchor] = k_infinity;
            any = true;
        }
        if (!any) continue;
        interpolate_cell(seen, reach_of(cell), work.lattice_points, k, 1, around_);
        light_.r[k] = around_.r[k], light_.g[k] = around_.g[k], light_.b[k] = around_.b[k];
        light_.form_factor[k] = around_.form_factor[k], light_.weight[k] = around_.weight[k];
        for (int i = 0; i < 4; ++i) light_.weight_of[i][k] = around_.weight_of[i][k];
    }
}

// Finds how much of each request's light comes from cache points whose light is steep.
void Interpolator::find_steep(const BatchWork& work)
{
    steep_.assign(work.lattice.size(), 0);
    for (const CollectedCell& cell : work.cells) {
        CellAnchors others = cell.anchors;
        bool any = false;
        for (int i = 0; i < 4; ++i) {
            if (!cell.point[i]->exists || !cell.point[i]->steep) continue;
            others.x[i] = others.low_b[i] = k_infinity;
            any = true;
        }
        if (!any) continue;
        interpolate_cell(others, reach_of(cell), work.lattice_points, cell.first, cell.end - cell.first, around_);
        for (std::size_t k = cell.first; k < cell.end; ++k)
            if (light_.weight[k] > 0) steep_[k] = std::max(1 - around_.weight[k] / light_.weight[k], 0.0f);
    }
}

// Copies the values of each cell's cache points into the layout of interpolate_cell().
void Interpolator::gather_anchors(BatchWork& work)
{
    for (CollectedCell& collected : work.cells) {
        CellAnchors& cell = collected.anchors;
        const int b = (cell.axis + 1) % 3, c = (cell.axis + 2) % 3;
        for (int i = 0; i < 4; ++i) {
            const CachePoint& from = *collected.point[i];
            work.queued = work.queued || from.queued;
            const glm::vec3 p = from.position, n = from.normal;
            // A point that holds for nothing around it is infinitely far away, and separated from everything.
            const bool holds = from.exists && !from.local && !from.covered_now;
            cell.x[i] = holds ? p.x : k_infinity, cell.y[i] = p.y, cell.z[i] = p.z;
            cell.nx[i] = n.x, cell.ny[i] = n.y, cell.nz[i] = n.z;
            const float room = k_room * lattice_spacing(from.key);
            const auto free = [&](int way) {   // across the surface that ends it
                return from.free[way] + room * std::sqrt(1 + from.slope(way) * from.slope(way));
            };
            cell.low_b[i] = holds ? p[b] - free(0) : k_infinity;
            cell.high_b[i] = p[b] + free(1);
            cell.low_c[i] = p[c] - free(2);
            cell.high_c[i] = p[c] + free(3);
            for (int way = 0; way < 4; ++way) cell.slope[way][i] = from.slope(way);
            for (int colour = 0; colour < 3; ++colour)
                for (int axis = 0; axis < 3; ++axis) cell.light[3 * colour + axis][i] = from.light[colour][axis];
            for (int axis = 0; axis < 3; ++axis) cell.facing[axis][i] = from.facing[axis];
        }
        cell.one_normal = have_one_normal(collected.point);
    }
}

// What a surface point takes from the near fields of a cell's points.
glm::vec4 Interpolator::near_at(const CollectedCell& cell, const LatticeLight& light, std::size_t k)
{
    if (!(light.weight[k] > 0)) return glm::vec4(0);
    const CachePoint* const points[4] = {cell.point[0], cell.point[1], cell.point[2], cell.point[3]};
    const float weights[4] = {light.weight_of[0][k], light.weight_of[1][k], light.weight_of[2][k],
                              light.weight_of[3][k]};
    return near_between(points, weights, light.weight[k]);
}

// What arrives by a cell of the lattice from beyond the near field, which parts do not hold.
Arriving Interpolator::without_near(const CollectedCell& cell, const LatticeLight& light, std::size_t k)
{
    const glm::vec3 arrives(light.r[k], light.g[k], light.b[k]), near(near_at(cell, light, k));
    return {glm::max(arrives - near, glm::vec3(0)), light.form_factor[k]};
}

// What arrives by a level where its weight is small. At the foot of a wall few cache points contribute, and the
// others lie inside the wall.
Arriving Interpolator::fallback(const BatchWork& work, std::size_t k)
{
    const glm::vec3 between(light_.r[k], light_.g[k], light_.b[k]);
    const LatticeRequest& request = work.lattice[k];
    if (between != glm::vec3(0)) return without_near(work.cells[request.cell], light_, k);
    interpolate_cell(work.cells[request.cell].anchors, {k_plane_around * spacing_of(request.level), k_facing, false},
                     work.lattice_points, k, 1, around_);
    return without_near(work.cells[request.cell], around_, k);
}

// Whether a part's point does not see the surface point that it stands for. Both ends are raised, so that a surface
// that curves does not hide one place of it from another.
void Interpolator::find_hidden(const CacheFrame& frame, std::span<const IndirectPoint> points, const BatchWork& work,
                               CacheCounters& counters)
{
    constexpr float k_lift = 0.2f, k_end = 0.999f;   // of the distance
    rays_.clear();
    hidden_.assign(work.parts.size(), 0);
    for (const PartRequest& request : work.parts) {
        const CachePoint& part = *request.part;
        const IndirectPoint& point = points[request.point];
        if (work.dynamic[request.point] || part.covered || part.covered_now || !part.exists) continue;
        const float lift = k_lift * glm::length(point.position - part.position);
        const glm::vec3 from = part.origin() + lift * part.geometric_normal;
        rays_.push(from, 0, point.position + (part.lift + lift) * point.geometric_normal - from, k_end);
    }
    occluded_.resize(rays_.size() + ray::k_packet_pad);
    frame.rays->occluded(rays_, 0, rays_.size(), occluded_.data(), ray::Against::static_only);
    counters.rays += rays_.size();
    std::size_t next = 0;
    for (std::size_t k = 0; k < work.parts.size(); ++k) {
        const CachePoint& part = *work.parts[k].part;
        if (work.dynamic[work.parts[k].point]) continue;
        hidden_[k] = part.covered || part.covered_now || (part.exists && occluded_[next++]);
    }
}

// The mean of the normals of a surface point's parts, by weight.
// @param first  of these parts, which follow one another
glm::vec3 Interpolator::mean_normal(const IndirectPoint& point, const BatchWork& work, std::size_t first)
{
    glm::vec3 sum(0);
    for (std::size_t k = first; k < work.parts.size() && work.parts[k].point == work.parts[first].point; ++k)
        sum += work.parts[k].weight * work.parts[k].part->normal;
    const float length = glm::length(sum);
    return length > 0 ? sum / length : point.normal;
}

void Interpolator::blend_parts(const CacheFrame& frame, std::span<const IndirectPoint> points, PartsAre are,
                               BatchWork& work, glm::vec3* irradiance, CacheCounters& counters)
{
    replaced_.clear();
    const auto is_of_mean = [&](const PartRequest& request) {
        return points[request.point].of_many && !work.dynamic[request.point];
    };
    if (are == PartsAre::far || are == PartsAre::finer) find_hidden(frame, points, work, counters);
    glm::vec3 mean(0);   // normal of a surface point's parts
    for (std::size_t k = 0; k < work.parts.size(); ++k) {
        const PartRequest& request = work.parts[k];
        const IndirectPoint& point = points[request.point];
        if (request.part->queued) {
            work.queued = true;
            continue;
        }
        const bool between = are == PartsAre::far && work.dynamic[request.point];
        if (between && (k == 0 || work.parts[k - 1].point != request.point)) mean = mean_normal(point, work, k);
        const glm::vec3 normal = between ? halfway_normal(request.part->normal, mean, point.normal) : point.normal;
        glm::vec3 light = request.part->irradiance(normal);
        // Take finer parts where geometry covers the centre of a part or hides it from the surface point, or where it
        // is dark, so that no black dot appears; of a mean, once. The part around a pixel beside a seam may lie beyond
        // it, inside other geometry: then one closer to the pixel takes its place.
        const bool last = are == PartsAre::closest || (are == PartsAre::finer && is_of_mean(request));
        const bool none = light == glm::vec3(0);
        const bool dark =
            !none && !work.dynamic[request.point] && luminance(light) < k_dark * luminance(request.fallback.light);
        const bool hidden = are != PartsAre::own && (hidden_[k] != 0 || none);
        float replaced = !last && (hidden || dark) ? 1.0f : 0.0f;
        // Take them, too, as far as the light of a part and that of the lattice around differ; not for a mean.
        if (are == PartsAre::far && replaced == 0 && !work.dynamic[request.point] && !point.of_many)
            replaced = unlike(luminance(light), luminance(request.fallback.light));
        if (replaced < 1) {
            const float weight = (1 - replaced) * request.weight;
            float form_factor = request.part->form_factor(normal);
            if (light == glm::vec3(0)) {
                const Arriving around = around_part(frame, point, request, work);
                light = around.light, form_factor = around.form_factor;
            }
            irradiance[request.point] += weight * light;
            work.form_factor[request.point] += weight * form_factor;
            if (!work.dynamic[request.point])
                if (const float near = frame.near_by_parts(point.width); near > 0)
                    work.near_parts.push_back({request.point, weight * near, request.key});
            if (replaced == 0) continue;
        }
        const float weight = replaced * request.weight;
        if (request.part->version == 0) {
            irradiance[request.point] += weight * around_part(frame, point, request, work).light;
            continue;
        }
        const bool finer = are == PartsAre::far && !work.dynamic[request.point];
        const float own = are == PartsAre::own ? frame.options.pixels_per_closest : frame.options.pixels_per_own;
        const PartWeights parts = !finer                ? select_pixel_parts(frame, point, own)
                                  : is_of_mean(request) ? select_parts_of_mean(frame, point)
                                                        : select_finer_parts(frame, point);
        for (int i = 0; i < parts.count; ++i)
            replaced_.push_back({request.point, weight * parts.weight[i], parts.key[i], nullptr, request.fallback});
    }
    work.parts.swap(replaced_);
}

}   // namespace gnomon::irradiance_cache
