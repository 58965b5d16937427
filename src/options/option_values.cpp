// SPDX-License-Identifier: Apache-2.0
#include "options/option_values.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "base/check.h"
#include "gnomon/ranges.h"

namespace gnomon::options {

namespace {
template <class T>
std::optional<T> parse_whole(std::string_view word)
{
    T value{};
    if (word.starts_with('+')) word.remove_prefix(1);
    const char* end = word.data() + word.size();
    const auto [stop, error] = std::from_chars(word.data(), end, value);
    if (error != std::errc() || stop != end || word.empty()) return std::nullopt;
    return value;
}

// Parses two positive integers with a separator between them.
std::optional<std::pair<int, int>> parse_pair(std::string_view word, std::string_view separators)
{
    const std::size_t at = word.find_first_of(separators);
    if (at == std::string_view::npos) return std::nullopt;
    const auto a = parse_whole<int>(word.substr(0, at)), b = parse_whole<int>(word.substr(at + 1));
    if (!a || !b || *a < 1 || *b < 1) return std::nullopt;
    return std::pair{*a, *b};
}

bool among(std::string_view word, std::string_view choices)
{
    while (!choices.empty()) {
        const std::size_t end = std::min(choices.find('|'), choices.size());
        if (choices.substr(0, end) == word) return true;
        choices.remove_prefix(std::min(end + 1, choices.size()));
    }
    return false;
}

// Describes the values that an option accepts, for the end of an error message; empty if the value is valid.
std::string expectation(const Option& option, const std::string& value)
{
    const auto within = [&](double v) { return option.range.contains(v); };
    switch (option.kind) {
        case Kind::flag:
        case Kind::optional_file:
            return {};
        case Kind::text:
            return value.empty() ? fmt::format("expected {}", option.argument) : std::string();
        case Kind::integer_or_all:
        case Kind::integer_or_auto:
            if (value == (option.kind == Kind::integer_or_all ? "all" : "auto")) return {};
            [[fallthrough]];
        case Kind::integer: {
            const auto v = parse_integer(value);
            if (v && within(static_cast<double>(*v))) return {};
            return fmt::format("expected {}a whole number from {} to {}",
                               option.kind == Kind::integer_or_all    ? "all or "
                               : option.kind == Kind::integer_or_auto ? "auto or "
                                                                      : "",
                               option.range.low, option.range.high);
        }
        case Kind::rate: {
            const auto v = parse_rate(value);
            if (v && within(*v)) return {};
            return fmt::format("expected a number from {} to {}, or a fraction such as 24000/1001", option.range.low,
                               option.range.high);
        }
        case Kind::number_or_auto:
            if (value == "auto" || among(value, option.choices)) return {};
            [[fallthrough]];
        case Kind::number: {
            const auto v = parse_number(value);
            if (v && within(*v)) return {};
            const std::string words = !option.choices.empty() ? fmt::format("auto, {} or ", listed(option.choices))
                                      : option.kind == Kind::number_or_auto ? "auto or "
                                                                            : "";
            return fmt::format("expected {}a number from {} to {}", words, option.range.low, option.range.high);
        }
        case Kind::choice:
            return among(value, option.choices) ? std::string() : "expected " + listed(option.choices);
        case Kind::size: {
            const auto v = parse_size(value);
            if (v && within(v->width) && within(v->height)) return {};
            return fmt::format("expected WxH, {} to {} a side", option.range.low, option.range.high);
        }
        case Kind::range:
            return parse_range(value) ? std::string() : "expected A-B with 1 <= A <= B";
        case Kind::chunk:
            return parse_chunk(value) ? std::string() : "expected I/N with 1 <= I <= N, or frames A-B";
    }
    return {};
}
}   // namespace

std::string listed(std::string_view choices)
{
    std::string text(choices);
    const std::size_t last = text.rfind('|');
    if (last != std::string::npos) text.replace(last, 1, " or ");
    for (std::size_t at = 0; (at = text.find('|', at)) != std::string::npos;) text.replace(at, 1, ", ");
    return text;
}

std::optional<double> parse_number(std::string_view word)
{
    const auto value = parse_whole<double>(word);
    return value && std::isfinite(*value) ? value : std::nullopt;
}

std::optional<double> parse_rate(std::string_view word)
{
    const std::size_t slash = word.find('/');
    if (slash == std::string_view::npos) return parse_number(word);
    const auto above = parse_integer(word.substr(0, slash)), below = parse_integer(word.substr(slash + 1));
    if (!above || !below || *above < 1 || *below < 1) return std::nullopt;
    return static_cast<double>(*above) / static_cast<double>(*below);
}

std::optional<long long> parse_integer(std::string_view word)
{
    return parse_whole<long long>(word);
}

std::optional<Size> parse_size(std::string_view word)
{
    const auto pair = parse_pair(word, "xX");
    return pair ? std::optional(Size{pair->first, pair->second}) : std::nullopt;
}

std::optional<FrameRange> parse_range(std::string_view word)
{
    if (const auto one = parse_whole<int>(word); one && *one >= 1) return FrameRange{*one, *one};
    const auto pair = parse_pair(word, "-");
    if (!pair || pair->first > pair->second) return std::nullopt;
    return FrameRange{pair->first, pair->second};
}

std::optional<Chunk> parse_chunk(std::string_view word)
{
    if (const auto range = parse_pair(word, "-"); range && range->first <= range->second)
        return Chunk{.frames = FrameRange{range->first, range->second}};
    const auto pair = parse_pair(word, "/");
    if (!pair || pair->first > pair->second) return std::nullopt;
    return Chunk{pair->first, pair->second};
}

void check_value(const Option& option, const std::string& value)
{
    const std::string shown =
        option.kind == Kind::flag ? fmt::format("--{}", option.name) : fmt::format("--{} {}", option.name, value);
    if (!option.built) throw UsageError(fmt::format("--{}: not built yet", option.name));
    if (const std::string expected = expectation(option, value); !expected.empty())
        throw UsageError(fmt::format("{}: {}", shown, expected));
    if (!option.built_choices.empty() && !among(value, option.built_choices))
        throw UsageError(fmt::format("{}: not built yet; built: {}", shown, listed(option.built_choices)));
}

std::string nearest(std::string_view word, std::span<const std::string> words)
{
    // Levenshtein's distance, one row at a time; a third of the word may differ.
    std::size_t best = std::max<std::size_t>(1, word.size() / 3) + 1;
    std::string found;
    for (const std::string& candidate : words) {
        std::vector<std::size_t> row(candidate.size() + 1);
        for (std::size_t j = 0; j < row.size(); ++j) row[j] = j;
        for (std::size_t i = 0; i < word.size(); ++i) {
            std::size_t diagonal = row[0];
            row[0] = i + 1;
            for (std::size_t j = 0; j < candidate.size(); ++j) {
                const std::size_t change = diagonal + (word[i] != candidate[j]);
                diagonal = row[j + 1];
                row[j + 1] = std::min({change, diagonal + 1, row[j] + 1});
            }
        }
        if (row.back() < best) best = row.back(), found = candidate;
    }
    return found;
}

void OptionValues::set(const Option& option, std::vector<std::string> values)
{
    if (values.size() > 1 && !option.repeats && option.kind != Kind::flag)
        throw UsageError(fmt::format("--{}: given {} times", option.name, values.size()));
    for (const std::string& value : values) check_value(option, value);
    values_[std::string(option.name)] = std::move(values);
}

void OptionValues::set_default(std::string_view name, std::string value)
{
    const Option* option = find_option(subcommand_, name);
    if (!option) throw InternalError(fmt::format("the subcommand has no option '{}'", name));
    check_value(*option, value);
    defaults_[std::string(name)] = std::move(value);
}

void OptionValues::unset(const Option& option)
{
    values_.erase(std::string(option.name));
}

bool OptionValues::given(std::string_view name) const
{
    const Option* option = find_option(subcommand_, name);
    if (!option) throw InternalError(fmt::format("the subcommand has no option '{}'", name));
    return values_.find(name) != values_.end();
}

std::string OptionValues::text(std::string_view name) const
{
    if (given(name)) return values_.find(name)->second.back();
    const auto other = defaults_.find(name);
    return other != defaults_.end() ? other->second : std::string(find_option(subcommand_, name)->fallback);
}

std::vector<std::string> OptionValues::all(std::string_view name) const
{
    return given(name) ? values_.find(name)->second : std::vector<std::string>();
}

int OptionValues::integer(std::string_view name) const
{
    const std::string word = text(name);
    if (word == "all") return static_cast<int>(ranges::reference_bounces.high);
    const auto value = parse_integer(word);
    GNOMON_CHECK(value.has_value());
    return static_cast<int>(*value);
}

void OptionValues::check_choices(std::string_view name, std::string_view choices) const
{
    const Option* option = find_option(subcommand_, name);
    if (!option || option->kind != Kind::choice || option->choices != choices)
        throw InternalError(fmt::format("the choices of --{} are '{}' in the table of options, and '{}' by its type",
                                        name, option ? option->choices : "", choices));
}

double OptionValues::number(std::string_view name) const
{
    const auto value = parse_rate(text(name));
    GNOMON_CHECK(value.has_value());
    return *value;
}

std::string shell_word(const std::string& word)
{
    constexpr std::string_view k_plain = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789%+,-./:=@_";
    if (!word.empty() && word.find_first_not_of(k_plain) == std::string::npos) return word;
    std::string text = "'";
    for (const char c : word) c == '\'' ? text += "'\\''" : text += c;
    return text + "'";
}

}   // namespace gnomon::options
