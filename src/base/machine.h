// SPDX-License-Identifier: Apache-2.0
#pragma once
// The processor's name, instruction sets and number of threads.

#include <string>
#include <utility>
#include <vector>

namespace gnomon {

/// The name that the processor reports; "CPU" if it reports none.
std::string processor_name();
/// Instruction sets that affect the speed of ray tracing, and whether the processor has them.
std::vector<std::pair<std::string, bool>> processor_features();
/// The number of threads that an option of 0 selects.
int processor_threads();

}   // namespace gnomon
