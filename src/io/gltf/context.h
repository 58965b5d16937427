// SPDX-License-Identifier: Apache-2.0
#pragma once
// State shared by all steps of the glTF importer: the file's name, errors and warnings, and limits.

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "io/gltf/repairs.h"
#include "scene/memory_budget.h"

namespace gnomon::io::gltf {

/// Limits on memory and time, in proportion to the file's size. A file beyond them is rejected with the reason.
struct Limits {
    std::uint64_t file_bytes = 4ull << 30;     // the scene file, and each file that it references
    std::uint64_t json_bytes = 128ull << 20;   // the JSON document, without a GLB's binary chunk
    std::uint64_t json_values = 2'000'000;     // a parsed value takes at most some 150 times the memory of its text
    int json_depth = 128;
    std::uint64_t elements = 300'000;   // of each kind: nodes, accessors, ...
    std::uint64_t scenes = 1000;
    // Accessors may overlap in a buffer; this bounds the time for reading them: numbers read in total, plus numbers per
    // byte of buffers.
    std::uint64_t numbers = 64ull << 20;
    std::uint64_t numbers_per_byte = 8;
    // Bytes of geometry in the scene (an accessor can be used often, and one without data is all zeros), plus bytes per
    // byte of buffers that exist.
    std::uint64_t geometry_bytes = 64ull << 20;
    std::uint64_t geometry_bytes_per_byte = 64;
    // Triangles drawn by repeated instances of meshes; an instance takes only a few bytes in the file.
    std::uint64_t repeated_triangles = 1ull << 27;
    // Instances of EXT_mesh_gpu_instancing, plus one for so many bytes of buffers.
    std::uint64_t instances = 64 << 10, bytes_per_instance = 8;
    // The same for images, in pixels: a byte of deflated data expands to at most 1032 bytes.
    std::uint64_t pixels = 4ull << 20;
    std::uint64_t pixels_per_byte = 1032;
    std::size_t warnings = 24;
};

/// Reports errors, repairs and warnings for one file.
class Context {
 public:
    /// @param strict  faults that could be repaired are errors
    /// @param bytes   that the file may ask for
    explicit Context(std::string file, bool strict = false, std::uint64_t bytes = scene::MemoryBudget::k_usual)
        : memory(bytes), file_(std::move(file)), strict_(strict)
    {
    }

    const std::string& file() const { return file_; }
    /// @param pointer  JSON pointer [RFC 6901] into the document
    [[noreturn]] void fail(const std::string& pointer, const std::string& problem) const;
    bool strict() const { return strict_; }
    /// Counts a fault that the caller then repairs; fails if strict.
    /// @param problem  called for the text of the error
    template <class Problem>
    void repair(Fault fault, const std::string& pointer, Problem problem)
    {
        if (strict_) fail(pointer, problem());
        repairs_.count(fault, pointer);
    }
    /// Adds a warning to the scene. The same problem at other places is counted with the first; further problems beyond
    /// the limit are only counted.
    void warn(const std::string& pointer, const std::string& problem);
    /// Returns all warnings: one for each cause of repairs, then the others, with a final line if some were omitted.
    std::vector<std::string> take_warnings();

    Limits limits;
    scene::MemoryBudget memory;

 private:
    std::string file_;
    bool strict_ = false;
    Repairs repairs_;
    struct Warning {
        std::string first;   // JSON pointer
        std::string problem;
        std::uint64_t number = 1;
    };
    std::vector<Warning> warnings_;
    std::size_t omitted_ = 0;
};

/// pointer + "/" + name, with ~ and / in the name escaped as in RFC 6901; long names are cut.
std::string at(const std::string& pointer, std::string_view name);
std::string at(const std::string& pointer, std::uint64_t index);

}   // namespace gnomon::io::gltf
