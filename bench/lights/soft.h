// SPDX-License-Identifier: Apache-2.0
#pragma once
// Soft shadow textures (shadow_textures/soft_textures.h) of planar lights, kept from frame to frame as bench lights
// measures them.

#include <memory>
#include <span>

#include "area_light/area_visibility.h"
#include "shadow_textures/soft_textures.h"
#include "visibility/shadow_point.h"

namespace gnomon::bench {

class SoftTextures {
 public:
    static constexpr int k_view_size = 512;   // texels a side of each of a light's five views

    explicit SoftTextures(shadow_textures::SoftScale scale) : scale_(scale) {}

    /// Brings views and textures up to date. The number of lights must stay.
    void update(const scene::SceneState& state, std::span<const area_light::AreaLight> lights);
    /// The visible part of a light, 0 to 1.
    float share(std::size_t light, const visibility::ShadowPoint& point) const;
    /// Textures that the last update made, and all that there are.
    std::size_t updated() const { return updated_; }
    std::size_t textures() const { return textures_; }

 private:
    shadow_textures::SoftScale scale_;
    std::vector<scene::Light> kinds_;
    std::vector<scene::LightState> states_;
    std::vector<scene::LightId> moved_, moved_before_;
    std::unique_ptr<light_views::LightViews> views_;
    std::vector<light_views::SoftwareView> buffers_;            // by view
    std::vector<shadow_textures::CoherentSoftTextures> kept_;   // by view
    std::size_t updated_ = 0, textures_ = 0;
};

}   // namespace gnomon::bench
