// SPDX-License-Identifier: Apache-2.0
#pragma once
// Forgets the states that the promotion of a static object may change, and no others.
//
//   its own parts      dropped: it is not a remembered receiver any more
//   FULL behind it     forgotten: it may have been the occluder
//   PARTIAL behind it  forgotten: may be decided without it, so is judged again
//   NONE               stays true when an object leaves
//
// "Behind it" is the shadow volume of its box, found by a traversal of the tree of static triangles. Cost: its own
// triangles, and those that it could have shadowed.

#include <span>

#include "shadow_culling/certified/certificates.h"
#include "shadow_culling/certified/shadow_memory.h"

namespace gnomon::shadow_culling {

/// A light whose states are valid.
struct RememberedLight {
    int index = 0;
    bool directional = false;
    glm::vec3 to{0};   // its position, or the direction towards it
};

struct Forgotten {
    std::uint64_t records = 0;   // dropped, of the object itself
    std::uint64_t visited = 0;   // pairs of a light and a triangle that it could have shadowed
};

/// Removes an object from the static triangles and from the shadow memory.
Forgotten forget_object(scene::ObjectId object, std::span<const RememberedLight> lights,
                        const CertificateOptions& options, StaticTriangles& triangles, ShadowMemory& memory);

}   // namespace gnomon::shadow_culling
