// SPDX-License-Identifier: Apache-2.0
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
// White diffuse surfaces under all lights with equal brightness, with the shadows of the receiver's textures.
#include "shadow_textures/vulkan/plain_shared.h"
#include "shadow_textures/vulkan/textures_shared.h"

layout(location = 0) flat in uint object;
layout(location = 1) in vec3 point;
layout(location = 0) out vec4 color;
layout(binding = 3) uniform sampler2DArray light_depth;
layout(binding = 4) uniform usampler2DArray light_item;
layout(binding = 5, scalar) readonly buffer ViewRecords { ViewRecord view_records[]; };
layout(binding = 6, scalar) readonly buffer LightRecords { LightRecord light_records[]; };
layout(binding = 7, scalar) readonly buffer Places { TexturePlace places[]; };
layout(binding = 8, scalar) readonly buffer Textures { uint textures[]; };
layout(binding = 9, scalar) readonly buffer Casts { uint casts[]; };
layout(push_constant, scalar) uniform Constants { PlainConstants frame; };
#define lookup frame.lookup
#include "shadow_textures/vulkan/lookup.glsl"

const float ambient = 0.15;

void main()
{
    vec3 normal = normalize(cross(dFdx(point), dFdy(point)));
    if (dot(normal, frame.eye - point) < 0.0) normal = -normal;
    float sum = 0.0;
    for (uint light = 0u; light < frame.lights; ++light) {
        ViewRecord view = view_records[light_records[light].first_view];
        vec3 to_light = view.perspective != 0u ? normalize(view.origin - point) : -view.forward;
        float cosine = dot(normal, to_light);
        if (cosine <= 0.0) continue;
        sum += cosine * (lookup.as_printed != 0u ? light_visibility_as_printed(light, point, normal, object)
                                                 : light_visibility(light, point, normal, object));
    }
    color = vec4(vec3(ambient + (1.0 - ambient) * sum / float(max(frame.lights, 1u))), 1.0);
}
