// SPDX-License-Identifier: Apache-2.0
#include "base/instruction_set.h"

namespace gnomon {

std::string instruction_set()
{
#if defined(__x86_64__)
    // Embree and Highway both choose the widest set of which the processor has all parts.
    __builtin_cpu_init();
    const bool avx2 = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") &&
                      __builtin_cpu_supports("bmi") && __builtin_cpu_supports("bmi2");
    if (avx2 && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
        __builtin_cpu_supports("avx512cd") && __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512vl"))
        return "avx512";
    if (avx2) return "avx2";
    return __builtin_cpu_supports("avx") ? "avx" : "sse4.2";
#else
    return "generic";
#endif
}

}   // namespace gnomon
