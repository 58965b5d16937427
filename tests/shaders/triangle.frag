// SPDX-License-Identifier: Apache-2.0
#version 460
layout(location = 0) flat in uint instance;
layout(location = 0) out uvec2 id;
void main() { id = uvec2(instance + 1u, uint(gl_PrimitiveID)); }
