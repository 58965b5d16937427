// SPDX-License-Identifier: Apache-2.0
#pragma once
// Meshes that the examples share.

#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include "gnomon/gnomon.h"

/// A cube of side 1 about the origin.
inline gnomon::MeshId add_cube(gnomon::SceneBuilder& builder)
{
    // Corner i lies at the high end of x, y and z where its bits 0, 1 and 2 are set.
    std::vector<gnomon::Vec3> points;
    for (unsigned i = 0; i < 8; ++i)
        points.push_back({i & 1 ? 0.5f : -0.5f, i & 2 ? 0.5f : -0.5f, i & 4 ? 0.5f : -0.5f});
    const std::vector<std::uint32_t> corners{0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5, 0, 1, 5, 0, 5, 4,
                                             2, 6, 7, 2, 7, 3, 0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6};
    gnomon::Mesh cube;
    cube.positions = points;
    cube.indices = corners;   // no normals: the faces are flat
    return builder.mesh(cube);
}

/// A sphere of radius 1 about the origin, with smooth normals.
inline gnomon::MeshId add_sphere(gnomon::SceneBuilder& builder)
{
    constexpr std::uint32_t rings = 16, around = 32;
    std::vector<gnomon::Vec3> points;
    for (std::uint32_t i = 0; i <= rings; ++i)
        for (std::uint32_t k = 0; k <= around; ++k) {
            const double down = std::numbers::pi * i / rings, turn = 2 * std::numbers::pi * k / around;
            points.push_back({static_cast<float>(std::sin(down) * std::cos(turn)), static_cast<float>(std::cos(down)),
                              static_cast<float>(-std::sin(down) * std::sin(turn))});
        }
    std::vector<std::uint32_t> corners;
    for (std::uint32_t i = 0; i < rings; ++i)
        for (std::uint32_t k = 0; k < around; ++k) {
            const std::uint32_t upper = i * (around + 1) + k, lower = upper + around + 1;
            if (i > 0) corners.insert(corners.end(), {upper, lower, upper + 1});
            if (i + 1 < rings) corners.insert(corners.end(), {upper + 1, lower, lower + 1});
        }
    gnomon::Mesh sphere;
    sphere.positions = sphere.normals = points;
    sphere.indices = corners;
    return builder.mesh(sphere);
}

/// Moves a shape to a place after scaling it along each axis.
inline gnomon::Transform place(double x, double y, double z, double width, double height, double depth)
{
    return gnomon::Transform::translation(x, y, z) * gnomon::Transform::scaling(width, height, depth);
}

/// A rough surface of one colour.
inline gnomon::MaterialId add_color(gnomon::SceneBuilder& builder, const gnomon::Vec3& color)
{
    gnomon::Material material;
    material.base_color = color;
    return builder.material(material);
}
