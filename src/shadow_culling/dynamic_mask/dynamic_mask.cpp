// SPDX-License-Identifier: Apache-2.0

#include <algorithm>
#include <cstring>

#include "ray/origin.h"
#include "shadow_culling/dynamic_mask/parts.h"

namespace gnomon::shadow_culling {

namespace {

// Rays start one lift above their triangle. Whatever rises less than this fraction of a lift does not occlude them.
constexpr float k_no_rise = 0.25f;

}   // namespace

DynamicMask::DynamicMask(const scene::SceneState& state, const ray::RayScene& rays, const StaticTriangles& triangles,
                         const MaskOptions& options)
    : state_(&state), rays_(&rays), options_(options), triangles_(triangles)
{
    const scene::Scene& scene = state.scene();
    for (const scene::ObjectId o : state.dynamic_objects()) add_unit(o);
    // Share the shape among instances of one mesh.
    std::unordered_map<const glm::vec3*, std::shared_ptr<const DynamicShape>> shapes[2];
    for (const auto& unit : units_) {
        const ray::ObjectGeometry& geometry = rays.geometry(unit->object);
        if (!geometry.mesh) continue;   // removed
        auto& shape = shapes[unit->deforming][geometry.positions];
        if (!shape) shape = std::make_shared<DynamicShape>(shape_of(scene, geometry, unit->deforming));
        unit->shape = shape;
    }
    for (std::size_t l = 0; l < scene.lights.size(); ++l) lights_.push_back(std::make_unique<LightMask>());
}

void DynamicMask::add_unit(scene::ObjectId object)
{
    units_.push_back(std::make_unique<Unit>());
    Unit& unit = *units_.back();
    unit.object = object;
    unit.deforming = state_->scene().objects[object].deforming;
    measure(unit);
}

void DynamicMask::measure(Unit& unit) const
{
    unit.own = Box3{};
    const ray::ObjectGeometry& geometry = rays_->geometry(unit.object);
    if (unit.deforming || !geometry.mesh) return;
    for (const glm::uvec3& t : geometry.mesh->triangles)
        for (int i = 0; i < 3; ++i) unit.own.add(geometry.positions[t[i]]);
}

DynamicMask::~DynamicMask() = default;

void DynamicMask::begin_frame(const scene::SceneState& state, const ray::RayScene& rays, const CullingView& view)
{
    state_ = &state;
    rays_ = &rays;
    view_ = view;
    const scene::FrameChanges& changes = state.changes();
    // Promoted objects, and those that left their group, now have a space of their own; added ones have any.
    const auto find_shape = [&](Unit& unit) {
        unit.shape =
            std::make_shared<DynamicShape>(shape_of(state.scene(), rays.geometry(unit.object), unit.deforming));
    };
    for (std::size_t u = units_.size(); u < state.dynamic_objects().size(); ++u) {
        add_unit(state.dynamic_objects()[u]);
        find_shape(*units_.back());
    }
    for (const auto* list : {&changes.separated, &changes.added})
        for (const scene::ObjectId o : *list) {
            Unit& unit = *units_[state.dynamic_index(o)];
            measure(unit);
            find_shape(unit);
        }
    bool crowded = false;   // with blocks of earlier views
    for (const auto& mask : lights_) crowded = crowded || 2 * mask->used > mask->table.size();
    if (changes.anything() || crowded) ++frame_;
}

DynamicMask::LightMask& DynamicMask::prepared(std::uint32_t light)
{
    LightMask& mask = *lights_[light];
    if (mask.prepared.load(std::memory_order_acquire) == frame_) return mask;
    const std::scoped_lock lock(mask.mutex);
    if (mask.prepared.load(std::memory_order_relaxed) == frame_) return mask;
    place_prints(mask, light);
    fill_bins(mask);
    mask.asked_before.clear();
    for (std::size_t b = 0; b < mask.used; ++b)
        mask.asked_before.emplace(mask.blocks[b]->key, mask.blocks[b]->rays.load(std::memory_order_relaxed));
    if (mask.used > 0)
        for (auto& entry : mask.table) entry.store(nullptr, std::memory_order_relaxed);
    mask.used = 0;
    mask.prepared.store(frame_, std::memory_order_release);
    return mask;
}

// Whether a dynamic object may occlude its own point.
bool DynamicMask::rises(const Print& print, const ShadowPoint& point) const
{
    const std::vector<float>& rise = units_[print.unit]->shape->rise;
    const std::size_t side = 2 * static_cast<std::size_t>(point.triangle) + (point.front != print.mirrored ? 0 : 1);
    if (side >= rise.size()) return true;
    const float lift = ray::k_lift_per_coordinate *
                       std::max({std::abs(point.origin.x), std::abs(point.origin.y), std::abs(point.origin.z)});
    return !(rise[side] * print.stretch <= k_no_rise * lift);
}

void DynamicMask::answer(std::uint32_t light, std::span<const ShadowPoint> points, Asked& asked)
{
    const std::size_t count = asked.count;
    if (count == 0) return;
    LightMask& mask = prepared(light);
    Texels& texels = asked.texels;
    texels.resize(count);
    for (std::size_t i = 0; i < count; ++i) {
        const glm::vec3& p = points[asked.point[i]].origin;
        texels.x[i] = p.x, texels.y[i] = p.y, texels.z[i] = p.z;
    }
    find_texels(mask.space, view_, options_.texel_pixels, texels);

    asked.answer.resize(texels.depth.size());
    asked.clear.resize(texels.depth.size());

    // Count the points of each block; neighbours mostly share one.
    asked.runs.clear();
    asked.key.clear();
    asked.asks.clear();
    asked.rays.clear();
    for (std::size_t i = 0; i < count;) {
        const std::uint32_t high = texels.high[i], low = texels.low[i];
        std::size_t end = i + 1;
        while (end < count && texels.low[end] == low && texels.high[end] == high) ++end;
        const BlockKey key = texels.key(i);
        const auto b = static_cast<std::size_t>(std::find(asked.key.begin(), asked.key.end(), key) - asked.key.begin());
        if (b == asked.key.size()) asked.key.push_back(key), asked.asks.push_back(0), asked.rays.push_back(0);
        asked.asks[b] += static_cast<std::uint32_t>(end - i);
        asked.rays[b] +=
            static_cast<std::uint32_t>(end - i +
                                       std::count(asked.moving.begin() + static_cast<std::ptrdiff_t>(i),
                                                  asked.moving.begin() + static_cast<std::ptrdiff_t>(end), 1));
        asked.runs.push_back({static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(b)});
        i = end;
    }
    asked.drawn.assign(asked.key.size(), nullptr);
    for (std::size_t b = 0; b < asked.key.size(); ++b)
        if (asked.asks[b] >= options_.asked && asked.key[b] != k_no_block)
            asked.drawn[b] = block_at(mask, asked.key[b], asked.rays[b]);

    for (std::size_t r = 0; r < asked.runs.size(); ++r) {
        const std::size_t first = asked.runs[r].first;
        const std::size_t end = r + 1 < asked.runs.size() ? asked.runs[r + 1].first : count;
        Block* const block = asked.drawn[asked.runs[r].block];
        const bool moving = std::memchr(&asked.moving[first], 1, end - first) != nullptr;
        if (block == nullptr || (block->empty && !moving)) {
            const Answer all = block == nullptr ? Answer::not_drawn : Answer::free;
            std::memset(&asked.answer[first], static_cast<int>(all), end - first);
            std::memset(&asked.clear[first], 0, end - first);
            continue;
        }
        const MaskTexels& over = block->texels;
        const float still = moving ? static_begins(mask, *block) : -k_infinity;
        compare_depths(texels, first, end, over, asked.moving.data(), still, asked.answer.data(), asked.clear.data());
        if (!moving) continue;

        // For points on dynamic objects, test whether the first object over the point is only its own.
        for (std::size_t i = first; i < end; ++i) {
            if (asked.answer[i] != Answer::maybe_self) continue;
            const ShadowPoint& point = points[asked.point[i]];
            const Print& print = mask.prints[block->print_of[over.first(texels.texel[i])]];
            const bool self = units_[print.unit]->object == point.object && !rises(print, point);
            asked.answer[i] = self ? Answer::free : Answer::unknown;
        }
    }
}

std::size_t DynamicMask::bytes() const
{
    std::size_t bytes = 0;
    for (const auto& mask : lights_) {
        bytes += mask->prints.capacity() * sizeof(Print) + mask->table.size() * sizeof(void*);
        for (const auto& outline : mask->outlines) bytes += outline.capacity() * sizeof(Piece);
        for (const auto& block : mask->blocks)
            bytes += sizeof(Block) + 2 * sizeof(float) * block->texels.begins.capacity();
    }
    return bytes;
}

}   // namespace gnomon::shadow_culling
