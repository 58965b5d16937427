// SPDX-License-Identifier: Apache-2.0
// The view of a light that contains a point; view_count must not be 0.
uint view_of_light(LightRecord light, vec3 point)
{
    if (light.view_count == 6u) {
        vec3 d = point - view_records[light.first_view].origin, size = abs(d);
        uint axis = size.x >= size.y && size.x >= size.z ? 0u : size.y >= size.z ? 1u : 2u;
        return light.first_view + 2u * axis + (d[axis] < 0.0 ? 1u : 0u);
    }
    if (light.view_count == 5u) {
        // The top of half a cube, or the side towards which the point lies.
        ViewRecord top = view_records[light.first_view];
        vec3 d = point - top.origin;
        float stretch = length(top.across);
        vec2 aside = vec2(dot(d, top.across), dot(d, top.down)) / stretch, size = abs(aside);
        if (max(size.x, size.y) <= dot(d, top.forward)) return light.first_view;
        uint axis = size.x >= size.y ? 0u : 1u;
        return light.first_view + 1u + 2u * axis + (aside[axis] < 0.0 ? 1u : 0u);
    }
    if (light.view_count == 2u) {
        ViewRecord dense = view_records[light.first_view];
        vec4 clip = dense.clip_from_world * vec4(point, 1);
        float inside = 1.0 - 2.0 * lookup.border / float(dense.size);
        return light.first_view + (abs(clip.x) <= inside && abs(clip.y) <= inside ? 0u : 1u);
    }
    return light.first_view;
}
