// SPDX-License-Identifier: Apache-2.0
#pragma once
// Checks what a host hands over for a frame, and stores it by the scene's own indices.

#include <memory>

#include "api/scene_access.h"
#include "frame/host_values.h"
#include "gnomon/frame_input.h"

namespace gnomon::api {

class HostState {
 public:
    /// Takes over a frame's input. Values of an earlier scene stay in force for the parts that this one still has.
    /// @throws UsageError  something is invalid; then nothing is taken over
    void apply(const Scene& scene, const FrameInput& input);

    /// The scene's values. @pre apply() was called
    frame::HostValues& values() { return *values_; }
    /// Whether a scene is that of the last apply(), or has a node in common with it.
    bool follows(const Scene& scene) const;
    /// The scene of the last apply(); none before.
    const Scene* scene() const { return scene_ ? &*scene_ : nullptr; }

 private:
    void follow(const Scene& scene);

    std::optional<Scene> scene_;
    std::unique_ptr<frame::HostValues> values_;
};

}   // namespace gnomon::api
