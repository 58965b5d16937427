// SPDX-License-Identifier: Apache-2.0
#pragma once
// Words and numbers out of OBJ and MTL text, with the place of each for messages.
//
// Lines end in LF or CR LF; a backslash before the line's end continues it; `#` begins a comment where a statement or a
// number may begin. Nothing is copied but names; every step moves forward, so time is linear in the size of the file.

#include <cstdint>
#include <string>
#include <string_view>

namespace gnomon::io {

class ObjText {
 public:
    /// @param file  for messages
    /// @param text  must outlive this; a zero byte in it is refused
    ObjText(std::string file, std::string_view text);

    /// Moves to the next statement and gives its keyword; empty at the end of the text.
    std::string_view next_statement();
    /// The next word of the statement; empty where it ends.
    std::string_view word();
    /// Whether nothing but blanks or a comment is left of the statement.
    bool at_end();
    /// What is left of the statement, without blanks around it (a name may have some inside).
    std::string rest();

    /// A finite number, no larger than a float may be.
    /// @throws InputError at its place
    float number(const char* what);
    /// A number if one is left and well-formed; nothing is consumed otherwise.
    bool try_number(float& value);
    /// Whole numbers of 64 bits out of a word, from `at` on: false if there is none.
    static bool integer(std::string_view word, std::size_t& at, std::int64_t& value);

    /// Where the last word begins.
    std::string place() const;
    std::uint32_t line() const { return word_line_; }
    const std::string& file() const { return file_; }
    /// Progress through the text, 0 to 1.
    double done() const;
    [[noreturn]] void fail(const std::string& what) const;

 private:
    void skip_blanks();
    bool ends_line(const char* p) const;   // at the end of a line or of the text
    // The length of a backslash and the line end behind it, or 0.
    std::size_t continuation(const char* p) const;
    static bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\v' || c == '\f'; }

    std::string file_;
    const char* begin_;
    const char* end_;
    const char* at_;
    const char* line_begin_;
    std::uint32_t line_ = 1, word_line_ = 1;
    std::size_t word_column_ = 1;
    bool impl_ = false;   // a statement
};

/// For messages: printable ASCII kept, the rest shown as '?', cut after 60 characters.
std::string shown(std::string_view text);

}   // namespace gnomon::io
