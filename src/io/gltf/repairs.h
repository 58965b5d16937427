// SPDX-License-Identifier: Apache-2.0
#pragma once
// Faults of glTF files that are repaired unless reading is strict, counted by cause.
//
// A fault is repaired if the file can be read safely and the repair gives the image that its author meant. Indices out
// of range, cycles, overlapping or truncated data and sizes beyond the limits are never repaired.

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace gnomon::io::gltf {

enum class Fault : std::uint8_t {
    empty_array,          // an empty array, as if absent
    factor_range,         // a number slightly out of range
    interpolation_type,   // an interpolation given as a number
    weights_sum,          // weights of a vertex that a skin deforms
    normal_length,        // a normal that is not of unit length
    tangent_length,       // a tangent that is not of unit length or whose w is not a sign
    missing_texcoord,     // a texture of a primitive without its texture coordinates
    missing_image,        // the file of an image does not exist
    position_bounds,      // POSITION without min and max
    buffer_target,        // a buffer view used for another kind of data than declared or used before
    inverse_bind_row,     // the last row of an inverse bind matrix
    skeleton,             // a joint that is not below the skeleton's root
    scene_root,           // a node of a scene that has a parent
    animation_stride,     // key times or values with a stride
    count
};

/// Counts repairs, and words one warning for each cause.
class Repairs {
 public:
    void count(Fault fault, const std::string& pointer);
    /// "PLACE OF THE FIRST: 14 vertices whose weights do not sum to 1: renormalised", in the order of Fault.
    std::vector<std::string> warnings() const;

 private:
    struct Counter {
        std::uint64_t number = 0;
        std::string first;   // JSON pointer
    };
    std::array<Counter, static_cast<std::size_t>(Fault::count)> counters_;
};

}   // namespace gnomon::io::gltf
