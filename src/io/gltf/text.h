// SPDX-License-Identifier: Apache-2.0
#pragma once
// Converts a file's bytes to a JSON document: the GLB container [glTF 2.0, 4], and JSON whose nesting depth and number
// of values are checked before it is parsed.

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string_view>

#include "io/gltf/context.h"

namespace gnomon::io::gltf {

struct Container {
    std::string_view json;
    std::uint64_t json_begin = 0;                       // offset in the file
    std::optional<std::span<const std::uint8_t>> bin;   // the binary chunk of a GLB
    bool binary = false;                                // GLB
};

/// Splits a file into its chunks. A file with the magic of a GLB (or with its extension) is a GLB; any other is JSON.
/// @param bytes  the whole file; the result refers to it
/// @throws InputError with the place "byte N"
Container open_container(std::string_view bytes, bool named_glb, Context& context);

/// @throws InputError with the place line:column (.gltf) or byte (.glb)
nlohmann::json parse_json(const Container& container, const Context& context);

}   // namespace gnomon::io::gltf
