// SPDX-License-Identifier: Apache-2.0
#include "irradiance_cache/near_field/near_step.h"

#include <algorithm>
#include <cmath>

namespace gnomon::irradiance_cache {

namespace {

// Pixels where less of the irradiance than this fraction lacks the near field go without it.
constexpr float k_least_weight = 0.02f;

// A vector along the surface towards the viewer.
glm::vec3 aside(const IndirectPoint& point, float pixels)
{
    const glm::vec3 &n = point.geometric_normal, &to = point.to_viewer;
    return pixels * point.width * (to - glm::dot(to, n) * n);
}

}   // namespace

bool NearFieldStep::select(const CacheFrame& frame, std::span<const IndirectPoint> points, const BatchWork& work,
                           const FrameFailure& failure, CacheCounters& counters)
{
    find_near_pixels(frame, points, work, failure, counters);
    selected_.clear();
    for (const NearPixel& pixel : pixels_) {
        const IndirectPoint& point = points[pixel.point];
        const float weight = (work.near_weight[pixel.point] - k_least_weight) / (1 - k_least_weight);
        const PartWeights parts = select_near_parts(frame, point);
        for (int i = 0; i < parts.count; ++i)
            selected_.push_back({pixel.point, weight * parts.weight[i],
                                 weight * parts.weight[i] / work.near_weight[pixel.point], parts.key[i], nullptr});
    }
    return !selected_.empty();
}

bool NearFieldStep::select_of_parts(const BatchWork& work)
{
    selected_.clear();
    for (const NearPartRequest& part : work.near_parts)
        selected_.push_back({part.point, part.weight, 0, part.key, nullptr});
    return !selected_.empty();
}

// Finds the pixels on static surfaces that have others close by.
void NearFieldStep::find_near_pixels(const CacheFrame& frame, std::span<const IndirectPoint> points,
                                     const BatchWork& work, const FrameFailure& failure, CacheCounters& counters)
{
    using State = NearHints::State;
    NearHints& hints = *frame.near_field.hints();
    pixels_.clear();
    claimed_.clear();
    awaited_.clear();
    // Look up the cell of each pixel. Neighbouring pixels share cells, and often the triangle.
    scene::ObjectId object = scene::none;
    std::uint32_t triangle = 0, side = 1;
    glm::vec3 winding(0);
    NearHints::Cell last = 0;
    State state = State::unknown;   // of `last`
    for (std::size_t i = 0; i < points.size(); ++i) {
        const IndirectPoint& point = points[i];
        if (!(work.near_weight[i] > k_least_weight) || !(point.width < 2 * frame.near_field.fade_width()) ||
            work.dynamic[i])
            continue;
        if (point.object != object || point.triangle != triangle) {
            object = point.object, triangle = point.triangle;
            glm::vec3 p[3];
            frame.rays->geometry(object).corners(triangle, p);
            winding = glm::cross(p[1] - p[0], p[2] - p[0]);
            side = hints.cells_along(p);
        }
        const bool front = glm::dot(winding, point.geometric_normal) > 0;
        const NearHints::Cell cell =
            NearHints::cell_at(frame.triangles.first(object) + triangle, side, point.u, point.v, front);
        if (cell != last || state == State::unknown) {
            last = cell;
            state = claim_cell(frame, {cell, object, triangle, side});
            if (state == State::unknown) continue;
        }
        if (state != State::none) pixels_.push_back({static_cast<std::uint32_t>(i), cell, state == State::near});
    }
    // Answer the claimed cells, then wait for those that other threads claimed.
    if (!claimed_.empty()) hints.answer(*frame.rays, claimed_, hints_);
    counters.rays += hints_.cast;
    hints_.cast = 0;
    for (const NearHints::Cell cell : awaited_)
        if (hints.wait(cell) == State::claimed) failure.rethrow();
    std::erase_if(pixels_, [&](const NearPixel& p) { return !p.known && hints.state(p.cell) != State::near; });
}

// The state of a cell; an unknown one is claimed, or deferred to a later frame if no rays are left.
NearHints::State NearFieldStep::claim_cell(const CacheFrame& frame, const NearHints::Claim& claim)
{
    using State = NearHints::State;
    NearHints& hints = *frame.near_field.hints();
    if (frame.budget.limited()) {
        const State state = hints.state(claim.cell);
        if (state == State::claimed) awaited_.push_back(claim.cell);
        if (state != State::unknown || !frame.budget.pay(hints.rays_of_cell())) return state;
    }
    claimed_.push_back(claim);   // before it is claimed: once claimed it must be answered, whatever fails
    const State state = hints.claim(claim.cell);
    if (state == State::unknown) return State::claimed;
    claimed_.pop_back();
    if (state == State::claimed) awaited_.push_back(claim.cell);
    return state;
}

void NearFieldStep::collect(const CacheFrame& frame, PointClaims& claims)
{
    claims.begin(frame.number);
    for (Selected& near : selected_) near.part = claims.find_or_create(near.key | k_near_anchor);
}

bool NearFieldStep::replace_hidden(const CacheFrame& frame, std::span<const IndirectPoint> points,
                                   CacheCounters& counters)
{
    constexpr float k_doubt = 2;        // no surface in between is nearer than this many times the pixel's distance
    constexpr float k_before = 0.25f;   // pixels by which the ray's end is moved towards the viewer, off a wall's foot
    constexpr float k_end = 0.999f;
    // Cast a ray to the pixel from each point with a surface nearer to it than the pixel.
    rays_.clear();
    doubted_.clear();
    for (std::uint32_t k = 0; k < selected_.size(); ++k) {
        const CachePoint& part = *selected_[k].part;
        const IndirectPoint& point = points[selected_[k].point];
        // Only for parts of the pixel's own triangle: points that represent small triangles may be anywhere around.
        const std::uint32_t own = frame.triangles.first(point.object) + point.triangle;
        if (const Part of = part_of(part.key); of.triangle != own || of.level == 0) continue;
        const glm::vec3 way = point.position + aside(point, k_before) - part.position;
        if (!part.exists || !(part.free[0] * part.free[0] < k_doubt * k_doubt * glm::dot(way, way))) continue;
        rays_.push(part.origin(), 0, way, k_end);
        doubted_.push_back(k);
    }
    const std::size_t count = rays_.size();
    if (count == 0) return false;
    occluded_.resize(count + ray::k_packet_pad);
    frame.rays->occluded(rays_, 0, count, occluded_.data(), ray::Against::static_only);
    counters.rays += count;
    bool any = false;
    for (std::size_t d = 0; d < count; ++d) {
        if (!occluded_[d]) continue;
        replace(frame, points[selected_[doubted_[d]].point], doubted_[d]);
        any = true;
    }
    return any;
}

// At the foot of a wall the centre of a part may lie beyond it. Takes a small part instead, a little nearer to the
// viewer, and the next coarser one as far as the level of detail fades.
void NearFieldStep::replace(const CacheFrame& frame, const IndirectPoint& point, std::size_t selected)
{
    constexpr float k_small = 0.5f;    // pixels: size of the part
    constexpr float k_beside = 2.5f;   // its distance from the pixel, in sizes
    glm::vec3 p[3];
    frame.rays->geometry(point.object).corners(point.triangle, p);
    const glm::vec3 a = p[1] - p[0], b = p[2] - p[0], n = glm::cross(a, b), by = aside(point, 1);
    const glm::vec2 step(glm::dot(glm::cross(by, b), n) / glm::dot(n, n),
                         glm::dot(glm::cross(a, by), n) / glm::dot(n, n));
    const float area = 0.5f * glm::length(n);
    const PartDetail detail = part_detail(area, k_small * point.width);
    const float finer = frame.fade_in(detail.fraction);
    const auto key_at = [&](std::uint32_t level) {
        const float pixels = std::sqrt(area) / (std::exp2(static_cast<float>(level)) * point.width);
        const glm::vec2 at = glm::vec2(point.u, point.v) + k_beside * pixels * step;
        const bool inside = at.x >= 0 && at.y >= 0 && at.x + at.y <= 1;   // of the triangle
        return part_key(frame.triangles.first(point.object) + point.triangle, glm::dot(n, point.geometric_normal) > 0,
                        level, inside ? at.x : point.u, inside ? at.y : point.v);
    };
    Selected& near = selected_[selected];
    near.key = key_at(detail.level);
    if (finer < 1) {
        const Selected coarser{near.point, (1 - finer) * near.weight, (1 - finer) * near.known,
                               key_at(detail.level - 1), nullptr};
        near.weight *= finer, near.known *= finer;
        selected_.push_back(coarser);
    }
}

void NearFieldStep::blend(std::span<const IndirectPoint> points, const BatchWork& work, glm::vec3* irradiance)
{
    blend_.begin(points.size());
    for (const Selected& near : selected_)
        blend_.add(near.point, near.weight, near.known, *near.part, points[near.point].normal);
    blend_.finish(work.near_known.data(), work.near_share.data(), irradiance);
}

}   // namespace gnomon::irradiance_cache
