// SPDX-License-Identifier: Apache-2.0
#ifndef GNOMON_RAY_LIMITS_SHARED_H
#define GNOMON_RAY_LIMITS_SHARED_H
// Numbers that rays on the processor and rays in shaders agree on. src/ray/origin.h and src/ray/triangle_test.h say
// what they mean.

#define GNOMON_SHADOW_RAY_END 0.9999f
#define GNOMON_LIFT_PER_COORDINATE 2e-6f
#define GNOMON_EDGE_SLACK 1.1920929e-7f

#endif
