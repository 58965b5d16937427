// SPDX-License-Identifier: Apache-2.0
#pragma once
// Runs the viewer's window with GLFW and Dear ImGui on OpenGL 3, which every machine has, at least in software. A
// ViewSession renders the images in the background; the window's thread draws the latest one and never waits.

#include <functional>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "viewer/latency.h"
#include "viewer/settings.h"

namespace gnomon::viewer {

struct ViewSummary {
    std::uint64_t window_frames = 0, images = 0, loads = 0;
    double longest_ms = 0;   // longest frame of the window, without waiting for the screen
    double median_image_ms = 0;
    /// How long inputs that change the image, such as drags, keys and options, waited until the window showed them, by
    /// an image that was moved or a new one; and until it showed one that was rendered for them.
    Latency::Summary latency, rendered;
    std::vector<std::string> files;        // files written
    std::set<std::string> options_set;     // options set in the panel
    std::set<std::string> frozen, moved;   // objects that the user froze or moved
};

class Viewer {
 public:
    /// @param scene  a file or a built-in scene
    /// @throws MissingError  if there is no display or no OpenGL 3
    Viewer(ViewSettings settings, std::string scene, int threads);
    ~Viewer();
    /// Runs until the window is closed, Escape is pressed, or `stopped`, which is called in every frame of the window,
    /// returns true.
    ViewSummary run(const std::function<bool()>& stopped);

 private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}   // namespace gnomon::viewer
