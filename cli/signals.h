// SPDX-License-Identifier: Apache-2.0
#pragma once
// Ctrl-C and friends, ends that nobody planned, and what a process is born with. The first signal asks the work to stop
// in an orderly way (progress then returns false); a second one ends the program at once.

namespace gnomon::cli {

/// SIGINT, SIGTERM and SIGHUP ask to stop; SIGPIPE and SIGXFSZ are ignored, so that a closed pipe and a file at
/// its limit are write errors. SIGCHLD is the usual one, whatever the parent made of it: a program that we run is
/// waited for.
void install_signal_handlers();

/// What nothing can catch, such as memory refused inside a destructor of a library, ends with its exit code and one
/// line too.
void install_terminate_handler();

/// Where a process was started with standard input, output or error closed, takes their places: else the next file that
/// is opened would get the number, and the text meant for it.
void fill_standard_descriptors();

/// Whether one of them came.
bool interrupted();

}   // namespace gnomon::cli
