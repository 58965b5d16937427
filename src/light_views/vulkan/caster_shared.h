// SPDX-License-Identifier: Apache-2.0
#ifndef GNOMON_LIGHT_VIEWS_CASTER_SHARED_H
#define GNOMON_LIGHT_VIEWS_CASTER_SHARED_H
// What the shaders that draw casters share with the host.

#include "vk/shared_types.h"

GNOMON_SHARED_BEGIN(light_views)

struct CasterConstants {
    mat4 clip_from_world;
    uint page;       // of the atlas
    uint ties;       // 1: where the static buffer is equally near, the higher item of both is written
    uint material;   // of alpha-tested parts: index into AlphaMaterial[]
    uint place;      // for those who draw receivers: the view's first entry in their table
};

// Side of a cell of CasterCells, in texels of the view.
#define GNOMON_CELL_TEXELS 16u

// A triangle that may lie over a cell.
struct CellEntry {
    uint triangle;   // of CellTriangle[]
    uint bounds;     // of its image in the cell, a byte each in 256ths of it: low x, low y, high x, high y
};

// A caster's triangle in the world.
struct CellTriangle {
    vec3 a, b, c;
    uint object;
    uint triangle;   // three of the casters' indices
    uint material;   // alpha-tested: index into AlphaMaterial[]; else none
};

// So many entries are passed over at once; the parts of a cell, along a side, that this knows apart.
#define GNOMON_BLOCK_ENTRIES 32u
#define GNOMON_BLOCK_PARTS 4u

struct CellBlock {
    uint around[16];   // by part of the cell, row by row: a bit for each entry whose bounds meet it
    float nearest;     // along the view's `forward` from its origin: no triangle of the block comes nearer the light
};

// Where an alpha-tested material's texture lies, and how it is looked up.
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
