// SPDX-License-Identifier: Apache-2.0
#pragma once
// The viewer's panel: a widget for every option of the table, frame times by stage, counters, the picked object and the
// list of keys.

#include <array>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "viewer/settings.h"

namespace gnomon::viewer {

/// Draws the times of the latest frames as stacked bars, one colour per stage.
class TimeGraph {
 public:
    void add(const ViewTimes& times);
    void draw() const;

 private:
    static constexpr std::size_t k_length = 160;
    std::array<ViewTimes, k_length> times_{};
    std::size_t next_ = 0, count_ = 0;
};

/// The position in the animation, and whether and how fast it plays.
struct Playback {
    bool playing = true;
    double frame = 1;   // from 1; a fractional part lies between two frames
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
    bool options_changed = false;   // options of the frame; render again
    bool scene_changed = false;     // options of the scene; load it again
    bool screenshot = false;
    bool record = false;         // start or stop recording
    bool scene_camera = false;   // return to the scene's camera
};

/// The user overrides: objects that the user froze or moved.
struct OverrideList {
    std::vector<UserOverride> list;
    UserOverride* find(const NodeId& node);
};

class Panel {
 public:
    /// Of the panel when the window opens, with the smallest font.
    static constexpr float k_width = 286;
    /// What the panel takes of the window's width, at its left; 0 while it is hidden, and in a window so narrow that it
    /// lies above the view.
    float docked_width() const;
    /// Draws all panels for one frame of the window and returns what the user did.
    PanelEvents draw(ViewSettings& settings, Playback& playback, OverrideList& overrides, const Scene* scene,
                     const ViewImage* image, const LoadState& load, bool own_camera, bool recording);
    void add(const ViewTimes& times) { graph_.add(times); }
    /// Holds the picked object where it is; it may be held already.
    /// @pre picked
    UserOverride& freeze(OverrideList& overrides);

    bool shown = true, help = false;
    std::optional<Picked> picked;
    std::string message;                   // the latest error or confirmation
    std::set<std::string> options_set;     // options that the user has set at least once
    std::set<std::string> frozen, moved;   // objects that the user has frozen or moved at least once

 private:
    void options(ViewSettings& settings, PanelEvents& events);
    void option(ViewSettings& settings, const options::Option& option, PanelEvents& events);
    void player(Playback& playback, const Scene& scene) const;
    // The clips, cameras and variants of a file that has several.
    void lists(ViewSettings& settings, const Scene& scene, std::uint64_t loads, PanelEvents& events);
    bool list(ViewSettings& settings, const char* name, const char* label, std::string_view explained,
              const std::vector<std::pair<std::string, std::string>>& entries);
    void counters(const ViewImage& image) const;
    void object(OverrideList& overrides, const ViewImage& image);
    void keys();
    static void legend(const std::string& overlay);

    void begin_docked();
    float middle_of_view() const;

    TimeGraph graph_;
    float width_ = 0;                  // 0: not drawn yet
    const Scene* listed_ = nullptr;    // the scene of which the lists are,
    std::uint64_t listed_loads_ = 0;   // and how many were loaded until then
    std::vector<std::pair<std::string, std::string>> clips_, cameras_, variants_;   // labels and options' values
    std::vector<std::pair<std::string, std::string>> typed_;   // option and its text while it is edited
};

}   // namespace gnomon::viewer
