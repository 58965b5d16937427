// SPDX-License-Identifier: Apache-2.0
#version 460
// Stores the ids of draw and triangle, from which later passes make the pixel's surface.
layout(location = 0) flat in uint draw;
layout(location = 0) out uvec2 id;

void main()
{
    id = uvec2(draw + 1, gl_PrimitiveID);
}
