// SPDX-License-Identifier: Apache-2.0
#pragma once
// Finds nodes that show a mesh in a place where many others show it.
//
// Exporters write a mesh twice in one place now and then, and nobody sees that. Thousands of copies are a mistake or an
// attack: a ray that passes the holes of one passes them all, so that the time for a ray grows with their number.
//
// Nodes that move, and those whose mesh is deformed, are not looked at. Cost: a map entry for each node with a mesh.

#include <array>
#include <map>

#include "io/gltf/model.h"
#include "scene/scene.h"

namespace gnomon::io::gltf {

class SamePlaces {
 public:
    static constexpr std::uint32_t k_most = 64;   // nodes with one mesh in one place

    explicit SamePlaces(const Model& model);
    /// Notes a node's matrix. Call for parents before their children.
    /// @param above  its parent; k_absent: none
    void add_node(Index node, Index above, const glm::dmat4& local);
    /// Notes that a node shows a mesh.
    /// @return  whether so many others show it in the same place already
    bool repeats(Index node, scene::MeshId mesh);

 private:
    struct Place {
        glm::dmat4 world{1};
        bool moves = false;
    };
    std::vector<Place> places_;   // by node
    std::map<std::pair<scene::MeshId, std::array<double, 16>>, std::uint32_t> count_;
};

}   // namespace gnomon::io::gltf
