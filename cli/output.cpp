// SPDX-License-Identifier: Apache-2.0
#include "cli/output.h"

#include <fmt/format.h>
#include <sys/resource.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <nlohmann/json.hpp>
#include <optional>

#include "base/one_line.h"
#include "cli/progress_line.h"
#include "cli/signals.h"
#include "gnomon/error.h"
#include "io/file/atomic_file.h"

namespace gnomon::cli {

struct Output::Impl {
    bool quiet = false, verbose = false;
    bool json_to_standard_output = false;
    std::optional<io::AtomicFile> json_file;
    ProgressLine progress;

    explicit Impl(bool be_quiet) : quiet(be_quiet), progress(be_quiet) {}
};

Output::Output(const options::OptionValues& values) : impl_(std::make_unique<Impl>(values.flag("quiet")))
{
    impl_->verbose = values.flag("verbose");
    const std::string json = values.text("json");
    if (json == "-") impl_->json_to_standard_output = true;
    // Open the file before the work, so that a name that cannot be written fails at once.
    if (!json.empty() && json != "-") impl_->json_file.emplace(json);
}

Output::~Output() = default;

void Output::say(std::string_view line)
{
    if (impl_->quiet) return;
    impl_->progress.clear();
    const std::string text = fmt::format("{}\n", line);
    if (impl_->json_to_standard_output)
        std::fputs(text.c_str(), stderr);
    else
        write_standard_output(text);
}

void Output::detail(std::string_view line)
{
    if (impl_->verbose) say(line);
}

void Output::warn(std::string_view line)
{
    if (impl_->quiet) return;
    impl_->progress.clear();
    std::fputs(fmt::format("warning: {}\n", one_line(std::string(line))).c_str(), stderr);
}

void Output::error(std::string_view line)
{
    impl_->progress.clear();
    std::fputs(fmt::format("gnomon: {}\n", one_line(std::string(line))).c_str(), stderr);
}

Progress Output::progress()
{
    return [inside = impl_.get()](const ProgressStep& step) {
        inside->progress.show(step);
        return !interrupted();
    };
}

void Output::finish(const nlohmann::ordered_json& document)
{
    impl_->progress.clear();
    if (!impl_->json_to_standard_output && !impl_->json_file) return;
    // Replace bytes that are not valid UTF-8, because names in scene files may contain any.
    const std::string text = document.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
    if (impl_->json_to_standard_output) write_standard_output(text);
    if (impl_->json_file) {
        impl_->json_file->write(text);
        impl_->json_file->commit();
    }
}

void write_standard_output(std::string_view text)
{
    if (std::fwrite(text.data(), 1, text.size(), stdout) != text.size() || std::fflush(stdout) != 0)
        throw MissingError(fmt::format("cannot write to standard output: {}", std::strerror(errno)));
}

std::uint64_t peak_memory_bytes()
{
    rusage usage{};
    ::getrusage(RUSAGE_SELF, &usage);
    return static_cast<std::uint64_t>(usage.ru_maxrss) * 1024;   // Linux reports kilobytes
}

}   // namespace gnomon::cli
