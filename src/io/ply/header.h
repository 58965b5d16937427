// SPDX-License-Identifier: Apache-2.0
#pragma once
// The header of a PLY file [Turk, The PLY Polygon File Format, 1994]: which elements follow, how many of each, and the
// types of their properties. Type names of both generations (`uchar`, `uint8`) are read.

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace gnomon::io {

enum class PlyFormat : std::uint8_t { ascii, little_endian, big_endian };
enum class PlyType : std::uint8_t { i8, u8, i16, u16, i32, u32, f32, f64 };

/// Bytes of a value in a binary file.
std::size_t ply_size(PlyType type);
bool ply_is_integer(PlyType type);

struct PlyProperty {
    std::string name;
    PlyType type = PlyType::f32;   // of a list: of its items
    bool is_list = false;
    PlyType count_type = PlyType::u8;   // an integer type
};

struct PlyElement {
    std::string name;
    std::uint64_t count = 0;
    std::vector<PlyProperty> properties;
    /// The number of the property of that name, or its list; -1 if there is none.
    int find(const std::string& property, bool list = false) const;
};

struct PlyHeader {
    PlyFormat format = PlyFormat::ascii;
    std::vector<PlyElement> elements;   // in the order of their data
    std::size_t body = 0;               // offset of the first byte after the header
    std::uint32_t lines = 0;            // of the header
};

/// @param file  for messages
/// @throws InputError with the place "line N"
PlyHeader read_ply_header(std::span<const std::uint8_t> bytes, const std::string& file);

}   // namespace gnomon::io
