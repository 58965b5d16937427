// SPDX-License-Identifier: Apache-2.0
#pragma once
// Everything that reads what strangers wrote, as functions of bytes: what libFuzzer drives (entry.cpp), and what the
// tests run over all seeds and over what was found.

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace gnomon::fuzz {

using Bytes = std::vector<std::uint8_t>;

struct Target {
    std::string_view name;
    /// Reads the bytes. Empty: accepted, and whole (a scene is evaluated at some times). Else why they were refused as
    /// they ought to be, in one line without control characters. An exception is a fault.
    std::string (*run)(std::span<const std::uint8_t> bytes);
    /// Small inputs with something of everything, made by code; all are accepted.
    std::vector<Bytes> (*seeds)();
    /// Makes good what nobody can guess (checksums, lengths), so that changes get further. May be null.
    void (*repair)(Bytes& bytes);
};

std::span<const Target> targets();
/// nullptr if there is none.
const Target* find_target(std::string_view name);

}   // namespace gnomon::fuzz
