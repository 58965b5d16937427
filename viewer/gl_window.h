// SPDX-License-Identifier: Apache-2.0
#pragma once
// Owns GLFW's window, its OpenGL context, the image that it shows, and the context of Dear ImGui. There is one window
// per process.
//
// The image is stretched to the screen's pixels here (stretch.h), and copied into the window without a shader, because
// without a graphics card both are several times as fast as drawing a textured rectangle.

#define GLFW_INCLUDE_NONE
#define GL_GLEXT_PROTOTYPES
#include <GL/gl.h>
#include <GL/glext.h>
#include <GLFW/glfw3.h>
#include <imgui.h>

#include <cstdint>
#include <string>

#include "base/image.h"
#include "gnomon/types.h"
#include "viewer/stretch.h"

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
    /// Draws an image of three channels. Where it is the same as in the last call, it is only copied.
    /// @param number  of the image: another one for another image
    /// @param left, top  in pixels of the window's content, from its top left corner
    /// @param size       in these pixels
    void draw(const Image8& image, std::uint64_t number, int left, int top, Size size);
    /// Size of the window's content in pixels; 0 x 0 while it is iconified.
    Size framebuffer() const;

    GLFWwindow* handle = nullptr;

 private:
    GLuint texture_ = 0, source_ = 0;   // source: a framebuffer of the texture
    Size texture_size_{};
    std::uint64_t number_ = 0;   // of the image in the texture; 0: none
    Stretcher stretcher_;
    bool ui_ = false;
};

}   // namespace gnomon::viewer
