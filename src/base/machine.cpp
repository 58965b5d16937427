// SPDX-License-Identifier: Apache-2.0
#include "base/machine.h"

#include <fstream>

#include "base/tasks.h"

namespace gnomon {

std::string processor_name()
{
    std::ifstream in("/proc/cpuinfo");
    for (std::string line; std::getline(in, line);) {
        const std::size_t colon = line.find(": ");
        if (line.starts_with("model name") && colon != std::string::npos) return line.substr(colon + 2);
    }
    return "CPU";
}

std::vector<std::pair<std::string, bool>> processor_features()
{
#if defined(__x86_64__)
    __builtin_cpu_init();
    return {{"sse4.2", __builtin_cpu_supports("sse4.2") != 0},    {"avx", __builtin_cpu_supports("avx") != 0},
            {"avx2", __builtin_cpu_supports("avx2") != 0},        {"fma", __builtin_cpu_supports("fma") != 0},
            {"avx512f", __builtin_cpu_supports("avx512f") != 0},  {"avx512dq", __builtin_cpu_supports("avx512dq") != 0},
            {"avx512vl", __builtin_cpu_supports("avx512vl") != 0}};
#else
    return {};
#endif
}

int processor_threads()
{
    return Tasks(0).threads();
}

}   // namespace gnomon
