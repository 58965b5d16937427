// SPDX-License-Identifier: Apache-2.0
#include "light_quadtree/map_views.h"

#include <algorithm>

#include "base/check.h"
#include "light_views/texel_ray.h"

namespace gnomon::light_quadtree {

namespace {

// The depth range of the scene over the whole clip along a view's axis; thresholds are fractions of it.
float depth_range_of(const light_views::ViewProjection& view, const Box3& bounds)
{
    if (!view.perspective) return view.reach;
    const glm::vec3 axis = glm::normalize(view.forward);
    float farthest = 0;
    for (int corner = 0; corner < 8; ++corner) {
        const glm::vec3 p(corner & 1 ? bounds.high.x : bounds.low.x, corner & 2 ? bounds.high.y : bounds.low.y,
                          corner & 4 ? bounds.high.z : bounds.low.z);
        farthest = std::max(farthest, glm::dot(p - view.origin, axis));
    }
    return farthest > 0 ? farthest : 1;
}

}   // namespace

std::vector<MapView> lay_out_views(const scene::Scene& scene, const light_views::SceneBounds& bounds,
                                   const LightMapOptions& options)
{
    std::vector<MapView> views;
    for (scene::LightId l = 0; l < scene.lights.size(); ++l) {
        if (scene.lights[l].of_environment) continue;
        for (int face = 0; face < light_views::view_count(scene.lights[l], bounds, light_views::k_projection); ++face) {
            MapView& view = views.emplace_back();
            view.light = l;
            view.face = face;
        }
    }
    int side = options.side;
    while (side > options.least_side &&
           views.size() * static_cast<std::size_t>(side) * static_cast<std::size_t>(side) > options.texels)
        side /= 2;
    std::size_t end = 0;
    for (MapView& view : views) {
        while ((1 << view.levels) < side) ++view.levels;
        GNOMON_CHECK(view.side() == side);
        view.first = end;
        end = view.end();
    }
    return views;
}

bool same_layout(const std::vector<MapView>& a, const std::vector<MapView>& b)
{
    return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const MapView& x, const MapView& y) {
        return x.light == y.light && x.face == y.face && x.levels == y.levels && x.first == y.first;
    });
}

void aim_view(MapView& view, const scene::SceneState& state, const light_views::SceneBounds& bounds)
{
    const scene::Light& light = state.scene().lights[view.light];
    const scene::LightState& at = state.light(view.light);
    view.on = at.visible && light.color != glm::vec3(0);
    if (!view.on) return;
    view.projection = light_views::project(light, at, bounds, view.side(),
                                           light_views::k_projection)[static_cast<std::size_t>(view.face)];
    view.depth_range = depth_range_of(view.projection, bounds.whole);
}

bool leaves_out(const MapView& view, const scene::SceneState& state, const light_views::SceneBounds& bounds,
                light_views::ViewProjection& near)
{
    const scene::Light& light = state.scene().lights[view.light];
    if (light.type != scene::LightType::directional || view.face != 1) return false;
    near = light_views::project(light, state.light(view.light), bounds, view.side(), light_views::k_projection)[0];
    return true;
}

}   // namespace gnomon::light_quadtree
