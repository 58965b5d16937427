// SPDX-License-Identifier: Apache-2.0
#pragma once
// Every subcommand and every option, as data: the command line, --config, --help, and whatever else speaks of options
// are made from these two tables and from nothing else.

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "gnomon/ranges.h"

namespace gnomon::options {

enum class Subcommand : std::uint8_t {
    render,
    view,
    info,
    compare,
    devices,
    bench_trace,
    bench_culling,
    bench_shadow_textures,
    bench_indirect,
    bench_all,
};

struct SubcommandInfo {
    Subcommand subcommand;
    std::string_view name;        // "render", "bench trace"
    std::string_view arguments;   // as --help shows them
    int positionals;              // how many arguments that are no options
    std::string_view summary;
    bool built;
};

enum class Kind : std::uint8_t {
    flag,
    optional_file,    // a flag that may name a file: --json or --json=FILE
    integer,          // in `range`
    number,           // in `range`
    number_or_auto,   // a number, or the word auto
    text,
    choice,   // one of `choices`
    size,     // WxH
    range,    // A-B
    chunk,    // I/N
};

struct Option {
    std::string_view name{};       // without dashes
    char letter = 0;               // the short form, if there is one
    std::string_view argument{};   // as --help shows it; empty for flags
    Kind kind = Kind::flag;
    std::string_view fallback{};        // the default, as it would be typed; empty: none, or said in `help`
    std::string_view choices{};         // "a|b|c"; of text: how values of a list begin, up to a colon
    std::string_view built_choices{};   // those of them that are built, if not all
    Range range{};                      // of numbers, and of the sides of a size
    bool repeats = false;
    bool built = true;
    std::uint32_t subcommands = 0;   // set of bit(Subcommand)
    std::string_view group{};
    std::string_view help{};
};

constexpr std::uint32_t bit(Subcommand subcommand)
{
    return 1u << static_cast<unsigned>(subcommand);
}

std::span<const SubcommandInfo> subcommands();
/// In the order in which --help shows them; a subcommand's options of one group stand together.
std::span<const Option> options();

/// nullptr if there is none.
const SubcommandInfo* find_subcommand(std::string_view name);
/// @param name  without dashes
const Option* find_option(Subcommand subcommand, std::string_view name);

/// The value must be what the option wants, and built.
/// @throws UsageError in one line that says what was expected
void check_value(const Option& option, const std::string& value);

/// The word most like `word`, or empty if none is near: for "did you mean".
std::string nearest(std::string_view word, std::span<const std::string> words);

}   // namespace gnomon::options
