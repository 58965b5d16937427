// SPDX-License-Identifier: Apache-2.0
#include "io/aff/tokens.h"

#include <fmt/format.h>

#include <array>
#include <charconv>
#include <cmath>

#include "gnomon/error.h"

namespace gnomon::io {

namespace {

enum class Kind : std::uint8_t { word, blank, brace, comment };

constexpr std::array<Kind, 256> k_kinds = [] {
    std::array<Kind, 256> kinds{};
    for (const char c : {' ', '\t', '\r', '\n', '\f'}) kinds[static_cast<unsigned char>(c)] = Kind::blank;
    for (const char c : {'{', '}'}) kinds[static_cast<unsigned char>(c)] = Kind::brace;
    for (const char c : {'#', '%'}) kinds[static_cast<unsigned char>(c)] = Kind::comment;
    return kinds;
}();

Kind kind_of(char c)
{
    return k_kinds[static_cast<unsigned char>(c)];
}

constexpr std::size_t k_longest_shown = 40;   // characters of a token in a message

// Whether a number that 64-bit floats cannot represent is too large rather than too small.
bool is_too_large(std::string_view digits)
{
    long double value = 0;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    if (error == std::errc()) return std::abs(value) > 1;
    // Even long doubles cannot represent it. Decide by the sign of the exponent.
    return digits.find("e-") == std::string_view::npos && digits.find("E-") == std::string_view::npos;
}

}   // namespace

std::string utf8_from_latin1(std::string_view text)
{
    std::string result;
    result.reserve(text.size());
    for (const char c : text) {
        const auto byte = static_cast<unsigned char>(c);
        if (byte < 0x80) {
            result += c;
        } else {
            result += static_cast<char>(0xc0 | (byte >> 6));
            result += static_cast<char>(0x80 | (byte & 0x3f));
        }
    }
    return result;
}

std::string shown(const AffToken& token)
{
    if (token.text.empty()) return "the end of the file";
    std::string text(token.text.substr(0, k_longest_shown));
    for (char& c : text)
        if (c < 0x20 || c == 0x7f) c = '?';
    return fmt::format("'{}{}'", text, token.text.size() > k_longest_shown ? "..." : "");
}

void AffTokens::look()
{
    const std::string& bytes = text_->bytes;
    std::size_t at = end_;

    // Skip blanks and comments.
    for (; at < bytes.size(); ++at) {
        const Kind kind = kind_of(bytes[at]);
        if (kind == Kind::comment)
            while (at + 1 < bytes.size() && bytes[at + 1] != '\n' && bytes[at + 1] != '\r') ++at;
        else if (kind != Kind::blank)
            break;
    }

    // Take a single brace, or everything up to the next separator.
    std::size_t end = at;
    if (end < bytes.size() && kind_of(bytes[end]) == Kind::brace)
        ++end;
    else
        while (end < bytes.size() && kind_of(bytes[end]) == Kind::word) ++end;
    next_ = {std::string_view(bytes).substr(at, end - at), at};
    end_ = end;
}

AffToken AffTokens::take()
{
    const AffToken token = next_;
    look();
    return token;
}

void AffTokens::move_to(std::size_t offset)
{
    end_ = offset;
    look();
}

void AffTokens::fail(const AffToken& token, const std::string& what) const
{
    std::size_t line = 1, start = 0;
    for (std::size_t i = 0; i < token.offset; ++i) {
        const char c = text_->bytes[i];
        const bool crlf = c == '\r' && i + 1 < text_->bytes.size() && text_->bytes[i + 1] == '\n';
        if (c == '\n' || (c == '\r' && !crlf)) ++line, start = i + 1;
    }
    throw InputError(text_->shown_as, fmt::format("{}:{}", line, token.offset - start + 1), what);
}

double AffTokens::number(std::string_view meaning)
{
    const AffToken token = take();
    const char* const end = token.text.data() + token.text.size();
    const char* begin = token.text.data();
    if (token.text.size() > 1 && token.text[0] == '+' && token.text[1] != '-') ++begin;

    double value = 0;
    const auto [stop, error] = std::from_chars(begin, end, value);
    if (error == std::errc::result_out_of_range && stop == end && !is_too_large({begin, end})) return 0;
    if (error == std::errc::invalid_argument || stop != end)
        fail(token, fmt::format("expected {}, found {}", meaning, shown(token)));
    if (error != std::errc() || !(std::abs(value) <= k_aff_largest_number))
        fail(token, fmt::format("{} {} is not a usable number", meaning, shown(token)));
    return value;
}

std::int64_t AffTokens::integer(std::string_view meaning, std::int64_t low, std::int64_t high)
{
    const AffToken token = take();
    const char* const end = token.text.data() + token.text.size();
    const char* begin = token.text.data();
    if (token.text.size() > 1 && token.text[0] == '+' && token.text[1] != '-') ++begin;

    std::int64_t value = 0;
    const auto [stop, error] = std::from_chars(begin, end, value);
    if (error == std::errc::invalid_argument || stop != end)
        fail(token, fmt::format("expected {} (a whole number), found {}", meaning, shown(token)));
    if (error != std::errc() || value < low || value > high)
        fail(token, fmt::format("{} {} is not in the range {} to {}", meaning, shown(token), low, high));
    return value;
}

std::size_t AffTokens::count(std::string_view meaning, std::size_t least, std::size_t tokens_each)
{
    const AffToken token = next_;
    const std::int64_t value = integer(meaning, 0, std::int64_t{1} << 40);
    if (static_cast<std::size_t>(value) < least)
        fail(token, fmt::format("{} {} is less than {}", meaning, value, least));
    // A token and its separator take two bytes, except for the last in a file.
    if (static_cast<std::size_t>(value) > (bytes_left() + 1) / (2 * tokens_each))
        fail(token, fmt::format("{} {} is more than the file can hold", meaning, value));
    return static_cast<std::size_t>(value);
}

AffToken AffTokens::word(std::string_view meaning)
{
    const AffToken token = take();
    if (token.text.empty() || token.text == "{" || token.text == "}")
        fail(token, fmt::format("expected {}, found {}", meaning, shown(token)));
    return token;
}

void AffTokens::expect(std::string_view keyword)
{
    const AffToken token = take();
    if (token.text != keyword) fail(token, fmt::format("expected '{}', found {}", keyword, shown(token)));
}

bool AffTokens::number_follows() const
{
    if (at_end()) return false;
    const char c = next_.text[0];
    return (c >= '0' && c <= '9') || c == '-' || c == '+' || c == '.';
}

}   // namespace gnomon::io
