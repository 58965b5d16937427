// SPDX-License-Identifier: Apache-2.0
#pragma once
// Everything that reads foreign data, as functions of bytes. libFuzzer runs them (entry.cpp), and the tests run them
// over all seeds and over the inputs that fuzzing found.

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
    /// Reads the bytes. Returns an empty string if they were accepted (a scene is then evaluated at several times),
    /// else the reason for the refusal, in one line without control characters. An exception is an error.
    std::string (*run)(std::span<const std::uint8_t> bytes);
    /// Small inputs, made by code, that cover all features; all are accepted.
    std::vector<Bytes> (*seeds)();
    /// Repairs checksums and lengths, so that mutated inputs get past these checks. May be null.
    void (*repair)(Bytes& bytes);
};

std::span<const Target> targets();
/// Removes the temporary folders of processes that were killed, or that a finding ended. Each process does it before it
/// makes a folder of its own.
void remove_left_folders();
/// Returns nullptr if there is no such target.
const Target* find_target(std::string_view name);

}   // namespace gnomon::fuzz
