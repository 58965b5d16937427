// SPDX-License-Identifier: Apache-2.0
#pragma once
// What the processor is and can do.

#include <string>
#include <utility>
#include <vector>

namespace gnomon {

/// As the processor calls itself; "CPU" if it does not say.
std::string processor_name();
/// Instruction sets that matter to tracing, and whether they are there.
std::vector<std::pair<std::string, bool>> processor_features();
/// How many threads 0 stands for.
int processor_threads();

}   // namespace gnomon
