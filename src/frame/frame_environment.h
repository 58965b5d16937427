// SPDX-License-Identifier: Apache-2.0
#pragma once
// The environment technique of traced frames (trace/environment_lighting.h), made and kept as options and scene need
// it.

#include <memory>

#include "gnomon/renderer.h"
#include "scene/state.h"
#include "trace/environment_lighting.h"

namespace gnomon::frame {

class FrameEnvironment {
 public:
    void reset() { technique_.reset(), reference_.reset(); }
    /// Discards what other options made. @param lights  the frame is traced and shows light
    void fit(const RenderOptions& options, bool lights);
    /// The technique of a frame; null: it needs none. What is remembered outlives it with certified culling alone.
    /// @param reference  the frame's indirect light is the reference, which samples environment images by itself
    /// @param preview    FrameInput::preview
    trace::EnvironmentTechnique* of_frame(const scene::SceneState& state, const RenderOptions& options, bool lights,
                                          bool reference, bool preview = false);
    /// Whether the last frame's environment image is roughly seen.
    bool rough() const { return rough_; }
    std::size_t bytes() const { return technique_ ? technique_->bytes() : 0; }

 private:
    std::unique_ptr<trace::EnvironmentTechnique> technique_;   // saw the last advance
    std::unique_ptr<trace::EnvironmentTechnique> reference_;   // of suns; of the last frame
    bool rough_ = false;
    double sun_size_ = 0;   // that the technique was made with
};

}   // namespace gnomon::frame
