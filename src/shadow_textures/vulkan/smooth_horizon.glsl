// SPDX-License-Identifier: Apache-2.0
// Moves a point of a triangle to the smooth surface above it (ray/smooth_surface.h), where a light lies between the
// horizons of the two, so that the triangle does not hide it. Needs `view_records`, `light_records`, view_of_light().
// `smooth_at`: the smooth horizon's normal, and the height
void move_between_horizons(uint light_number, vec4 smooth_at, inout vec3 point, inout vec3 normal)
{
    const LightRecord light = light_records[light_number];
    if (light.view_count == 0u) return;
    const ViewRecord view = view_records[view_of_light(light, point)];
    const vec3 to_light = view.perspective != 0u ? view.origin - point : -view.forward;
    if (dot(normal, to_light) > 0.0 || dot(smooth_at.xyz, to_light) <= 0.0) return;
    point += smooth_at.w * smooth_at.xyz;
    normal = smooth_at.xyz;
}
