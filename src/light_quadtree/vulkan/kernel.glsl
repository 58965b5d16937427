// SPDX-License-Identifier: Apache-2.0
// The irradiance by one light at one receiver, for the sum over clusters and for the sampling to which it is compared.
// The same operations as kernel-inl.h.

const float k_least_square = 1e-30;

void add_light(vec3 position, vec3 normal, float disk, vec3 power, vec3 at, vec3 facing, inout vec3 sum)
{
    const vec3 way = position - at;
    const float square = dot(way, way), there = -dot(way, normal), here = dot(way, facing);
    sum += max(there, 0) * max(here, 0) / (square * (square + disk) + k_least_square) * power;
}
