// SPDX-License-Identifier: Apache-2.0
#version 460
// The ray is not occluded.
#extension GL_EXT_ray_tracing : require

layout(location = 0) rayPayloadInEXT uint occluded;

void main()
{
    occluded = 0;
}
