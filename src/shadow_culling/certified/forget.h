// SPDX-License-Identifier: Apache-2.0
#pragma once
// What is forgotten when a static object starts to move: only what its absence can change.
//
//   its own parts      it is no remembered receiver any more
//   FULL behind it     it may have been what occluded
//   PARTIAL behind it  can do better without it; judged again
//   NONE               stays true when something leaves
//
// Behind it: in the shadow volume of its box, found by walking down the tree of the static triangles. Cost: its own
// triangles, and those that it could have shadowed.

#include <span>

#include "shadow_culling/certified/certificates.h"
#include "shadow_culling/certified/shadow_memory.h"

namespace gnomon::shadow_culling {

/// A light whose states count.
struct RememberedLight {
    int index = 0;
    bool directional = false;
    glm::vec3 to{0};   // its place, or the direction towards it
};

struct Forgotten {
    std::uint64_t records = 0;   // dropped: the object's own
    std::uint64_t visited = 0;   // triangles that it could have shadowed, by light
};

/// Takes an object out of the static triangles and out of what is remembered.
Forgotten forget_object(scene::ObjectId object, std::span<const RememberedLight> lights,
                        const CertificateOptions& options, StaticTriangles& triangles, ShadowMemory& memory);

}   // namespace gnomon::shadow_culling
