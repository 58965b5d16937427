// SPDX-License-Identifier: Apache-2.0
#pragma once
// Runs the program as a user would, and captures its output.

#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "sanitized.h"
#include "support.h"

namespace gnomon::test {

inline std::string bytes_of(const std::filesystem::path& file)
{
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

/// Names of all files in a folder, sorted, hidden ones included.
inline std::vector<std::string> names_in(const std::filesystem::path& folder)
{
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(folder)) names.push_back(entry.path().filename());
    std::sort(names.begin(), names.end());
    return names;
}

struct Outcome {
    int code = -1;   // exit status, or -signal
    std::string out, err;

    nlohmann::json json() const { return nlohmann::json::parse(out); }
};

using Environment = std::map<std::string, std::string>;

/// A running program; it is killed when the object is destroyed.
class RunningProgram {
 public:
    /// @param in_child  called in the new process before the program starts, for example to set limits
    explicit RunningProgram(const std::vector<std::string>& arguments, const Environment& environment = {},
                            const std::string& standard_output = {}, const std::function<void()>& in_child = {})
    {
        const std::string out = standard_output.empty() ? folder_ / "out" : std::filesystem::path(standard_output);
        const std::string err = folder_ / "err";
        std::vector<std::string> words{places::program};
        words.insert(words.end(), arguments.begin(), arguments.end());
        std::vector<char*> argv;
        for (std::string& word : words) argv.push_back(word.data());
        argv.push_back(nullptr);
        process_ = ::fork();
        if (process_ < 0) throw std::runtime_error("fork failed");
        if (process_ > 0) return;

        for (const auto& [name, value] : environment) ::setenv(name.c_str(), value.c_str(), 1);
        // Reset signals that the parent of the tests may have ignored (nohup, background jobs), because ignored signals
        // are inherited.
        for (const int signal : {SIGINT, SIGTERM, SIGHUP}) ::signal(signal, SIG_DFL);
        ::dup2(::open("/dev/null", O_RDONLY), STDIN_FILENO);
        ::dup2(::open(out.c_str(), O_WRONLY | O_CREAT | (standard_output.empty() ? O_TRUNC : 0), 0600), STDOUT_FILENO);
        ::dup2(::open(err.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600), STDERR_FILENO);
        if (in_child) in_child();
        ::execv(argv[0], argv.data());
        ::_exit(127);
    }
    ~RunningProgram()
    {
        if (process_ <= 0) return;
        ::kill(process_, SIGKILL);
        ::waitpid(process_, nullptr, 0);
    }
    RunningProgram(const RunningProgram&) = delete;
    RunningProgram& operator=(const RunningProgram&) = delete;

    void send(int signal) { ::kill(process_, signal); }
    /// @param usage  what the program took, if not null
    Outcome wait(struct rusage* usage = nullptr)
    {
        int status = 0;
        ::wait4(process_, &status, 0, usage);
        process_ = -1;
        return {WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status), bytes_of(folder_ / "out"),
                bytes_of(folder_ / "err")};
    }

 private:
    ScratchFolder folder_;
    pid_t process_ = -1;
};

inline Outcome run(const std::vector<std::string>& arguments, const Environment& environment = {})
{
    return RunningProgram(arguments, environment).wait();
}

/// Waits for a condition, at most two minutes (times k_patience): on a busy machine, a frame can take one.
template <class Condition>
bool wait_until(const Condition& condition)
{
    const auto limit = std::chrono::steady_clock::now() + std::chrono::seconds(120 * k_patience);
    while (!condition()) {
        if (std::chrono::steady_clock::now() > limit) return false;
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return true;
}

/// A failure is an exit code, one line on standard error, and nothing on standard output.
inline void expect_failure(const Outcome& outcome, int code, const std::string& about)
{
    EXPECT_EQ(outcome.code, code) << outcome.err;
    EXPECT_EQ(outcome.out, "");
    EXPECT_TRUE(outcome.err.starts_with("gnomon: ")) << outcome.err;
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
    EXPECT_NE(outcome.err.find(about), std::string::npos) << "'" << about << "' in: " << outcome.err;
}

/// Whether ffmpeg and ffprobe are available.
inline bool video_tools()
{
    return std::system("ffmpeg -version >/dev/null 2>&1") == 0;
}

}   // namespace gnomon::test
