// SPDX-License-Identifier: Apache-2.0
#include "io/aff_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

#include "gnomon/error.h"

namespace gnomon::io {

namespace {
constexpr std::size_t k_longest_shown = 40;

bool is_blank(std::uint8_t c)
{
    return c == ' ' || c == '\t' || c == '\r' || c == '\n' || c == '\f' || c == '\v';
}
bool is_brace(std::uint8_t c)
{
    return c == '{' || c == '}';
}
bool starts_comment(std::uint8_t c)
{
    return c == '#' || c == '%';
}
}   // namespace

AffText::AffText(std::vector<std::uint8_t> bytes, std::string shown_as)
    : bytes_(std::move(bytes)), shown_as_(std::move(shown_as))
{
}

void AffText::skip_blanks()
{
    while (at_ < bytes_.size()) {
        if (is_blank(bytes_[at_])) {
            ++at_;
        } else if (starts_comment(bytes_[at_])) {
            while (at_ < bytes_.size() && bytes_[at_] != '\n' && bytes_[at_] != '\r') ++at_;
        } else {
            return;
        }
    }
}

std::string_view AffText::next()
{
    skip_blanks();
    token_at_ = at_;
    if (at_ >= bytes_.size()) return {};
    if (is_brace(bytes_[at_]))
        ++at_;
    else
        while (at_ < bytes_.size() && !is_blank(bytes_[at_]) && !is_brace(bytes_[at_]) && !starts_comment(bytes_[at_]))
            ++at_;
    return {reinterpret_cast<const char*>(bytes_.data()) + token_at_, at_ - token_at_};
}

std::string_view AffText::peek()
{
    const std::size_t at = at_, token_at = token_at_;
    const std::string_view token = next();
    at_ = at, token_at_ = token_at;
    return token;
}

bool AffText::number_next()
{
    const std::string_view token = peek();
    return !token.empty() && (std::isdigit(static_cast<unsigned char>(token[0])) || token[0] == '-' ||
                              token[0] == '+' || token[0] == '.');
}

std::string AffText::found(std::string_view token) const
{
    if (token.empty()) return "the end of the file";
    return fmt::format("'{}{}'", token.substr(0, k_longest_shown), token.size() > k_longest_shown ? "..." : "");
}

void AffText::expect(std::string_view word)
{
    const std::string_view token = next();
    if (token != word) fail(fmt::format("expected '{}', found {}", word, found(token)));
}

double AffText::number(std::string_view what)
{
    std::string_view token = next();
    const std::string_view whole = token;
    if (!token.empty() && token[0] == '+') token.remove_prefix(1);
    double value = 0;
    const auto [end, error] = std::from_chars(token.data(), token.data() + token.size(), value);
    if (token.empty() || end != token.data() + token.size() ||
        (error != std::errc() && error != std::errc::result_out_of_range))
        fail(fmt::format("expected a number ({}), found {}", what, found(whole)));
    // What single precision cannot hold is no coordinate.
    if (error == std::errc::result_out_of_range || !std::isfinite(static_cast<float>(value)))
        fail(fmt::format("{} is not a finite number: {}", what, found(whole)));
    return value;
}

glm::dvec3 AffText::vector(std::string_view what)
{
    glm::dvec3 v;
    for (int c = 0; c < 3; ++c) v[c] = number(what);
    return v;
}

long long AffText::integer(std::string_view what, long long least, long long most)
{
    std::string_view token = next();
    const std::string_view whole = token;
    if (!token.empty() && token[0] == '+') token.remove_prefix(1);
    long long value = 0;
    const auto [end, error] = std::from_chars(token.data(), token.data() + token.size(), value);
    if (token.empty() || end != token.data() + token.size() || error == std::errc::invalid_argument)
        fail(fmt::format("expected a whole number ({}), found {}", what, found(whole)));
    if (error != std::errc() || value < least || value > most)
        fail(fmt::format("{} is {}, not in {} to {}", what, found(whole), least, most));
    return value;
}

std::size_t AffText::count(std::string_view what, std::size_t least, std::size_t bytes_each)
{
    const long long value = integer(what, 0, std::numeric_limits<long long>::max());
    const auto n = static_cast<std::size_t>(value);
    if (n < least) fail(fmt::format("{} is {}, at least {} are needed", what, n, least));
    // Checked before anything is allocated for them.
    if (n > (bytes_.size() - at_) / bytes_each + 1)
        fail(fmt::format("{} is {}, more than the rest of the file can hold", what, n));
    return n;
}

std::string AffText::name(std::string_view what)
{
    const std::string_view token = next();
    if (token.empty() || token == "{" || token == "}") fail(fmt::format("expected {}, found {}", what, found(token)));
    return std::string(token);
}

void AffText::fail(const std::string& problem) const
{
    // Count lines only now: nobody needs them otherwise.
    std::size_t line = 1, column = 1;
    for (std::size_t i = 0; i < std::min(token_at_, bytes_.size()); ++i) {
        const bool line_end =
            bytes_[i] == '\n' || (bytes_[i] == '\r' && (i + 1 >= bytes_.size() || bytes_[i + 1] != '\n'));
        line_end ? (++line, column = 1) : ++column;
    }
    throw InputError(shown_as_, fmt::format("{}:{}", line, column), problem);
}

}   // namespace gnomon::io
