// SPDX-License-Identifier: Apache-2.0
// Bounced light at an image's surfaces, or at a list of points: sparse receivers first, then every pixel, interpolated
// from surrounding receivers that agree with it, or gathered by itself [Ki and Oh 2007, 3.3]. Same method as
// map_light.cpp. An invocation processes several pixels, so that it loads a light once for all of them. Included after
//
//     GNOMON_ACROSS, GNOMON_DOWN   an invocation's pixels
//     GNOMON_IMAGES                the binding at which images begin
//     GNOMON_ADDS                  optional: whether to add to the images' light; interpolated pixels keep theirs
//     void all_light(vec3 at[GNOMON_TOGETHER], vec3 normal[GNOMON_TOGETHER], inout vec3 sum[GNOMON_TOGETHER])

layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = GNOMON_IMAGES) uniform texture2D positions;  // w: 0 where no light is computed
layout(binding = GNOMON_IMAGES + 1) uniform texture2D normals;
layout(binding = GNOMON_IMAGES + 2, rgba32f) uniform image2D grid_position;
layout(binding = GNOMON_IMAGES + 3, rgba32f) uniform image2D grid_normal;
layout(binding = GNOMON_IMAGES + 4, rgba32f) uniform image2D grid_light;
#ifdef GNOMON_ADDS
layout(binding = GNOMON_IMAGES + 5, rgba32f) uniform image2D irradiance;
#else
layout(binding = GNOMON_IMAGES + 5, rgba32f) uniform writeonly image2D irradiance;
#endif

// The pixel at which a receiver of the grid lies; clamped to the image.
ivec2 grid_pixel(ivec2 at)
{
    return min(at * int(push.step), ivec2(push.width, push.height) - 1);
}

bool interpolate(ivec2 pixel, vec3 at, vec3 normal, out vec3 light)
{
    const ivec2 cell = pixel / int(push.step);
    const ivec2 low = grid_pixel(cell), high = grid_pixel(cell + 1);
    const vec2 part = vec2(pixel - low) / vec2(max(high - low, ivec2(1)));
    const float width = push.pixel_width + length(at - push.eye) * push.pixel_spread;
    const float most_off = push.grid_off_plane * float(push.step) * width;
    vec3 sum = vec3(0);
    float weights = 0;
    uint agree = 0;
    for (int corner = 0; corner < 4; ++corner) {
        const ivec2 step = ivec2(corner % 2, corner / 2), other = cell + step;
        if (!(dot(imageLoad(grid_normal, other).xyz, normal) > push.grid_normals)) continue;
        if (!(abs(dot(imageLoad(grid_position, other).xyz - at, normal)) < most_off)) continue;
        ++agree;
        const float weight = (step.x != 0 ? part.x : 1 - part.x) * (step.y != 0 ? part.y : 1 - part.y);
        sum += weight * imageLoad(grid_light, other).xyz;
        weights += weight;
    }
    light = sum / max(weights, 1e-30);
    return agree >= push.grid_neighbours && weights > 0;
}

void main()
{
    const bool fill_grid = push.fill_grid != 0;
    const ivec2 size = fill_grid ? ivec2(push.columns, push.rows) : textureSize(positions, 0);
    const ivec2 first = ivec2(gl_GlobalInvocationID.xy) * ivec2(GNOMON_ACROSS, GNOMON_DOWN);
    if (first.x >= size.x || first.y >= size.y) return;

    // Collect the pixels that must gather; the others get a zero normal.
    vec3 at[GNOMON_TOGETHER], normal[GNOMON_TOGETHER], light[GNOMON_TOGETHER];
    bool gathers = false, done[GNOMON_TOGETHER];
    [[unroll]] for (int i = 0; i < GNOMON_TOGETHER; ++i) {
        const ivec2 here = first + ivec2(i % GNOMON_ACROSS, i / GNOMON_ACROSS);
        at[i] = normal[i] = light[i] = vec3(0);
        done[i] = false;
        if (here.x >= size.x || here.y >= size.y) continue;
        const ivec2 pixel = fill_grid ? grid_pixel(here) : here;
        const vec4 position = texelFetch(positions, pixel, 0);
        const vec3 facing = position.w != 0 ? texelFetch(normals, pixel, 0).xyz : vec3(0);
        if (fill_grid) {
            imageStore(grid_position, here, position);
            imageStore(grid_normal, here, vec4(facing, 0));
        }
        if (position.w == 0) continue;
        if (!fill_grid && push.step != 0) {
            const int listed = int(position.w) - 1;
            const ivec2 place = push.listed != 0 ? ivec2(listed % int(push.width), listed / int(push.width)) : here;
            if (interpolate(place, position.xyz, facing, light[i])) {
                done[i] = true;
                continue;
            }
            light[i] = vec3(0);
        }
#ifdef GNOMON_ADDS
        if (GNOMON_ADDS) light[i] = (fill_grid ? imageLoad(grid_light, here) : imageLoad(irradiance, here)).xyz;
#endif
        at[i] = position.xyz, normal[i] = facing;
        gathers = true;
    }
    if (gathers) all_light(at, normal, light);

    [[unroll]] for (int i = 0; i < GNOMON_TOGETHER; ++i) {
        const ivec2 here = first + ivec2(i % GNOMON_ACROSS, i / GNOMON_ACROSS);
        if (here.x >= size.x || here.y >= size.y) continue;
#ifdef GNOMON_ADDS
        if (GNOMON_ADDS && done[i]) continue;
#endif
        if (fill_grid)
            imageStore(grid_light, here, vec4(light[i], 0));
        else
            imageStore(irradiance, here, vec4(light[i], 0));
    }
}
