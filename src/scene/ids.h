// SPDX-License-Identifier: Apache-2.0
#pragma once
// Indices into the scene's arrays, as named integer types; `none` stands for the absence of each.

#include <cstdint>

namespace gnomon::scene {

using NodeId = std::uint32_t;
using MeshId = std::uint32_t;
using SkinId = std::uint32_t;
using ObjectId = std::uint32_t;   // an instance of a mesh, the smallest unit that moves
using GroupId = std::uint32_t;    // objects that always move as one rigid body
using MaterialId = std::uint32_t;
using TextureId = std::uint32_t;
using LightId = std::uint32_t;
using CameraId = std::uint32_t;

inline constexpr std::uint32_t none = 0xffffffffu;

}   // namespace gnomon::scene
