// SPDX-License-Identifier: Apache-2.0
#include "irradiance_cache/near_field/near_field.h"

#include <cmath>

#include "irradiance_cache/points/anchors.h"

namespace gnomon::irradiance_cache {

void NearField::update(const LightTree& tree)
{
    const float wanted = options_.near_radius * tree.leaf_spacing();
    if (!(wanted > 0) || !std::isfinite(wanted)) {
        radius_ = 0;
        light_ = NearLight({0, options_.near_rays, surface_lights()});
        hints_.reset();
        return;
    }
    constexpr float k_steps = 2;   // to twice the radius
    const float radius = std::exp2(std::round(k_steps * std::log2(wanted)) / k_steps);
    if (hints_ && radius == radius_) return;
    radius_ = radius;
    light_ =
        NearLight({options_.near_reach * radius, options_.near_rays, surface_lights(), &tree, options_.near_widths});
    forget_hints();
    // The widest lattice level at this width is the widest of those where the near field applies, a power of two.
    fade_width_ = 2 * spacing_of(detail_of(options_.near_spacing * radius).level) / options_.widest;
}

void NearField::forget_hints()
{
    const NearHintOptions options{.radius = radius_, .memory = options_.memory / 4};
    hints_ = options.radius > 0 ? std::make_unique<NearHints>(options) : nullptr;
}

}   // namespace gnomon::irradiance_cache
