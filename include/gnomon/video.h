// SPDX-License-Identifier: Apache-2.0
#pragma once
// Renders many frames to files: numbered images, or a video.
//
// A video's frames are kept as PNG in OUT.frames/ until all are there; then ffmpeg encodes them in one go,
// single-threaded and bit-exact, and they are removed. So any chunking, resumption and number of threads gives the same
// bytes.

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "gnomon/renderer.h"

namespace gnomon {

struct VideoJob {
    std::filesystem::path out;          // .png, .mp4, or a numbered set: name-{frame:04}.png
    std::optional<FrameRange> frames;   // inclusive; none: the whole clip, or frame 1 for a single image
    double fps = 24;                    // of a video, 0.001 to 1000
    int chunk = 1,
        chunks = 1;        // render only the chunk-th of so many contiguous parts; a video's parts are frames only
    bool resume = false;   // keep frames that are already complete
    /// Renders so many frames first, unseen, so that there is something to remember: those before the first one that is
    /// rendered, and the clip's first again where there are not as many. None: 8 for a single image with an overlay
    /// of shadow states, else 0.
    std::optional<int> warm_up;
    std::filesystem::path contact_sheet;   // .png: also a labelled grid of frames, evenly spaced over the range
};

struct FrameRecord {
    int frame = 1;
    double time = 0;
    std::filesystem::path file;
    double milliseconds = 0;   // 0 if kept from an earlier run
    FrameTimes times;
    bool kept = false;   // made by an earlier run: times, counters and noise are not known, and 0
    FrameCounters counters;
    double noise = 0;   // of a reference, see Image
};

struct VideoResult {
    Size size;
    std::vector<FrameRecord> frames;
    std::vector<std::filesystem::path> files;   // what the job made, for people: the video, or the images
};

/// @param on_frame  called after each frame is complete; optional
/// @throws UsageError        a pattern, range or rate that makes no sense; a video's side below 2 pixels or above
/// 16,385;
///                           more lights than an .exr has room for layers
/// @throws MissingError      no ffmpeg, unwritable folder, full disk; another run is at work on the same video
/// @throws InterruptedError  progress returned false; complete frames stay for --resume
VideoResult render_video(const Scene& scene, Renderer& renderer, const VideoJob& job, const Progress& progress = {},
                         const std::function<void(const FrameRecord&)>& on_frame = {});

/// The n-th of `chunks` contiguous parts of a range; parts differ in length by at most one frame and may be empty.
FrameRange chunk_of(FrameRange range, int chunk, int chunks);

/// One image of several, in a grid with labels below each: for looking at a clip at a glance.
void write_contact_sheet(const std::vector<std::filesystem::path>& pngs, const std::vector<std::string>& labels,
                         int columns, const std::filesystem::path& out);

}   // namespace gnomon
