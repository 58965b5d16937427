// SPDX-License-Identifier: Apache-2.0
#pragma once
// The viewer's panels: every option of the table as a widget, times by stage, what was remembered, the picked object,
// the keys.

#include <array>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "viewer/settings.h"

namespace gnomon::viewer {

/// The last frames' times by stage, as stacked bars.
class TimeGraph {
 public:
    void add(const ViewTimes& times);
    void draw() const;

 private:
    static constexpr std::size_t k_length = 160;
    std::array<ViewTimes, k_length> times_{};
    std::size_t next_ = 0, count_ = 0;
};

/// The clip's clock.
struct Playback {
    bool playing = true;
    double frame = 1;   // a fraction says how far to the next
    float speed = 1;
    int frames = 1;
    double fps = 24;

    /// @param seconds  since the last call
    void advance(double seconds);
    void step(int by);
    void go(int to);
    double time(const Scene& scene) const;
};

struct PanelEvents {
    bool options_changed = false;   // of a frame
    bool scene_changed = false;     // of the scene's recipe
    bool screenshot = false;
    bool record = false;         // toggled
    bool scene_camera = false;   // back to it
};

struct HandList {
    std::vector<HandMoved> hands;
    HandMoved* find(scene::NodeId node);
};

class Panel {
 public:
    /// Draws everything for one frame of the window.
    PanelEvents draw(ViewSettings& settings, Playback& playback, HandList& hands, const Scene* scene,
                     const ViewImage* image, const LoadState& load, bool own_camera, bool recording);
    void add(const ViewTimes& times) { graph_.add(times); }

    bool shown = true, help = false;
    std::optional<Picked> picked;
    std::string message;                   // what went wrong last, or was done
    std::set<std::string> options_set;     // by hand, at least once
    std::set<std::string> frozen, moved;   // objects, by hand, at least once

 private:
    void options(ViewSettings& settings, PanelEvents& events);
    void option(ViewSettings& settings, const options::Option& option, PanelEvents& events);
    void player(Playback& playback, const Scene& scene) const;
    void counters(const ViewImage& image) const;
    void object(HandList& hands, const ViewImage& image);
    void keys();
    static void legend(const std::string& overlay);

    TimeGraph graph_;
    std::vector<std::pair<std::string, std::string>> typed_;   // text under way, by option
};

}   // namespace gnomon::viewer
