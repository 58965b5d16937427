// SPDX-License-Identifier: Apache-2.0
#pragma once
// Answers requests for rendering, one after the other, and keeps what two in turn have in common.
//
// Requests that show the same things at other places, or from elsewhere, use the scene and the caches of the one
// before: the nodes' matrices are handed over as a host's. All nodes are declared movable from the start, and a scene
// without lights is lit by an environment that does not depend on it, so that an answer depends on its request alone.

#include <filesystem>
#include <memory>
#include <string>

#include "cli/serve/form.h"
#include "gnomon/renderer.h"

namespace gnomon::cli {

struct Answer {
    std::string type, body;    // MIME type; the image's file
    bool reused = false;       // the scene of the request before was used
    double milliseconds = 0;   // of the frame
};

class RenderService {
 public:
    /// @param options      of colour images; size, camera and layers are those of the request
    /// @param environment  lights scenes without lights: a file, or builtin:studio
    /// @throws MissingError  no folder for temporary files
    RenderService(RenderOptions options, std::string environment);
    ~RenderService();
    RenderService(const RenderService&) = delete;
    RenderService& operator=(const RenderService&) = delete;

    /// @param scene     a glTF file, text or binary, that contains all it needs
    /// @param progress  returns false to stop
    /// @throws UsageError, InputError  the request is wrong
    /// @throws MissingError, InterruptedError
    Answer answer(const RenderForm& form, const std::string& scene, const Progress& progress);

 private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}   // namespace gnomon::cli
