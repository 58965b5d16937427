// SPDX-License-Identifier: Apache-2.0
#pragma once
// What the scene's lights shine on, as lights themselves: the leaves are pixels of light maps [Dachsbacher and
// Stamminger 2005], the nodes above them their pyramids [Ki and Oh 2007, 3.1].
//
// Leaves are static surfaces alone. Where something that moves stands between a light and a leaf, the leaf is dark for
// as long; that changes its present flux and that of the nodes above it, and nothing else. So which nodes a surface
// point sees, past everything static, is worth remembering.
//
// Cost: construction casts one ray a leaf. A frame: rays against what moves, in the tiles that it left or entered, and
// the nodes above what changed (`dirty_leaves`, `dirty_nodes`). Present flux equals that of a tree made anew, to the
// bit.

#include <atomic>
#include <vector>

#include "base/tasks.h"
#include "light_views/casters.h"
#include "ray/ray_scene.h"

namespace gnomon::light_quadtree {

struct EmitterOptions {
    int side = 256;                  // texels of a view, at most; a power of two
    std::size_t leaves = 1u << 17;   // of all views together, at most; views get smaller sides by halves
    int least_side = 16;
    float least_cosine = 0.05f;   // surfaces at a more grazing angle stand for no larger area
    float ray_end = 0.9999f;
};

using NodeId = std::uint32_t;

/// Four nodes with the same parent, side by side. A node stands for the static leaves below it.
struct EmitterQuad {
    float x[4], y[4], z[4];      // mean position, weighted by static flux
    float radius[4];             // around it, holds all leaves
    float nx[4], ny[4], nz[4];   // mean normal, weighted by static flux; shorter than 1 where they differ
    float area[4];               // of the surfaces, square units
    float flux[4];               // static, luminance; 0: nothing there
};

class EmitterTree {
 public:
    /// Lights that move are made anew in every frame in which they do.
    EmitterTree(const scene::SceneState& state, const ray::RayScene& rays, const EmitterOptions& options, Tasks& tasks);

    /// Follows one advance() of the state, after the ray scene did.
    void update(const scene::SceneState& state, const ray::RayScene& rays, Tasks& tasks);

    /// Nodes 4 q ... 4 q + 3.
    const EmitterQuad& quad(NodeId q) const { return quads_[q]; }
    /// The quad of a node's children; none for leaves.
    NodeId children(NodeId id) const { return children_[id]; }
    /// Present flux by node: radiant exitance times area, pi times the radiance of a diffuse surface times its area.
    struct Flux {
        std::vector<float> r, g, b;
    };
    const Flux& flux() const { return flux_; }
    /// By node: a place on the leaf nearest to the mean, lifted: where visibility is asked.
    struct Samples {
        std::vector<float> x, y, z;
        glm::vec3 at(NodeId id) const { return {x[id], y[id], z[id]}; }
    };
    const Samples& samples() const { return samples_; }
    /// Quads below the tops of the views' pyramids, of those that have any flux.
    const std::vector<NodeId>& roots() const { return roots_; }
    /// Nodes were made anew: what was remembered about them is void. Counts up.
    std::uint32_t geometry_version() const { return geometry_version_; }
    /// Present flux changed. Counts up.
    std::uint32_t flux_version() const { return flux_version_; }

    std::size_t size() const { return children_.size(); }
    std::uint64_t dirty_leaves() const { return dirty_leaves_; }
    std::uint64_t dirty_nodes() const { return dirty_nodes_; }
    std::size_t bytes() const;

 private:
    struct View {
        scene::LightId light = scene::none;
        int face = 0;
        int side = 0, levels = 0;   // 2^levels texels a side
        NodeId first = 0;           // of its nodes, a multiple of 4: level 1, level 2, ... in Morton order
        bool on = false;
        light_views::ViewProjection projection;
        std::vector<light_views::Rect> movers;   // footprints now
        std::vector<std::uint8_t> blocked;       // by leaf, in tree order
    };
    void make_view(View& view, const scene::SceneState& state, const ray::RayScene& rays);
    void block_leaves(View& view, const std::vector<light_views::Rect>& where, const scene::SceneState& state,
                      const ray::RayScene& rays);
    void find_roots();
    void sum_children(NodeId id);
    void set_flux(NodeId id, const glm::vec3& flux);
    glm::vec3 flux_of(NodeId id) const;
    void find_movers(View& view, const scene::SceneState& state) const;
    static NodeId first_of_level(const View& view, int level)
    {
        return view.first + ((1u << (2 * level)) - 4) / 3;   // level 1 is the first
    }

    EmitterOptions options_;
    light_views::Casters casters_;
    light_views::SceneBounds bounds_;
    std::vector<View> views_;
    std::vector<EmitterQuad> quads_;
    Samples samples_;
    Flux flux_;                          // present
    std::vector<glm::vec3> leaf_flux_;   // static, by node id (leaves only used)
    std::vector<NodeId> children_;
    std::vector<NodeId> roots_;
    std::vector<scene::ObjectId> dynamics_;
    std::uint32_t geometry_version_ = 1, flux_version_ = 1;
    std::atomic<std::uint64_t> dirty_leaves_ = 0, dirty_nodes_ = 0;
};

}   // namespace gnomon::light_quadtree
