// SPDX-License-Identifier: Apache-2.0
#pragma once
// Decodes primitives that are compressed with KHR_draco_mesh_compression, with libdraco.

#include "io/gltf/data.h"

namespace gnomon::io::gltf {

/// Decodes the compressed primitives whose accessors have no data otherwise, and lets these accessors refer to what was
/// decoded. Decoded normals and tangents have unit length, indices 32 bits, and no accessor has bounds. Sizes are
/// checked against the accessors and the limits before memory is taken.
/// @throws InputError  the data cannot be decoded, or disagrees with the accessors
void decode_draco(Model& model, Data& data, Context& context);

}   // namespace gnomon::io::gltf
