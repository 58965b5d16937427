// SPDX-License-Identifier: Apache-2.0
#ifndef GNOMON_SHADOW_TEXTURES_PLAIN_SHARED_H
#define GNOMON_SHADOW_TEXTURES_PLAIN_SHARED_H
// Structures that the plain frame's shaders share with the host.

#include "shadow_textures/vulkan/lookup_shared.h"

GNOMON_SHARED_BEGIN(shadow_textures)

struct PlainConstants {
    mat4 clip_from_world;
    vec3 eye;
    uint lights;
    LookupConstants lookup;
};

#ifdef __cplusplus
GNOMON_MEMBERS(PlainConstants, clip_from_world, eye, lights, lookup)
#endif

GNOMON_SHARED_END

#endif
