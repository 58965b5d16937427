// SPDX-License-Identifier: Apache-2.0
#pragma once
// The inner loops of the visible scheme for one surface point, with what the processor at hand offers (Highway): its
// cut through the emitters' tree, and the sum over what it sees.
//
// Irradiance from a node of flux P at distance d: P / pi * cosine at the emitter * cosine at the point / (d^2 + A /
// pi). The disk's kernel stays finite where surfaces meet.

#include <vector>

#include "light_quadtree/emitters.h"

namespace gnomon::light_quadtree {

struct CutOptions {
    float error = 0.03f;        // a node that may be wrong by more than this share of all light is refined,
    float nearest = 0.6f;       // all the more if it is wider than this share of its distance
    float negligible = 1e-5f;   // shares smaller than this are left out
};

/// Walks the tree from its roots: a node whose light may be wrong by too much is refined [Walter et al. 2005].
/// @param nodes, weights  out: the cut, and the irradiance that a unit of flux of each node brings, visibility apart
/// @param stack           scratch
void cut_tree(const EmitterTree& tree, const CutOptions& options, const glm::vec3& origin, const glm::vec3& normal,
              std::vector<NodeId>& nodes, std::vector<float>& weights, std::vector<NodeId>& stack);

/// Seen emitters come in steps of this many; fill the last step with weight 0.
inline constexpr std::uint32_t k_seen_step = 16;

struct Sphere {
    glm::vec3 centre;
    float radius;
};

/// Sums flux times weight times direction over seen emitters, by colour.
/// @param movers   emitters whose way to the point passes one of these spheres are left out,
/// @param through  and appended here: places in the list
void sum_seen(const EmitterTree& tree, const NodeId* nodes, const float* weights, std::uint32_t count,
              const glm::vec3& origin, const std::vector<Sphere>& movers, glm::vec3 (&light)[3],
              std::vector<std::uint32_t>& through);

}   // namespace gnomon::light_quadtree
