// SPDX-License-Identifier: Apache-2.0
#pragma once
// Data structures of the mask of dynamic objects; private to this folder.

#include <array>
#include <unordered_map>

#include "shadow_culling/dynamic_mask/dynamic_mask.h"

namespace gnomon::shadow_culling {

inline constexpr std::uint32_t k_bins = 64;   // of prints, per axis

// A segment of an outline on a light's plane.
struct Piece {
    float ax, ay, bx, by;
    float widen;
    std::int32_t layers;   // that begin to the right of it, where it goes up
};

// A dynamic object.
struct DynamicMask::Unit {
    scene::ObjectId object = scene::none;
    bool deforming = false;
    Box3 own;   // of a rigid one, in the space of its geometry (its own, or its group's)
    std::shared_ptr<const DynamicShape> shape;
};

// The bounds of a unit on one face of a light's plane.
struct DynamicMask::Print {
    std::uint32_t unit = 0, face = 0;
    float low_x = 0, low_y = 0, high_x = 1, high_y = 1;   // on the plane
    float between = 0;                                    // depth margin
    float begins = -k_infinity, ends = k_infinity;        // depths, margins included; known with the outline
    float stretch = 1;                                    // upper bound of its matrix's scale
    bool mirrored = false, masked = false;
    bool blind = false;   // it may be anywhere: too near to the light's plane to be drawn, or ray::Meeting::roughly
};

struct DynamicMask::Block {
    BlockKey key = 0;
    std::atomic<bool> ready = false;   // the list of prints is complete
    std::atomic<int> drawn = 0;        // 1: a thread is drawing it; 2: drawn; 3: cannot be drawn
    bool empty = true;
    std::uint32_t edges = 0;               // of the units in `prints`
    std::uint32_t expected = 0;            // rays of the points queried in the last frame
    std::atomic<std::uint32_t> rays = 0;   // of this frame, from batches with enough points
    std::atomic<float> static_begins;      // least depth of static geometry, margin included; NaN: not known yet
    std::vector<std::uint32_t> prints;
    MaskTexels texels;
    std::vector<std::uint32_t> print_of;   // by object number in `texels`
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
    std::unordered_map<BlockKey, std::uint32_t> asked_before;   // rays in the last frame

    // Depths of static geometry, kept from frame to frame.
    std::unordered_map<BlockKey, float> static_begins;
    double static_margin = 0, static_between = 0;   // margins that it was found with
};

}   // namespace gnomon::shadow_culling
