// SPDX-License-Identifier: Apache-2.0
#pragma once
// Where a subcommand's words go: text for people, one JSON document for programs, progress for the patient.
//
// With --json, standard output carries the document and nothing else; text goes to standard error. The document is
// written last, when all else has worked.

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

    /// One line of text, unless --quiet.
    void say(std::string_view line);
    /// The same, with -v alone.
    void detail(std::string_view line);
    /// "warning: ...", on standard error, unless --quiet.
    void warn(std::string_view line);

    /// One line on standard error, even with --quiet.
    void error(std::string_view line);

    /// Shows the way and listens to signals. Lives as long as this.
    Progress progress();

    /// Writes the document, if one was asked for, and makes sure that all text has arrived.
    /// @throws MissingError
    void finish(const nlohmann::ordered_json& document);

 private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

/// All of it, or MissingError with the reason.
void write_standard_output(std::string_view text);

/// Largest memory this process has held, in bytes.
std::uint64_t peak_memory_bytes();

}   // namespace gnomon::cli
