// SPDX-License-Identifier: Apache-2.0
#pragma once
// The light map: the surfaces that the scene's lights illuminate, texel by texel (flux, position, normal, depth), and a
// pyramid over it. It is a reflective shadow map [Dachsbacher and Stamminger 2005], of which every texel is a virtual
// point light, with the quad-tree of [Ki and Oh 2007, 3.1]: nodes that may represent everything below them are marked
// valid.
//
// The map is ray traced: spot lights have one view, point lights six, directional lights one or two. Rays pass through
// surfaces that do not occlude light; they hit alpha-tested surfaces where these are opaque.
//
// There are two layers. Static objects are traced once. Where a dynamic object is or was, texels are traced again tile
// by tile, or restored to their static contents; then only the nodes above changed texels are recomputed. A map that
// was updated over any number of frames equals a new one, bit for bit, because a tile's rays always form the same
// packets. Rays at dynamic objects end at the static layer, so static objects are not traced again.
//
// With LightMapOptions::separate_trees there are two pyramids. That of static objects has all static texels, those that
// a dynamic object covers as well, but these without flux: its means and its validity change only with the light. The
// other one has the texels of dynamic objects. So no node is a mean over an object and the wall behind it, which moves
// as the object passes and was what flickered.
//
// Cost: construction, a light that moved or was relit, or a material that changed: a ray per texel. A frame: rays at
// texels that dynamic objects may cover, in the tiles that they left or entered. Memory: 68 bytes per texel, and 17
// more with separate trees.

#include <array>
#include <span>
#include <vector>

#include "base/tasks.h"
#include "light_quadtree/map_views.h"
#include "light_views/casters.h"
#include "ray/ray_scene.h"

namespace gnomon::light_quadtree {

class LightMap {
 public:
    LightMap(const scene::SceneState& state, const ray::RayScene& rays, const LightMapOptions& options, Tasks& tasks);

    /// Updates the map after an advance() of the state and the update of the ray scene.
    void update(const scene::SceneState& state, const ray::RayScene& rays, Tasks& tasks);

    /// Makes everything anew, whatever changed.
    void remake(const scene::SceneState& state, const ray::RayScene& rays, Tasks& tasks);

    /// The pyramids: one over the whole map, or two (LightMapOptions::separate_trees).
    enum class Tree : std::uint8_t { whole, static_objects, dynamic_objects };
    std::span<const Tree> trees() const;

    using View = MapView;
    std::span<const View> views() const { return views_; }
    std::span<const LightNode> nodes() const { return nodes_; }
    /// Of separate trees, that of static objects; its texels are those of the whole map.
    const LightNode& node(std::size_t id) const { return nodes_[id]; }
    /// Whether a node stands for everything below it: all of the light is its own.
    bool valid(std::size_t id) const { return share_[id] == k_whole_share; }
    Share share(std::size_t id) const { return share_[id]; }
    const LightMapOptions& options() const { return options_; }

    /// A node of a tree, and its share; `view` is one of views().
    LightNode node(Tree tree, const View& view, int level, int x, int y) const;
    Share share(Tree tree, const View& view, int level, int x, int y) const;
    /// A number of a node, unique among those of all trees.
    std::size_t number(Tree tree, std::size_t id) const
    {
        return tree == Tree::dynamic_objects ? nodes_.size() + id : id;
    }
    /// The tree that a texel's light belongs to.
    Tree tree_of(const View& view, int x, int y) const;

    /// Increases with every change of the map.
    std::uint32_t version() const { return version_; }
    /// Work of the last update: texels traced, texels and nodes that changed.
    struct Work {
        std::uint64_t cast = 0, dirty_texels = 0, dirty_nodes = 0;
    };
    const Work& work() const { return work_; }
    std::size_t bytes() const;

 private:
    static constexpr int k_tile = 8;   // texels a side, traced together
    using Tile = std::array<LightNode, k_tile * k_tile>;
    using Distances = std::array<float, k_tile * k_tile>;   // along the texels' rays; infinity: no hit
    using TexelMask = std::uint64_t;                        // one bit per texel of a tile, row by row
    static constexpr TexelMask k_whole_row = (TexelMask{1} << k_tile) - 1, k_whole_tile = ~TexelMask{0};
    static_assert(k_tile * k_tile == 64);
    struct Layers {
        std::vector<light_views::Rect> footprints;   // current footprints, by SceneState::dynamic_index()
        std::vector<std::int32_t> slot;   // by tile: index of its saved static layer; -1: the tile is all static
        std::vector<Tile> kept;
        std::vector<Distances> reach;   // by tile: distances to the static layer
    };
    void make_view(std::size_t v, const scene::SceneState& state, const ray::RayScene& rays, Work& work);
    void repair_view(std::size_t v, std::span<const light_views::Rect> where, const scene::SceneState& state,
                     const ray::RayScene& rays, Work& work);
    void cast_tile(const View& view, int tile, TexelMask which, const scene::SceneState& state,
                   const ray::RayScene& rays, ray::Against against, Tile& texels, Distances& reach) const;
    void make_node(const View& view, int level, int x, int y);
    std::size_t view_number(const View& view) const { return static_cast<std::size_t>(&view - views_.data()); }
    std::size_t upper(const View& view, int level, int x, int y) const;
    const LightNode* static_layer(const View& view, int x, int y) const;
    light_views::Rect footprint(const View& view, const scene::SceneState& state, scene::ObjectId object) const;

    LightMapOptions options_;
    light_views::Casters casters_;
    light_views::SceneBounds bounds_;
    std::vector<View> views_;
    std::vector<Layers> layers_;   // by view
    std::vector<LightNode> nodes_;
    std::vector<Share> share_;
    // Separate trees: nodes above the texels of the tree of dynamic objects, view by view.
    std::vector<std::size_t> first_upper_;   // by view
    std::vector<LightNode> dynamic_nodes_;
    std::vector<Share> dynamic_share_;
    std::vector<float> ball_;   // by SceneState::dynamic_index(): radius about the centre of its box; 0: it deforms
    std::uint32_t version_ = 1;
    Work work_;
};

}   // namespace gnomon::light_quadtree
