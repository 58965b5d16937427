// SPDX-License-Identifier: Apache-2.0
#pragma once
// Runs the program: parses the arguments, runs a subcommand and turns errors into messages and exit codes.

#include <string>
#include <vector>

namespace gnomon::cli {

inline constexpr int k_exit_done = 0;
inline constexpr int k_exit_different = 1;   // a comparison or check failed
inline constexpr int k_exit_usage = 2;       // invalid arguments
inline constexpr int k_exit_input = 3;       // invalid input file
inline constexpr int k_exit_missing = 4;     // a device, driver, ffmpeg or disk space is missing
inline constexpr int k_exit_internal = 5;    // a bug in this program
inline constexpr int k_exit_interrupted = 130;

/// Runs one subcommand and returns its exit code. Every failure is reported in one line on standard error.
/// @param arguments  without the program's name
int run_program(const std::vector<std::string>& arguments);

}   // namespace gnomon::cli
