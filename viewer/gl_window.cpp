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

void GlWindow::show(const Image8& image)
{
    if (!texture_) {
        glGenTextures(1, &texture_);
        glBindTexture(GL_TEXTURE_2D, texture_);
        glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
        glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    }
    glBindTexture(GL_TEXTURE_2D, texture_);
    glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
    const Size size{image.width, image.height};
    if (size == texture_size_) {
        glTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, size.width, size.height, GL_RGB, GL_UNSIGNED_BYTE, image.data.data());
        return;
    }
    glTexImage2D(GL_TEXTURE_2D, 0, GL_RGB8, size.width, size.height, 0, GL_RGB, GL_UNSIGNED_BYTE, image.data.data());
    texture_size_ = size;
}

ImTextureID GlWindow::texture() const
{
    return reinterpret_cast<ImTextureID>(static_cast<std::uintptr_t>(texture_));
}

Size GlWindow::framebuffer() const
{
    Size size;
    glfwGetFramebufferSize(handle, &size.width, &size.height);
    return size;
}

}   // namespace gnomon::viewer
