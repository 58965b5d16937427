// SPDX-License-Identifier: Apache-2.0
#include "cli/signals.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/time.h>
#include <unistd.h>

#include <atomic>
#include <cmath>
#include <cstring>
#include <exception>
#include <new>

#include "cli/program.h"

namespace gnomon::cli {

namespace {
// Atomic, because the system may run the handler on any thread and other threads read the flag.
std::atomic<bool> g_interrupted = false, g_out_of_time = false;
static_assert(std::atomic<bool>::is_always_lock_free, "a signal handler must not take a lock");

extern "C" void note_signal(int)
{
    if (g_interrupted.exchange(true)) ::_exit(k_exit_interrupted);
}

extern "C" void note_time(int)
{
    if (!g_interrupted.exchange(true)) g_out_of_time = true;
}

// Allocates no memory, because memory may be exhausted.
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
    end_with(k_exit_internal, "gnomon: internal error: uncaught exception\n");
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
        // Keep ignoring a signal that was ignored at the start, as nohup arranges.
        struct sigaction before = {};
        if (::sigaction(signal, nullptr, &before) == 0 && before.sa_handler == SIG_IGN) continue;
        ::sigaction(signal, &action, nullptr);
    }
    for (const int signal : {SIGPIPE, SIGXFSZ}) ::signal(signal, SIG_IGN);
    ::signal(SIGCHLD, SIG_DFL);
}

void fill_standard_descriptors()
{
    // Open the root folder until all three are taken, because open() returns the lowest free number. The root folder
    // always exists, and writing to it fails.
    int descriptor = 0;
    do {
        descriptor = ::open("/", O_RDONLY | O_DIRECTORY);
    } while (descriptor >= 0 && descriptor <= STDERR_FILENO);
    if (descriptor >= 0) ::close(descriptor);
}

void start_time_limit(double seconds)
{
    struct sigaction action = {};
    action.sa_handler = note_time;
    sigemptyset(&action.sa_mask);
    ::sigaction(SIGALRM, &action, nullptr);
    struct itimerval timer = {};
    double whole = 0;
    timer.it_value.tv_usec = static_cast<suseconds_t>(1e6 * std::modf(seconds, &whole));
    timer.it_value.tv_sec = static_cast<time_t>(whole);
    if (timer.it_value.tv_sec == 0 && timer.it_value.tv_usec == 0) timer.it_value.tv_usec = 1;   // 0 would be never
    ::setitimer(ITIMER_REAL, &timer, nullptr);
}

bool out_of_time()
{
    return g_out_of_time;
}

bool interrupted()
{
    return g_interrupted;
}

}   // namespace gnomon::cli
