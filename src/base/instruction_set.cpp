// SPDX-License-Identifier: Apache-2.0
#include "base/instruction_set.h"

#include <fmt/format.h>
#include <hwy/targets.h>

#include <array>
#include <cstdlib>

#include "gnomon/error.h"

namespace gnomon {

namespace {

constexpr std::array<std::string_view, 4> k_names = {"sse4.2", "avx", "avx2", "avx512"};
constexpr const char* k_variable = "GNOMON_ISA";

InstructionSet of_processor()
{
#if defined(__x86_64__)
    __builtin_cpu_init();
    // Embree's code for AVX-512 needs all of these.
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512cd") &&
        __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512vl"))
        return InstructionSet::avx512;
    if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) return InstructionSet::avx2;
    if (__builtin_cpu_supports("avx")) return InstructionSet::avx;
#endif
    return InstructionSet::sse42;
}

// Keeps vectorised loops from later instruction sets.
void limit_loops(InstructionSet set)
{
#if defined(__x86_64__)
    std::int64_t later = 0;
    if (set < InstructionSet::avx512) later |= HWY_AVX3 | HWY_AVX3_DL;
    if (set < InstructionSet::avx2) later |= HWY_AVX2;
    hwy::DisableTargets(later);
#else
    static_cast<void>(set);
#endif
}

InstructionSet choose()
{
    const InstructionSet best = of_processor();
    const char* const wanted = std::getenv(k_variable);
    if (!wanted || !*wanted) return best;
    for (std::size_t i = 0; i < k_names.size(); ++i) {
        if (wanted != k_names[i]) continue;
        const auto set = static_cast<InstructionSet>(i);
        if (set > best)
            throw MissingError(fmt::format("{}={}: this processor lacks that instruction set; it has {}", k_variable,
                                           wanted, name_of(best)));
        limit_loops(set);
        return set;
    }
    throw UsageError(fmt::format("{}={}: not an instruction set; use sse4.2, avx, avx2 or avx512", k_variable, wanted));
}

}   // namespace

std::string_view name_of(InstructionSet set)
{
    return k_names[static_cast<std::size_t>(set)];
}

InstructionSet instruction_set()
{
    static const InstructionSet chosen = choose();
    return chosen;
}

std::string_view instruction_set_name()
{
    return name_of(instruction_set());
}

bool instruction_set_is_limited()
{
    return instruction_set() < of_processor();
}

}   // namespace gnomon
