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
#include <span>
#include <vector>

#include "base/tasks.h"
#include "light_views/casters.h"
#include "ray/origin.h"
#include "ray/ray_scene.h"

namespace gnomon::irradiance_cache {

struct EmitterOptions {
    int side = 256;                  // texels of a view, at most; a power of two
    std::size_t leaves = 1u << 17;   // of all views together, at most; views get smaller sides by halves
    int least_side = 16;             // or smaller, where there would be more nodes than numbers for them
    std::size_t views = 6144;        // at most, six for a lamp that shines all around; the weakest lights are left out
    float least_cosine = 0.05f;      // surfaces at a more grazing angle stand for no larger area
    float ray_end = ray::k_shadow_ray_end;
    std::size_t dynamic_rays = 4096;     // by view, against what moves and is lit
    std::size_t dynamic_emitters = 64;   // at most; the darkest are left out
};

using NodeId = std::uint32_t;
inline constexpr std::uint32_t k_node_bits = 18;   // of a node's number, at most

/// Four nodes with the same parent, side by side. A node stands for the static leaves below it.
struct EmitterQuad {
    float x[4], y[4], z[4];      // mean position, weighted by static flux
    float radius[4];             // around it, holds all leaves
    float nx[4], ny[4], nz[4];   // mean normal, weighted by static flux; shorter than 1 where they differ
    float area[4];               // of the surfaces, square units
    float flux[4];               // static, luminance; 0: nothing there
};

/// What the lights shine on of a thing that moves, and that faces one octant.
struct DynamicEmitter {
    std::uint32_t owner = 0;            // owner_of() what it is on
    glm::vec3 position{0}, normal{0};   // means weighted by flux; the normal is unit
    glm::vec3 sample{0};                // where visibility is asked
    glm::vec3 flux{0};
    float area = 0;
};

class EmitterTree {
 public:
    /// Lights that move are made anew in every frame in which they do.
    EmitterTree(const scene::SceneState& state, const ray::RayScene& rays, const EmitterOptions& options, Tasks& tasks);

    /// Follows one advance() of the state, after the ray scene did. Where somebody moved something static by hand, for
    /// the first time, all is made anew.
    void update(const scene::SceneState& state, const ray::RayScene& rays, Tasks& tasks);

    /// Nodes 4 q ... 4 q + 3.
    const EmitterQuad& quad(NodeId q) const { return quads_[q]; }
    /// All of them: four nodes each.
    std::span<const EmitterQuad> quads() const { return quads_; }
    /// The quad of a node's children; none for leaves.
    NodeId children(NodeId id) const { return children_[id]; }
    /// The same by node.
    std::span<const NodeId> children() const { return children_; }
    /// Present flux by node: radiant exitance times area, pi times the radiance of a diffuse surface times its area.
    struct Flux {
        std::vector<float> r, g, b;
        glm::vec3 at(NodeId id) const { return {r[id], g[id], b[id]}; }
        void set(NodeId id, const glm::vec3& flux) { r[id] = flux.x, g[id] = flux.y, b[id] = flux.z; }
    };
    const Flux& flux() const { return flux_; }
    /// As if nothing that moves stood in the light.
    const Flux& still_flux() const { return still_; }
    bool differs(NodeId id) const { return samples_.places[id].w != 0; }
    bool any_differs() const { return differing_ > 0; }
    /// Nodes that the last update asked anew, or all that may have changed: their flux and their mark; some twice.
    const std::vector<NodeId>& changed() const { return changed_; }
    const std::vector<DynamicEmitter>& dynamic_objects() const { return dynamic_; }
    /// Of an object that moves: its rigid group, or it alone.
    std::uint32_t owner_of(scene::ObjectId object) const;
    /// By node: a place on the leaf nearest to the mean, promoted: where visibility is asked. Beside it, w: 1 if
    /// present flux differs from still flux, else 0: who asks which ways cross what moves wants both.
    struct Samples {
        std::vector<glm::vec4> places;
        glm::vec3 at(NodeId id) const { return glm::vec3(places[id]); }
    };
    const Samples& samples() const { return samples_; }
    /// Quads below the tops of the views' pyramids, of those that have any flux.
    const std::vector<NodeId>& roots() const { return roots_; }
    /// Nodes were made anew: what was remembered about them is void. Counts up.
    std::uint32_t geometry_version() const { return geometry_version_; }
    /// By the last update.
    bool geometry_changed() const { return geometry_changed_; }
    /// Present flux changed. Counts up.
    std::uint32_t flux_version() const { return flux_version_; }

    /// Of the lit leaves: the square root of their median area.
    float leaf_spacing() const;

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
        std::vector<light_views::Rect> dynamic_objects;   // footprints now
        glm::mat4 near_clip{1};                           // of the same light's first view
        std::vector<std::uint8_t> occluded;               // by leaf, in tree order
        std::vector<NodeId> dirty;                        // flux changed in this frame
    };
    struct Leaf {
        scene::ObjectId object = scene::none;
        glm::vec3 position{0}, normal{0}, sample{0}, flux{0};
        float area = 0;
    };
    void make_view(View& view);
    Leaf leaf_at(const View& view, const ray::RayQueue& queue, const ray::Hits& hits, std::size_t i,
                 double measure) const;
    void follow_dynamic(const scene::FrameChanges& changes);
    void find_dynamic(View& view) const;
    void block_leaves(View& view, const std::vector<light_views::Rect>& where);
    void mark_changes();
    void gather_dynamic();
    void find_dynamics();
    void find_roots();
    void sum_children(Flux& flux, NodeId id) const;
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
    Flux flux_, still_;
    std::size_t differing_ = 0;
    std::vector<DynamicEmitter> dynamic_;
    const scene::SceneState* state_;
    const ray::RayScene* rays_;
    std::vector<NodeId> children_;
    std::vector<NodeId> roots_;
    std::vector<NodeId> changed_;             // by the last update
    std::vector<scene::ObjectId> dynamics_;   // what moves and casts shadows
    std::uint32_t promoted_ = 0;              // RayScene::promoted() then
    std::uint32_t geometry_version_ = 1, flux_version_ = 1;
    bool geometry_changed_ = false;
    std::atomic<std::uint64_t> dirty_leaves_ = 0, dirty_nodes_ = 0;
};

}   // namespace gnomon::irradiance_cache
