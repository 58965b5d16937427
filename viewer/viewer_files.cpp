// SPDX-License-Identifier: Apache-2.0
// The scene's file, screenshots and recordings.
#include <fmt/format.h>

#include <cmath>

#include "options/option_table.h"
#include "viewer/viewer_impl.h"

namespace gnomon::viewer {

namespace {

constexpr double k_look_seconds = 0.5;   // between checks whether the scene's file changed

std::filesystem::file_time_type changed_at(const std::string& file)
{
    std::error_code error;
    const auto time = std::filesystem::last_write_time(file, error);
    return error ? std::filesystem::file_time_type{} : time;
}

}   // namespace

void Viewer::Impl::open(const std::string& file)
{
    if (file != what)
        // These names belong to the previous scene.
        for (const char* name : {"camera", "animation", "variant"})
            settings.set(*options::find_option(options::Subcommand::view, name), "");
    what = file;
    file_time = changed_at(what);
    session.load(settings.recipe(what));
    glfwSetWindowTitle(window.handle, fmt::format("Gnomon - {}", what).c_str());
}

// Loads the scene's file again when it has changed.
void Viewer::Impl::look_at_file()
{
    if (seconds_since(looked) < k_look_seconds || what.starts_with("builtin:")) return;
    looked = Clock::now();
    const auto now = changed_at(what);
    if (now == file_time || now == std::filesystem::file_time_type{}) return;
    file_time = now;
    session.load(settings.recipe(what));
}

void Viewer::Impl::screenshot()
{
    wants_screenshot = dirty = true;
    shot_request = 0;
}

void Viewer::Impl::toggle_recording()
{
    if (recorder.recording()) return end_recording({});
    if (!scene) {   // the scene determines the frame rate
        panel.message = "the scene is still loading; record when it is shown";
        return;
    }
    panel.message = recorder.start(playback.fps);
    if (!panel.message.empty()) return;
    panel.message = "recording every frame of the clip; press R to stop";
    video_size = view_size();
    video_request = 0;   // ignore images that were requested before
    video_exposure.reset();
    playback.playing = false;
    dirty = true;
}

/// @param why  the reason; empty if the user stopped the recording
void Viewer::Impl::end_recording(const std::string& why)
{
    const std::string file = recorder.stop();
    if (!file.empty()) summary.files.push_back(file);
    panel.message = file.empty() ? "nothing was recorded" : fmt::format("encoding {}", file);
    if (!why.empty()) panel.message = fmt::format("recording ended: {}; {}", why, panel.message);
}

// Ends the recording or cancels the screenshot whose frame failed.
void Viewer::Impl::handle_failed_frame(const LoadState& load)
{
    if (load.failed == 0) return;
    if (recorder.recording() && load.failed == video_request) end_recording("a frame failed");
    if (load.failed == shot_request) wants_screenshot = false;
}

}   // namespace gnomon::viewer
