// SPDX-License-Identifier: Apache-2.0
#pragma once
// From arguments to a verb and its values.

#include <filesystem>
#include <string>
#include <vector>

#include "app/option_table.h"
#include "app/option_values.h"

namespace gnomon::app {

struct CommandLine {
    const VerbInfo* verb = nullptr;   // nullptr: none was named; only --help and --version make sense then
    std::vector<std::string> positionals;
    OptionValues values{Verb::render};
    std::string command;   // the whole of it, as a shell takes it
    bool help = false;
    bool version = false;
};

/// @param arguments  without the program's name
/// @throws UsageError for unknown verbs and options (with the nearest name), and values that make no sense;
///         InputError for a --config file that is wrong
CommandLine parse_command_line(const std::vector<std::string>& arguments);

/// Sets options from a JSON object, but for those already given.
/// @throws InputError
void read_config(const std::filesystem::path& file, const VerbInfo& verb, OptionValues& values);

/// A word as a shell must be given it.
std::string shell_word(const std::string& word);

/// What --help prints. @param verb  nullptr: the program as a whole
std::string help_text(const VerbInfo* verb);

}   // namespace gnomon::app
