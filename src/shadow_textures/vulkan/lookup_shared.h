// SPDX-License-Identifier: Apache-2.0
#ifndef GNOMON_SHADOW_TEXTURES_LOOKUP_SHARED_H
#define GNOMON_SHADOW_TEXTURES_LOOKUP_SHARED_H
// Light views for look-ups: light_views::ViewProjection and the view's location in the atlas.

#include "vk/shared_types.h"

GNOMON_SHARED_BEGIN(shadow_textures)

struct ViewRecord {
    mat4 clip_from_world;
    vec3 origin;
    float reach;
    vec3 forward;
    uint perspective;
    vec3 across;
    uint size;
    vec3 down;
    uint page;
    ivec2 corner;   // of its square, in texels of the page
};

struct LightRecord {
    uint first_view;
    uint view_count;   // 1; 2: a dense part, then everything; 5: half a cube; 6: faces. 0: the light is off or has none
};

struct LookupConstants {
    uvec2 size;           // of the image
    float filter_width;   // of the box filter for edges, in texels; 0: hard
    float self_margin;    // see LookupOptions
    float other_margin;
    float border;   // texels: ProjectionOptions::border
    uint objects;
    uint by_textures;   // 1: use the receiver's own texture; 0: use the items
    uint first_light;   // first light to look up
    uint as_printed;    // 1: the texture's colour decides, see LookupOptions
};

/// Of look-ups as printed: pairs of a surface that faces a light and that light, and those of them in which comparing
/// distances decides otherwise.
struct LookupCounts {
    uint results, wrong;
};

#ifdef __cplusplus
GNOMON_MEMBERS(ViewRecord, clip_from_world, origin, reach, forward, perspective, across, size, down, page, corner)
GNOMON_MEMBERS(LightRecord, first_view, view_count)
GNOMON_MEMBERS(LookupConstants, size, filter_width, self_margin, other_margin, border, objects, by_textures,
               first_light, as_printed)
GNOMON_MEMBERS(LookupCounts, results, wrong)
#endif

GNOMON_SHARED_END

#endif
