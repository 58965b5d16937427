// SPDX-License-Identifier: Apache-2.0
#pragma once
// AFF as text: tokens with their place, numbers checked.
//
// Latin-1. Tokens are separated by blanks, tabs, CR, LF and form feed; `#` and `%` start a comment that ends with the
// line; `{` and `}` are tokens of their own, even where they touch others.

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "base/math.h"

namespace gnomon::io {

class AffText {
 public:
    AffText(std::vector<std::uint8_t> bytes, std::string shown_as);

    /// Next token; empty at the end of the file.
    std::string_view next();
    /// The same without taking it.
    std::string_view peek();
    /// Whether a number comes next.
    bool number_next();

    void expect(std::string_view word);
    double number(std::string_view what);
    glm::dvec3 vector(std::string_view what);
    long long integer(std::string_view what, long long least, long long most);
    /// A count of things that each take at least so many more bytes of this file.
    std::size_t count(std::string_view what, std::size_t least, std::size_t bytes_each);
    std::string name(std::string_view what);

    /// Refuses the file at the last token taken.
    [[noreturn]] void fail(const std::string& problem) const;
    const std::string& shown_as() const { return shown_as_; }
    double part_read() const
    {
        return bytes_.empty() ? 1.0 : static_cast<double>(at_) / static_cast<double>(bytes_.size());
    }

 private:
    void skip_blanks();
    std::string found(std::string_view token) const;

    std::vector<std::uint8_t> bytes_;
    std::string shown_as_;
    std::size_t at_ = 0;
    std::size_t token_at_ = 0;   // of the last token taken
};

}   // namespace gnomon::io
