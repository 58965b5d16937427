// SPDX-License-Identifier: Apache-2.0
#pragma once
// Foliage: many small leaves of two triangles each, folded at the rib.

#include "scene/builtin/kinetic.h"

namespace gnomon::scene::kinetic {

/// Uniform on the unit sphere.
glm::vec3 on_sphere(Random& random);

/// A leaf from its stalk along `grow`, its face towards `face`. Adds nothing if the two are parallel.
void add_leaf(MeshBuilder& builder, const glm::vec3& stalk, const glm::vec3& grow, const glm::vec3& face, float length,
              float width);

/// A factor around 1 for a leaf's colour: lighter or darker, some of it yellower.
glm::vec3 vary(Random& random, float amount);

}   // namespace gnomon::scene::kinetic
