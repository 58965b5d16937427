// SPDX-License-Identifier: Apache-2.0
#pragma once
// The program: arguments in, exit code out.

#include <string>
#include <vector>

namespace gnomon::cli {

inline constexpr int k_exit_done = 0;
inline constexpr int k_exit_different = 1;   // a comparison or check failed
inline constexpr int k_exit_usage = 2;       // wrong usage
inline constexpr int k_exit_input = 3;       // bad input file
inline constexpr int k_exit_missing = 4;     // a device, driver, ffmpeg, disk
inline constexpr int k_exit_internal = 5;    // a bug of ours
inline constexpr int k_exit_interrupted = 130;

/// Runs one subcommand. Every failure is one line on standard error.
/// @param arguments  without the program's name
int run_program(const std::vector<std::string>& arguments);

}   // namespace gnomon::cli
