// SPDX-License-Identifier: Apache-2.0
#pragma once
// Checks the rules of the glTF 2.0 specification that its JSON schema does not express, in the order in which later
// steps rely on them. After check_layout(), every accessor lies within its buffer view and every view within its
// buffer. After the other checks, nodes form a forest; primitives, skins and animations are consistent; numbers are
// finite, in range, and of unit length where required. Sizes are computed in 64 bits without overflow: numbers of a
// document are at most 2^53, and sums and products are compared by difference and quotient.

#include <string>
#include <vector>

#include "io/gltf/data.h"
#include "io/gltf/model.h"
#include "io/gltf/schema.h"

namespace gnomon::io::gltf {

/// The use of an accessor, recorded at its first user, and the conditions that its data must fulfil.
struct AccessorUse {
    enum class Role : std::uint8_t { none, vertex, index, animation_input, animation_output, inverse_bind };
    Role role = Role::none;
    std::string user;             // JSON pointer
    bool unit = false;            // NORMAL
    bool not_position = false;    // of a vertex, with a value that stands for none: zero
    bool tangent = false;         // xyz of unit length, w a sign
    bool quaternion = false;      // a rotation
    bool cubic = false;           // with tangents before and after each value
    std::uint64_t vertices = 0;   // for an index accessor: of the smallest primitive that uses it
};

/// Checks versions and extensions; unsupported optional extensions are warnings.
void check_extensions(const Model& model, Context& context);

/// Checks buffer views against buffers and accessors against views: ranges, alignment, strides, sparse parts, bounds.
void check_layout(const Model& model, Context& context);

/// Checks meshes, skins, animations, images, cameras and lights against accessors and each other.
/// @returns one use per accessor
std::vector<AccessorUse> check_links(const Model& model, const std::vector<TextureBinding>& bindings, Context& context);

/// Checks the node graph: nodes form a forest, scenes list roots, and the joints of a skin have a common root.
/// @returns the parent of each node, or k_absent
std::vector<Index> check_nodes(const Model& model, Context& context);

/// Removes from a checked model what was counted as a fault and is not read around: weights without targets, skins
/// without joints, channels without an effect. A model without faults stays as it is.
void repair_model(Model& model);

/// Checks the data: bounds as declared, indices in range, unit vectors, increasing key times, weights that sum to one.
void check_data(const Model& model, const Data& data, const std::vector<AccessorUse>& uses, Context& context);

/// Checks that all users of a buffer view or an accessor use it in the same way.
class Uses {
 public:
    Uses(const Model& model, Context& context);
    AccessorUse& accessor(Index accessor, AccessorUse::Role role, const std::string& pointer);
    /// The kind of data in a buffer view.
    enum class ViewRole : std::uint8_t { none, vertex, index, image, inverse_bind, other };
    void view(Index view, ViewRole role, const std::string& pointer);
    /// Vertex accessors that share a view require it to have a stride.
    void vertex_view(Index accessor, const std::string& pointer);
    std::vector<AccessorUse> take() { return std::move(accessors_); }

 private:
    const Model& model_;
    Context& context_;
    std::vector<AccessorUse> accessors_;
    std::vector<ViewRole> views_;
    std::vector<Index> view_accessor_;   // the first vertex accessor on a view without stride
};

/// Parts of check_links().
void check_mesh(const Model& model, Index mesh, const std::vector<std::vector<const TextureBinding*>>& bindings,
                Uses& uses, Context& context);
void check_animation(const Model& model, Index animation, Uses& uses, Context& context);

}   // namespace gnomon::io::gltf
