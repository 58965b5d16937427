// SPDX-License-Identifier: Apache-2.0
#pragma once
// Loads a glTF file in a process of its own, with limits on time and memory, so that a hostile file cannot affect the
// test.

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <string>

#include "gnomon/error.h"
#include "io/load.h"
#include "sanitized.h"

namespace gnomon::test {

struct Outcome {
    enum class Kind { loaded, refused, other_error, died } kind = Kind::died;
    std::string what;   // text of the exception
    std::string file, place;
    int signal = 0;   // the signal that ended it; SIGALRM, SIGXCPU: took too long
    std::size_t warnings = 0;
    long peak_kib = 0;   // peak memory of the process
};

/// Runs a function that loads a scene, and returns the number of its warnings, in a process of its own. Allows some
/// seconds and 512 MiB of address space (unlimited memory with a sanitizer).
template <class Load>
Outcome run_in_child(const Load& load, rlim_t seconds = 10 * k_patience)
{
    constexpr rlim_t bytes = 512ull << 20;
    int pipe_ends[2];
    if (pipe(pipe_ends) != 0) throw std::runtime_error("pipe failed");
    const pid_t child = fork();
    if (child < 0) throw std::runtime_error("fork failed");
    if (child == 0) {
        close(pipe_ends[0]);
        const rlimit time{seconds, seconds}, memory{bytes, bytes};
        setrlimit(RLIMIT_CPU, &time);
        if (!k_sanitized) setrlimit(RLIMIT_AS, &memory);
        alarm(static_cast<unsigned>(12 * seconds));   // by the clock, if it sleeps: a busy machine takes longer
        std::string answer;
        try {
            answer = "L" + std::to_string(load());
        } catch (const InputError& error) {
            answer = "R" + error.file() + '\n' + error.place() + '\n' + error.what();
        } catch (const std::exception& error) {
            answer = std::string("O") + error.what();
        }
        const ssize_t written = write(pipe_ends[1], answer.data(), answer.size());
        _exit(written == static_cast<ssize_t>(answer.size()) ? 0 : 1);
    }
    close(pipe_ends[1]);
    std::string answer;
    char buffer[4096];
    for (ssize_t got; (got = read(pipe_ends[0], buffer, sizeof buffer)) > 0;)
        answer.append(buffer, static_cast<std::size_t>(got));
    close(pipe_ends[0]);
    int status = 0;
    rusage usage{};
    wait4(child, &status, 0, &usage);

    Outcome outcome;
    outcome.peak_kib = usage.ru_maxrss;
    if (WIFSIGNALED(status)) outcome.signal = WTERMSIG(status);
    if (!WIFEXITED(status) || WEXITSTATUS(status) != 0 || answer.empty()) return outcome;
    const std::string rest = answer.substr(1);
    if (answer[0] == 'L') {
        outcome.kind = Outcome::Kind::loaded;
        outcome.warnings = std::stoul(rest);
    } else if (answer[0] == 'R') {
        outcome.kind = Outcome::Kind::refused;
        const auto first = rest.find('\n'), second = rest.find('\n', first + 1);
        outcome.file = rest.substr(0, first);
        outcome.place = rest.substr(first + 1, second - first - 1);
        outcome.what = rest.substr(second + 1);
    } else {
        outcome.kind = Outcome::Kind::other_error;
        outcome.what = rest;
    }
    return outcome;
}

/// Allows 10 seconds, or 200 with a sanitizer.
inline Outcome load_in_child(const std::filesystem::path& file, bool strict = false)
{
    return run_in_child([&] { return io::load_gltf(file, {}, {.strict = strict}).warnings.size(); });
}

}   // namespace gnomon::test
