// SPDX-License-Identifier: Apache-2.0
#version 460
#extension GL_EXT_samplerless_texture_functions : require
// Draws one layer of transparent surfaces [Everitt 2001, "Interactive Order-Independent Transparency"]: the nearest in
// front of all opaque surfaces and behind the layer before. Depths are reversed: nearer is greater.
layout(binding = 2) uniform texture2D opaque_depth;
layout(binding = 3) uniform texture2D last_depth;
layout(location = 0) flat in uint draw;
layout(location = 0) out uvec2 id;

void main()
{
    const ivec2 at = ivec2(gl_FragCoord.xy);
    if (gl_FragCoord.z <= texelFetch(opaque_depth, at, 0).x || gl_FragCoord.z >= texelFetch(last_depth, at, 0).x) discard;
    id = uvec2(draw + 1, gl_PrimitiveID);
}
