// SPDX-License-Identifier: Apache-2.0
#pragma once
// The shape of a glTF document as tables [glTF 2.0, JSON schema; Khronos extensions], and the walk that holds a
// document against them: types, required properties, ranges, lengths, references that lead somewhere, extensions where
// they belong. What has passed may be read without asking again, enumerations excepted: unknown values of those are
// warnings, since files with new ones must still load as far as they can.
//
// Cost: one visit a value. Recursion follows the tables, whose depth is fixed, never the document.

#include <cstdint>
#include <limits>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <vector>

#include "io/gltf/context.h"

namespace gnomon::io::gltf {

enum class Kind : std::uint8_t {
    boolean,
    integer,   // not negative
    number,
    string,
    version,      // "major.minor"
    code,         // an integer out of `codes`
    word,         // a string out of `words`
    index,        // into the array `target`
    object,       // of table `inner`
    attributes,   // names to indices of accessors, at least one
    // Arrays of the above, `min_items` to `max_items` long:
    numbers,
    strings,
    indices,   // no two equal
    objects,
    attribute_lists,
};

struct Table;

/// One property.
struct Rule {
    const char* name;
    Kind kind;
    bool required = false;
    double low = -std::numeric_limits<double>::infinity();
    double high = std::numeric_limits<double>::infinity();
    bool above_low = false;   // low itself is not allowed
    std::size_t min_items = 1, max_items = std::numeric_limits<std::size_t>::max();
    std::span<const int> codes{};
    std::span<const char* const> words{};
    const char* target = nullptr;   // JSON pointer of an array; nullptr: resolved elsewhere
    const Table* inner = nullptr;
    const char* needs = nullptr;   // another property of the same object
};

struct Table {
    const char* name;
    std::span<const Rule> rules;
};

/// Where an extension may stand and what it holds there.
struct ExtensionPlace {
    const char* extension;
    const Table* owner;
    const Table* inner;
};

const Table& document_table();
std::span<const ExtensionPlace> extension_places();

/// A texture that a material asks for, wherever it stands in it.
struct TextureBinding {
    std::string pointer;
    std::uint64_t material = 0;
    std::uint64_t texcoord = 0;
};

/// Holds the document against the tables.
/// @returns the texture coordinates that materials need
/// @throws InputError
std::vector<TextureBinding> check_schema(const nlohmann::json& document, Context& context);

}   // namespace gnomon::io::gltf
