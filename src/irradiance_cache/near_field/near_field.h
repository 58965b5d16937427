// SPDX-License-Identifier: Apache-2.0
#pragma once
// The near field of a scene: its radius, which follows the light tree, and where it is needed (near_hints.h).
//
// The radius is that from which leaves of the light tree can mostly tell surfaces apart. It changes in steps, so that
// hints and cache points stay valid while lights move a little. Where light grazes a surface, leaves are many times
// wider: a ceiling beside a light has one for a metre, and the wall below it cannot tell which part of it is lit. So the
// short rays of lattice points go farther than the radius, to leaves that are so wide.

#include <memory>

#include "irradiance_cache/cache_options.h"
#include "irradiance_cache/near_field/near_hints.h"
#include "irradiance_cache/near_field/near_light.h"

namespace gnomon::irradiance_cache {

class NearField {
 public:
    explicit NearField(const CacheOptions& options) : options_(options) {}
    /// Follows the light tree after its geometry changed.
    void update(const LightTree& tree);
    /// Forgets all hints: because static geometry changed, or some will never be answered.
    void forget_hints();
    /// Drops the hints until the next change of the radius or of the light tree.
    void drop_hints() { hints_.reset(); }

    const NearLight& light() const { return light_; }
    /// Scene units; 0: there is no near field. The short rays of light() are longer.
    float radius() const { return radius_; }
    /// Null where there is no near field.
    NearHints* hints() const { return hints_.get(); }
    /// The width of a pixel, in scene units, from which the near field fades. From twice as wide on there is none.
    float fade_width() const { return fade_width_; }
    /// Whether near-field points take the place of the near fields that lattice points of this spacing hold. They do
    /// not between points that are farther apart than the near field reaches.
    bool applies_at(float spacing) const { return spacing <= options_.near_spacing * radius_; }
    std::size_t bytes() const { return hints_ ? hints_->bytes() : 0; }

 private:
    bool surface_lights() const { return !options_.light_tree.patches.emission; }

    const CacheOptions& options_;
    NearLight light_;
    std::unique_ptr<NearHints> hints_;
    float radius_ = 0, fade_width_ = 0;
};

}   // namespace gnomon::irradiance_cache
