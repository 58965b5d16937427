// SPDX-License-Identifier: Apache-2.0
#pragma once
// The views of light maps and the order of their nodes: the same whether rays or Vulkan fill them.
//
// Spot lights have one view, point lights six, directional lights one or two. Cost: a few matrix products a view.

#include <vector>

#include "light_quadtree/light_node.h"
#include "light_views/projection.h"

namespace gnomon::light_quadtree {

struct LightMapOptions {
    int side = 512;                  // texels of a view; a power of two
    std::size_t texels = 1u << 20;   // of all views together, at most; views get smaller sides by halves
    int least_side = 64;
    float least_cosine = 0.05f;   // surfaces at a more grazing angle stand for no larger area
    int most_transparent = 16;    // surfaces that a ray passes before it is given up
    Validity validity;
    bool against_everything = false;   // dynamic objects' tiles are cast as if no static layer were kept: the slow twin
};

/// One view of a light and its pyramid. The grid of level l has 2^l nodes a side; level `levels` are the texels.
struct MapView {
    scene::LightId light = scene::none;
    int face = 0;
    int levels = 0;
    bool on = false;         // nothing to be seen of dark lights
    std::size_t first = 0;   // node
    light_views::ViewProjection projection;
    float depth_range = 1;   // scene units

    int side() const { return 1 << levels; }
    std::size_t node(int level, int x, int y) const
    {
        return first + ((std::size_t{1} << (2 * level)) - 1) / 3 + (static_cast<std::size_t>(y) << level) +
               static_cast<std::size_t>(x);
    }
    std::size_t end() const { return node(levels + 1, 0, 0); }
};

/// Every view of every light that is not of the environment, none aimed yet; their nodes one after the other.
std::vector<MapView> lay_out_views(const scene::Scene& scene, const light_views::SceneBounds& bounds,
                                   const LightMapOptions& options);

/// Follows the light: `on`, `projection`, `depth_range`.
void aim_view(MapView& view, const scene::SceneState& state, const light_views::SceneBounds& bounds);

/// The wide view of a directional light leaves out what this other view has; none of other views.
bool leaves_out(const MapView& view, const scene::SceneState& state, const light_views::SceneBounds& bounds,
                light_views::ViewProjection& near);

}   // namespace gnomon::light_quadtree
