// SPDX-License-Identifier: Apache-2.0
// The part of a tile's work that shows it: from what its shadows were answered, and which answers were wrong. Nothing
// here changes the image.
#include <algorithm>

#include "scene/light_reach.h"
#include "trace/tile_tracer.h"

namespace gnomon::trace {

// Says of every first hit from what this light's shadow is answered there.
void TileTracer::mark_states(std::size_t l, const TileRect& tile)
{
    const auto panel = std::find(states_->lights.begin(), states_->lights.end(), static_cast<int>(l));
    if (panel == states_->lights.end()) return;
    std::uint8_t* const cells = states_->panel(static_cast<std::size_t>(panel - states_->lights.begin()));
    for (std::uint32_t p = 0; p < points_.size(); ++p) {
        const shading::SurfacePoint& s = points_[p].surface;
        const std::size_t pixel = pixel_of_image(points_[p].pixel, tile);
        bool untrusted = false;
        const StateMark mark = mark_of(p, l, untrusted);
        cells[pixel] =
            static_cast<std::uint8_t>(static_cast<unsigned>(mark) | (untrusted ? StateCell::k_untrusted : 0u));
        const float facing = std::clamp(std::abs(glm::dot(s.normal, s.to_viewer)), 0.0f, 1.0f);
        states_->shade[pixel] = static_cast<std::uint8_t>(facing * 255.0f + 0.5f);
    }
}

StateMark TileTracer::mark_of(std::uint32_t p, std::size_t l, bool& untrusted) const
{
    const scene::Light& light = scene_.lights[l];
    const scene::LightState& at = state_.light(static_cast<scene::LightId>(l));
    const shadow_culling::ShadowPoint& here = shadow_points_[p];
    const glm::vec3 to_light = scene::LightReach(light, at).from(here.origin);
    if (!at.visible || !scene::LightReach::faces(to_light, here.normal) ||
        !scene::LightReach::faces(to_light, shading_normals_[p]) ||
        scene::illuminate(light, at, points_[p].surface.position).irradiance == glm::vec3(0))
        return StateMark::away;
    if (state_.is_dynamic(here.object)) return StateMark::moving;
    if (culling_) switch (culling_->state_of(*batch_, p, static_cast<int>(l))) {
            case shadow_culling::ShadowState::none:
                return StateMark::none;
            case shadow_culling::ShadowState::full:
                return StateMark::full;
            case shadow_culling::ShadowState::partial:
                return StateMark::partial;
            case shadow_culling::ShadowState::unknown:
                return StateMark::unknown;
        }
    if (!paper_) return StateMark::unknown;
    const shadow_culling::PrimitiveId origin = paper_->primitive(here.object, here.triangle);
    if (paper_->triangles().is_dynamic(origin)) return StateMark::moving;
    untrusted = paper_->modes().occlusion(origin) != shadow_culling::OcclusionMode::fully_rendered;
    switch (paper_->modes().shadow(origin, static_cast<int>(l))) {
        case shadow_culling::ShadowMode::non_shadow:
            return StateMark::none;
        case shadow_culling::ShadowMode::full_shadow:
            return StateMark::full;
        case shadow_culling::ShadowMode::partial_shadow:
            return StateMark::partial;
        case shadow_culling::ShadowMode::init:
            break;
    }
    return StateMark::unknown;
}

// Traces every ray after all, and counts and marks the answers that differ.
void TileTracer::check_lit(std::size_t l, bool primary, const TileRect& tile)
{
    queue_shadow_rays(l);
    shadow_rays_.purpose = ray::RayClass::check;
    const std::size_t count = shadow_rays_.size();
    occluded_.resize(count + ray::k_packet_pad);
    rays_.occluded(shadow_rays_, 0, count, occluded_.data());
    found_lit_.assign(points_.size(), 0);
    for (const std::uint32_t p : lit_) found_lit_[p] = 1;

    const auto panel = std::find(states_->lights.begin(), states_->lights.end(), static_cast<int>(l));
    const bool shown = panel != states_->lights.end();
    const auto flag = static_cast<std::uint8_t>(primary ? StateCell::k_wrong : StateCell::k_wrong_behind);
    for (std::size_t i = 0; i < count; ++i) {
        const std::uint32_t p = shadow_point_[i];
        if (found_lit_[p] == !occluded_[i]) continue;
        ++*counters_.shadow.rays_wrong;
        if (shown)
            states_->panel(static_cast<std::size_t>(
                panel - states_->lights.begin()))[pixel_of_image(points_[p].pixel, tile)] |= flag;
    }
}

}   // namespace gnomon::trace
