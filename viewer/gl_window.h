// SPDX-License-Identifier: Apache-2.0
#pragma once
// Owns GLFW's window, its OpenGL context, the texture that shows the image, and the context of Dear ImGui. There is one
// window per process.

#define GLFW_INCLUDE_NONE
#include <GL/gl.h>
#include <GLFW/glfw3.h>
#include <imgui.h>

#include <string>

#include "base/image.h"
#include "gnomon/types.h"

namespace gnomon::viewer {

class GlWindow {
 public:
    /// @param size    of the view, in screen coordinates
    /// @param beside  width of what stands beside the view, in screen coordinates of a screen that enlarges nothing
    /// @throws MissingError  if there is no display or no OpenGL 3
    GlWindow(Size size, float beside, const std::string& title);
    ~GlWindow();
    GlWindow(const GlWindow&) = delete;
    GlWindow& operator=(const GlWindow&) = delete;

    /// Starts Dear ImGui without its input callbacks, because InputQueue provides the input.
    void start_ui();
    /// Makes an image of three channels the one that texture() shows.
    void show(const Image8& image);
    ImTextureID texture() const;
    /// Size of the window's content in pixels; 0 x 0 while it is iconified.
    Size framebuffer() const;

    GLFWwindow* handle = nullptr;

 private:
    GLuint texture_ = 0;
    Size texture_size_{};
    bool ui_ = false;
};

}   // namespace gnomon::viewer
