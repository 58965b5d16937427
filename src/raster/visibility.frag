// SPDX-License-Identifier: Apache-2.0
#version 460
// Which draw's which triangle a pixel shows: all that the later passes need to make its surface.
layout(location = 0) flat in uint draw;
layout(location = 0) out uvec2 id;

void main()
{
    id = uvec2(draw + 1, gl_PrimitiveID);
}
