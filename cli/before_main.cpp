// SPDX-License-Identifier: Apache-2.0
// Ends the program with a clear message on a processor that lacks the instructions that it is compiled for, before any
// of them is used. Compiled without them (CMakeLists.txt), and with system calls of the C library alone.

#if defined(__x86_64__)

#include <cpuid.h>
#include <unistd.h>

namespace {

constexpr int k_exit_missing = 4;
constexpr char k_message[] = "gnomon: this processor lacks SSE4.2, which every x86-64 processor since 2009 has\n";

// Bits of CPUID, leaf 1, register ECX: SSE3, SSSE3, CMPXCHG16B, SSE4.1, SSE4.2, POPCNT, which x86-64-v2 is made of.
constexpr unsigned k_needed = 1u << 0 | 1u << 9 | 1u << 13 | 1u << 19 | 1u << 20 | 1u << 23;

void check_processor()
{
    unsigned a = 0, b = 0, c = 0, d = 0;
    if (__get_cpuid(1, &a, &b, &c, &d) != 0 && (c & k_needed) == k_needed) return;
    if (write(STDERR_FILENO, k_message, sizeof k_message - 1) < 0) _exit(k_exit_missing);
    _exit(k_exit_missing);
}

// The dynamic linker calls what this section lists before any constructor of the program.
__attribute__((section(".preinit_array"), used)) void (*check_first)() = &check_processor;

}   // namespace

#endif
