// SPDX-License-Identifier: Apache-2.0
#version 460
// Writes the draw and the triangle that a light sees.
layout(location = 0) flat in uint draw;
layout(location = 0) out uvec2 id;

void main()
{
    id = uvec2(draw + 1, gl_PrimitiveID);
}
