// SPDX-License-Identifier: Apache-2.0
#pragma once
// A limit on the memory that one renderer holds.

#include <cstddef>
#include <string_view>

namespace gnomon {

class MemoryLimit {
 public:
    /// @param bytes  0: no limit
    explicit MemoryLimit(std::size_t bytes = 0) : bytes_(bytes) {}

    std::size_t bytes() const { return bytes_; }
    bool allows(std::size_t held) const { return bytes_ == 0 || held <= bytes_; }
    /// @param held  bytes
    /// @param what  what took or would take them: "the ray tracing trees"
    /// @throws MissingError  the limit does not allow them
    void check(std::size_t held, std::string_view what) const
    {
        if (!allows(held)) refuse(what);
    }
    /// @throws MissingError  always
    [[noreturn]] void refuse(std::string_view what) const;

 private:
    std::size_t bytes_;
};

}   // namespace gnomon
