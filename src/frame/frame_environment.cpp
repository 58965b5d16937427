// SPDX-License-Identifier: Apache-2.0
#include "frame/frame_environment.h"

namespace gnomon::frame {

void FrameEnvironment::fit(const RenderOptions& options, bool lights)
{
    rough_ = false;
    if (!lights || options.sun_size != sun_size_) reset();
}

trace::EnvironmentTechnique* FrameEnvironment::of_frame(const scene::SceneState& state, const RenderOptions& options,
                                                        bool lights, bool reference, bool preview)
{
    reference_.reset();
    rough_ = false;
    const double sun_diameter = options.sun_size * k_pi / 180;
    const bool has_image = state.scene().background.kind == scene::Background::Kind::image;
    if (!lights || reference || (!has_image && !(sun_diameter > 0))) {
        technique_.reset();
        if (!reference || !(sun_diameter > 0)) return nullptr;
        reference_ = trace::EnvironmentTechnique::of_every_ray(sun_diameter);
        return reference_.get();
    }
    // A preview, which is no frame of its own, leaves what is remembered.
    if (!technique_ || (options.shadow_culling != ShadowCulling::certified && !preview)) {
        environment_light::EnvironmentOptions made;
        made.sun_diameter = sun_diameter;
        technique_ = std::make_unique<trace::EnvironmentTechnique>(made);
        if (options.interactive) technique_->remember_first();
        sun_size_ = options.sun_size;
    }
    technique_->be_rough(preview);
    rough_ = preview && has_image;
    return technique_.get();
}

}   // namespace gnomon::frame
