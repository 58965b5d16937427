// SPDX-License-Identifier: Apache-2.0
#pragma once
// glTF documents around compressed bytes, for the targets that fuzz decoders.
//
// The meshes are grids of k_decoded_side points a side. Bytes for meshoptimizer begin with one that selects mode and
// filter.

#include <string>

#include "fuzz/targets.h"

namespace gnomon::fuzz {

inline constexpr std::uint32_t k_decoded_side = 6, k_decoded_points = k_decoded_side * k_decoded_side;
inline constexpr std::uint32_t k_decoded_corners = 6 * (k_decoded_side - 1) * (k_decoded_side - 1);

enum class MeshoptKind : std::uint8_t { attributes, exponential, octahedral, quaternion, triangles, sequence, k_kinds };

/// @param file  of the buffer with the compressed bytes
std::string draco_document(std::size_t bytes, const std::string& file);
std::string meshopt_document(MeshoptKind kind, std::size_t bytes, const std::string& file);

}   // namespace gnomon::fuzz
