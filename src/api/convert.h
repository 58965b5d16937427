// SPDX-License-Identifier: Apache-2.0
#pragma once
// Converts what a host passes to what scenes are made of, and back. What is out of range is rejected.
//
// All functions that convert to the scene's types throw UsageError with the name of what is wrong; those that convert
// back cannot fail.

#include <string>
#include <string_view>

#include "api/stamps.h"
#include "gnomon/math.h"
#include "gnomon/scene_parts.h"
#include "scene/scene.h"

namespace gnomon::api {

inline glm::vec3 vec(const Vec3& v)
{
    return {v.x, v.y, v.z};
}
inline Vec3 vec(const glm::vec3& v)
{
    return {v.x, v.y, v.z};
}

/// A part in a message: "KIND 'NAME'", in one line; without a name, "KIND".
std::string titled(std::string_view kind, const std::string& name);

/// @throws UsageError  "WHAT: ..." unless all elements are finite and the last row is 0 0 0 1
glm::dmat4 matrix_of(const Transform& transform, std::string_view what);
Transform transform_of(const glm::dmat4& matrix);

scene::Material to_scene(const Material& material, const SceneStamps& stamps);
Material from_scene(const scene::Material& material, const SceneStamps& stamps);

/// Its node is not set.
scene::Light to_scene(const Light& light);
Light from_scene(const scene::Light& light);

/// Its node is not set, and its transform is not read.
scene::Camera to_scene(const Camera& camera);
Camera from_scene(const scene::Camera& camera, const glm::dmat4& transform);

/// Its parts have the material `material` where they have none of their own; it is not checked. Normals become unit
/// vectors.
scene::Mesh to_scene(const Mesh& mesh, const SceneStamps& stamps, scene::MaterialId material);

/// @throws UsageError  "WHAT is not in this scene", for an id of another scene or of a part that was removed
template <class Id>
std::uint32_t require(const StampList& list, const Id& id, std::string_view what);

/// Rejects a value that its enum does not have.
/// @param last  the enum's last value
template <class Enum>
void require_known(Enum value, Enum last, std::string_view owner, std::string_view what);

[[noreturn]] void refuse_id(std::string_view what, bool given);

[[noreturn]] void refuse_value(int value, std::string_view owner, std::string_view what);

template <class Enum>
void require_known(Enum value, Enum last, std::string_view owner, std::string_view what)
{
    const auto number = static_cast<int>(value);
    if (number < 0 || number > static_cast<int>(last)) refuse_value(number, owner, what);
}

template <class Id>
std::uint32_t require(const StampList& list, const Id& id, std::string_view what)
{
    const std::uint32_t index = list.search(id.index, id.stamp);
    if (index == scene::none) refuse_id(what, static_cast<bool>(id));
    return index;
}

}   // namespace gnomon::api
