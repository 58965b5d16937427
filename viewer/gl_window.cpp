// SPDX-License-Identifier: Apache-2.0
#include "viewer/gl_window.h"

#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "gnomon/error.h"

namespace gnomon::viewer {

namespace {

std::string last_error()
{
    const char* text = nullptr;
    glfwGetError(&text);
    return text ? text : "no display";
}

}   // namespace

GlWindow::GlWindow(Size size, float beside, const std::string& title)
{
    if (!glfwInit()) throw MissingError(fmt::format("cannot open a window: {}", last_error()));
    glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
    glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 2);
    glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
    glfwWindowHint(GLFW_OPENGL_FORWARD_COMPAT, GLFW_TRUE);
    float scale = 1, unused = 1;
    if (GLFWmonitor* const monitor = glfwGetPrimaryMonitor()) glfwGetMonitorContentScale(monitor, &scale, &unused);
    const int width = size.width + static_cast<int>(std::lround(beside * std::max(scale, 1.0f)));
    handle = glfwCreateWindow(width, size.height, title.c_str(), nullptr, nullptr);
    if (!handle) {
        const std::string why = last_error();
        glfwTerminate();
        throw MissingError(fmt::format("cannot open a window: {}", why));
    }
    glfwMakeContextCurrent(handle);
    glfwSwapInterval(1);
    IMGUI_CHECKVERSION();
    ImGui::CreateContext();
    ImGui::GetIO().IniFilename = nullptr;
    ImGui::StyleColorsDark();
    ImGui::GetStyle().WindowRounding = 4;
}

GlWindow::~GlWindow()
{
    if (source_) glDeleteFramebuffers(1, &source_);
    if (texture_) glDeleteTextures(1, &texture_);
    if (ui_) {
        ImGui_ImplOpenGL3_Shutdown();
        ImGui_ImplGlfw_Shutdown();
    }
    ImGui::DestroyContext();
    glfwDestroyWindow(handle);
    glfwTerminate();
}

void GlWindow::start_ui()
{
    float scale = 1, unused = 1;
    glfwGetWindowContentScale(handle, &scale, &unused);
    ImGui::GetIO().FontGlobalScale = std::max(scale, 1.0f);
    ImGui_ImplGlfw_InitForOpenGL(handle, false);
    ImGui_ImplOpenGL3_Init("#version 150");
    ui_ = true;
}

void GlWindow::draw(const Image8& image, std::uint64_t number, int left, int top, Size size)
{
    if (size.width < 1 || size.height < 1) return;
    if (!texture_) {
        glGenTextures(1, &texture_);
        glGenFramebuffers(1, &source_);
    }
    glBindFramebuffer(GL_READ_FRAMEBUFFER, source_);
    if (number != number_ || !(size == texture_size_)) {
        const std::vector<std::uint8_t>& texels = stretcher_.stretched(image, size);
        glBindTexture(GL_TEXTURE_2D, texture_);
        glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
        if (size == texture_size_)
            glTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, size.width, size.height, GL_BGRA, GL_UNSIGNED_BYTE, texels.data());
        else
            glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, size.width, size.height, 0, GL_BGRA, GL_UNSIGNED_BYTE,
                         texels.data());
        glFramebufferTexture2D(GL_READ_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, texture_, 0);
        texture_size_ = size, number_ = number;
    }
    // The texture's first row is the top one; OpenGL counts from the bottom.
    const int bottom = framebuffer().height - top - size.height;
    glBlitFramebuffer(0, size.height, size.width, 0, left, bottom, left + size.width, bottom + size.height,
                      GL_COLOR_BUFFER_BIT, GL_NEAREST);
    glBindFramebuffer(GL_READ_FRAMEBUFFER, 0);
}

Size GlWindow::framebuffer() const
{
    Size size;
    glfwGetFramebufferSize(handle, &size.width, &size.height);
    return size;
}

}   // namespace gnomon::viewer
