// SPDX-License-Identifier: Apache-2.0
// Determines whether a point of an object is in shadow. Same computation as shadow_textures::visibility (lookup.h),
// which explains it; light_visibility_as_printed is visibility_as_printed there. Needs `view_records`, `light_records`,
// `places`, `textures`, `casts`, the images light_depth and light_item, and `lookup`.

#include "shadow_textures/vulkan/view_of_light.glsl"

// Whether a receiver is the nearest object to the light at a texel.
bool is_nearest(uint view, ivec3 at, uint object)
{
    if (lookup.by_textures == 0u) return texelFetch(light_item, at, 0).x == object + 1u;
    TexturePlace place = places[view * lookup.objects + object];
    ivec2 texel = at.xy - place.corner;
    // Outside the texture, the word index would refer to another texture.
    if (place.row_words == 0u || any(lessThan(texel, ivec2(0))) || texel.x >= place.columns || texel.y >= place.rows) return false;
    return (textures[place.first_word + uint(texel.y) * place.row_words + uint(texel.x) / 32u] >> (uint(texel.x) % 32u) & 1u) != 0u;
}

// Whether a surface faces a light that is on.
bool faces_light(uint light_number, vec3 point, vec3 normal)
{
    LightRecord light = light_records[light_number];
    if (light.view_count == 0u) return false;
    ViewRecord view = view_records[view_of_light(light, point)];
    return dot(normal, view.perspective != 0u ? view.origin - point : -view.forward) > 0.0;
}

// The visibility of a light by the comparison of distances, or as printed by the texture's colour.
float light_visibility_by(uint light_number, vec3 point, vec3 normal, uint object, bool as_printed)
{
    // Find the view that contains the point.
    LightRecord light = light_records[light_number];
    if (light.view_count == 0u) return 0.0;
    uint number = view_of_light(light, point);
    ViewRecord view = view_records[number];
    bool perspective = view.perspective != 0u;
    if (dot(normal, perspective ? view.origin - point : -view.forward) <= 0.0) return 0.0;
    vec4 clip = view.clip_from_world * vec4(point, 1);
    if (clip.w <= 0.0) return 1.0;
    float size = float(view.size);
    vec2 at = (0.5 * clip.xy / clip.w + 0.5) * size;
    if (any(lessThan(at, vec2(0))) || any(greaterThanEqual(at, vec2(size)))) return 1.0;

    // Compute the filter's texels, and the width of a texel at the point.
    float own = perspective ? clip.w : dot(point - view.origin, view.forward);
    float texel_width = 2.0 * length(view.across) / size * (perspective ? own : 1.0);
    float above = dot(normal, point - view.origin);
    float half_width = 0.5 * lookup.filter_width;
    ivec2 first = ivec2(floor(at - half_width)), last = ivec2(ceil(at + half_width)) - 1;
    if (half_width == 0.0) last = first;

    // Read the colour of each texel, or compare distances at its centre, weighted by the area that the filter covers.
    float sum = 0.0, covered = 0.0;
    for (int y = first.y; y <= last.y; ++y)
        for (int x = first.x; x <= last.x; ++x) {
            vec2 low = max(vec2(x, y), at - half_width), high = min(vec2(x + 1, y + 1), at + half_width);
            float cover = half_width == 0.0 ? 1.0 : (high.x - low.x) * (high.y - low.y);
            ivec2 texel = clamp(ivec2(x, y), ivec2(0), ivec2(int(view.size) - 1));
            ivec3 in_page = ivec3(view.corner + texel, view.page);
            covered += cover;
            bool nearest_here = is_nearest(number, in_page, object);
            if (as_printed) {
                if (nearest_here) sum += cover;
                continue;
            }
            float depth = texelFetch(light_depth, in_page, 0).x;
            float nearest = depth <= 0.0 ? 3.0e38 : perspective ? view.reach / depth : (1.0 - depth) * view.reach;
            vec2 centre = 2.0 * (vec2(texel) + 0.5) / size - 1.0;
            vec3 offset = centre.x * view.across + centre.y * view.down;
            vec3 ray = perspective ? view.forward + offset : view.forward;
            float plane = (above - (perspective ? 0.0 : dot(normal, offset))) / dot(normal, ray);
            float here = plane > 0.0 && plane < own ? plane : own;
            float margin = texel_width * (nearest_here ? lookup.self_margin : lookup.other_margin);
            if (nearest >= here - margin) sum += cover;
        }
    return covered > 0.0 ? sum / covered : 1.0;
}

float light_visibility(uint light_number, vec3 point, vec3 normal, uint object)
{
    return light_visibility_by(light_number, point, normal, object, false);
}

// DEVIATION(Oh and Shin 2004, 2): a surface that casts no shadow has no texture (a transparent one); its distances are
// compared.
float light_visibility_as_printed(uint light_number, vec3 point, vec3 normal, uint object)
{
    return light_visibility_by(light_number, point, normal, object, casts[object] != 0u);
}
