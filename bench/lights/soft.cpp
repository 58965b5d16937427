// SPDX-License-Identifier: Apache-2.0
#include "bench/lights/soft.h"

#include <algorithm>

#include "shadow_textures/lookup.h"

namespace gnomon::bench {

namespace {

constexpr float k_lift = 1e-3f;   // of the light's size: views begin in front of its own surface

shadow_textures::SoftLight soft_light_of(const area_light::LightPolygon& p)
{
    shadow_textures::SoftLight light;
    light.half_s = 0.5f * (p.corner[1] - p.corner[0]);
    light.half_t = 0.5f * (p.corner[static_cast<std::size_t>(p.corners - 1)] - p.corner[0]);
    return light;
}

}   // namespace

void SoftTextures::update(const scene::SceneState& state, std::span<const area_light::AreaLight> lights)
{
    // Place a view's origin at each light's middle.
    std::vector<scene::LightState> states;
    for (const area_light::AreaLight& light : lights) {
        const area_light::LightPolygon& p = light.shape.outline;
        glm::vec3 middle(0);
        for (int k = 0; k < p.corners; ++k) middle += p.corner[static_cast<std::size_t>(k)];
        middle /= static_cast<float>(p.corners);
        states.push_back({middle + k_lift * glm::length(p.corner[1] - p.corner[0]) * p.normal, p.normal, true});
    }
    moved_before_.swap(moved_);
    moved_.clear();
    std::vector<scene::LightId> started;
    for (scene::LightId l = 0; l < states_.size(); ++l) {
        if (states[l] == states_[l]) continue;
        moved_.push_back(l);
        if (!std::binary_search(moved_before_.begin(), moved_before_.end(), l)) started.push_back(l);
    }
    states_ = std::move(states);
    if (!views_) {
        kinds_.resize(lights.size());
        for (scene::Light& kind : kinds_)
            kind.type = scene::LightType::spot, kind.outer_angle = static_cast<float>(k_pi / 2);
        light_views::LightViewsOptions options;
        options.projection.half_cubes = true;
        options.atlas.view_size = k_view_size;
        options.receivers = true;
        views_ = std::make_unique<light_views::LightViews>(state, light_views::ViewedLights{kinds_, states_, {}, {}},
                                                           options);
        for (const light_views::LightView& view : views_->views()) buffers_.emplace_back(view.tile.size);
        kept_.assign(buffers_.size(), shadow_textures::CoherentSoftTextures(scale_));
    }
    views_->update(state, {kinds_, states_, moved_, started});

    updated_ = textures_ = 0;
    for (std::size_t v = 0; v < buffers_.size(); ++v) {
        const light_views::LightView& view = views_->views()[v];
        buffers_[v].execute(view.plan, view.projection, state);
        kept_[v].update(view, buffers_[v].rendering(), views_->casters(), state,
                        soft_light_of(lights[view.light].shape.outline));
        updated_ += kept_[v].updated(), textures_ += kept_[v].textures().size();
    }
}

float SoftTextures::share(std::size_t light, const visibility::ShadowPoint& point) const
{
    const std::uint32_t first = views_->first_view(static_cast<scene::LightId>(light));
    const std::span<const light_views::LightView> views(views_->views().data() + first, 5);
    const light_views::LightView* view = shadow_textures::view_of(views, point.origin);
    const auto& textures = kept_[static_cast<std::size_t>(view - views_->views().data())].textures();
    const auto found = textures.find(point.object);
    if (found == textures.end()) return 1;
    return shadow_textures::soft_visibility(view->projection, found->second, point.origin, point.normal);
}

}   // namespace gnomon::bench
