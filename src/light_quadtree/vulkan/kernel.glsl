// SPDX-License-Identifier: Apache-2.0
// The light of one light at one receiver: shared by the sum over clusters and by the sampling it is compared with, and
// the twin of kernel-inl.h, operation by operation.

const float k_least_square = 1e-30;

void add_light(vec3 position, vec3 normal, float disk, vec3 power, vec3 at, vec3 facing, inout vec3 sum)
{
    const vec3 way = position - at;
    const float square = dot(way, way), there = -dot(way, normal), here = dot(way, facing);
    sum += max(there, 0) * max(here, 0) / (square * (square + disk) + k_least_square) * power;
}
