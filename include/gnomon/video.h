// SPDX-License-Identifier: Apache-2.0
#pragma once
// Renders many frames to files: numbered images, or a video (docs/guide/videos.md).
//
// The frames of a video are kept as PNG files in OUT.frames/ until all are complete. ffmpeg then encodes them in one
// pass, single-threaded and bit-exact, and the PNG files are removed. The video therefore has the same bytes for any
// division into chunks, after any interruption, and for any number of threads. Frames and videos note which version and
// instruction set rendered them, and hashes of the scene and the options, so that only what is still valid is reused.

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "gnomon/renderer.h"

namespace gnomon {

/// A clip of more frames is rendered only where VideoJob::frames names them.
constexpr int k_most_frames_unasked = 100'000;

/// The codec of a video. automatic: h264; vp9 in a .webm; and for a transparent background what has alpha: prores in a
/// .mov, ffv1 in a .mkv. A .gif has none of them.
enum class VideoCodec { automatic, h264, h265, prores, vp9, ffv1 };

/// The quality of videos, from 0 to 100, if none is given.
constexpr int k_video_quality = 75;

/// How a video is encoded.
struct Encoding {
    VideoCodec codec = VideoCodec::automatic;
    std::optional<int> quality{};   // 0 to 100, the best; none: k_video_quality. Not of ffv1 and .gif, which have none
    /// A file with sound, which begins with the video and ends with it at the latest; none: no sound. Its samples are
    /// copied if the container takes their codec, and encoded otherwise.
    std::filesystem::path audio{};
    /// The timecode of the clip's frame 1, HH:MM:SS:FF, or HH:MM:SS;FF with dropped numbers. Empty: 00:00:00:00 in a
    /// .mov and a .mkv, and none in other files or at a rate that is neither whole nor a whole one times 1000/1001.
    std::string timecode{};
};

/// What to render, and where to.
struct VideoJob {
    /// .png, .jpg, .exr, a numbered set of them (name-{frame:04}.png or name-%04d.png), .mp4, .mov, .mkv, .webm or
    /// .gif.
    std::filesystem::path out;
    std::optional<FrameRange> frames;   // inclusive; none: the whole clip, or frame 1 for a single image
    double fps = 24;                    // frames a second of a video, 0.001 to 1000
    /// Renders only the part `chunk` (from 1) of `chunks` contiguous ones; of a video, it leaves frames only.
    int chunk = 1;
    int chunks = 1;   // the number of parts
    /// Renders only these frames of the range, instead of a chunk by number; of a video, it leaves frames only.
    std::optional<FrameRange> part;
    /// Keeps frames that are already complete; a video that is complete is left as it is.
    bool resume = false;
    /// Number of frames that are rendered and discarded first, to fill the caches: the frames before the first one, or
    /// the clip's first frame repeatedly where there are too few. None: 8 for a single image with an overlay of shadow
    /// states, else 0.
    std::optional<int> warm_up;
    std::filesystem::path contact_sheet;   // .png: also writes a labelled grid of frames, evenly spaced over the range
    /// Where RenderOptions::exposure is none: the exposure of videos and numbered sets is computed from each frame, as
    /// that of a single image is. Otherwise it is computed once, from small frames spread over the whole clip, whatever
    /// frames are rendered.
    bool exposure_of_each_frame = false;
    Encoding encoding;     // of a video
    ImageOptions images;   // of images
    /// Called with one line for each reason why existing frames are rendered again; optional.
    std::function<void(const std::string&)> on_notice;
};

/// One frame that was written.
struct FrameRecord {
    int frame = 1;
    double time = 0;
    std::filesystem::path file;
    double milliseconds = 0;   // 0 if kept from an earlier run
    FrameTimes times;
    bool kept = false;   // made by an earlier run: times, counters and noise are unknown and 0
    FrameCounters counters;
    double noise = 0;      // of a reference, see Frame::noise
    double exposure = 0;   // stops; 0 if kept from an earlier run
};

/// What was written.
struct VideoResult {
    Size size;
    bool complete_before = false;   // the video was complete before, and nothing was done
    std::vector<FrameRecord> frames;
    std::vector<std::filesystem::path> files;   // the resulting video or images
};

/// Renders frames to files, continues interrupted work if asked to, and encodes a video when all frames are there.
/// @param on_frame  called after each completed frame; optional
/// @throws UsageError        an invalid pattern, range or rate; a video with a side below 2 or above 16,385 pixels;
///         a codec that the container does not take, or that has no alpha for a transparent background; more lights
///         than an .exr has room for layers; existing frames of the same scene with other options
/// @throws InputError        Encoding::audio has no sound that ffmpeg can read
/// @throws MissingError      no ffmpeg, or one without the encoder; unwritable folder, full disk; another run is
///         writing the same video
/// @throws InterruptedError  progress returned false; complete frames remain for --resume
VideoResult render_video(const Scene& scene, Renderer& renderer, const VideoJob& job, const Progress& progress = {},
                         const std::function<void(const FrameRecord&)>& on_frame = {});

/// Ends a video whose chunks are all in OUT.frames/: checks that every frame is there and is of this video, encodes it,
/// and removes the frames. A video that is complete already is left as it is.
/// @throws UsageError        no chunk was rendered; frames are missing, incomplete or of another video, and which
/// @throws MissingError      no ffmpeg, unwritable folder, full disk; chunks are still at work
/// @throws InterruptedError  progress returned false
VideoResult join_video(const std::filesystem::path& out, const Progress& progress = {});

/// Whether videos can be encoded as H.264: the program ffmpeg is found, and has an encoder for it.
/// @throws InterruptedError  progress returned false
bool can_encode_video(const Progress& progress = {});

/// Encodes PNG frames of one size, by default to H.264 in MP4, playable everywhere; the bytes depend on the frames, the
/// rate and the encoding alone. Where colours have half the resolution (H.264, H.265, VP9), an odd side loses its last
/// row or column. The file is replaced atomically.
/// @param pngs  8 or 16 bits a channel; alpha is encoded if the first one has it
/// @param fps   frames a second, above 0
/// @throws UsageError        no frames, or the rate is not above 0; see also render_video
/// @throws InputError        Encoding::audio has no sound that ffmpeg can read
/// @throws MissingError      a frame cannot be read; ffmpeg is not found, fails, or is killed
/// @throws InterruptedError  progress returned false
void encode_video(const std::vector<std::filesystem::path>& pngs, double fps, const std::filesystem::path& out,
                  const Progress& progress = {}, const Encoding& encoding = {});

/// The n-th of `chunks` contiguous parts of a range; parts differ in length by at most one frame and may be empty.
FrameRange chunk_of(FrameRange range, int chunk, int chunks);

/// Writes a contact sheet: a grid of images with a label below each.
void write_contact_sheet(const std::vector<std::filesystem::path>& pngs, const std::vector<std::string>& labels,
                         int columns, const std::filesystem::path& out);

}   // namespace gnomon
