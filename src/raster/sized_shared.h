// SPDX-License-Identifier: Apache-2.0
#ifndef GNOMON_SIZED_SHARED_H
#define GNOMON_SIZED_SHARED_H
// Lights with size for the rasterised frame's shaders: scene::SizedLight, its faces and places. Layout: scalar.

#include "shadow_textures/vulkan/lookup_shared.h"

GNOMON_SHARED_BEGIN(raster)

#ifdef __cplusplus
using gnomon::shadow_textures::shared::LookupConstants;
#endif

struct SizedLightRecord {
    vec3 centre;   // of a sphere around all faces
    float radius;
    uint first_face, face_count;
    uint first_place, place_count;   // by which a distant cluster is summed
    uint first_view, view_count;     // places that have light views
    uint first_cell, cells;          // mean radiances over cells x cells parts of a textured polygon; cells: 0 if none
    uint proven;                     // its visible shares are known (ProvenShares)
    vec3 cone_axis;                  // of scene::EmissionCone
    float cos_outer, cos_inner;      // outer GNOMON_NO_CONE: there is none
};

struct SizedFaceRecord {
    vec3 corner[4];
    uint corners;
    vec3 normal;
    uint two_sided;
    vec3 radiance;
};

struct SizedPlaceRecord {
    vec3 position;
    uint face;   // index of SizedFaceRecord[]
    vec3 radiance;
    float area;
};

/// shading::TransformedCosineFit.
struct LobeFit {
    float a, b, c, tilt;
    float scale;
};

/// Push constants of lighting by lights with size.
struct SizedPush {
    LookupConstants look_up;
    uint first_light, lights;
    uint continued;          // add to the image what these lights bring
    uint unshadowed;         // nothing occludes
    float far;               // PolygonLightOptions::far
    float least_roughness;   // PolygonLightOptions::least_roughness, for the places that have views
};

/// Push constants of adding it to the image.
struct SizedSumPush {
    uint layers;   // also add to the layer of direct light
};

#ifdef __cplusplus
GNOMON_MEMBERS(SizedLightRecord, centre, radius, first_face, face_count, first_place, place_count, first_view,
               view_count, first_cell, cells, proven, cone_axis, cos_outer, cos_inner)
GNOMON_MEMBERS(SizedFaceRecord, corner, corners, normal, two_sided, radiance)
GNOMON_MEMBERS(SizedPlaceRecord, position, face, radiance, area)
GNOMON_MEMBERS(LobeFit, a, b, c, tilt, scale)
GNOMON_MEMBERS(SizedPush, look_up, first_light, lights, continued, unshadowed, far, least_roughness)
GNOMON_MEMBERS(SizedSumPush, layers)
#endif

GNOMON_SHARED_END
#endif
