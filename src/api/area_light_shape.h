// SPDX-License-Identifier: Apache-2.0
#pragma once
// The meshes that stand for a host's lights with size.

#include <cstdint>
#include <vector>

#include "gnomon/scene_parts.h"

namespace gnomon::api {

struct LightShape {
    std::vector<Vec3> positions, normals;
    std::vector<std::uint32_t> indices;   // three per triangle, counter-clockwise seen from where it emits
};

/// @throws UsageError  a size is out of range, or the shape is not one of AreaLightShape
LightShape shape_of(const AreaLight& light);

}   // namespace gnomon::api
