// SPDX-License-Identifier: Apache-2.0
#pragma once
// Decodes buffer views that are compressed with EXT_meshopt_compression, with libmeshoptimizer.

#include "io/gltf/data.h"

namespace gnomon::io::gltf {

/// Decodes the compressed buffer views that have no bytes otherwise, and lets them refer to what was decoded. Sizes are
/// checked against the limits before memory is taken.
/// @throws InputError  a view cannot be decoded, or has a stride, count or filter that its mode does not allow
void decode_meshopt(Model& model, Data& data, Context& context);

}   // namespace gnomon::io::gltf
