// SPDX-License-Identifier: Apache-2.0
#pragma once
// The Happy Buddha in builtin:cornell, in place of the two blocks: the second scene of [Ki and Oh 2007, Table 2].

#include "gnomon/scene.h"

namespace gnomon::bench {

/// @param file  an OBJ file; all of its meshes are placed, as one model 1.3 high that stands on the floor
/// @throws InputError  the file is missing or invalid
Scene make_buddha_box(const std::string& file);

}   // namespace gnomon::bench
