// SPDX-License-Identifier: Apache-2.0
#ifndef GNOMON_LIGHT_VIEWS_CASTER_SHARED_H
#define GNOMON_LIGHT_VIEWS_CASTER_SHARED_H
// Structures and constants that the shaders for casters share with the host.

#include "vk/shared_types.h"

GNOMON_SHARED_BEGIN(light_views)

struct CasterConstants {
    mat4 clip_from_world;
    uint page;       // of the atlas
    uint ties;       // 1: where the static buffer is equally near, the higher of both items is written
    uint material;   // of alpha-tested parts: index into AlphaMaterial[]
    uint place;      // for drawing receivers: the view's first entry in their table
};

// Side of a cell of CasterCells, in texels of the view.
#define GNOMON_CELL_TEXELS 16u

// An entry of a cell's list: a triangle that may cover the cell.
struct CellEntry {
    uint triangle;   // index of CellTriangle[]
    uint bounds;     // of the projection in the cell, a byte each in 256ths of the cell: low x, low y, high x, high y
};

// A caster's triangle in world space.
struct CellTriangle {
    vec3 a, b, c;
    uint object;
    uint triangle;   // index of the first of three caster indices
    uint material;   // alpha-tested: index into AlphaMaterial[]; else none
};

// Entries per block, which are skipped together; and the parts of a cell, along a side, that a block distinguishes.
#define GNOMON_BLOCK_ENTRIES 32u
#define GNOMON_BLOCK_PARTS 4u

struct CellBlock {
    uint around[16];   // by part of the cell, row by row: a bit for each entry whose bounds meet it
    float nearest;     // least distance of the block's triangles along the view's `forward` from its origin
};

// The location of an alpha-tested material's texture, and how it is sampled.
struct AlphaMaterial {
    uint first_byte;   // of its alpha texels; none: no texture
    uint width, height;
    uint wrap_u, wrap_v;   // scene::Wrap
    uint nearest;          // 1: no interpolation
    float alpha, cutoff;
    vec2 offset;         // of uv
    vec2 row_u, row_v;   // uv' = offset + (dot(row_u, uv), dot(row_v, uv))
};

#ifdef __cplusplus
GNOMON_MEMBERS(CasterConstants, clip_from_world, page, ties, material, place)
GNOMON_MEMBERS(CellEntry, triangle, bounds)
GNOMON_MEMBERS(CellTriangle, a, b, c, object, triangle, material)
GNOMON_MEMBERS(CellBlock, around, nearest)
GNOMON_MEMBERS(AlphaMaterial, first_byte, width, height, wrap_u, wrap_v, nearest, alpha, cutoff, offset, row_u, row_v)
#endif

GNOMON_SHARED_END

#endif
