// SPDX-License-Identifier: Apache-2.0
#pragma once
// The light map: what the scene's lights shine on, texel by texel (flux, position, normal, depth), and the pyramid over
// it. A reflective shadow map [Dachsbacher and Stamminger 2005], of which every texel is a light, with the quad-tree of
// [Ki and Oh 2007, 3.1]: nodes that may stand for all below them are marked valid.
//
// By ray casting: spot lights have one view, point lights six, directional lights one or two. Surfaces that let light
// pass are passed; alpha-tested ones are met where they are opaque.
//
// Two layers. What stands still is cast once. Where something that moves is or was, tile by tile, texels are cast anew,
// or put back as they were without it; then the nodes above what changed are made anew, and no others. A map that
// followed any number of frames equals a new one, to the bit (a tile's rays always share the same packets). Rays at
// dynamic objects end where the static layer begins: what stands still is not met twice.
//
// Cost: construction, or a light that moved: a ray a texel. A frame: rays at texels that dynamic objects may cover, in
// the tiles that they left or entered. 68 bytes a texel.

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

    /// Follows one advance() of the state, after the ray scene did.
    void update(const scene::SceneState& state, const ray::RayScene& rays, Tasks& tasks);

    using View = MapView;
    std::span<const View> views() const { return views_; }
    std::span<const LightNode> nodes() const { return nodes_; }
    const LightNode& node(std::size_t id) const { return nodes_[id]; }
    bool valid(std::size_t id) const { return valid_[id] != 0; }
    const LightMapOptions& options() const { return options_; }

    /// Something changed. Counts up.
    std::uint32_t version() const { return version_; }
    /// Of the last update: texels cast, texels and nodes that changed.
    struct Work {
        std::uint64_t cast = 0, dirty_texels = 0, dirty_nodes = 0;
    };
    const Work& work() const { return work_; }
    std::size_t bytes() const;

 private:
    static constexpr int k_tile = 8;   // texels a side, cast together
    using Tile = std::array<LightNode, k_tile * k_tile>;
    using Distances = std::array<float, k_tile * k_tile>;   // along the texels' rays; infinity: nothing in the way
    using TexelMask = std::uint64_t;                        // a bit a texel of a tile, row by row
    static constexpr TexelMask k_whole_row = (TexelMask{1} << k_tile) - 1, k_whole_tile = ~TexelMask{0};
    static_assert(k_tile * k_tile == 64);
    struct Layers {
        std::vector<light_views::Rect> dynamic_objects;   // footprint now, by place in dynamics_
        std::vector<std::int32_t> slot;   // by tile: where its static layer is kept; -1: the tile is all static
        std::vector<Tile> kept;
        std::vector<Distances> reach;   // by tile: to the static layer
    };
    void make_view(std::size_t v, const scene::SceneState& state, const ray::RayScene& rays, Work& work);
    void repair_view(std::size_t v, std::span<const light_views::Rect> where, const scene::SceneState& state,
                     const ray::RayScene& rays, Work& work);
    void cast_tile(const View& view, int tile, TexelMask which, const scene::SceneState& state,
                   const ray::RayScene& rays, ray::Against against, Tile& texels, Distances& reach) const;
    void make_node(const View& view, int level, int x, int y);
    light_views::Rect footprint(const View& view, const scene::SceneState& state, scene::ObjectId object) const;

    LightMapOptions options_;
    light_views::Casters casters_;
    light_views::SceneBounds bounds_;
    std::vector<View> views_;
    std::vector<Layers> layers_;   // by view
    std::vector<LightNode> nodes_;
    std::vector<std::uint8_t> valid_;
    std::vector<scene::ObjectId> dynamics_;      // that cast
    std::vector<std::uint32_t> dynamic_place_;   // by object; none: static
    std::vector<float> ball_;                    // by place in dynamics_: about the middle of its box; 0: deforms
    std::uint32_t version_ = 1;
    Work work_;
};

}   // namespace gnomon::light_quadtree
