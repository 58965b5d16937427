// SPDX-License-Identifier: Apache-2.0
#pragma once
// Another program, run with an argument vector (no shell), fed through its standard input.
//
// Its standard input is a socket, so that writing to a program that has died is an error and never a signal. What it
// prints is kept in memory. It has a process group of its own: Ctrl-C reaches us, and we end it.

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

namespace gnomon::video {

class Process {
 public:
    /// Asked now and then while waiting; false: stop waiting, InterruptedError.
    using GoOn = std::function<bool()>;

    /// @param arguments  the program, looked up in PATH, then its arguments
    /// @throws MissingError if it cannot be started
    explicit Process(const std::vector<std::string>& arguments);
    /// Kills the program if it still runs.
    ~Process();
    Process(const Process&) = delete;
    Process& operator=(const Process&) = delete;

    /// Feeds bytes; false if the program does not listen any more.
    bool write(std::span<const std::uint8_t> bytes, const GoOn& go_on = {});
    void close_input();
    /// Closes the input and waits for the end: the exit status, or -signal.
    int wait(const GoOn& go_on = {});

    std::string output() const { return text_of(output_); }
    std::string errors() const { return text_of(errors_); }

 private:
    static std::string text_of(int descriptor);

    int process_ = -1;
    int input_ = -1, output_ = -1, errors_ = -1;
};

}   // namespace gnomon::video
