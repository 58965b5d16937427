// SPDX-License-Identifier: Apache-2.0
#pragma once
// The values after a PLY header, one after the other, in any of the three formats. Every step advances, and lengths are
// held against the bytes that are left before memory is taken.

#include <string_view>

#include "io/ply/header.h"

namespace gnomon::io {

class PlyBody {
 public:
    /// @param bytes  the whole file; must outlive this object
    PlyBody(std::span<const std::uint8_t> bytes, const PlyHeader& header, std::string file);

    /// Fails unless all elements may fit into the bytes that are left.
    void require_room(const PlyElement& element) const;
    /// The next number.
    /// @throws InputError  the file ends, or there is no number
    double value(PlyType type);
    /// The length of a list whose items fit into the bytes that are left.
    std::uint64_t length(const PlyProperty& list);
    /// Reads and drops a property.
    void skip(const PlyProperty& property);
    /// Fails at the value that was read last.
    [[noreturn]] void fail(const std::string& problem) const;
    /// Progress through the file, 0 to 1.
    double done() const { return static_cast<double>(at_) / static_cast<double>(bytes_.size()); }

 private:
    std::string_view word();
    std::size_t least_bytes(PlyType type) const;   // of a value

    std::span<const std::uint8_t> bytes_;
    std::string file_;
    PlyFormat format_;
    std::size_t at_ = 0, value_at_ = 0;
    std::uint32_t line_ = 0;
};

}   // namespace gnomon::io
