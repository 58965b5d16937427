// SPDX-License-Identifier: Apache-2.0
#pragma once
// The nodes of a point's cut whose visibility is tested, where there are more than rays are to be cast.
//
// A cut is fine so that each node's place, distance and direction are right; most of its nodes bring next to nothing,
// and neighbours are hidden or visible together. So each node gets a chance in proportion to its light, and in part to
// its form factor, because a node that is dark now may reflect light of a dynamic object later. Nodes are in the order
// of their numbers: by light, by level, and along a Morton curve. Where the sum of their chances passes a whole number,
// a node is tested, and stands for those since the last one: its weight is divided by its chance. Nodes whose chance is
// at least 1 stand for themselves.
//
// This is systematic sampling with unequal probabilities [Madow 1949] along the tree, and without a random number: the
// same point tests the same nodes in every frame.
//
// Cost: some fifty operations per node of the cut.

#include <span>
#include <vector>

#include "irradiance_cache/light_tree/facing_place.h"

namespace gnomon::irradiance_cache {

class TestedNodes {
 public:
    /// Chooses about `count` nodes of a cut; all, if it has no more.
    /// @param weights  the irradiance that a unit of each node's flux brings, visibility ignored
    void choose(const LightTree& tree, const FacingPoint& point, std::span<const NodeId> cut,
                std::span<const float> weights, std::size_t count);
    /// Valid until choose() is called again, as long as the cut is.
    std::span<const NodeId> nodes() const { return nodes_; }
    /// The irradiance that a unit of flux of each brings, with that of the nodes it stands for.
    std::span<const float> weights() const { return weights_; }

 private:
    struct Share {
        float light = 0, form_factor = 0;
    };
    struct Node {
        NodeId id;
        float weight;
        Share share;
    };
    void sort(std::span<const NodeId> cut, std::span<const float> weights);

    std::span<const NodeId> nodes_;
    std::span<const float> weights_;
    std::vector<NodeId> chosen_;
    std::vector<float> chosen_weights_;
    std::vector<Node> sorted_, half_sorted_;
    std::vector<std::uint32_t> places_;   // by digit
};

}   // namespace gnomon::irradiance_cache
