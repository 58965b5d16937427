// SPDX-License-Identifier: Apache-2.0
#include "cli/signals.h"

#include <fcntl.h>
#include <signal.h>
#include <unistd.h>

#include <atomic>
#include <cstring>
#include <exception>
#include <new>

#include "cli/program.h"

namespace gnomon::cli {

namespace {
// The system may run the handler on any thread: what is volatile alone would be a race with those that ask.
std::atomic<bool> g_interrupted = false;
static_assert(std::atomic<bool>::is_always_lock_free, "a handler may not wait");

extern "C" void note_signal(int)
{
    if (g_interrupted.exchange(true)) ::_exit(k_exit_interrupted);
}

// Takes no memory: there may be none.
[[noreturn]] void end_with(int code, const char* line)
{
    [[maybe_unused]] const ssize_t written = ::write(STDERR_FILENO, line, std::strlen(line));
    ::_exit(code);
}

[[noreturn]] void note_end()
{
    try {
        if (const std::exception_ptr error = std::current_exception()) std::rethrow_exception(error);
    } catch (const std::bad_alloc&) {
        end_with(k_exit_missing, "gnomon: out of memory\n");
    } catch (...) {
    }
    end_with(k_exit_internal, "gnomon: internal error: an exception where none may be\n");
}
}   // namespace

void install_terminate_handler()
{
    std::set_terminate(note_end);
}

void install_signal_handlers()
{
    struct sigaction action = {};
    action.sa_handler = note_signal;
    sigemptyset(&action.sa_mask);
    for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
        // What was ignored at the start (nohup) stays ignored.
        struct sigaction before = {};
        if (::sigaction(signal, nullptr, &before) == 0 && before.sa_handler == SIG_IGN) continue;
        ::sigaction(signal, &action, nullptr);
    }
    for (const int signal : {SIGPIPE, SIGXFSZ}) ::signal(signal, SIG_IGN);
    ::signal(SIGCHLD, SIG_DFL);
}

void fill_standard_descriptors()
{
    // The lowest free number is given first. A folder is always there, and what is written to it is refused.
    int descriptor = 0;
    do {
        descriptor = ::open("/", O_RDONLY | O_DIRECTORY);
    } while (descriptor >= 0 && descriptor <= STDERR_FILENO);
    if (descriptor >= 0) ::close(descriptor);
}

bool interrupted()
{
    return g_interrupted;
}

}   // namespace gnomon::cli
