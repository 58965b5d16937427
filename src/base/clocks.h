// SPDX-License-Identifier: Apache-2.0
#pragma once
// Clocks of benches, in milliseconds; only differences mean anything.

#include <chrono>
#include <ctime>

namespace gnomon {

inline double clock_ms(clockid_t clock)
{
    timespec t{};
    clock_gettime(clock, &t);
    return 1e3 * static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_nsec);
}

/// Processor time of all threads of this process.
inline double cpu_ms()
{
    return clock_ms(CLOCK_PROCESS_CPUTIME_ID);
}

/// Processor time of the calling thread.
inline double thread_cpu_ms()
{
    return clock_ms(CLOCK_THREAD_CPUTIME_ID);
}

inline double wall_ms()
{
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

}   // namespace gnomon
