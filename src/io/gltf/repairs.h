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
    factor_range,         // a number out of range
    interpolation_type,   // an interpolation given as a number
    weights_sum,          // weights of a vertex that a skin deforms
    normal_length,        // a normal that is not of unit length
    tangent_length,       // a tangent that is not of unit length or whose w is not a sign
    missing_texcoord,     // a texture of a primitive without its texture coordinates
    missing_image,        // the file of an image does not exist
    file_name,            // a file whose name is written differently, or that lies in another folder
    bounds,               // min and max of an accessor that are missing or are not those of its data
    buffer_target,        // a buffer view used for another kind of data than declared or used before
    inverse_bind_row,     // the last row of an inverse bind matrix
    skeleton,             // a joint that is not below the skeleton's root
    scene_root,           // a node of a scene that has a parent
    stride,               // a stride of data that cannot have one, or none where several accessors share a view
    alignment,            // offsets or strides that are not multiples of the size that they should be
    rotation_length,      // a quaternion that is not of unit length
    shear,                // a node's matrix that is not a product of translation, rotation and scale
    joint_twice,          // a vertex that uses a joint twice
    joint_roots,          // joints of a skin without a common root
    unused_skin,          // a skin of a mesh that has no joints
    weight_count,         // default weights of a mesh or node that are not as many as its morph targets
    target_attribute,     // an attribute of a morph target that the primitive itself lacks
    attribute_gap,        // a set of attributes without the set before it
    unknown_attribute,    // an attribute that glTF does not have
    channel,              // a channel of an animation that has nothing to animate, or what another one animates already
    extension_list,       // an extension that is not listed as used or required where it should be
    extension_place,      // an extension where it has no meaning
    image_source,         // an image without its type, or with two sources or none
    buffer_type,          // a data URI of another type than that of buffers
    cone,                 // the angles of a spot light
    camera_depth,         // a camera whose far plane is not behind its near plane
    byte_order_mark,      // at the beginning of the JSON
    same_place,           // a node that repeats the mesh of many others in the same place
    empty_colors,         // vertex colours that nobody painted: zero, opacity included
    null_value,           // a property that is null
    no_elements,          // an accessor without elements
    two_places,           // a node with a matrix beside translation, rotation or scale
    animated_matrix,      // a matrix of a node whose translation, rotation or scale is animated
    key_values,           // a channel of an animation whose values are not as many as its keys
    key_order,            // a key that is not later than the one before it
    key_before_zero,      // a key at a negative time
    spot_without_cone,    // a spot light without the angles of its cone
    not_finite,           // an attribute of a vertex that is not finite, positions apart
    uri_escape,           // a percent sign in a URI that does not begin an escape
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
