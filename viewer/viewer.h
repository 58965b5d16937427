// SPDX-License-Identifier: Apache-2.0
#pragma once
// The window: GLFW and Dear ImGui on OpenGL 3, which any machine has, if only in software. Images come from a
// ViewSession; this thread draws the latest and never waits for one.

#include <functional>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "viewer/settings.h"

namespace gnomon::viewer {

struct ViewSummary {
    std::uint64_t window_frames = 0, images = 0, loads = 0;
    double longest_ms = 0;   // of a window frame, waiting left out
    double median_image_ms = 0;
    std::vector<std::string> files;        // written
    std::set<std::string> options_set;     // in the panel
    std::set<std::string> frozen, moved;   // objects, by hand
};

class Viewer {
 public:
    /// @throws MissingError  no display, or no OpenGL 3
    Viewer(ViewSettings settings, std::string what, int threads);
    ~Viewer();
    /// Until the window is closed, Escape is pressed, or `stopped` returns true; it is called once a window frame.
    ViewSummary run(const std::function<bool()>& stopped);

 private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}   // namespace gnomon::viewer
