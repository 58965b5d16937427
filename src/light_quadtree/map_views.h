// SPDX-License-Identifier: Apache-2.0
#pragma once
// The views of light maps and the layout of their nodes, the same for ray tracing and for Vulkan.
//
// Spot lights have one view, point lights six, directional lights one or two. Cost: a few matrix products per view.

#include <vector>

#include "light_quadtree/light_node.h"
#include "light_views/projection.h"

namespace gnomon::light_quadtree {

struct LightMapOptions {
    int side = 512;                  // texels of a view; a power of two
    std::size_t texels = 1u << 20;   // limit on all views together; to fit, the sides of views are halved
    int least_side = 64;
    float least_cosine = 0.05f;   // limits the area of a texel on surfaces at grazing angles
    int most_transparent = 16;    // surfaces that a ray passes through at most
    Validity validity;
    /// Static and dynamic texels form trees of their own (LightMap::Tree); false: one tree, as published. Traced maps.
    bool separate_trees = false;
    bool against_everything = false;   // ignore the static layer for dynamic objects; slow, for tests
};

/// One view of a light and its pyramid. Level l is a grid of 2^l nodes a side; level `levels` are the texels.
struct MapView {
    scene::LightId light = scene::none;
    int face = 0;
    int levels = 0;
    bool on = false;         // false: the light is dark
    std::size_t first = 0;   // index of the first node
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

/// Makes the views of all lights except those of the environment, not aimed yet, with consecutive nodes.
std::vector<MapView> lay_out_views(const scene::Scene& scene, const light_views::SceneBounds& bounds,
                                   const LightMapOptions& options);

/// Whether two layouts have the same views and nodes, wherever they are aimed.
bool same_layout(const std::vector<MapView>& a, const std::vector<MapView>& b);

/// Updates the view for the current light: `on`, `projection`, `depth_range`.
void aim_view(MapView& view, const scene::SceneState& state, const light_views::SceneBounds& bounds);

/// Whether this is the wide view of a directional light, which skips the part that its other view covers;
/// `near` then gets the projection of that view.
bool leaves_out(const MapView& view, const scene::SceneState& state, const light_views::SceneBounds& bounds,
                light_views::ViewProjection& near);

}   // namespace gnomon::light_quadtree
