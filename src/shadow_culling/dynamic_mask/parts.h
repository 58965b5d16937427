// SPDX-License-Identifier: Apache-2.0
#pragma once
// What a dynamic object mask is made of; for its own files alone.

#include <array>
#include <unordered_map>

#include "shadow_culling/dynamic_mask/dynamic_mask.h"

namespace gnomon::shadow_culling {

inline constexpr std::uint32_t k_bins = 64;   // of prints, a side

// A piece of an outline on a light's plane.
struct Piece {
    float ax, ay, bx, by;
    float widen;
    std::int32_t layers;   // that begin right of it, where it goes up
};

// A dynamic object.
struct DynamicMask::Unit {
    scene::ObjectId object = scene::none;
    bool deforming = false;
    Box3 own;   // of a rigid one, in the space of its geometry (its own, or its group's)
    std::shared_ptr<const DynamicShape> shape;
};

// A unit on one face of a light's plane.
struct DynamicMask::Print {
    std::uint32_t unit = 0, face = 0;
    float low_x = 0, low_y = 0, high_x = 1, high_y = 1;   // on the plane
    float between = 0;                                    // margin of depths
    float begins = -k_infinity, ends = k_infinity;        // in depth, margins included; known with the outline
    float stretch = 1;                                    // of its matrix, at most
    bool mirrored = false, masked = false;
    bool blind = false;   // may be anywhere: too near to the light's plane to be drawn, or met roughly
};

struct DynamicMask::Block {
    BlockKey key = 0;
    std::atomic<bool> ready = false;   // who may be here is known
    std::atomic<int> drawn = 0;        // 1: someone draws it; 2: it is; 3: it cannot be
    bool empty = true;
    std::uint32_t edges = 0;               // of those who may be here
    std::uint32_t expected = 0;            // rays of the points that asked in the frame before
    std::atomic<std::uint32_t> rays = 0;   // now; of batches that asked for enough
    std::atomic<float> static_begins;      // least depth of what stands still, margin included; NaN: not asked yet
    std::vector<std::uint32_t> prints;
    MaskTexels texels;
    std::vector<std::uint32_t> print_of;   // by number in `texels`
};

struct DynamicMask::LightMask {
    std::mutex mutex;
    std::atomic<std::uint32_t> prepared = 0;   // frame
    LightSpace space;
    double margin = 0;   // scene units
    std::vector<Print> prints;
    std::vector<std::vector<Piece>> outlines;   // by print
    std::unique_ptr<std::once_flag[]> outlined;
    float bins_low_x = 0, bins_low_y = 0, bins_scale_x = 0, bins_scale_y = 0;
    std::vector<std::uint32_t> bin_begin, binned;
    std::vector<std::atomic<Block*>> table = std::vector<std::atomic<Block*>>(1u << 12);
    std::vector<std::unique_ptr<Block>> blocks;
    std::size_t used = 0;                                       // of `blocks`
    std::unordered_map<BlockKey, std::uint32_t> asked_before;   // in the frame before

    // What is known of what stands still, kept from frame to frame.
    std::unordered_map<BlockKey, float> static_begins;
    double static_margin = 0, static_between = 0;   // that it was found with
};

}   // namespace gnomon::shadow_culling
