// SPDX-License-Identifier: Apache-2.0
// Percentage-closer soft shadows [Fernando 2005]: from one light view, the mean distance of what is nearer, and a filter
// as wide as the penumbra that such an occluder would cast. A baseline, which bench lights and tests compare with.

// Steps of the patterns on both sides of the middle.
const int k_search_steps = 3, k_filter_steps = 5;
const float k_closer_margin = 2;   // texel widths at the receiver that a nearer surface must be away

// The texel of a light view towards which a point lies: distances along the view's axis of the nearest surface and of
// the plane of the receiver.
bool closer_texel(uint number, vec3 target, vec3 at, vec3 normal, out float nearest, out float own)
{
    const LightRecord light = light_records[number];
    const ViewRecord view = view_records[view_of_light(light, target)];
    const vec4 clip = view.clip_from_world * vec4(target, 1);
    if (clip.w <= 0) return false;
    const float size = float(view.size);
    const ivec2 texel = ivec2(floor((0.5 * clip.xy / clip.w + 0.5) * size));
    if (any(lessThan(texel, ivec2(0))) || any(greaterThanEqual(texel, ivec2(int(view.size))))) return false;
    const float depth = texelFetch(light_depth, ivec3(view.corner + texel, view.page), 0).x;
    nearest = depth <= 0 ? 3.0e38 : view.reach / depth;
    const vec2 centre = 2 * (vec2(texel) + 0.5) / size - 1;
    const vec3 ray = view.forward + centre.x * view.across + centre.y * view.down;
    const float plane = dot(normal, at - view.origin) / dot(normal, ray);
    own = plane > 0 && plane < 2 * clip.w ? plane : clip.w;
    own -= k_closer_margin * 2 * length(view.across) / size * own;
    return true;
}

float percentage_closer(Point p, SizedLightRecord light)
{
    const uint number = light.first_view;
    const SizedFaceRecord face = sized_faces[light.first_face];
    const vec3 origin = view_records[light_records[number].first_view].origin;
    // Half the light's sides; of a triangle or cluster, a square of the same size.
    vec3 side[2];
    if (light.face_count == 1 && face.corners == 4) {
        side[0] = 0.5 * (face.corner[1] - face.corner[0]), side[1] = 0.5 * (face.corner[3] - face.corner[0]);
    } else {
        const vec3 aside = abs(face.normal.x) < 0.5 ? vec3(1, 0, 0) : vec3(0, 1, 0);
        side[0] = 0.7 * light.radius * normalize(cross(aside, face.normal));
        side[1] = 0.7 * light.radius * normalize(cross(face.normal, side[0]));
    }
    const float own = dot(p.position - origin, face.normal);
    if (!(own > 0)) return 0;

    // Find the mean distance of the surfaces between the point and the light.
    float sum = 0, count = 0;
    for (int j = -k_search_steps; j <= k_search_steps; ++j)
        for (int i = -k_search_steps; i <= k_search_steps; ++i) {
            const vec2 at = vec2(i, j) / float(k_search_steps);
            const vec3 target = p.position + at.x * side[0] + at.y * side[1];
            float nearest, here;
            if (!closer_texel(number, target, p.position, p.geometric, nearest, here) || nearest >= here) continue;
            sum += nearest / here, count += 1;
        }
    if (count == 0) return 1;
    const float ratio = sum / count, width = (1 - ratio) / max(ratio, 1e-3);

    // Filter over the penumbra's width.
    float seen = 0, all = 0;
    for (int j = -k_filter_steps; j <= k_filter_steps; ++j)
        for (int i = -k_filter_steps; i <= k_filter_steps; ++i) {
            const vec2 at = width * vec2(i, j) / float(k_filter_steps);
            const vec3 target = p.position + at.x * side[0] + at.y * side[1];
            float nearest, here;
            if (!closer_texel(number, target, p.position, p.geometric, nearest, here)) continue;
            seen += nearest >= here ? 1 : 0, all += 1;
        }
    return all > 0 ? seen / all : 1;
}
