// SPDX-License-Identifier: Apache-2.0
// The light at a point, as in src/scene/light.cpp. Included after gpu_scene/gpu_scene_shared.h.

#include "scene/light_shared.h"

const float k_most_irradiance = GNOMON_MOST_IRRADIANCE, k_least_square = GNOMON_LEAST_SQUARE;

// Computes the unoccluded light at a point. Returns false if there is none.
bool illuminate(GpuLight light, vec3 point, out vec3 to_light, out vec3 irradiance)
{
    if (light.shown == 0) return false;
    if (light.type == GNOMON_LIGHT_DIRECTIONAL) {
        to_light = -light.direction;
        irradiance = min(light.color, vec3(k_most_irradiance));
        return true;
    }
    const vec3 offset = light.position - point;
    const float square = dot(offset, offset);
    if (!(square > 0)) return false;
    to_light = offset / sqrt(square);
    float strength = light.constant_falloff != 0 ? 1 : 1 / max(square, k_least_square);
    if (light.range > 0) {
        const float ratio = square / (light.range * light.range);
        strength *= clamp(1 - ratio * ratio, 0, 1);
    }
    if (light.type == GNOMON_LIGHT_SPOT) {
        const float cosine = -dot(to_light, light.direction);
        if (cosine <= light.cos_outer) return false;
        if (light.profile == GNOMON_SPOT_COSINE) {
            strength *= cosine;
        } else {
            const float fade =
                clamp((cosine - light.cos_outer) / max(light.cos_inner - light.cos_outer, 1e-4), 0, 1);
            strength *= light.profile == GNOMON_SPOT_SMOOTH ? fade * fade : cosine * fade * fade * (3 - 2 * fade);
        }
    }
    irradiance = min(light.color * strength, vec3(k_most_irradiance));
    return true;
}
