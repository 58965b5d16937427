// SPDX-License-Identifier: Apache-2.0
#include "scene/node_poses.h"

namespace gnomon::scene {

namespace {

glm::dmat4 local_at(const Node& node, double time)
{
    return node.transform ? node.transform->evaluate(time) : node.local;
}

bool shown_at(const Node& node, double time)
{
    return !node.visibility || node.visibility->evaluate(time);
}

}   // namespace

NodePoses::NodePoses(const Scene& scene, double time)
    : scene_(scene), world_(scene.nodes.size()), visible_(scene.nodes.size())
{
    std::vector<char> moves(scene.nodes.size());
    for (std::size_t n = 0; n < scene.nodes.size(); ++n) {
        const Node& node = scene.nodes[n];
        const glm::dmat4 local = local_at(node, time);
        const bool shown = shown_at(node, time), has_tracks = node.transform || node.visibility;
        world_[n] = node.parent == none ? local : world_[node.parent] * local;
        visible_[n] = shown && (node.parent == none || visible_[node.parent]);
        moves[n] = has_tracks || (node.parent != none && moves[node.parent]);
        if (has_tracks) with_tracks_.push_back(moving_.size());
        if (moves[n]) moving_.push_back({static_cast<NodeId>(n), node.parent, shown, local});
    }
}

void NodePoses::go_to(double time)
{
    for (const std::size_t i : with_tracks_) {
        const Node& node = scene_.nodes[moving_[i].node];
        moving_[i].local = local_at(node, time);
        moving_[i].shown = shown_at(node, time);
    }
    for (const Moving& at : moving_) {
        world_[at.node] = at.parent == none ? at.local : world_[at.parent] * at.local;
        visible_[at.node] = at.shown && (at.parent == none || visible_[at.parent]);
    }
}

}   // namespace gnomon::scene
