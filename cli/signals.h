// SPDX-License-Identifier: Apache-2.0
#pragma once
// Handles signals, uncaught exceptions and closed standard descriptors. After the first signal the progress callback
// returns false, so that the work stops in an orderly way; a second signal ends the program at once.

namespace gnomon::cli {

/// SIGINT, SIGTERM and SIGHUP request a stop. SIGPIPE and SIGXFSZ are ignored, so that a closed pipe and a file at its
/// size limit become write errors. SIGCHLD is reset to its default, because the parent may have ignored it and we wait
/// for the programs that we start.
void install_signal_handlers();

/// Makes uncaught exceptions, such as a failed allocation in a library's destructor, end the program with one line and
/// an exit code, too.
void install_terminate_handler();

/// Opens those of standard input, output and error that the process was started without. Otherwise the next file opened
/// would get such a descriptor and receive the text written to it.
void fill_standard_descriptors();

/// Requests a stop after some time, as a signal does.
void start_time_limit(double seconds);

/// Whether a stop was requested.
bool interrupted();
/// Whether it was the limit of time that requested it.
bool out_of_time();

}   // namespace gnomon::cli
