// SPDX-License-Identifier: Apache-2.0
// Light with size at a point, without occlusion: src/shading/polygon_light.cpp and the tables of transformed_cosines.h
// and glossy.h, in single precision. Included with `sized_faces`, `sized_places`, `sized_cells`, `lobe_fits` and
// `lobe_albedos` declared.
//
// Only products, quotients and square roots are used, because devices may compute inverse trigonometric functions to
// three digits.

#include "ray/limits_shared.h"
#include "raster/emission_cone.glsl"
#include "shading/lobe_shared.h"

const float k_pi = 3.14159265358979;
const uint k_most_corners = 8;
const float k_small = 0.02;   // angle of a polygon below which a sum over few points is more exact than over edges

struct Point {
    vec3 position, normal, geometric, smooth_normal, to_viewer, diffuse, specular;
    uint model;
    float roughness, coverage;
    float lift;   // least distance of the light's plane
};

// A polygon relative to the point: at most four corners, each plane that clips it adds one.
struct Clipped {
    vec3 corner[k_most_corners];
    uint count;
};

// Keeps the part of a convex polygon on the inner side of a plane through the origin.
Clipped clip(Clipped from, vec3 normal)
{
    Clipped to;
    to.count = 0;
    for (uint i = 0; i < from.count; ++i) {
        const vec3 a = from.corner[i], b = from.corner[i + 1 < from.count ? i + 1 : 0];
        const float at_a = dot(normal, a), at_b = dot(normal, b);
        if (at_a >= 0) to.corner[to.count++] = a;
        if ((at_a < 0) != (at_b < 0)) to.corner[to.count++] = a + (at_a / (at_a - at_b)) * (b - a);
    }
    return to;
}

// asin(x) for 0 <= x <= 1 [Moshier 1989].
float arc_sine(float x)
{
    const bool large = x > 0.5;
    const float z = large ? 0.5 * (1 - x) : x * x, y = large ? sqrt(z) : x;
    const float p =
        ((((4.2163199048e-2 * z + 2.4181311049e-2) * z + 4.5470025998e-2) * z + 7.4953002686e-2) * z + 1.6666752422e-1);
    const float result = p * z * y + y;
    return large ? 0.5 * k_pi - 2 * result : result;
}

// The form factor of a polygon above the horizon of `normal`, up to its sign: Lambert's sum over the edges.
// @param middle  out: leads to the middle of what is seen of it, in this direction or the opposite one
float form_factor(Clipped polygon, vec3 normal, out vec3 middle)
{
    middle = vec3(0);
    float farthest = 0;
    const vec3 first = polygon.corner[0];
    for (uint i = 1; i < polygon.count; ++i) {
        const vec3 d = polygon.corner[i] - first;
        farthest = max(farthest, dot(d, d));
    }
    float sum = 0;
    if (farthest < k_small * k_small * dot(first, first)) {
        // Sum the triangles of a small polygon over the middles of their sides, which is exact to the second degree.
        for (uint i = 1; i + 1 < polygon.count; ++i) {
            const vec3 b = polygon.corner[i], c = polygon.corner[i + 1];
            const vec3 area = 0.5 * cross(b - first, c - first);
            for (uint k = 0; k < 3; ++k) {
                const vec3 m = 0.5 * (k == 0 ? first + b : k == 1 ? b + c : c + first);
                const float square = dot(m, m);
                const float seen = dot(area, m) / (square * square);
                sum += seen * max(dot(normal, m), 0);
                middle += seen * m;
            }
        }
        return abs(sum) / (3 * k_pi);
    }
    for (uint i = 0; i < polygon.count; ++i) {
        const vec3 a = polygon.corner[i], b = polygon.corner[i + 1 < polygon.count ? i + 1 : 0];
        const float a_b = sqrt(dot(a, a) * dot(b, b));
        if (!(a_b > 0)) continue;
        const vec3 chord = 0.5 * (normalize(a) - normalize(b));
        const float square = min(dot(chord, chord), 1.0), half_sine = sqrt(square);
        // The angle between a and b over its sine.
        const float sine = 2 * half_sine * sqrt(1 - square);
        const float ratio = half_sine < 1e-3 ? 1 + (2.0 / 3.0) * square : sine > 0 ? 2 * arc_sine(half_sine) / sine : 0;
        sum += ratio / a_b * dot(normal, cross(a, b - a));
        middle += ratio / a_b * cross(a, b - a);
    }
    return abs(sum) / (2 * k_pi);
}

// The table of albedos at a point: x, y of shading::glossy_albedo_table().
vec2 albedo_parts(float n_v, float roughness)
{
    const vec2 t = clamp(vec2(n_v, roughness), vec2(0), vec2(1)) * (GNOMON_ALBEDO_SIDE - 1);
    const uvec2 low = min(uvec2(t), uvec2(GNOMON_ALBEDO_SIDE - 2));
    const vec2 along = t - vec2(low);
    const uint at = low.y * GNOMON_ALBEDO_SIDE + low.x;
    return mix(mix(lobe_albedos[at], lobe_albedos[at + 1], along.x),
               mix(lobe_albedos[at + GNOMON_ALBEDO_SIDE], lobe_albedos[at + GNOMON_ALBEDO_SIDE + 1], along.x), along.y);
}

vec3 glossy_albedo(Point p)
{
    const vec2 parts = albedo_parts(dot(p.normal, p.to_viewer), p.roughness);
    const float kept = parts.x + parts.y;
    return min((p.specular * parts.x + parts.y) * (vec3(1) + p.specular * ((1 - kept) / max(kept, 1e-3))), vec3(1));
}

LobeFit mixed(LobeFit a, LobeFit b, float t)
{
    return LobeFit(mix(a.a, b.a, t), mix(a.b, b.b, t), mix(a.c, b.c, t), mix(a.tilt, b.tilt, t), mix(a.scale, b.scale, t));
}

// The lobe of a point as a transformed cosine.
struct Lobe {
    mat3 to_cosine;
    float scale;
    vec3 albedo;   // coverage included
    mat3 from_cosine;
    vec3 mean;   // reflectance of all of it
};

// Reflectance of light from a direction of any length.
vec3 reflectance(Point p, vec3 direction)
{
    const float cosine = dot(p.to_viewer, direction) / length(direction);
    const float away = 1 - sqrt(clamp(0.5 * (1 + cosine), 0, 1)), square = away * away;
    return p.specular + (vec3(1) - p.specular) * (square * square * away);
}

Lobe lobe_of(Point p)
{
    const float n_v = dot(p.normal, p.to_viewer);
    const float cosine = clamp(n_v, GNOMON_COSINE_LEAST_VIEW, 1.0),
                roughness = clamp(p.roughness, GNOMON_COSINE_FIRST_ROUGHNESS, 1.0), alpha = roughness * roughness;
    // Interpolate the four surrounding fits.
    const float row_at = (roughness - GNOMON_COSINE_FIRST_ROUGHNESS) / (1 - GNOMON_COSINE_FIRST_ROUGHNESS) *
                         (GNOMON_COSINE_ROWS - 1),
                column_at = (1 - sqrt(max(0, 1 - cosine))) * (GNOMON_COSINE_COLUMNS - 1);
    const uint row = min(uint(row_at), GNOMON_COSINE_ROWS - 2), column = min(uint(column_at), GNOMON_COSINE_COLUMNS - 2);
    const uint at = row * GNOMON_COSINE_COLUMNS + column;
    const float across = column_at - float(column);
    const LobeFit fit =
        mixed(mixed(lobe_fits[at], lobe_fits[at + 1], across),
              mixed(lobe_fits[at + GNOMON_COSINE_COLUMNS], lobe_fits[at + GNOMON_COSINE_COLUMNS + 1], across),
              row_at - float(row));
    // Turn to the lobe's axis: the angle of the mirror direction less the tilt.
    const float t = fit.tilt * alpha, t2 = t * t;
    const float sin_t = t * (1 - t2 / 6 * (1 - t2 / 20 * (1 - t2 / 42))),
                cos_t = 1 - t2 / 2 * (1 - t2 / 12 * (1 - t2 / 30 * (1 - t2 / 56)));
    const float sin_m = sqrt(max(0, 1 - cosine * cosine));
    const float sin_turn = sin_m * cos_t - cosine * sin_t, cos_turn = cosine * cos_t + sin_m * sin_t;
    // The surface's frame: z is the normal, and the viewer lies in the plane of x and z.
    vec3 x = p.to_viewer - n_v * p.normal;
    const float size = length(x);
    if (size > 1e-6) {
        x /= size;
    } else {
        const vec3 aside = abs(p.normal.x) < 0.5 ? vec3(1, 0, 0) : vec3(0, 1, 0);
        x = normalize(aside - dot(aside, p.normal) * p.normal);
    }
    const vec3 y = cross(p.normal, x);
    const vec3 lobe_x = cos_turn * x + sin_turn * p.normal, lobe_z = -sin_turn * x + cos_turn * p.normal;
    // Rows of the inverse of [a 0 c; 0 b 0; 0 0 1], in units of alpha, times the frame.
    Lobe lobe;
    lobe.to_cosine = transpose(mat3((lobe_x - fit.c * alpha * lobe_z) / (fit.a * alpha), y / (fit.b * alpha), lobe_z));
    lobe.scale = fit.scale;
    lobe.albedo = glossy_albedo(p) * p.coverage;
    lobe.from_cosine = inverse(lobe.to_cosine);
    const vec2 parts = albedo_parts(n_v, p.roughness);
    lobe.mean = (p.specular * parts.x + parts.y) / max(parts.x + parts.y, 1e-3);
    return lobe;
}

// What a lobe reflects of a part of what it sees: by the reflectance there and its mean.
vec3 lobe_part(Point p, Lobe lobe, float share, vec3 middle)
{
    if (!(share > 0)) return vec3(0);
    const vec3 there = mix(reflectance(p, lobe.from_cosine * (middle.z < 0 ? -middle : middle)), lobe.mean, share * share);
    return lobe.albedo * share * vec3(lobe.mean.x > 0 ? there.x / lobe.mean.x : 1, lobe.mean.y > 0 ? there.y / lobe.mean.y : 1,
                                      lobe.mean.z > 0 ? there.z / lobe.mean.z : 1);
}

struct Unshadowed {
    vec3 irradiance;   // on the shading normal's plane
    vec3 lobe;         // radiance that the lobe reflects to the viewer
};

// Adds what a part of a light brings. One loop with one call of each function, because compilers inline them.
void add_polygon(Point p, Lobe lobe, bool has_lobe, Clipped polygon, vec3 radiance, inout Unshadowed sum)
{
    // Clip at both horizons and sum; then transform to the lobe's cosine, clip at its horizon and sum.
    for (uint step = 0; step < (has_lobe ? 3 : 2); ++step) {
        if (step == 2)
            for (uint i = 0; i < polygon.count; ++i) polygon.corner[i] = lobe.to_cosine * polygon.corner[i];
        const vec3 normal = step == 0 ? p.smooth_normal : step == 1 ? p.normal : vec3(0, 0, 1);
        polygon = clip(polygon, normal);
        if (polygon.count < 3) return;
        if (step == 0) continue;
        vec3 middle;
        const float form = form_factor(polygon, normal, middle);
        if (step == 1)
            sum.irradiance += k_pi * form * radiance;
        else
            sum.lobe += lobe_part(p, lobe, min(1, lobe.scale * form), middle) * radiance;
    }
}

vec3 face_at(SizedFaceRecord face, float u, float v)
{
    if (face.corners == 3)
        return face.corner[0] + sqrt(u) * ((face.corner[1] - face.corner[0]) + v * (face.corner[2] - face.corner[1]));
    return (1 - u) * (1 - v) * face.corner[0] + u * (1 - v) * face.corner[1] + u * v * face.corner[2] +
           (1 - u) * v * face.corner[3];
}

float largest_of(vec3 v)
{
    const vec3 size = abs(v);
    return max(max(size.x, size.y), size.z);
}

// Whether a face emits towards a point, which is farther from its plane than rounding may put a point of the face.
bool emits_towards(Point p, SizedFaceRecord face)
{
    const float height = dot(face.normal, p.position - face.corner[0]);
    float largest = 0;
    for (uint k = 0; k < 4; ++k) largest = max(largest, largest_of(face.corner[k]));
    const float least = max(p.lift, GNOMON_LIFT_PER_COORDINATE * largest);
    return face.two_sided != 0 ? abs(height) > least : height > least;
}

float masking(float cosine, float a2)
{
    return 2 * cosine / (cosine + sqrt(a2 + (1 - a2) * cosine * cosine));
}

// The lobe towards one direction, times the cosine there: reflect_glossy of src/shading/glossy.cpp.
vec3 reflect_glossy(Point p, vec3 to_light, float roughness)
{
    const float n_l = dot(p.normal, to_light), n_v = dot(p.normal, p.to_viewer);
    const vec3 between = normalize(to_light + p.to_viewer);
    const float n_h = clamp(dot(p.normal, between), 0, 1), v_h = dot(p.to_viewer, between);
    const float alpha = roughness * roughness, a2 = alpha * alpha;
    const float x = 1 - clamp(v_h, 0, 1), x2 = x * x;
    const vec3 fresnel = p.specular + (vec3(1) - p.specular) * (x2 * x2 * x);
    const float d = n_h * n_h * (a2 - 1) + 1, distribution = a2 / (k_pi * d * d);
    const float v = n_l * sqrt(a2 + (1 - a2) * n_v * n_v), l = n_v * sqrt(a2 + (1 - a2) * n_l * n_l);
    const float lobe = distribution * (2 * n_v * n_l / (v + l)) / (4 * n_v);
    const vec2 parts = albedo_parts(n_v, roughness);
    const float kept = parts.x + parts.y;
    return fresnel * (vec3(1) + p.specular * ((1 - kept) / max(kept, 1e-3))) * (lobe * p.coverage);
}

bool has_cone(SizedLightRecord light)
{
    return light.cos_outer != GNOMON_NO_CONE;
}

// Leaves of a light without its cone what its places bring within the cone.
void limit_to_cone(vec3 within[2], vec3 everywhere[2], inout Unshadowed arrives)
{
    for (uint c = 0; c < 3; ++c) {
        arrives.irradiance[c] *= everywhere[0][c] > 0 ? within[0][c] / everywhere[0][c] : 0;
        arrives.lobe[c] *= everywhere[1][c] > 0 ? within[1][c] / everywhere[1][c] : 0;
    }
}

// What one place of a light brings to a point, but for the light's cone, and how much of it leaves within the cone.
// Returns false if it brings nothing.
bool place_weight(Point p, SizedLightRecord light, SizedPlaceRecord place, bool has_lobe, float roughness,
                  out vec3 irradiance, out vec3 lobe, out float share)
{
    const vec3 to_place = place.position - p.position;
    const float square = dot(to_place, to_place);
    if (!(square > 0)) return false;
    const vec3 direction = to_place / sqrt(square);
    const float cosine = dot(direction, p.normal);
    if (!(cosine > 0) || !(dot(direction, p.smooth_normal) > 0)) return false;
    const SizedFaceRecord face = sized_faces[place.face];
    const float emitted = -dot(direction, face.normal);
    if (!(face.two_sided != 0 ? abs(emitted) > 0 : emitted > 0)) return false;
    share = 1;
    if (has_cone(light)) share = share_of_cone(-dot(direction, light.cone_axis), light.cos_outer, light.cos_inner);
    const vec3 radiance = place.radiance * (abs(emitted) * place.area / square);
    irradiance = radiance * cosine;
    lobe = has_lobe ? radiance * reflect_glossy(p, direction, roughness) : vec3(0);
    return true;
}

// Light that reaches a point if nothing occludes it, of a light that is not summed over its places.
Unshadowed unshadowed(Point p, SizedLightRecord light, Lobe lobe, bool has_lobe)
{
    Unshadowed sum = Unshadowed(vec3(0), vec3(0));
    const uint parts = max(light.cells * light.cells, 1);
    const float size = 1 / float(max(light.cells, 1));
    for (uint f = 0; f < light.face_count; ++f) {
        const SizedFaceRecord face = sized_faces[light.first_face + f];
        if (!emits_towards(p, face)) continue;
        for (uint part = 0; part < parts; ++part) {
            Clipped polygon;
            polygon.count = light.cells == 0 ? face.corners : 4;
            const vec2 low = size * vec2(part % max(light.cells, 1), part / max(light.cells, 1));
            for (uint k = 0; k < 4; ++k) {
                const vec2 at = low + size * vec2(k == 1 || k == 2 ? 1 : 0, k >= 2 ? 1 : 0);
                polygon.corner[k] = (light.cells == 0 ? face.corner[k] : face_at(face, at.x, at.y)) - p.position;
            }
            const vec3 radiance = light.cells == 0 ? face.radiance : sized_cells[light.first_cell + part];
            if (radiance != vec3(0)) add_polygon(p, lobe, has_lobe, polygon, radiance, sum);
        }
    }
    return sum;
}

bool below_horizon(Point p, SizedLightRecord light)
{
    const vec3 to_centre = light.centre - p.position;
    return dot(to_centre, p.smooth_normal) < -light.radius || dot(to_centre, p.normal) < -light.radius;
}

// Whether a cluster of many faces is so distant that it is summed over its places.
bool is_distant(Point p, SizedLightRecord light, float far)
{
    return light.face_count > light.place_count && length(light.centre - p.position) > far * light.radius;
}
