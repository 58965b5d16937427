// SPDX-License-Identifier: Apache-2.0
#pragma once
// The output of a subcommand: lines of text, one JSON document and the progress of long work.
//
// With --json, standard output carries the document and nothing else, and text goes to standard error. The document is
// written last, after everything else has succeeded.

#include <nlohmann/json_fwd.hpp>

#include <memory>
#include <string>
#include <string_view>

#include "gnomon/types.h"
#include "options/option_values.h"

namespace gnomon::cli {

class ProgressLine;

class Output {
 public:
    /// @throws MissingError if the file of --json=FILE cannot be written
    explicit Output(const options::OptionValues& values);
    ~Output();

    /// Prints one line of text, unless --quiet.
    void say(std::string_view line);
    /// Prints one line of text with -v only.
    void detail(std::string_view line);
    /// Prints "warning: ..." on standard error, unless --quiet.
    void warn(std::string_view line);

    /// Prints one line on standard error, even with --quiet.
    void error(std::string_view line);

    /// A callback that shows progress and returns false after a signal. Valid as long as this object.
    Progress progress();

    /// Writes the document if --json was given.
    /// @throws MissingError
    void finish(const nlohmann::ordered_json& document);

 private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

/// Writes all of the text and flushes. @throws MissingError  with the reason
void write_standard_output(std::string_view text);

/// Peak resident memory of this process, in bytes.
std::uint64_t peak_memory_bytes();

}   // namespace gnomon::cli
