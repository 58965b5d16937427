// SPDX-License-Identifier: Apache-2.0
#version 460
// Stores the flux of changed nodes.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "irradiance_cache/vulkan/points_shared.h"

layout(local_size_x = 64) in;
layout(binding = 0, scalar) readonly buffer Changed { GpuNodeFlux at[]; } changed;
layout(binding = 1, scalar) writeonly buffer Flux { vec3 at[]; } flux;
layout(push_constant, scalar) uniform Push { PointFluxPush push; };

void main()
{
    const uint i = gl_GlobalInvocationID.x;
    if (i < push.count) flux.at[changed.at[i].node] = changed.at[i].flux;
}
