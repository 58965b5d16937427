// SPDX-License-Identifier: Apache-2.0
#pragma once
// Splits OBJ and MTL text into words and numbers, and tracks the place of each for messages.
//
// Lines end in LF or CR LF, or in CR where the text has no LF; a backslash before the end continues a line; `#` starts
// a comment where a statement or a number may start. Only names are copied. Every step advances, so time is linear in
// the size of the file.

#include <cstdint>
#include <string>
#include <string_view>

namespace gnomon::io {

class ObjText {
 public:
    /// @param file  for messages
    /// @param text  must outlive this object; a zero byte in it is an error
    /// @param decimal_commas  whether "0,5" is read as 0.5 and counted: some programs write so where people do
    ObjText(std::string file, std::string_view text, bool decimal_commas = false);

    /// Moves to the next statement and returns its keyword; empty at the end of the text.
    std::string_view next_statement();
    /// The next word of the statement; empty where it ends.
    std::string_view word();
    /// Whether only blanks or a comment are left of the statement.
    bool at_end();
    /// The rest of the statement, without blanks around it (a name may contain some).
    std::string rest();

    /// Reads a finite number that fits into a float.
    /// @throws InputError at its place
    float number(const char* what);
    /// Reads a number if the next word is a valid one; otherwise consumes nothing.
    bool try_number(float& value);
    /// Consumes the next word if it is how programs write a number that is not finite: nan, inf, infinity, -nan(ind),
    /// 1.#QNAN and the like.
    bool skip_not_finite();
    /// Reads a 64-bit integer from a word, from `at` on; returns false if there is none.
    static bool integer(std::string_view word, std::size_t& at, std::int64_t& value);

    /// The place where the last word begins.
    std::string place() const;
    std::uint32_t line() const { return word_line_; }
    const std::string& file() const { return file_; }
    /// Progress through the text, 0 to 1.
    double done() const;
    /// How many numbers had a decimal comma.
    std::size_t comma_count() const { return comma_count_; }
    /// A warning about them; empty where there were none.
    std::string comma_warning() const;
    [[noreturn]] void fail(const std::string& what) const;

 private:
    void skip_blanks();
    bool ends_line(const char* p) const;   // at the end of a line or of the text
    // The length of a backslash and the line end behind it, or 0.
    std::size_t continuation(const char* p) const;
    bool is_blank(char c) const
    {
        return c == ' ' || c == '\t' || (c == '\r' && line_end_ != '\r') || c == '\v' || c == '\f';
    }
    enum class Parsed : std::uint8_t { number, malformed, too_large };
    Parsed parse(std::string_view word, float& value);

    std::string file_;
    const char* begin_;
    const char* end_;
    const char* at_;
    const char* line_begin_;
    std::uint32_t line_ = 1, word_line_ = 1;
    std::size_t word_column_ = 1;
    std::size_t comma_count_ = 0;
    char line_end_ = '\n';
    bool decimal_commas_;
    bool impl_ = false;   // a statement
};

/// Text for messages: printable ASCII is kept, other characters become '?', cut after 60 characters.
std::string shown(std::string_view text);

}   // namespace gnomon::io
