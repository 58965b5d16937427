// SPDX-License-Identifier: Apache-2.0
#pragma once
// Runs another program with an argument vector (no shell) and feeds its standard input.
//
// The standard input is a socket, so writing to a program that has died is an error and never a signal. Its output is
// kept in memory. It has its own process group: Ctrl-C reaches only us, and we end it.

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

namespace gnomon::video {

class Process {
 public:
    /// Called from time to time while waiting; return false to stop, which throws InterruptedError.
    using KeepWaiting = std::function<bool()>;

    /// @param arguments  the program, looked up in PATH, then its arguments
    /// @throws MissingError  it cannot be started
    explicit Process(const std::vector<std::string>& arguments);
    /// Kills the program if it is still running.
    ~Process();
    Process(const Process&) = delete;
    Process& operator=(const Process&) = delete;

    /// Feeds bytes; returns false if the program has stopped reading.
    bool write(std::span<const std::uint8_t> bytes, const KeepWaiting& keep_waiting = {});
    void close_input();
    /// Closes the input and waits for the program to end. Returns its exit status, or -signal.
    int wait(const KeepWaiting& keep_waiting = {});

    std::string output() const { return text_of(output_); }
    std::string errors() const { return text_of(errors_); }

 private:
    static std::string text_of(int descriptor);

    int process_ = -1;
    int input_ = -1, output_ = -1, errors_ = -1;
};

}   // namespace gnomon::video
