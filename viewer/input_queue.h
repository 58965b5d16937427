// SPDX-License-Identifier: Apache-2.0
#pragma once
// Input events in their order, however slow the window's frames are. GLFW says where the mouse is and which keys are
// down *now*: a press and its release between two frames leave no trace, and a click belongs to wherever the mouse went
// since. So events are queued, and a frame takes as many as cannot hide one another (the rest wait for the next one).
//
// What a frame may see together: movements; one change of a button, of a key; text; a key that acts after the text
// before it. Not: anything after a click, since the click may open what the next event is meant for.

#include <deque>
#include <functional>
#include <set>

struct GLFWwindow;

namespace gnomon::viewer {

class InputQueue {
 public:
    /// Takes the place of the window's callbacks for input; Dear ImGui's are called from here.
    /// @param on_key  called for every key pressed or repeated that no text field takes
    InputQueue(GLFWwindow* window, std::function<void(int key)> on_key);
    ~InputQueue();
    InputQueue(const InputQueue&) = delete;
    InputQueue& operator=(const InputQueue&) = delete;

    /// After ImGui_ImplGlfw_NewFrame, before ImGui::NewFrame: gives Dear ImGui this frame's share.
    void feed();
    bool empty() const { return events_.empty(); }

 private:
    struct Event {
        enum class Kind { move, leave, button, wheel, key, text } kind;
        int code = 0, scancode = 0, action = 0, mods = 0;   // button or key, as GLFW names them; text: a character
        double x = 0, y = 0;
    };
    // What this frame has taken so far.
    struct Taken {
        std::set<int> keys;
        bool button = false, wheel = false, command = false;
    };
    bool fits(const Event& event, const Taken& taken) const;
    void take(const Event& event, Taken& taken);
    static bool acts(const Event& event);

    static InputQueue* current;   // GLFW's callbacks carry no data of ours but the window's pointer, which is taken
    GLFWwindow* window_;
    std::function<void(int)> on_key_;
    std::deque<Event> events_;
    double x_, y_;
    bool down_[5] = {};
};

}   // namespace gnomon::viewer
