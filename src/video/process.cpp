// SPDX-License-Identifier: Apache-2.0
#include "video/process.h"

#include <fmt/format.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>

#include "gnomon/error.h"

extern char** environ;

namespace gnomon::video {

namespace {
constexpr int k_ask_every_ms = 100;          // interval of calls of keep_waiting while the program does not read
constexpr long k_wait_step_ns = 5'000'000;   // interval of checks whether the program has ended

void close_and_forget(int& descriptor)
{
    if (descriptor >= 0) ::close(descriptor);
    descriptor = -1;
}

// Reset signals that this process ignores or blocks to their defaults, because the program would inherit them.
void reset_signals(posix_spawnattr_t& attributes)
{
    sigset_t none, usual;
    sigemptyset(&none);
    sigemptyset(&usual);
    for (const int signal : {SIGPIPE, SIGXFSZ, SIGINT, SIGTERM, SIGHUP}) sigaddset(&usual, signal);
    posix_spawnattr_setsigmask(&attributes, &none);
    posix_spawnattr_setsigdefault(&attributes, &usual);
    posix_spawnattr_setpgroup(&attributes, 0);
    posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETPGROUP);
}
}   // namespace

Process::Process(const std::vector<std::string>& arguments)
{
    int pair[2] = {-1, -1};
    // Create files in memory for the output, and a socket for the input.
    output_ = ::memfd_create("output", MFD_CLOEXEC);
    errors_ = ::memfd_create("errors", MFD_CLOEXEC);
    int error = errno;
    if (output_ >= 0 && errors_ >= 0) {
        error = ::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, pair) == 0 ? 0 : errno;
        if (error == 0) {
            // Start the program with these as its standard streams.
            posix_spawn_file_actions_t actions;
            posix_spawnattr_t attributes;
            posix_spawn_file_actions_init(&actions);
            posix_spawnattr_init(&attributes);
            posix_spawn_file_actions_adddup2(&actions, pair[1], STDIN_FILENO);
            posix_spawn_file_actions_adddup2(&actions, output_, STDOUT_FILENO);
            posix_spawn_file_actions_adddup2(&actions, errors_, STDERR_FILENO);
            reset_signals(attributes);
            std::vector<char*> argv;
            for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
            argv.push_back(nullptr);
            pid_t process = -1;
            error = ::posix_spawnp(&process, argv[0], &actions, &attributes, argv.data(), environ);
            if (error == 0) process_ = process;
            posix_spawn_file_actions_destroy(&actions);
            posix_spawnattr_destroy(&attributes);
        }
    }
    close_and_forget(pair[1]);
    input_ = pair[0];
    // On failure, close everything.
    if (process_ >= 0) return;
    close_and_forget(input_);
    close_and_forget(output_);
    close_and_forget(errors_);
    throw MissingError(fmt::format("cannot run {}: {}", arguments[0], std::strerror(error)));
}

Process::~Process()
{
    if (process_ >= 0) {
        ::kill(process_, SIGKILL);
        while (::waitpid(process_, nullptr, 0) < 0 && errno == EINTR) {
        }
    }
    close_and_forget(input_);
    close_and_forget(output_);
    close_and_forget(errors_);
}

bool Process::write(std::span<const std::uint8_t> bytes, const KeepWaiting& keep_waiting)
{
    while (!bytes.empty()) {
        const ssize_t n = ::send(input_, bytes.data(), bytes.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
        if (n > 0) {
            bytes = bytes.subspan(static_cast<std::size_t>(n));
        } else if (errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR) {
            if (keep_waiting && !keep_waiting()) throw InterruptedError("interrupted");
            pollfd room{input_, POLLOUT, 0};
            ::poll(&room, 1, k_ask_every_ms);
        } else {
            return false;
        }
    }
    return true;
}

void Process::close_input()
{
    close_and_forget(input_);
}

int Process::wait(const KeepWaiting& keep_waiting)
{
    close_input();
    for (;;) {
        int status = 0;
        const pid_t ended = ::waitpid(process_, &status, WNOHANG);
        if (ended == process_) {
            process_ = -1;
            return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
        }
        if (ended < 0 && errno != EINTR) {
            process_ = -1;   // the process was already reaped, e.g. because the embedding program ignores SIGCHLD
            throw MissingError(fmt::format("cannot wait for a program that was started: {}", std::strerror(errno)));
        }
        if (keep_waiting && !keep_waiting()) throw InterruptedError("interrupted");
        const timespec step{0, k_wait_step_ns};
        ::nanosleep(&step, nullptr);
    }
}

std::string Process::text_of(int descriptor)
{
    std::string text;
    std::array<char, 4096> part{};
    for (off_t at = 0;;) {
        const ssize_t n = ::pread(descriptor, part.data(), part.size(), at);
        if (n <= 0) return text;
        text.append(part.data(), static_cast<std::size_t>(n));
        at += n;
    }
}

}   // namespace gnomon::video
