// SPDX-License-Identifier: Apache-2.0
#pragma once
// The values of a subcommand's options: what was given, else the default of the table.

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "gnomon/types.h"
#include "options/enum_names.h"
#include "options/option_table.h"

namespace gnomon::options {

/// Words that stand for values; nothing if they do not.
std::optional<double> parse_number(std::string_view word);
std::optional<long long> parse_integer(std::string_view word);
std::optional<Size> parse_size(std::string_view word);          // WxH
std::optional<FrameRange> parse_range(std::string_view word);   // A-B, or A alone
/// A word as a shell must be given it.
std::string shell_word(const std::string& word);

struct Chunk {
    int number = 1, of = 1;
};
std::optional<Chunk> parse_chunk(std::string_view word);   // I/N

/// Asking for a name that the subcommand does not have is a bug of ours (InternalError).
class OptionValues {
 public:
    explicit OptionValues(Subcommand subcommand) : subcommand_(subcommand) {}

    /// Checks and keeps; a later call replaces an earlier one.
    /// @throws UsageError
    void set(const Option& option, std::vector<std::string> values);

    /// Back to the default.
    void unset(const Option& option);

    bool given(std::string_view name) const;
    bool flag(std::string_view name) const { return given(name); }
    /// The last one given, else the default; empty if there is neither.
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
};

}   // namespace gnomon::options
