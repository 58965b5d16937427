// SPDX-License-Identifier: Apache-2.0
#pragma once
// What the first bytes of a glTF's image tell.

#include <cstdint>
#include <span>
#include <string>

namespace gnomon::io::gltf {

enum class ImageFormat : std::uint8_t { png, jpeg, webp, other };

ImageFormat format_of(std::span<const std::uint8_t> bytes);

/// Returns the fault of an image up to where its pixels begin, or an empty string.
std::string header_fault(std::span<const std::uint8_t> bytes);

}   // namespace gnomon::io::gltf
