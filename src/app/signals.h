// SPDX-License-Identifier: Apache-2.0
#pragma once
// Ctrl-C and friends, and ends that nobody planned. The first signal asks the work to stop in an orderly way (progress
// then returns false); a second one ends the program at once.

namespace gnomon::app {

/// SIGINT, SIGTERM and SIGHUP ask to stop; SIGPIPE and SIGXFSZ are ignored, so that a closed pipe and a file at
/// its limit are write errors.
void install_signal_handlers();

/// What nothing can catch, such as memory refused inside a destructor of a library, ends with its exit code and one
/// line too.
void install_terminate_handler();

/// Whether one of them came.
bool interrupted();

}   // namespace gnomon::app
