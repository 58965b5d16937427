// SPDX-License-Identifier: Apache-2.0
#pragma once
// Ctrl-C and friends. The first signal asks the work to stop in an orderly way (progress then returns false); a second
// one ends the program at once.

namespace gnomon::app {

/// SIGINT, SIGTERM and SIGHUP ask to stop; SIGPIPE is ignored, so that a closed pipe is a write error.
void install_signal_handlers();

/// Whether one of them came.
bool interrupted();

}   // namespace gnomon::app
