// SPDX-License-Identifier: Apache-2.0
#version 460
// sized.comp with percentage-closer soft shadows, for comparison.
#extension GL_GOOGLE_include_directive : require
#define GNOMON_CLOSER
#include "raster/sized_body.glsl"
