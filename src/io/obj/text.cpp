// SPDX-License-Identifier: Apache-2.0
#include "io/obj/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>

#include "gnomon/error.h"

namespace gnomon::io {

namespace {

// The number that a word is.
// @return an empty error code, invalid_argument or result_out_of_range
std::errc parse_number(std::string_view word, float& value)
{
    if (word.starts_with('+')) {
        word.remove_prefix(1);
        if (word.starts_with('-')) return std::errc::invalid_argument;
    }
    double wide = 0;
    const auto [stop, error] = std::from_chars(word.data(), word.data() + word.size(), wide);
    if (error == std::errc::invalid_argument || stop != word.data() + word.size()) return std::errc::invalid_argument;
    if (error == std::errc::result_out_of_range) {
        // A number too small for a double is zero; one too large is an error. The latter has no negative exponent.
        const std::size_t exponent = word.find_first_of("eE");
        const bool tiny = exponent != std::string_view::npos && word.substr(exponent + 1).starts_with('-');
        if (!tiny) return error;
        wide = 0;
    }
    if (!std::isfinite(wide)) return std::errc::invalid_argument;
    if (std::abs(wide) > static_cast<double>(std::numeric_limits<float>::max())) return std::errc::result_out_of_range;
    value = static_cast<float>(wide);
    return {};
}

// A word with one comma as a number with a point; empty where it has none, or has a point.
std::string with_point(std::string_view word)
{
    const std::size_t comma = word.find(',');
    if (comma == std::string_view::npos || word.find_first_of(",.", comma + 1) != std::string_view::npos ||
        word.substr(0, comma).find('.') != std::string_view::npos)
        return {};
    std::string result(word);
    result[comma] = '.';
    return result;
}

}   // namespace

std::string shown(std::string_view text)
{
    constexpr std::size_t longest = 60;
    std::string result(text.substr(0, longest));
    for (char& c : result)
        if (c < ' ' || c > '~') c = '?';
    if (text.size() > longest) result += "...";
    return result;
}

ObjText::ObjText(std::string file, std::string_view text, bool decimal_commas)
    : file_(std::move(file)),
      begin_(text.data()),
      end_(text.data() + text.size()),
      at_(begin_),
      line_begin_(begin_),
      decimal_commas_(decimal_commas)
{
    if (text.find('\n') == std::string_view::npos) line_end_ = '\r';
    if (text.starts_with("\xef\xbb\xbf")) at_ = line_begin_ = begin_ + 3;   // a byte order mark
    if (const std::size_t zero = text.find('\0'); zero != std::string_view::npos)
        throw InputError(file_, fmt::format("byte {}", zero), "contains a zero byte: not a text file");
}

std::size_t ObjText::continuation(const char* p) const
{
    if (p == end_ || *p != '\\') return 0;
    if (end_ - p >= 2 && p[1] == line_end_) return 2;
    if (end_ - p >= 3 && p[1] == '\r' && p[2] == '\n') return 3;
    return 0;
}

bool ObjText::ends_line(const char* p) const
{
    return p == end_ || *p == line_end_;
}

void ObjText::skip_blanks()
{
    while (at_ != end_) {
        if (is_blank(*at_)) {
            ++at_;
        } else if (const std::size_t length = continuation(at_)) {
            at_ += length;
            ++line_;
            line_begin_ = at_;
        } else {
            return;
        }
    }
}

std::string_view ObjText::next_statement()
{
    // Skip the rest of the statement, including continued lines.
    while (impl_ && !ends_line(at_)) {
        const std::size_t length = continuation(at_);
        at_ += std::max<std::size_t>(length, 1);
        if (length) ++line_, line_begin_ = at_;
    }
    impl_ = true;

    // Skip empty lines and comments; a comment cannot be continued.
    while (true) {
        skip_blanks();
        if (at_ == end_) return {};
        if (*at_ == line_end_) {
            ++at_, ++line_;
            line_begin_ = at_;
            continue;
        }
        if (*at_ != '#') return word();
        while (!ends_line(at_)) ++at_;
    }
}

std::string_view ObjText::word()
{
    skip_blanks();
    word_line_ = line_;
    word_column_ = static_cast<std::size_t>(at_ - line_begin_) + 1;
    const char* const start = at_;
    while (!ends_line(at_) && !is_blank(*at_) && !continuation(at_)) ++at_;
    return {start, static_cast<std::size_t>(at_ - start)};
}

bool ObjText::at_end()
{
    skip_blanks();
    return ends_line(at_) || *at_ == '#';
}

std::string ObjText::rest()
{
    std::string result;
    for (std::string_view first = word(); !first.empty();) {
        result += first;
        // Keep blanks inside a name.
        const char* const blank = at_;
        skip_blanks();
        if (ends_line(at_)) break;
        const std::string_view between(blank, static_cast<std::size_t>(at_ - blank));
        result += between.find(line_end_) == std::string_view::npos ? between : std::string_view(" ");
        const char* const start = at_;
        while (!ends_line(at_) && !is_blank(*at_) && !continuation(at_)) ++at_;
        first = {start, static_cast<std::size_t>(at_ - start)};
    }
    return result;
}

ObjText::Parsed ObjText::parse(std::string_view word, float& value)
{
    std::errc error = parse_number(word, value);
    if (error == std::errc::invalid_argument && decimal_commas_) {
        const std::string repaired = with_point(word);
        if (!repaired.empty()) {
            error = parse_number(repaired, value);
            comma_count_ += error == std::errc();
        }
    }
    if (error == std::errc()) return Parsed::number;
    return error == std::errc::invalid_argument ? Parsed::malformed : Parsed::too_large;
}

std::string ObjText::comma_warning() const
{
    if (comma_count_ == 0) return {};
    return fmt::format("{}: {} a decimal comma: read as a point", file_,
                       comma_count_ == 1 ? "1 number has" : fmt::format("{} numbers have", comma_count_));
}

float ObjText::number(const char* what)
{
    const std::string_view text = word();
    if (text.empty()) fail(fmt::format("{} is missing", what));
    float value = 0;
    switch (parse(text, value)) {
        case Parsed::malformed:
            fail(fmt::format("expected {}, found '{}'", what, shown(text)));
        case Parsed::too_large:
            fail(fmt::format("{} is out of range: '{}'", what, shown(text)));
        case Parsed::number:
            break;
    }
    return value;
}

bool ObjText::try_number(float& value)
{
    const ObjText before = *this;
    const std::string_view text = word();
    if (!text.empty() && parse(text, value) == Parsed::number) return true;
    *this = before;
    return false;
}

bool ObjText::skip_not_finite()
{
    // Look ahead by a few characters first, because most words are numbers.
    skip_blanks();
    const char* first = at_;
    if (first != end_ && (*first == '-' || *first == '+')) ++first;
    if (first == end_ || (*first != 'n' && *first != 'N' && *first != 'i' && *first != 'I' && *first != '1'))
        return false;
    std::string name;
    for (const char* p = first; p != end_ && *p > ' ' && name.size() < 16; ++p)
        name += *p >= 'A' && *p <= 'Z' ? static_cast<char>(*p - 'A' + 'a') : *p;
    if (name != "nan" && name != "inf" && name != "infinity" && !name.starts_with("nan(") && !name.starts_with("1.#"))
        return false;
    word();
    return true;
}

bool ObjText::integer(std::string_view word, std::size_t& at, std::int64_t& value)
{
    const char* const first = word.data() + at;
    const auto [stop, error] = std::from_chars(first, word.data() + word.size(), value);
    if (error == std::errc::invalid_argument) return false;
    if (error == std::errc::result_out_of_range)
        value = *first == '-' ? std::numeric_limits<std::int64_t>::min() : std::numeric_limits<std::int64_t>::max();
    at = static_cast<std::size_t>(stop - word.data());
    return true;
}

std::string ObjText::place() const
{
    return fmt::format("{}:{}", word_line_, word_column_);
}

double ObjText::done() const
{
    return end_ == begin_ ? 1.0 : static_cast<double>(at_ - begin_) / static_cast<double>(end_ - begin_);
}

void ObjText::fail(const std::string& what) const
{
    throw InputError(file_, place(), what);
}

}   // namespace gnomon::io
