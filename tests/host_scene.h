// SPDX-License-Identifier: Apache-2.0
#pragma once
// Small parts for scenes that tests build as a host does.

#include <vector>

#include "gnomon/gnomon.h"

namespace gnomon::test {

/// The arrays of a mesh, which a Mesh only refers to.
struct Shape {
    std::vector<Vec3> positions;
    std::vector<std::uint32_t> indices;
    Mesh mesh() const
    {
        Mesh mesh;
        mesh.positions = positions;
        mesh.indices = indices;
        return mesh;
    }
};

/// A square in the plane z = 0 that faces +Z.
inline Shape square(float half)
{
    return {{{-half, -half, 0}, {half, -half, 0}, {half, half, 0}, {-half, half, 0}}, {0, 1, 2, 0, 2, 3}};
}

/// A cube around the origin that faces outwards.
inline Shape cube(float half)
{
    Shape shape;
    for (int i = 0; i < 8; ++i)
        shape.positions.push_back({i & 1 ? half : -half, i & 2 ? half : -half, i & 4 ? half : -half});
    shape.indices = {0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
                     2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5};
    return shape;
}

/// A camera at the origin that looks along -Z, with a whole vertical angle of 90 degrees: its focal length is half the
/// image's height.
inline Camera camera_along_z()
{
    Camera camera;
    camera.vertical_fov = 1.5707963267948966;
    return camera;
}

/// Direct light alone, one sample per pixel, with ids.
inline RenderOptions plain(Size size)
{
    RenderOptions options;
    options.size = size;
    options.indirect = Indirect::off;
    options.layers = options.ids = true;
    return options;
}

/// The message of the UsageError that a call throws; empty if it throws none.
template <class Call>
std::string usage_error(const Call& call)
{
    try {
        call();
    } catch (const UsageError& error) {
        return error.what();
    }
    return {};
}

}   // namespace gnomon::test
