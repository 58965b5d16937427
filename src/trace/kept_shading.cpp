// SPDX-License-Identifier: Apache-2.0
// Tiles that keep their first hits from frame to frame (kept_tiles.h).
#include "base/interruption.h"
#include "trace/tile_tracer.h"

namespace gnomon::trace {

namespace {

// Whether nothing follows from a first hit but the bounced light that its diffuse layer reflects.
bool is_diffuse(const TilePoint& point)
{
    const shading::Continuation& next = point.next;
    const glm::vec3 none(0);
    return next.reflected_weight == none && next.refracted_weight == none && next.straight_weight == none &&
           next.lobe_weight == none && !point.surface.layered && !point.behind && !point.glossy && !point.coat_glossy &&
           point.throughput == glm::vec3(1);
}

KeptPoint kept_point(const TilePoint& point, const shadow_culling::ShadowPoint& at)
{
    const shading::SurfacePoint& s = point.surface;
    KeptPoint kept;
    kept.position = s.position, kept.geometric_normal = s.geometric_normal, kept.normal = s.normal;
    kept.to_viewer = s.to_viewer, kept.width = s.cone.width;
    kept.object = at.object, kept.triangle = at.triangle, kept.u = at.u, kept.v = at.v;
    return kept;
}

KeptReflection kept_reflection(const TilePoint& point)
{
    const shading::SurfacePoint& s = point.surface;
    return {s.diffuse, s.coverage, static_cast<std::uint16_t>(point.pixel), s.model};
}

}   // namespace

void TileTracer::trace(const Tile& tile, shading::FrameBuffers& out, std::size_t index, KeptTiles& tiles)
{
    KeptTile* const known = tiles.find(index);
    std::unique_ptr<KeptTile> made = known ? nullptr : tiles.take();
    if (!known && !made) return trace(tile, out);

    interruption_point();
    Stopwatch watch(times_);
    begin_tile(tile);
    if (known) {
        shade_kept(*known, tiles, watch);
    } else {
        for (int y = tile.y; centres_ && y < tile.y + tile.height; ++y) centres_->clear(y, tile.x, tile.x + tile.width);
        queue_primary(0);
        shade_first_hits(0, watch);
        keep_first_hits(*made);
        watch.end(FrameTimes::surfaces);
        shade_rest(0, watch);
        tiles.keep(index, std::move(made));
    }
    watch.restart();
    store_lobes();
    store(out);
    watch.end(FrameTimes::surfaces);
}

void TileTracer::keep_first_hits(KeptTile& kept) const
{
    kept.color = color_;
    kept.misses = points_.size() < primary_.rays.size();
    const int blocks = (tile_.side + KeptTile::k_block - 1) / KeptTile::k_block;
    kept.blocks.resize(static_cast<std::size_t>(blocks) * static_cast<std::size_t>(blocks));
    const auto add = [&](std::size_t p, const glm::vec3& at) {
        const auto x = static_cast<int>(points_[p].pixel) % tile_.side,
                   y = static_cast<int>(points_[p].pixel) / tile_.side;
        kept.blocks[static_cast<std::size_t>(y / KeptTile::k_block * blocks + x / KeptTile::k_block)].add(at);
    };
    std::size_t whole = 0;
    for (const TilePoint& point : points_) whole += is_diffuse(point) ? 0 : 1;
    kept.points.reserve(points_.size()), kept.reflections.reserve(points_.size());
    kept.whole.reserve(whole), kept.whole_shadow_points.reserve(whole);
    for (std::size_t p = 0; p < points_.size(); ++p) {
        add(p, points_[p].surface.position), add(p, shadow_points_[p].origin);
        if (is_diffuse(points_[p])) {
            kept.points.push_back(kept_point(points_[p], shadow_points_[p]));
            kept.reflections.push_back(kept_reflection(points_[p]));
            continue;
        }
        kept.points.emplace_back();
        kept.reflections.emplace_back().whole = true;
        kept.whole.push_back(points_[p]), kept.whole_shadow_points.push_back(shadow_points_[p]);
    }
    for (const std::uint32_t p : horizon_.points()) add(p, horizon_.origin(p));
    for (const Box3& block : kept.blocks) kept.hits.add(block);
}

// Adds to the first hits of a kept tile what changes from frame to frame: bounced light, and what is mirrored.
void TileTracer::shade_kept(KeptTile& kept, KeptTiles& tiles, Stopwatch& watch)
{
    color_ = kept.color;
    clear_points();
    if (indirect_ && kept.bounced && indirect_->gather_again(*kept.bounced, arrives_)) {
        interruption_point();
        add_kept_bounced(kept);
    } else {
        take_kept_points(kept);
        watch.end(FrameTimes::surfaces);
        gather_kept(kept, tiles);
    }
    watch.end(FrameTimes::indirect);
    follow_hits(0, watch);
}

// Adds the bounced light of restored first hits, and remembers what they found.
void TileTracer::gather_kept(KeptTile& kept, KeptTiles& tiles)
{
    if (!indirect_) return;
    interruption_point();
    const std::size_t count = kept.points.size();
    const PointBatch batch{std::span<const TilePoint>(kept_points_.data(), count),
                           std::span(kept_shadow_points_).first(count),
                           std::span(kept_normals_).first(count),
                           tile_,
                           true,
                           true};
    tiles.remember(kept, indirect_->gather_and_remember(batch, arrives_));
    add_gathered(batch);
}

// Adds the bounced light of first hits without restoring all of them: what add_gathered() adds, to the bit. Lists those
// from which rays may go on.
void TileTracer::add_kept_bounced(const KeptTile& kept)
{
    const auto note = [&](std::uint32_t pixel, const glm::vec3& radiance) {
        if (!centres_) return;
        const glm::ivec2 at = tile_.pixel_of_image(pixel);
        centres_->at(at.x, at.y).bounced = radiance;
    };
    std::size_t next = 0, whole = 0;
    for (std::uint32_t p = 0; p < kept.points.size(); ++p) {
        const KeptReflection& reflection = kept.reflections[p];
        const bool lit = next < arrives_.point.size() && arrives_.point[next] == p;
        const glm::vec3 irradiance = lit ? arrives_.irradiance[next++] : glm::vec3(0);
        if (!reflection.whole) {
            if (!lit) continue;
            const glm::vec3 radiance = shading::reflect_diffusely(reflection.diffuse, reflection.coverage, irradiance);
            color_[reflection.pixel] += radiance;
            note(reflection.pixel, radiance);
            if (places_) note_kept_place(kept.points[p], irradiance);
            continue;
        }
        const TilePoint& point = kept.whole[whole];
        const shadow_culling::ShadowPoint& at = kept.whole_shadow_points[whole++];
        points_.push_back(point), shadow_points_.push_back(at), normals_.push_back(point.surface.normal);
        if (!lit) continue;
        const glm::vec3 radiance = reflect_bounced(point, irradiance, glm::vec3(0));
        add_light(point, radiance);
        note(point.pixel, radiance);
        if (places_) note_place(point, at, true, irradiance);
    }
}

void TileTracer::note_kept_place(const KeptPoint& from, const glm::vec3& irradiance)
{
    kept_plain_.throughput = glm::vec3(1);
    shading::SurfacePoint& s = kept_plain_.surface;
    s.position = from.position, s.geometric_normal = from.geometric_normal, s.normal = from.normal;
    s.cone.width = from.width;
    shadow_culling::ShadowPoint at;
    at.object = from.object, at.triangle = from.triangle, at.u = from.u, at.v = from.v;
    note_place(kept_plain_, at, true, irradiance);
}

// Restores the first hits of a kept tile, and lists those from which rays may go on.
void TileTracer::take_kept_points(const KeptTile& kept)
{
    TilePoint plain;
    plain.pixel = 0, plain.throughput = glm::vec3(1);
    const std::size_t count = kept.points.size();
    if (kept_points_.size() < count) {
        kept_points_.resize(count, plain);
        kept_shadow_points_.resize(count), kept_normals_.resize(count), kept_whole_.resize(count);
    }
    std::size_t whole = 0;
    for (std::size_t p = 0; p < count; ++p) {
        const KeptPoint& from = kept.points[p];
        const KeptReflection& reflection = kept.reflections[p];
        TilePoint& to = kept_points_[p];
        shadow_culling::ShadowPoint& at = kept_shadow_points_[p];
        if (reflection.whole) {
            to = kept.whole[whole], at = kept.whole_shadow_points[whole], kept_normals_[p] = to.surface.normal;
            points_.push_back(to), shadow_points_.push_back(at), normals_.push_back(to.surface.normal);
            kept_whole_[p] = 1, ++whole;
            continue;
        }
        if (kept_whole_[p] != 0) to = plain, kept_whole_[p] = 0;
        shading::SurfacePoint& s = to.surface;
        s.position = from.position, s.geometric_normal = from.geometric_normal, s.normal = from.normal;
        s.to_viewer = from.to_viewer, s.diffuse = reflection.diffuse, s.coverage = reflection.coverage;
        s.model = reflection.model;
        s.cone.width = from.width;
        to.pixel = reflection.pixel;
        at.object = from.object, at.triangle = from.triangle, at.u = from.u, at.v = from.v;
        kept_normals_[p] = from.normal;
    }
}

}   // namespace gnomon::trace
