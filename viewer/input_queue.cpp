// SPDX-License-Identifier: Apache-2.0
#include "viewer/input_queue.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <backends/imgui_impl_glfw.h>
#include <imgui.h>

#include <algorithm>
#include <cfloat>
#include <cstddef>

namespace gnomon::viewer {

namespace {

constexpr int k_first_named_key = 256;   // GLFW's codes below this one are keys that type a character

bool modifier(int key)
{
    return key >= GLFW_KEY_LEFT_SHIFT && key <= GLFW_KEY_RIGHT_SUPER;
}

}   // namespace

InputQueue* InputQueue::current = nullptr;

InputQueue::InputQueue(GLFWwindow* window, std::function<void(int key)> on_key)
    : window_(window), on_key_(std::move(on_key)), x_(-FLT_MAX), y_(-FLT_MAX)
{
    current = this;
    using Kind = Event::Kind;
    glfwSetCursorPosCallback(window, [](GLFWwindow*, double x, double y) {
        current->events_.push_back({.kind = Kind::move, .x = x, .y = y});
    });
    glfwSetCursorEnterCallback(window, [](GLFWwindow*, int entered) {
        if (!entered) current->events_.push_back({.kind = Kind::leave});
    });
    glfwSetMouseButtonCallback(window, [](GLFWwindow*, int button, int action, int mods) {
        current->events_.push_back({.kind = Kind::button, .code = button, .action = action, .mods = mods});
    });
    glfwSetScrollCallback(window, [](GLFWwindow*, double x, double y) {
        current->events_.push_back({.kind = Kind::wheel, .x = x, .y = y});
    });
    glfwSetKeyCallback(window, [](GLFWwindow*, int key, int scancode, int action, int mods) {
        current->events_.push_back(
            {.kind = Kind::key, .code = key, .scancode = scancode, .action = action, .mods = mods});
    });
    glfwSetCharCallback(window, [](GLFWwindow*, unsigned int character) {
        current->events_.push_back({.kind = Kind::text, .code = static_cast<int>(character)});
    });
    glfwSetWindowFocusCallback(window, ImGui_ImplGlfw_WindowFocusCallback);
}

InputQueue::~InputQueue()
{
    glfwSetCursorPosCallback(window_, nullptr);
    glfwSetCursorEnterCallback(window_, nullptr);
    glfwSetMouseButtonCallback(window_, nullptr);
    glfwSetScrollCallback(window_, nullptr);
    glfwSetKeyCallback(window_, nullptr);
    glfwSetCharCallback(window_, nullptr);
    glfwSetWindowFocusCallback(window_, nullptr);
    current = nullptr;
}

// Whether the event is a command key: Return, Backspace, Control with a letter; outside text fields, any key.
bool InputQueue::acts(const Event& event)
{
    if (event.kind != Event::Kind::key || event.action == GLFW_RELEASE || modifier(event.code)) return false;
    return event.code >= k_first_named_key || (event.mods & GLFW_MOD_CONTROL) || !ImGui::GetIO().WantTextInput;
}

// Whether the frame may take the event in addition to those it has taken.
bool InputQueue::fits(const Event& event, const Taken& taken) const
{
    switch (event.kind) {
        case Event::Kind::move:
        case Event::Kind::leave:
            return !taken.button && !taken.wheel;
        case Event::Kind::button:
            return !taken.button && !taken.wheel && !taken.command;
        case Event::Kind::wheel:
            return !taken.button;
        case Event::Kind::key:
            if (event.action == GLFW_REPEAT) return !taken.button;   // Dear ImGui repeats by itself
            // Keep a modifier for the command key that it is held down for.
            if (taken.button || ((acts(event) || modifier(event.code)) && taken.command)) return false;
            // Accept a letter twice while text is typed.
            return !taken.keys.contains(event.code) ||
                   (event.code < k_first_named_key && ImGui::GetIO().WantTextInput && !taken.command);
        case Event::Kind::text:
            return !taken.button && !taken.command;
    }
    return true;
}

void InputQueue::take(const Event& event, Taken& taken)
{
    ImGuiIO& io = ImGui::GetIO();
    switch (event.kind) {
        case Event::Kind::move:
            x_ = event.x, y_ = event.y;
            break;
        case Event::Kind::leave:
            if (std::none_of(std::begin(down_), std::end(down_), [](bool down) { return down; })) x_ = y_ = -FLT_MAX;
            break;
        case Event::Kind::button:
            if (event.code < static_cast<int>(std::size(down_)))
                down_[static_cast<std::size_t>(event.code)] = event.action == GLFW_PRESS;
            taken.button = true;
            break;
        case Event::Kind::wheel:
            ImGui_ImplGlfw_ScrollCallback(window_, event.x, event.y);
            taken.wheel = true;
            break;
        case Event::Kind::key:
            ImGui_ImplGlfw_KeyCallback(window_, event.code, event.scancode, event.action, event.mods);
            if (event.action != GLFW_RELEASE && !io.WantTextInput) on_key_(event.code);
            taken.keys.insert(event.code);
            taken.command |= acts(event) || modifier(event.code);
            break;
        case Event::Kind::text:
            ImGui_ImplGlfw_CharCallback(window_, static_cast<unsigned>(event.code));
            break;
    }
}

bool InputQueue::feed()
{
    Taken taken;
    const bool any = !events_.empty();
    came_ = any ? events_.front().came : std::chrono::steady_clock::now();
    while (!events_.empty() && fits(events_.front(), taken)) {
        take(events_.front(), taken);
        events_.pop_front();
    }
    ImGuiIO& io = ImGui::GetIO();
    io.MousePos = {static_cast<float>(x_), static_cast<float>(y_)};
    std::copy(std::begin(down_), std::end(down_), io.MouseDown);
    return any;
}

}   // namespace gnomon::viewer
