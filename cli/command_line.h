// SPDX-License-Identifier: Apache-2.0
#pragma once
// From arguments to a subcommand and its values.

#include <filesystem>
#include <string>
#include <vector>

#include "options/option_table.h"
#include "options/option_values.h"

namespace gnomon::cli {

struct CommandLine {
    const options::SubcommandInfo* subcommand =
        nullptr;   // nullptr: none was named; only --help and --version make sense then
    std::vector<std::string> positionals;
    options::OptionValues values{options::Subcommand::render};
    std::string command;   // the whole of it, as a shell takes it
    bool help = false;
    bool version = false;
};

/// @param arguments  without the program's name
/// @throws UsageError for unknown subcommands and options (with the nearest name), and values that make no sense;
///         InputError for a --config file that is wrong
CommandLine parse_command_line(const std::vector<std::string>& arguments);

/// Sets options from a JSON object, but for those already given.
/// @throws InputError
void read_config(const std::filesystem::path& file, const options::SubcommandInfo& subcommand,
                 options::OptionValues& values);

/// What --help prints. @param subcommand  nullptr: the program as a whole
std::string help_text(const options::SubcommandInfo* subcommand);

}   // namespace gnomon::cli
