// SPDX-License-Identifier: Apache-2.0
#include "app/signals.h"

#include <signal.h>
#include <unistd.h>

#include "app/program.h"

namespace gnomon::app {

namespace {
volatile sig_atomic_t g_interrupted = 0;

extern "C" void note_signal(int)
{
    if (g_interrupted) ::_exit(k_exit_interrupted);
    g_interrupted = 1;
}
}   // namespace

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
    ::signal(SIGPIPE, SIG_IGN);
}

bool interrupted()
{
    return g_interrupted != 0;
}

}   // namespace gnomon::app
