// SPDX-License-Identifier: Apache-2.0
// Near light in the visible scheme: where it is wanted, where it is remembered, and what dynamic objects change of it.
#include <algorithm>
#include <cmath>

#include "irradiance_cache/irradiance_cache.h"

namespace gnomon::irradiance_cache {

namespace {

// Points that take no more of their light from where near light is apart are not asked for it.
constexpr float k_least_share = 0.02f;

}   // namespace

// The radius follows the lights, in steps: from it on, leaves can tell surfaces apart.
void VisibleLight::follow_radius(bool first)
{
    if (!first && !emitters_.geometry_changed()) return;
    const float wanted = options_.near_radius * emitters_.leaf_spacing();
    if (!(wanted > 0) || !std::isfinite(wanted)) {
        near_ = NearLight({0, options_.near_rays});
        hints_.reset();
        return;
    }
    constexpr float k_steps = 2;   // to twice the radius
    const float radius = std::exp2(std::round(k_steps * std::log2(wanted)) / k_steps);
    if (hints_ && radius == near_.options().radius) return;
    near_ = NearLight({radius, options_.near_rays});
    forget_hints();
    // Their widest lattice has one of near_at()'s spacings, which are powers of two.
    near_width_ = 2 * spacing_of(detail_of(options_.near_spacing * radius).level) / options_.widest;
}

void VisibleLight::forget_hints()
{
    const NearHintOptions options{.radius = near_.options().radius, .memory = options_.memory / 4};
    hints_ = options.radius > 0 ? std::make_unique<NearHints>(options) : nullptr;
}

// Leaves in `near_points` those with other surfaces close by. `moving` says what moves.
void VisibleLight::find_hints(Batch& batch, std::span<const IndirectPoint> points)
{
    batch.near_points.clear();
    batch.asked_cells.clear();
    batch.awaited_cells.clear();
    scene::ObjectId object = scene::none;
    std::uint32_t triangle = 0, side = 1;
    glm::vec3 winding(0);
    NearHints::Cell last = 0;   // with its state: neighbours share it
    NearHints::State state = NearHints::State::unknown;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const IndirectPoint& point = points[i];
        if (!(batch.near_share[i] > k_least_share) || !(point.width < 2 * near_width_) || batch.moving[i]) continue;
        if (point.object != object || point.triangle != triangle) {
            object = point.object, triangle = point.triangle;
            glm::vec3 p[3];
            rays_->geometry(object).corners(triangle, p);
            winding = glm::cross(p[1] - p[0], p[2] - p[0]);
            side = hints_->cells_along(p);
        }
        const bool front = glm::dot(winding, point.geometric_normal) > 0;
        const NearHints::Cell cell =
            NearHints::cell_at(first_triangle_[object] + triangle, side, point.u, point.v, front);
        if (cell != last || state == NearHints::State::unknown) {
            last = cell;
            const bool put_off = out_of_rays();   // read once: others cast, too
            state = put_off ? hints_->state(cell) : hints_->claim(cell);
            if (state == NearHints::State::asked) batch.awaited_cells.push_back(cell);
            if (state == NearHints::State::unknown) {
                if (put_off) {
                    lacking_ = true;
                    continue;
                }
                batch.asked_cells.push_back({cell, object, triangle, side});
                state = NearHints::State::asked;
            }
        }
        if (state != NearHints::State::none)
            batch.near_points.push_back({static_cast<std::uint32_t>(i), cell, state == NearHints::State::near});
    }
    if (!batch.asked_cells.empty()) hints_->answer(*rays_, batch.asked_cells, batch.hints);
    batch.counters.rays += batch.hints.cast;
    batch.hints.cast = 0;
    // Nobody waits before having published what it claimed.
    for (const NearHints::Cell cell : batch.awaited_cells)
        await([&] { return hints_->state(cell) != NearHints::State::asked; });
    std::erase_if(batch.near_points, [&](const Batch::NearPoint& p) {
        return !p.known && hints_->state(p.cell) != NearHints::State::near;
    });
}

void VisibleLight::add_near_light(Batch& batch, std::span<const IndirectPoint> points, glm::vec3* irradiance)
{
    find_hints(batch, points);
    if (batch.near_points.empty()) return;
    batch.near_parts.clear();
    for (const Batch::NearPoint& near : batch.near_points) {
        const IndirectPoint& point = points[near.point];
        const float share = (batch.near_share[near.point] - k_least_share) / (1 - k_least_share);
        const PartAnchors anchors =
            part_anchors(point, options_.pixels_per_near * point.width, options_.pixels_per_near_cluster * point.width);
        for (int i = 0; i < anchors.count; ++i)
            batch.near_parts.push_back({near.point, share * anchors.share[i], anchors.key[i], nullptr});
    }
    serve_near(batch);
    replace_hidden(batch, points);
    for (const Batch::NearPart& near : batch.near_parts)
        irradiance[near.point] += near.share * at_part(*near.part, points[near.point].normal);
}

void VisibleLight::serve_near(Batch& batch)
{
    batch.claimed.clear();
    batch.awaited.clear();
    for (Batch::NearPart& near : batch.near_parts) near.part = want(batch, near.key | k_near_anchor);
    serve(batch);
}

// At the foot of a wall a part may have its middle beyond it: then rather a small one, a little nearer to the viewer.
void VisibleLight::replace_hidden(Batch& batch, std::span<const IndirectPoint> points)
{
    constexpr float k_doubt = 2;        // times as far as the pixel is: nothing nearer can stand between
    constexpr float k_before = 0.25f;   // pixels: so much nearer to the viewer, a pixel at the very foot is before it
    constexpr float k_small = 0.5f;     // pixels
    constexpr float k_beside = 2.5f;    // of its size: a small part so much nearer to the viewer
    constexpr float k_end = 0.999f;
    const auto aside = [](const IndirectPoint& point, float pixels) {
        const glm::vec3 &n = point.geometric_normal, &to = point.to_viewer;
        return pixels * point.width * (to - glm::dot(to, n) * n);
    };
    batch.rays.clear();
    batch.doubted.clear();
    for (std::uint32_t k = 0; k < batch.near_parts.size(); ++k) {
        const RememberedPoint& part = *batch.near_parts[k].part;
        const IndirectPoint& point = points[batch.near_parts[k].point];
        // Only of a triangle's own parts: what stands for small ones may be anywhere around.
        const std::uint32_t own = first_triangle_[point.object] + point.triangle;
        if (const Part of = part_of(part.key); of.triangle != own || of.level == 0) continue;
        const glm::vec3 way = point.position + aside(point, k_before) - part.position;
        if (!part.exists || !(part.free[0] * part.free[0] < k_doubt * k_doubt * glm::dot(way, way))) continue;
        batch.rays.push(part.origin(), 0, way, k_end);
        batch.doubted.push_back(k);
    }
    const std::size_t count = batch.rays.size();
    if (count == 0) return;
    batch.occluded.resize(count + ray::k_packet_pad);
    rays_->occluded(batch.rays, 0, count, batch.occluded.data(), ray::Against::static_only);
    batch.counters.rays += count;
    std::size_t hidden = 0;
    for (std::size_t d = 0; d < count; ++d) {
        if (!batch.occluded[d]) continue;
        Batch::NearPart& near = batch.near_parts[batch.doubted[d]];
        const IndirectPoint& point = points[near.point];
        // One level of detail fades into the next here, too.
        glm::vec3 p[3];
        rays_->geometry(point.object).corners(point.triangle, p);
        const glm::vec3 a = p[1] - p[0], b = p[2] - p[0], n = glm::cross(a, b), by = aside(point, 1);
        const glm::vec2 step(glm::dot(glm::cross(by, b), n) / glm::dot(n, n),
                             glm::dot(glm::cross(a, by), n) / glm::dot(n, n));
        const float area = 0.5f * glm::length(n);
        const PartDetail detail = part_detail(area, k_small * point.width);
        const float finer = faded(detail.fraction);
        const auto key_at = [&](int level) {
            const float pixels = std::sqrt(area) / (std::exp2(static_cast<float>(level)) * point.width);
            const glm::vec2 at = glm::vec2(point.u, point.v) + k_beside * pixels * step;
            const bool inside = at.x >= 0 && at.y >= 0 && at.x + at.y <= 1;   // else it would be another triangle's
            return part_key(first_triangle_[point.object] + point.triangle, glm::dot(n, point.geometric_normal) > 0,
                            level, inside ? at.x : point.u, inside ? at.y : point.v);
        };
        near.key = key_at(detail.level);
        if (finer < 1) {
            batch.near_parts.push_back({near.point, (1 - finer) * near.share, key_at(detail.level - 1), nullptr});
            batch.near_parts[batch.doubted[d]].share *= finer;
        }
        ++hidden;
    }
    if (hidden > 0) serve_near(batch);
}

// Asks new points for near light from what stands still; and those that dynamic objects may touch for what is left of
// it.
void VisibleLight::see_near(Batch& batch)
{
    if (!hints_) return;
    const std::uint32_t version = emitters_.geometry_version();
    const auto ask = [&](ray::Against against, const auto& wanted, const auto& answered) {
        constexpr std::size_t k_rays = 4096;
        const std::size_t most = std::max<std::size_t>(1, k_rays / static_cast<std::size_t>(options_.near_rays));
        std::size_t next = 0;
        while (next < batch.claimed.size()) {
            batch.near_asked.clear();
            batch.near_receivers.clear();
            for (; next < batch.claimed.size() && batch.near_asked.size() < most; ++next) {
                RememberedPoint& point = *batch.claimed[next];
                if (!point.exists || !is_near(point.key) || !wanted(point)) continue;
                batch.near_asked.push_back(&point);
                batch.near_receivers.push_back({point.origin(), point.normal, point.geometric_normal});
            }
            batch.near_answers.resize(batch.near_asked.size());
            near_.ask(*state_, *rays_, batch.near_receivers.data(), batch.near_receivers.size(), against, batch.near,
                      batch.near_answers.data());
            for (std::size_t k = 0; k < batch.near_asked.size(); ++k)
                answered(*batch.near_asked[k], batch.near_answers[k]);
        }
        batch.counters.rays += batch.near.cast;
        batch.near.cast = 0;
    };
    ask(
        ray::Against::static_only, [&](const RememberedPoint& point) { return point.version != version; },
        [&](RememberedPoint& point, const NearAnswer& answer) {
            std::copy(answer.light, answer.light + 3, point.still);
            point.free[0] = answer.nearest;
            point.version = version;
            point.dynamic_version = 0;
            ++batch.counters.near_points;
        });
    ask(
        ray::Against::everything,
        [&](RememberedPoint& point) {
            if (point.dynamic_version == dynamic_version_) return false;
            point.dynamic_version = dynamic_version_;
            std::copy(point.still, point.still + 3, point.light);
            return dynamic_may_touch(point);
        },
        [&](RememberedPoint& point, const NearAnswer& answer) {
            std::copy(answer.light, answer.light + 3, point.light);
        });
}

// Whether something that moves may come between near surfaces and the point, or between them and a light.
bool VisibleLight::dynamic_may_touch(const RememberedPoint& point) const
{
    if (dynamic_.empty()) return false;
    if (point.still[0] == glm::vec3(0) && point.still[1] == glm::vec3(0) && point.still[2] == glm::vec3(0))
        return false;
    const float radius = near_.options().radius;
    const scene::Scene& scene = state_->scene();
    // From the point to `way` beyond it; without an end if `endless`.
    const auto meets = [&](const Sphere& sphere, const glm::vec3& way, bool endless) {
        const glm::vec3 at = sphere.centre - point.origin();
        const float square = glm::dot(way, way);
        float along = square > 0 ? std::max(glm::dot(at, way) / square, 0.0f) : 0.0f;
        if (!endless) along = std::min(along, 1.0f);
        const glm::vec3 off = at - along * way;
        const float reach = sphere.radius + radius;
        return glm::dot(off, off) <= reach * reach;
    };
    for (scene::LightId l = 0; l < scene.lights.size(); ++l) {
        const scene::Light& light = scene.lights[l];
        const scene::LightState& at = state_->light(l);
        if (!at.visible || light.of_environment) continue;
        const bool endless = light.type == scene::LightType::directional;
        const glm::vec3 way = endless ? -at.direction : at.position - point.origin();
        if (dynamic_.any([&](const Sphere& sphere) { return meets(sphere, way, endless); },
                         [](const Sphere&) { return true; }))
            return true;
    }
    return false;
}

std::size_t VisibleLight::bytes() const
{
    return emitters_.bytes() + points_.bytes() + clusters_.bytes() + (hints_ ? hints_->bytes() : 0) +
           (engine_ ? engine_->bytes() : 0);
}

}   // namespace gnomon::irradiance_cache
