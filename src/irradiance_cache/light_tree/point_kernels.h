// SPDX-License-Identifier: Apache-2.0
#pragma once
// The inner loops of the visible scheme for one surface point, with what the processor at hand offers (Highway): its
// cut through the emitters' tree, and the sum over what it sees.
//
// Irradiance from a node of flux P and area A at distance d, its cosine e, the point's r, m that between their normals:
// P / (pi d^2) * e * (r + g (r (1 - 3 e^2) - m e)), g = A / (pi d^2): the mean over a disk to second order in its
// radius. For a disk that faces the point, r = e = -m = 1, the first terms of 1 / (d^2 + A / pi). Less than nothing is
// written as a quotient, and g beyond 1/2 only widens the distance, so that it stays finite where surfaces meet.
// Normals of a node that differ have cosines on both sides of e, and those below 0 give no light: with their spread
// s^2 = 1 - |mean normal|^2 in space, a third of it along any one direction, they lie about evenly in e - s ... e + s,
// and the mean of those above 0 takes the place of e. The mean's own would be too dark: clamping is convex.

#include <vector>

#include "irradiance_cache/light_tree/light_tree.h"
#include "irradiance_cache/light_tree/moving_spheres.h"

namespace gnomon::irradiance_cache {

struct CutOptions {
    float error = 0.04f;        // a node that may be wrong by more than this share of all light is refined,
    float nearest = 0.6f;       // all the more if it is wider than this share of its distance
    float negligible = 1e-5f;   // shares smaller than this are left out
    float estimate = 0.003f;    // the error of the cut from which all light is estimated first
};

/// Walks the tree from its roots: a node whose light may be wrong by too much is refined [Walter et al. 2005].
/// @param nodes, weights  out: the cut, and the irradiance that a unit of flux of each node brings, visibility apart
/// @param stack           scratch
void cut_tree(const LightTree& tree, const CutOptions& options, const glm::vec3& origin, const glm::vec3& normal,
              std::vector<NodeId>& nodes, std::vector<float>& weights, std::vector<NodeId>& stack);

/// A seen node and what a unit of its flux adds to the light that arrives from there, in one word: the number of the
/// node above the leading bits of the float, which is within 0.4 % of the weight.
using SeenNode = std::uint32_t;
inline constexpr std::uint32_t k_weight_bits = 32 - k_node_bits;
SeenNode pack_seen(NodeId node, float weight);
inline NodeId seen_node(SeenNode seen)
{
    return seen >> k_weight_bits;
}
float seen_weight(SeenNode seen);

/// Seen nodes come in steps of this many; what fills the last step is 0.
inline constexpr std::uint32_t k_seen_step = 16;

/// Sums still flux times weight times direction over seen nodes, by colour.
void sum_seen(const LightTree& tree, const SeenNode* seen, std::uint32_t count, const glm::vec3& origin,
              glm::vec3 (&light)[3]);

/// Which seen nodes may bring other light now: their flux differs from still flux, or their way to the point passes one
/// of these spheres.
struct ChangedNode {
    std::uint32_t place;   // in the list
    bool crossed;          // its way passes a sphere; else its flux alone differs
};
/// @param count    without what fills the last step
/// @param changed  out: by place, rising
void find_changed(const LightTree& tree, const SeenNode* seen, std::uint32_t count, const glm::vec3& origin,
                  const MovingSpheres& dynamic_objects, std::vector<ChangedNode>& changed);

}   // namespace gnomon::irradiance_cache
