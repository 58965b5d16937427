// SPDX-License-Identifier: Apache-2.0
#version 460
// Computes the direct light of lights with size at each surface; what a surface sees of a light is found from light
// views of several places.
#extension GL_GOOGLE_include_directive : require
#include "raster/sized_body.glsl"
