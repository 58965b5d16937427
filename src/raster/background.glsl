// SPDX-License-Identifier: Apache-2.0
// Radiance of the background, by the formulas of src/scene/light.cpp and environment.cpp. The including shader declares
// `frame` (RasterFrame) and `environment` (texels).
#include "scene/light_shared.h"

vec3 environment_texel(int column, int row)
{
    const int width = int(frame.environment_width), height = int(frame.environment_height);
    return texelFetch(environment, clamp(row, 0, height - 1) * width + ((column % width) + width) % width).xyz;
}

vec3 background_radiance(vec3 direction)
{
    if (frame.background == GNOMON_BACKGROUND_COLOR) return frame.background_color;
    if (frame.background == GNOMON_BACKGROUND_IMAGE) {
        const float pi = 3.14159265358979;
        const float u = 0.5 + atan(direction.x, -direction.z) / (2 * pi);
        const float v = acos(clamp(direction.y, -1, 1)) / pi;
        const float x = u * float(frame.environment_width) - 0.5, y = v * float(frame.environment_height) - 0.5;
        const int c = int(floor(x)), r = int(floor(y));
        return mix(mix(environment_texel(c, r), environment_texel(c + 1, r), x - floor(x)),
                   mix(environment_texel(c, r + 1), environment_texel(c + 1, r + 1), x - floor(x)), y - floor(y));
    }
    const float y = clamp(direction.y, -1, 1);
    vec3 result = y >= 0 ? mix(frame.horizon, frame.zenith, sqrt(y))
                         : mix(frame.horizon, frame.ground, min(1, -y / GNOMON_SKY_HAZE_DEPTH));
    if (frame.sun_radiance != vec3(0)) {
        const float cosine = dot(direction, frame.sun_direction);
        if (cosine > GNOMON_SUN_DISC)
            result += frame.sun_radiance;
        else if (cosine > 0)
            result += GNOMON_SUN_GLOW * frame.horizon * pow(cosine, GNOMON_SUN_GLOW_POWER);
    }
    return result;
}

vec3 background_ambient(vec3 n)
{
    if (frame.background == GNOMON_BACKGROUND_COLOR) return vec3(0);
    if (frame.background == GNOMON_BACKGROUND_IMAGE) {
        const float b[9] = {0.282095, 0.488603 * n.y, 0.488603 * n.z, 0.488603 * n.x, 1.092548 * n.x * n.y,
                            1.092548 * n.y * n.z, 0.315392 * (3 * n.z * n.z - 1), 1.092548 * n.x * n.z,
                            0.546274 * (n.x * n.x - n.y * n.y)};
        vec3 sum = vec3(0);
        for (int i = 0; i < 9; ++i) sum += b[i] * frame.harmonics[i];
        return max(sum, vec3(0));
    }
    const vec3 sky = 0.5 * (frame.zenith + frame.horizon);
    return mix(frame.ground, sky, 0.5 + 0.5 * clamp(n.y, -1, 1));
}
