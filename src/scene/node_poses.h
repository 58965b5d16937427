// SPDX-License-Identifier: Apache-2.0
#pragma once
// World matrices and visibility of all nodes at one time after another, for looks at a whole clip.
//
// The values are those that a SceneState has at the same time, bit for bit, without its lists of what changed, its
// overrides and its deformed meshes. Cost of a time: the tracks, and one product of matrices for each node that moves
// or is below one that does.

#include <vector>

#include "scene/scene.h"

namespace gnomon::scene {

class NodePoses {
 public:
    /// @pre the scene is finished, and outlives this
    NodePoses(const Scene& scene, double time);

    void go_to(double time);
    const glm::dmat4& world(NodeId node) const { return world_[node]; }
    bool visible(NodeId node) const { return visible_[node]; }

 private:
    // A node that may move or be hidden during the clip, itself or with its parent.
    struct Moving {
        NodeId node = none, parent = none;
        bool shown = true;
        glm::dmat4 local{1};
    };
    const Scene& scene_;
    std::vector<Moving> moving_;             // parents first
    std::vector<std::size_t> with_tracks_;   // those of them with tracks
    std::vector<glm::dmat4> world_;
    std::vector<char> visible_;
};

}   // namespace gnomon::scene
