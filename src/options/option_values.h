// SPDX-License-Identifier: Apache-2.0
#pragma once
// The values of a subcommand's options: as given, else the table's defaults.

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "gnomon/types.h"
#include "options/enum_names.h"
#include "options/option_table.h"

namespace gnomon::options {

/// Parse words as values; return nothing if they are invalid.
std::optional<double> parse_number(std::string_view word);
/// A number, or a fraction of two whole numbers above 0: 24000/1001.
std::optional<double> parse_rate(std::string_view word);
std::optional<long long> parse_integer(std::string_view word);
std::optional<Size> parse_size(std::string_view word);          // WxH
std::optional<FrameRange> parse_range(std::string_view word);   // A-B, or A alone
/// Quotes a word for a shell where necessary.
std::string shell_word(const std::string& word);

/// A part of a range by its number, or by its frames.
struct Chunk {
    int number = 1, of = 1;
    std::optional<FrameRange> frames{};
};
std::optional<Chunk> parse_chunk(std::string_view word);   // I/N, or frames A-B

/// Asking for an option that the subcommand does not have is an internal error (InternalError).
class OptionValues {
 public:
    explicit OptionValues(Subcommand subcommand) : subcommand_(subcommand) {}

    /// Checks and stores values; a later call replaces an earlier one.
    /// @throws UsageError
    void set(const Option& option, std::vector<std::string> values);

    /// Replaces the default of the table; the option does not count as given.
    /// @throws UsageError     the value is invalid
    /// @throws InternalError  the subcommand has no such option
    void set_default(std::string_view name, std::string value);

    /// Resets the option to its default.
    void unset(const Option& option);

    bool given(std::string_view name) const;
    bool flag(std::string_view name) const { return given(name); }
    /// The last value given, else the default; empty if there is neither.
    std::string text(std::string_view name) const;
    std::vector<std::string> all(std::string_view name) const;
    int integer(std::string_view name) const;
    double number(std::string_view name) const;
    /// An option whose choices are an enum's.
    /// @throws InternalError  if the option's choices are not those of E
    template <class E>
    E choice(std::string_view name) const
    {
        check_choices(name, k_choices<E>);
        return parse_enum<E>(name, text(name));
    }

 private:
    void check_choices(std::string_view name, std::string_view choices) const;

    Subcommand subcommand_;
    std::map<std::string, std::vector<std::string>, std::less<>> values_;
    std::map<std::string, std::string, std::less<>> defaults_;   // in place of the table's
};

}   // namespace gnomon::options
