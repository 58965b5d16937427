// SPDX-License-Identifier: Apache-2.0
#pragma once
// The inner loops for one surface point, in the widest instruction set of the CPU (Highway): its cut through the light
// tree, and the sum over the nodes that it sees.
//
// Irradiance from a node of flux P and area A at distance d, where e is the cosine at the node, r that at the point and
// m that between their normals: P / (pi d^2) * e * (r + g (r (1 - 3 e^2) - m e)) with g = A / (pi d^2). This is the
// mean over a disk, to second order in its radius. For a disk that faces the point, r = e = -m = 1, it gives the first
// terms of 1 / (d^2 + A / pi). A negative second-order term is written as a quotient, and g beyond 1/2 only increases
// the distance, so that the result stays finite where surfaces meet. If the normals of a node differ, their cosines
// spread on both sides of e, and those below 0 give no light. With the spread s^2 = 1 - |mean normal|^2 in space, of
// which one direction has a third, they are about uniform in e - s ... e + s, and the mean of max(cosine, 0) replaces
// e. The cosine of the mean would be too dark, because clamping is convex.

#include <vector>

#include "irradiance_cache/light_tree/light_tree.h"
#include "irradiance_cache/light_tree/moving_spheres.h"

namespace gnomon::irradiance_cache {

struct CutOptions {
    // Fractions of the light of all nodes, visibility ignored.
    float error = 0.04f;        // a node whose error bound exceeds this is refined
    float negligible = 1e-5f;   // a node with less light is left out
    float estimate = 0.003f;    // `error` of the cut that estimates the light of all nodes first
    float nearest = 0.6f;       // nodes with a radius above this fraction of their distance get a larger bound
};

/// The memory of cut_tree(), which may be used again and again.
struct CutScratch {
    std::vector<NodeId> stack;         // quads
    std::vector<NodeId> node, below;   // nodes that are not refined, and the quads of their children
    std::vector<float> flux, spread;   // of these nodes
};

/// Refines nodes from the tree's roots until the error bound of each is small enough [Walter et al. 2005, Section 4].
/// @param nodes, weights  out: the cut, and the irradiance that a unit of flux of each node brings, visibility ignored
void cut_tree(const LightTree& tree, const CutOptions& options, const glm::vec3& origin, const glm::vec3& normal,
              std::vector<NodeId>& nodes, std::vector<float>& weights, CutScratch& scratch);

/// Marks of nodes.
class MarkedNodes {
 public:
    void resize(std::size_t nodes)
    {
        if (marked_.size() < nodes) marked_.resize(nodes);
    }
    void mark(NodeId node) { marked_[node] = 1; }
    void unmark(NodeId node) { marked_[node] = 0; }
    bool has(NodeId node) const { return marked_[node] != 0; }

 private:
    std::vector<std::uint8_t> marked_;   // by node
};

/// Finds the lit patches whose surface is uneven, within PatchLight::k_uneven_reach of their radii around a point.
/// @param but    nodes that are left out, with all below them
/// @param found  out: leaves of the tree
/// @param stack  scratch
void find_uneven(const LightTree& tree, const glm::vec3& origin, const MarkedNodes& but, std::vector<NodeId>& found,
                 std::vector<NodeId>& stack);

/// A visible node and the irradiance that a unit of its flux brings, in one word: the number of the node above the
/// leading bits of the float, which is within 0.4 % of the weight.
using SeenNode = std::uint32_t;
inline constexpr std::uint32_t k_weight_bits = 32 - k_node_bits;
SeenNode pack_seen(NodeId node, float weight);
inline NodeId seen_node(SeenNode seen)
{
    return seen >> k_weight_bits;
}
float seen_weight(SeenNode seen);

/// Lists of visible nodes are padded with 0 to a multiple of this.
inline constexpr std::uint32_t k_seen_step = 16;

/// Sums static flux times weight times direction over visible nodes, by colour.
void sum_seen(const LightTree& tree, const SeenNode* seen, std::uint32_t count, const glm::vec3& origin,
              glm::vec3 (&light)[3]);
/// The same with LightTree::patch_difference(); nodes of light maps count as 0.
void sum_seen_difference(const LightTree& tree, const SeenNode* seen, std::uint32_t count, const glm::vec3& origin,
                         glm::vec3 (&light)[3]);

/// A visible node that may bring other light than without dynamic objects: its flux differs from its static flux, or
/// its path to the point crosses a bounding sphere.
struct ChangedNode {
    std::uint32_t place;   // in the list
    bool crossed;          // its path crosses a sphere; else only its flux differs
};
/// @param count    without padding
/// @param changed  out: by place, rising
void find_changed(const LightTree& tree, const SeenNode* seen, std::uint32_t count, const glm::vec3& origin,
                  const MovingSpheres& dynamic_bounds, std::vector<ChangedNode>& changed);

}   // namespace gnomon::irradiance_cache
