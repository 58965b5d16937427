// SPDX-License-Identifier: Apache-2.0
#pragma once
// The strict pass: what the glTF 2.0 specification forbids beyond the schema, in the order in which later steps rely on
// it. After check_layout() no accessor can leave its buffer view, no view its buffer; after the others nodes are a
// forest, primitives, skins and animations fit together, and numbers are finite, in range and of unit length where they
// have to be. All arithmetic on sizes is in 64 bits and cannot overflow: numbers of a document are at most 2^53, and
// sums and products are compared by difference and quotient.

#include <string>
#include <vector>

#include "io/gltf/data.h"
#include "io/gltf/model.h"
#include "io/gltf/schema.h"

namespace gnomon::io::gltf {

/// What an accessor is for, by the first that uses it, and what its data must fulfil.
struct AccessorUse {
    enum class Role : std::uint8_t { none, vertex, index, animation_input, animation_output, inverse_bind };
    Role role = Role::none;
    std::string user;             // JSON pointer
    bool unit = false;            // NORMAL
    bool tangent = false;         // xyz of unit length, w a sign
    bool quaternion = false;      // rotations
    bool cubic = false;           // with their tangents around them
    std::uint64_t vertices = 0;   // of the smallest primitive that an index accessor serves
};

/// Versions and extensions; unsupported optional ones are warnings.
void check_extensions(const Model& model, Context& context);

/// Buffer views within buffers, accessors within buffer views; alignment, strides, sparse parts, declared bounds.
void check_layout(const Model& model, Context& context);

/// Meshes, skins, animations, images, cameras, lights against accessors and each other.
/// @returns one use an accessor
std::vector<AccessorUse> check_links(const Model& model, const std::vector<TextureBinding>& bindings, Context& context);

/// The node graph: a forest, scenes of roots, skins whose joints hang together.
/// @returns the parent of each node, or k_absent
std::vector<Index> check_nodes(const Model& model, Context& context);

/// What the bytes say: bounds as declared, indices in range, unit vectors, key times that rise, weights that sum to
/// one.
void check_data(const Model& model, const Data& data, const std::vector<AccessorUse>& uses, Context& context);

/// Follows buffer views and accessors through all who use them: each has one kind of use.
class Uses {
 public:
    Uses(const Model& model, Context& context);
    AccessorUse& accessor(Index accessor, AccessorUse::Role role, const std::string& pointer);
    /// A buffer view holds one kind of thing.
    enum class ViewRole : std::uint8_t { none, vertex, index, image, inverse_bind, other };
    void view(Index view, ViewRole role, const std::string& pointer);
    /// Vertex accessors that share a view need its stride.
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
