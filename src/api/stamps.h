// SPDX-License-Identifier: Apache-2.0
#pragma once
// The stamps by which public ids are recognised: every part of every scene in the process has another one.
//
// An id is a part's index and its stamp. A part keeps its stamp from scene to scene as long as it exists, so an id of
// another scene, or of a part that was removed, does not match the stamp at its index. Stamps wrap around after 2^32
// parts.

#include <cstdint>
#include <unordered_map>
#include <vector>

#include "gnomon/ids.h"
#include "scene/scene.h"

namespace gnomon::api {

/// Reserves `count` stamps and returns the first; none of them is 0.
std::uint32_t new_stamps(std::size_t count);

/// The stamps of one kind of part, by index; 0: there is no part.
class StampList {
 public:
    StampList() = default;
    /// New stamps for `count` parts.
    explicit StampList(std::size_t count);

    std::size_t size() const { return stamps_.size(); }
    std::uint32_t operator[](std::size_t index) const { return stamps_[index]; }
    /// Gives a part at an index a new stamp, and returns it; extends the list by one if the index is its size.
    std::uint32_t renew(std::size_t index);
    void clear(std::size_t index) { stamps_[index] = 0; }
    /// Removes an entry, and moves the later ones down.
    void erase(std::size_t index) { stamps_.erase(stamps_.begin() + static_cast<std::ptrdiff_t>(index)); }

    template <class Id>
    Id id(std::size_t index) const
    {
        Id result;
        result.index = static_cast<std::uint32_t>(index);
        result.stamp = stamps_[index];
        return result;
    }
    /// The index of a part that keeps its index; scene::none if there is no such part.
    std::uint32_t find(std::uint32_t index, std::uint32_t stamp) const
    {
        return stamp != 0 && index < stamps_.size() && stamps_[index] == stamp ? index : scene::none;
    }
    /// The same where earlier parts may have been removed. Cost: the parts, if the index is not the present one.
    std::uint32_t search(std::uint32_t index, std::uint32_t stamp) const;

 private:
    std::vector<std::uint32_t> stamps_;
};

struct SceneStamps {
    StampList nodes, meshes, materials, textures, skins;   // whose indices never change
    StampList lights, cameras;                             // whose later ones move down after a removal

    /// A mesh that an instance uses with another material, and has no id: the mesh that it is a copy of, and the
    /// material.
    struct MeshVariant {
        scene::MeshId mesh = scene::none;
        scene::MaterialId material = scene::none;
    };
    std::unordered_map<scene::MeshId, MeshVariant> mesh_variants;

    /// The material of meshes that were given none; scene::none: there is none yet.
    scene::MaterialId grey = scene::none;

    /// Where the origin of the scene's coordinates lies in those of its file and of the interface.
    glm::dvec3 origin{0};   // scene::bring_near()

    SceneStamps() = default;
    explicit SceneStamps(const scene::Scene& scene);
};

}   // namespace gnomon::api
