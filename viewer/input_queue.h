// SPDX-License-Identifier: Apache-2.0
#pragma once
// Queues input events and passes them to Dear ImGui in order, however slow the window's frames are.
//
// GLFW reports only the current position of the mouse and the current state of the keys. A press and release between
// two frames would be lost, and a click would be assigned to the latest mouse position. Therefore events are queued,
// and each frame takes as many as do not hide one another; the others wait for the next frame.
//
// One frame may take several movements, one change of a button, one change of each key, and text followed by a command
// key. Nothing follows a click in the same frame, because the click may open the widget that the next event is for.

#include <chrono>
#include <deque>
#include <functional>
#include <set>

struct GLFWwindow;

namespace gnomon::viewer {

class InputQueue {
 public:
    /// Replaces the window's input callbacks and calls those of Dear ImGui itself.
    /// @param on_key  called for every key pressed or repeated while no text field has the focus
    InputQueue(GLFWwindow* window, std::function<void(int key)> on_key);
    ~InputQueue();
    InputQueue(const InputQueue&) = delete;
    InputQueue& operator=(const InputQueue&) = delete;

    /// Passes this frame's events to Dear ImGui. Call it between ImGui_ImplGlfw_NewFrame and ImGui::NewFrame.
    /// @return whether there were any
    bool feed();
    /// When the first of this frame's events came; without any, when feed() was called.
    std::chrono::steady_clock::time_point came() const { return came_; }
    bool empty() const { return events_.empty(); }

 private:
    struct Event {
        enum class Kind { move, leave, button, wheel, key, text } kind;
        int code = 0, scancode = 0, action = 0,
            mods = 0;   // GLFW's codes of a button or key; for text, `code` is the character
        double x = 0, y = 0;
        std::chrono::steady_clock::time_point came = std::chrono::steady_clock::now();
    };
    // The kinds of events that this frame has taken so far.
    struct Taken {
        std::set<int> keys;
        bool button = false, wheel = false, command = false;
    };
    bool fits(const Event& event, const Taken& taken) const;
    void take(const Event& event, Taken& taken);
    static bool acts(const Event& event);

    static InputQueue* current;   // for GLFW's callbacks; the window's user pointer belongs to the viewer
    GLFWwindow* window_;
    std::function<void(int)> on_key_;
    std::deque<Event> events_;
    double x_, y_;
    std::chrono::steady_clock::time_point came_{};
    bool down_[5] = {};
};

}   // namespace gnomon::viewer
