// SPDX-License-Identifier: Apache-2.0
#pragma once
// What every step of the glTF importer shares: which file it is about, how errors and warnings are made, the limits.

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace gnomon::io::gltf {

/// Nothing is taken from the machine that the file does not justify. A file beyond these is refused, with the reason.
struct Limits {
    std::uint64_t file_bytes = 4ull << 30;     // the scene file, and each file that it names
    std::uint64_t json_bytes = 128ull << 20;   // the document alone, without a GLB's binary chunk
    std::uint64_t json_values = 2'000'000;     // what a parsed value costs is some 150 times its text, at worst
    int json_depth = 128;
    std::uint64_t elements = 300'000;   // of one kind: nodes, accessors, ...
    std::uint64_t scenes = 1000;
    // Accessors may overlap in a buffer, but not so much that reading them all takes for ever: numbers read in all, and
    // for each byte of buffers.
    std::uint64_t numbers = 64ull << 20;
    std::uint64_t numbers_per_byte = 8;
    // Geometry in the scene may take this many bytes (one accessor can be used often, and one without data is zeros),
    // and for each byte of buffers that exist this many more.
    std::uint64_t geometry_bytes = 64ull << 20;
    std::uint64_t geometry_bytes_per_byte = 64;
    // Instances of meshes cost a few bytes of the file each; what all of them draw that others have drawn already.
    std::uint64_t repeated_triangles = 1ull << 27;
    // Images likewise, in pixels: a byte of deflated data stands for at most 1032 bytes.
    std::uint64_t pixels = 4ull << 20;
    std::uint64_t pixels_per_byte = 1032;
    std::size_t warnings = 24;
};

/// Makes errors and warnings of one file.
class Context {
 public:
    explicit Context(std::string file) : file_(std::move(file)) {}

    const std::string& file() const { return file_; }
    /// @param pointer  JSON pointer [RFC 6901] into the document
    [[noreturn]] void fail(const std::string& pointer, const std::string& problem) const;
    /// Kept for the scene; beyond the limit they are only counted.
    void warn(const std::string& pointer, const std::string& problem);
    /// All, with a last line if some were left out.
    std::vector<std::string> take_warnings();

    Limits limits;

 private:
    std::string file_;
    std::vector<std::string> warnings_;
    std::size_t left_out_ = 0;
};

/// pointer + "/" + name, with ~ and / of the name escaped as RFC 6901 has it; long names are cut.
std::string at(const std::string& pointer, std::string_view name);
std::string at(const std::string& pointer, std::uint64_t index);

}   // namespace gnomon::io::gltf
