// SPDX-License-Identifier: Apache-2.0
// As scene::EmissionCone::share().

/// @param cosine  between the direction and the cone's axis
float share_of_cone(float cosine, float cos_outer, float cos_inner)
{
    if (cosine <= cos_outer) return 0;
    const float fade = clamp((cosine - cos_outer) / max(cos_inner - cos_outer, 1e-4), 0, 1);
    return cosine * fade * fade * (3 - 2 * fade);
}
