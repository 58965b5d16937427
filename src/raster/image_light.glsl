// SPDX-License-Identifier: Apache-2.0
// Light as it is added to the image: to its colour, or to its fourth component, which says how much is seen of what lies
// behind the scene (RasterFrame::backdrop_apart).

// Luminance, as in base/math.h.
float seen_of(vec3 part)
{
    return dot(part, vec3(0.2126, 0.7152, 0.0722));
}

vec4 image_light(vec3 light, bool behind)
{
    return behind ? vec4(0, 0, 0, seen_of(light)) : vec4(light, 0);
}
