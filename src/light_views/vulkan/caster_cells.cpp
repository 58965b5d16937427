// SPDX-License-Identifier: Apache-2.0
#include "light_views/vulkan/caster_cells.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "gnomon/error.h"

namespace gnomon::light_views {

namespace {

// Margin around every projected triangle, in cells: more than the rounding of vertices and points.
constexpr double k_margin = 0.01;
// Triangles nearer to the light than this fraction of the view's near plane cast no shadows.
constexpr double k_nearest = 1e-3;

// A triangle in front of the light, clipped at most once.
struct Polygon {
    std::array<glm::dvec2, 4> at;
    int count = 0;
};

// The distance of its nearest corner along the view; corners outside the view count, too.
float nearest_of(const ViewProjection& view, const glm::vec3 (&corners)[3])
{
    float nearest = k_infinity;
    for (const glm::vec3& p : corners) nearest = std::min(nearest, glm::dot(p - view.origin, view.forward));
    return nearest;
}

Polygon image_of(const ViewProjection& view, const glm::vec3 (&corners)[3], double side)
{
    const glm::dmat4 clip(view.clip_from_world);
    glm::dvec4 p[3];
    for (int i = 0; i < 3; ++i) p[i] = clip * glm::dvec4(glm::dvec3(corners[i]), 1);
    const double least = view.perspective ? k_nearest * static_cast<double>(view.reach) : 0.0;
    Polygon polygon;
    const auto add = [&](const glm::dvec4& q) {
        polygon.at[static_cast<std::size_t>(polygon.count++)] = side * (0.5 * glm::dvec2(q.x / q.w, q.y / q.w) + 0.5);
    };
    for (int i = 0; i < 3; ++i) {
        const glm::dvec4 &a = p[i], &b = p[(i + 1) % 3];
        if (a.w >= least) add(a);
        if ((a.w >= least) == (b.w >= least)) continue;
        glm::dvec4 cut = a + (least - a.w) / (b.w - a.w) * (b - a);
        cut.w = least;
        add(cut);
    }
    return polygon;
}

// The bounds of a projected triangle in one cell, slightly enlarged; see CellEntry.
std::uint32_t bounds_in(const glm::dvec2& low, const glm::dvec2& high, int x, int y)
{
    const auto byte = [](double at, double room) {
        return static_cast<std::uint32_t>(std::clamp(std::floor(256 * (at + room)), 0.0, 255.0));
    };
    return byte(low.x - x, -k_margin) | byte(low.y - y, -k_margin) << 8 | byte(high.x - x, k_margin) << 16 |
           byte(high.y - y, k_margin) << 24;
}

// The part of a cell, along one side, that contains a byte of the bounds.
std::uint32_t part_of(std::uint32_t byte)
{
    return (byte & 255u) * GNOMON_BLOCK_PARTS / 256u;
}

}   // namespace

CasterCells::CasterCells(const std::shared_ptr<vk::Device>& device, const LightViews& views)
    : device_(device), triangles_(device)
{
    for (const LightView& view : views.views()) {
        side_.push_back(std::max(1u, static_cast<std::uint32_t>(view.tile.size) / GNOMON_CELL_TEXELS));
        base_.push_back(lists_);
        lists_ += 2 * side_.back() * side_.back() + 1;
    }
    for (Set& set : sets_) {
        set.views.resize(side_.size());
        set.stale.assign(side_.size(), 1);
    }
    in_dynamic_set_.resize(side_.size());
    found_.resize(side_.size());
    bases_ = vk::Buffer(device, "cells of views", std::max<std::size_t>(base_.size(), 1) * sizeof(std::uint32_t));
}

// Adds a triangle to the cells that its projection meets, row by row.
void CasterCells::add_triangle(std::size_t view, const ViewProjection& projection, const shared::CellTriangle& triangle,
                               std::uint32_t number)
{
    const glm::vec3 corners[3] = {triangle.a, triangle.b, triangle.c};
    const std::uint32_t masked = triangle.material == scene::none ? 0 : 1;
    const double side = side_[view];
    const Polygon polygon = image_of(projection, corners, side);
    if (polygon.count == 0) return;
    const float nearest = nearest_of(projection, corners);
    glm::dvec2 low = polygon.at[0], high = low;
    for (int i = 1; i < polygon.count; ++i) {
        low = glm::min(low, polygon.at[static_cast<std::size_t>(i)]);
        high = glm::max(high, polygon.at[static_cast<std::size_t>(i)]);
    }
    const auto cell_of = [&](double x) { return static_cast<int>(std::clamp(std::floor(x), -1.0, side)); };
    const int first = std::max(cell_of(low.y - k_margin), 0),
              last = std::min(cell_of(high.y + k_margin), static_cast<int>(side) - 1);
    for (int y = first; y <= last; ++y) {
        // Clip each edge to the row.
        const double top = y - k_margin, bottom = y + 1 + k_margin;
        double left = std::numeric_limits<double>::infinity(), right = -left;
        for (int i = 0; i < polygon.count; ++i) {
            const glm::dvec2 &a = polygon.at[static_cast<std::size_t>(i)],
                             &b = polygon.at[static_cast<std::size_t>((i + 1) % polygon.count)];
            if (std::max(a.y, b.y) < top || std::min(a.y, b.y) > bottom) continue;
            const auto x_at = [&](double at) {
                return a.y == b.y ? a.x
                                  : a.x + (std::clamp(at, std::min(a.y, b.y), std::max(a.y, b.y)) - a.y) / (b.y - a.y) *
                                              (b.x - a.x);
            };
            for (const double x : {x_at(top), x_at(bottom)}) left = std::min(left, x), right = std::max(right, x);
            if (a.y == b.y) left = std::min({left, a.x, b.x}), right = std::max({right, a.x, b.x});
        }
        const int x0 = std::max(cell_of(left - k_margin), 0),
                  x1 = std::min(cell_of(right + k_margin), static_cast<int>(side) - 1);
        for (int x = x0; x <= x1; ++x) {
            Found& found = found_[view].emplace_back();
            found.list = 2 * (static_cast<std::uint32_t>(y) * side_[view] + static_cast<std::uint32_t>(x)) + masked;
            found.entry = {number, bounds_in(low, high, x, y)};
            found.nearest = nearest;
        }
    }
}

// Adds an object's triangles to all views that need new lists of this set and to whose set the object belongs.
void CasterCells::add_object(const Set& set, const LightViews& views, const CasterGeometry& casters,
                             const scene::SceneState& state, scene::ObjectId object)
{
    const bool moving = &set == &sets_[1];
    for (std::size_t v = 0; v < side_.size(); ++v) {
        const LightView& view = views.views()[v];
        if (!set.stale[v] || !view.shown || (in_dynamic_set_[v][object] != 0) != moving) continue;
        if (views.casters().footprint(view.projection, state, object).empty()) continue;
        const CasterTriangles::Run run = triangles_.of(casters, state, object);
        for (std::uint32_t t = 0; t < run.triangles.size(); ++t)
            add_triangle(v, view.projection, run.triangles[t], run.first + t);
    }
}

// Sorts the collected entries by list, and makes the blocks over them.
void CasterCells::sort(std::size_t view, Lists& lists)
{
    lists.first.assign(2 * side_[view] * side_[view] + 1, 0);
    for (const Found& found : found_[view]) ++lists.first[found.list + 1];
    for (std::size_t c = 1; c < lists.first.size(); ++c) lists.first[c] += lists.first[c - 1];
    lists.entries.resize(found_[view].size());
    const std::size_t blocks = (found_[view].size() + GNOMON_BLOCK_ENTRIES - 1) / GNOMON_BLOCK_ENTRIES;
    lists.blocks.assign(blocks, {{}, k_infinity});
    std::vector<std::uint32_t> next(lists.first.begin(), lists.first.end() - 1);
    for (const Found& found : found_[view]) {
        const std::uint32_t at = next[found.list]++;
        lists.entries[at] = found.entry;
        shared::CellBlock& block = lists.blocks[at / GNOMON_BLOCK_ENTRIES];
        block.nearest = std::min(block.nearest, found.nearest);
        const std::uint32_t bounds = found.entry.bounds, bit = 1u << (at % GNOMON_BLOCK_ENTRIES);
        for (std::uint32_t y = part_of(bounds >> 8); y <= part_of(bounds >> 24); ++y)
            for (std::uint32_t x = part_of(bounds); x <= part_of(bounds >> 16); ++x)
                block.around[GNOMON_BLOCK_PARTS * y + x] |= bit;
    }
    found_[view].clear();
}

void CasterCells::make(Set& set, bool moving, const LightViews& views, const CasterGeometry& casters,
                       const scene::SceneState& state)
{
    if (moving) {
        std::vector<scene::ObjectId> all;
        for (std::size_t v = 0; v < side_.size(); ++v)
            if (set.stale[v])
                for (const scene::ObjectId o : views.views()[v].plan.dynamics) all.push_back(o);
        std::sort(all.begin(), all.end());
        all.erase(std::unique(all.begin(), all.end()), all.end());
        for (const scene::ObjectId o : all) add_object(set, views, casters, state, o);
    } else {
        for (scene::ObjectId o = 0; o < views.object_count(); ++o) add_object(set, views, casters, state, o);
    }
    for (std::size_t v = 0; v < side_.size(); ++v)
        if (set.stale[v]) sort(v, set.views[v]);
}

// Concatenates and uploads the lists of all views.
void CasterCells::send(vk::Commands& commands, Set& set, const char* name)
{
    std::vector<std::uint32_t> first;
    std::vector<shared::CellEntry> entries;
    std::vector<shared::CellBlock> blocks;
    first.reserve(lists_);
    for (const Lists& lists : set.views) {
        const auto before = static_cast<std::uint32_t>(entries.size());
        for (const std::uint32_t f : lists.first) first.push_back(before + f);
        entries.insert(entries.end(), lists.entries.begin(), lists.entries.end());
        blocks.insert(blocks.end(), lists.blocks.begin(), lists.blocks.end());
        entries.resize(blocks.size() * GNOMON_BLOCK_ENTRIES);   // blocks do not span views
    }
    const auto fit = [&](vk::Buffer& buffer, std::size_t bytes) {
        if (bytes > device_->limits().maxStorageBufferRange)
            throw MissingError(
                fmt::format("Vulkan: the lists of triangles for hard shadows need {} MB, but the device's "
                            "buffers hold only {} MB; use --shadow-filter 1 instead",
                            bytes >> 20, device_->limits().maxStorageBufferRange >> 20));
        if (!buffer || buffer.bytes() < bytes)
            buffer = vk::Buffer(device_, name, std::bit_ceil(std::max<std::size_t>(bytes, 16)));
    };
    fit(set.first, first.size() * sizeof(std::uint32_t));
    fit(set.entries, entries.size() * sizeof(shared::CellEntry));
    fit(set.blocks, blocks.size() * sizeof(shared::CellBlock));
    std::vector<vk::Upload> uploads;
    if (!first.empty()) uploads.push_back(vk::upload_of(set.first, std::span<const std::uint32_t>(first)));
    if (!entries.empty()) uploads.push_back(vk::upload_of(set.entries, std::span<const shared::CellEntry>(entries)));
    if (!blocks.empty()) uploads.push_back(vk::upload_of(set.blocks, std::span<const shared::CellBlock>(blocks)));
    if (!uploads.empty()) commands.upload(name, uploads);
}

void CasterCells::update(vk::Commands& commands, const LightViews& views, const CasterGeometry& casters,
                         const scene::SceneState& state)
{
    // Find the views whose lists changed, and the objects that are dynamic in them.
    bool any[2] = {false, false};
    for (std::size_t v = 0; v < side_.size(); ++v) {
        const ViewPlan& plan = views.views()[v].plan;
        const bool changed = plan.kind != ViewPlan::Kind::idle;
        const bool statics = plan.kind == ViewPlan::Kind::whole || plan.kind == ViewPlan::Kind::restless ||
                             !plan.rebuild.empty() || !plan.settle.empty();
        sets_[0].stale[v] = (changed && statics) || sets_[0].views[v].first.empty();
        sets_[1].stale[v] = changed || sets_[1].views[v].first.empty();
        any[0] = any[0] || sets_[0].stale[v], any[1] = any[1] || sets_[1].stale[v];
        if (!sets_[1].stale[v]) continue;
        in_dynamic_set_[v].assign(views.object_count(), 0);
        for (const scene::ObjectId o : plan.dynamics) in_dynamic_set_[v][o] = 1;
    }
    for (const bool moving : {false, true}) {
        Set& set = sets_[moving ? 1 : 0];
        if (!any[moving ? 1 : 0] && set.first) continue;
        make(set, moving, views, casters, state);
        send(commands, set, moving ? "cells of dynamic objects" : "cells of static objects");
    }
    triangles_.send(commands);
    if (!sent_bases_ && !base_.empty()) {
        const vk::Upload upload = vk::upload_of(bases_, std::span<const std::uint32_t>(base_));
        commands.upload("cells of views", {&upload, 1});
    }
    sent_bases_ = true;
}

vk::Pass& CasterCells::declare(vk::Pass& pass) const
{
    for (const vk::Buffer* buffer : {&bases_, &triangles_.buffer()}) pass.reads(*buffer, vk::Use::storage_read);
    for (const Set& set : sets_)
        for (const vk::Buffer* buffer : {&set.first, &set.blocks, &set.entries})
            pass.reads(*buffer, vk::Use::storage_read);
    return pass;
}

void CasterCells::bind(vk::Recorder& recorder) const
{
    recorder.set("CellBases", bases_);
    recorder.set("CellTriangles", triangles_.buffer());
    recorder.set("StaticFirst", sets_[0].first);
    recorder.set("StaticBlocks", sets_[0].blocks);
    recorder.set("StaticEntries", sets_[0].entries);
    recorder.set("MovingFirst", sets_[1].first);
    recorder.set("MovingBlocks", sets_[1].blocks);
    recorder.set("MovingEntries", sets_[1].entries);
}

}   // namespace gnomon::light_views
