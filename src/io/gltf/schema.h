// SPDX-License-Identifier: Apache-2.0
#pragma once
// The structure of a glTF document as tables [glTF 2.0, JSON schema; Khronos extensions], and the walk that checks a
// document against them: types, required properties, ranges, lengths, references in range, extensions in their places.
// A document that has passed can be read without further checks, except for enumerations: unknown values are warnings,
// because files with newer values should still load.
//
// Cost: one visit per value. Recursion follows the tables, whose depth is fixed, not the document.

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
    code,         // an integer from `codes`
    word,         // a string from `words`
    index,        // into the array `target`
    object,       // of table `inner`
    attributes,   // an object of names and accessor indices, at least one
    // Arrays of the above, `min_items` to `max_items` long:
    numbers,
    strings,
    indices,   // all different
    objects,
    attribute_lists,
};

struct Table;

/// The rule for one property.
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
    const char* target = nullptr;   // JSON pointer of an array; nullptr: checked elsewhere
    const Table* inner = nullptr;
    const char* needs = nullptr;   // another property that must be present
    // Repairs: a required array may be empty; a number in the place of a word stands for the default; so does 0.
    bool may_be_empty = false, number_as_default = false, zero_as_absent = false;
};

struct Table {
    const char* name;
    std::span<const Rule> rules;
};

/// Where an extension is allowed, and the table for its content.
struct ExtensionPlace {
    const char* extension;
    const Table* owner;
    const Table* inner;
};

const Table& document_table();
std::span<const ExtensionPlace> extension_places();

/// A texture reference anywhere in a material.
struct TextureBinding {
    std::string pointer;
    std::uint64_t material = 0;
    std::uint64_t texcoord = 0;
};

/// Repairs what the tables cannot: null properties, accessors without elements and the primitives that use them, nodes
/// with two placements, matrices that are animated, channels without a value for each key, spot lights without a cone.
/// A document may be of any form; what is not as expected is left for check_schema(). Not for strict reading.
void repair_document(nlohmann::json& document, Context& context);

/// Checks the document against the tables, and repairs it in place where that is allowed (see Repairs).
/// @returns the texture coordinates that materials need
/// @throws InputError
std::vector<TextureBinding> check_schema(nlohmann::json& document, Context& context);

}   // namespace gnomon::io::gltf
