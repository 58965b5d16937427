// SPDX-License-Identifier: Apache-2.0
// Adds light to the image. A pixel's weight has two parts: xyz of what the image shows of a surface, and w of what counts
// as lying behind the scene (RasterFrame::backdrop_apart). The image keeps the luminance of the latter in w.
#include "base/luminance_shared.h"

vec4 weighted(vec4 weight, vec3 radiance)
{
    const vec3 luminance = vec3(GNOMON_LUMINANCE_RED, GNOMON_LUMINANCE_GREEN, GNOMON_LUMINANCE_BLUE);
    return vec4(weight.xyz * radiance, weight.w * dot(luminance, radiance));
}
