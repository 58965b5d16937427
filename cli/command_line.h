// SPDX-License-Identifier: Apache-2.0
#pragma once
// The command-line parser: turns arguments into a subcommand, its positional arguments and the values of its options.

#include <filesystem>
#include <string>
#include <vector>

#include "options/option_table.h"
#include "options/option_values.h"

namespace gnomon::cli {

struct CommandLine {
    const options::SubcommandInfo* subcommand =
        nullptr;   // nullptr if none was named, which is valid only with --help and --version
    std::vector<std::string> positionals;
    options::OptionValues values{options::Subcommand::render};
    std::string command;   // the whole command line, quoted for a shell
    bool help = false;
    bool version = false;
};

/// @param arguments  without the program's name
/// @throws UsageError for unknown subcommands and options (the message names the nearest one), and for invalid values;
///         InputError for an invalid --config file
CommandLine parse_command_line(const std::vector<std::string>& arguments);

/// Sets the options that `values` does not hold yet from the JSON object in `file`.
/// @throws InputError
void read_config(const std::filesystem::path& file, const options::SubcommandInfo& subcommand,
                 options::OptionValues& values);

/// The text that --help prints. @param subcommand  nullptr: the overview of the program
std::string help_text(const options::SubcommandInfo* subcommand);

}   // namespace gnomon::cli
