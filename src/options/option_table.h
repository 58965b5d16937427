// SPDX-License-Identifier: Apache-2.0
#pragma once
// Tables of all subcommands and options. The command line, --config, --help and the manual are generated from these two
// tables only.

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "gnomon/ranges.h"

namespace gnomon::options {

enum class Subcommand : std::uint8_t {
    render,
    join,
    view,
    info,
    compare,
    devices,
    serve,
    bench_trace,
    bench_culling,
    bench_shadow_textures,
    bench_indirect,
    bench_lights,
    bench_all,
};

struct SubcommandInfo {
    Subcommand subcommand;
    std::string_view name;        // "render", "bench trace"
    std::string_view arguments;   // as shown by --help
    int positionals;              // number of arguments that are not options
    std::string_view summary;
    bool built;
};

enum class Kind : std::uint8_t {
    flag,
    optional_file,     // a flag with an optional file: --json or --json=FILE
    integer,           // in `range`
    number,            // in `range`
    rate,              // a number in `range`, or a fraction A/B
    number_or_auto,    // a number, the word auto, or one of `choices`
    integer_or_auto,   // in `range`, or the word auto
    integer_or_all,    // in `range`, or the word all, which is its end
    text,
    choice,   // one of `choices`
    size,     // WxH
    range,    // A-B
    chunk,    // I/N, or frames A-B
};

struct Option {
    std::string_view name{};       // without dashes
    char letter = 0;               // the short form; 0: none
    std::string_view argument{};   // as shown by --help; empty for flags
    Kind kind = Kind::flag;
    std::string_view fallback{};        // the default, as it would be typed; empty: none, or described in `help`
    std::string_view choices{};         // "a|b|c"; of text: prefixes of the values in a list, up to a colon
    std::string_view built_choices{};   // the choices that are built; empty: all
    Range range{};                      // of numbers, and of the sides of a size
    bool repeats = false;
    bool built = true;
    std::uint32_t subcommands = 0;   // set of bit(Subcommand) that accept it
    std::string_view group{};
    std::string_view help{};
};

constexpr std::uint32_t bit(Subcommand subcommand)
{
    return 1u << static_cast<unsigned>(subcommand);
}

std::span<const SubcommandInfo> subcommands();
/// In the order of --help; a subcommand's options of one group are adjacent.
std::span<const Option> options();

/// Returns nullptr if there is none.
const SubcommandInfo* find_subcommand(std::string_view name);
/// @param name  without dashes
const Option* find_option(Subcommand subcommand, std::string_view name);

/// Checks that the value is valid for the option and built.
/// @throws UsageError in one line that says what was expected
void check_value(const Option& option, const std::string& value);

/// The word most similar to `word`, or empty if none is close: for "did you mean".
std::string nearest(std::string_view word, std::span<const std::string> words);

}   // namespace gnomon::options
