// SPDX-License-Identifier: Apache-2.0
#pragma once
// Tokenises the AFF scene format [BART AFF]: Latin-1, separated by blanks, tabs, line ends (LF, CR LF, CR) and form
// feeds. '#' and '%' start a comment that ends with the line. A brace is always a token of its own.
//
// Line and column are computed only for error messages, by counting from the start, so that reading takes one pass.

#include <cstdint>
#include <string>
#include <string_view>

namespace gnomon::io {

/// Larger numbers are rejected, because their squares would exceed the range of 32-bit floats.
inline constexpr double k_aff_largest_number = 1e18;

/// The text of one file. Must outlive the tokens taken from it.
struct AffText {
    std::string shown_as;   // for messages
    std::string bytes;
};

/// A range of a file's text; empty at the end of the file.
struct AffToken {
    std::string_view text;
    std::size_t offset = 0;
};

/// Converts Latin-1 to UTF-8, for names.
std::string utf8_from_latin1(std::string_view text);
/// A token for messages: quoted, shortened, printable; "the end of the file" if empty.
std::string shown(const AffToken& token);

class AffTokens {
 public:
    explicit AffTokens(const AffText& text) : text_(&text) { look(); }

    const AffToken& peek() const { return next_; }
    AffToken take();
    bool at_end() const { return next_.text.empty(); }
    /// Bytes from the next token to the end of the file.
    std::size_t bytes_left() const { return text_->bytes.size() - next_.offset; }
    std::size_t offset() const { return next_.offset; }
    /// Continues at another offset in the same file, at which a token must start.
    void move_to(std::size_t offset);
    const AffText& text() const { return *text_; }

    /// @throws InputError "file:line:column: what"
    [[noreturn]] void fail(const AffToken& token, const std::string& what) const;

    /// @param meaning  the expected value, for the message: "a radius"
    double number(std::string_view meaning);
    /// @throws InputError  not an integer, or not in low ... high
    std::int64_t integer(std::string_view meaning, std::int64_t low, std::int64_t high);
    /// Reads a number of elements, each of which takes at least `tokens_each` tokens of the bytes that are left.
    std::size_t count(std::string_view meaning, std::size_t least, std::size_t tokens_each);
    /// Reads any token except a brace.
    AffToken word(std::string_view meaning);
    void expect(std::string_view keyword);
    /// Whether the next token starts like a number (well-formed or not).
    bool number_follows() const;

 private:
    void look();
    const AffText* text_;
    std::size_t end_ = 0;   // offset after the next token
    AffToken next_;
};

}   // namespace gnomon::io
