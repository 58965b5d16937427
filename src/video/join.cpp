// SPDX-License-Identifier: Apache-2.0
// Ends a video whose chunks are all rendered. The manifest says which frames it has; no scene is loaded.
#include <fmt/format.h>

#include <map>

#include "gnomon/error.h"
#include "gnomon/video.h"
#include "io/file/atomic_file.h"
#include "io/file/output_name.h"
#include "video/encoder.h"
#include "video/finished_video.h"
#include "video/frame_list.h"
#include "video/frames_folder.h"

namespace gnomon {

namespace fs = std::filesystem;

namespace {
// Throws if a frame is missing, incomplete or of another video.
void check_frames(const video::FramesFolder& folder, const video::VideoIdentity& identity, const Progress& progress)
{
    std::vector<int> missing;
    std::map<std::string, std::vector<int>> outdated;   // by reason
    for (int frame = identity.frames.first; frame <= identity.frames.last; ++frame) {
        if (progress && !progress({"checking", static_cast<double>(frame - identity.frames.first) /
                                                   static_cast<double>(identity.frames.count())}))
            throw InterruptedError("interrupted");
        const auto found = folder.find(frame, identity);
        if (!found)
            missing.push_back(frame);
        else if (found->difference != video::Difference::none)
            outdated[describe(found->difference, found->stamp, identity)].push_back(frame);
    }
    std::vector<int> faulty = missing;
    std::vector<std::string> faults;
    if (!missing.empty())
        faults.push_back(fmt::format("{} of {}-{} {} missing", video::list_frames(missing), identity.frames.first,
                                     identity.frames.last, missing.size() == 1 ? "is" : "are"));
    for (const auto& [reason, frames] : outdated) {
        faulty.insert(faulty.end(), frames.begin(), frames.end());
        faults.push_back(
            fmt::format("{} {} {}", video::list_frames(frames), frames.size() == 1 ? "is" : "are", reason));
    }
    if (faults.empty()) return;
    throw UsageError(fmt::format("{}: {}; render again with --chunk {}", folder.path().string(),
                                 fmt::join(faults, "; "), video::first_range(std::move(faulty))));
}
}   // namespace

VideoResult join_video(const fs::path& out, const Progress& progress)
{
    if (io::output_kind(out) != io::OutputKind::video)
        throw UsageError(fmt::format(
            "{}: only the chunks of a video are joined; expected .mp4, .mov, .mkv, .webm or .gif", out.string()));
    video::FramesFolder folder(out);
    const std::optional<video::VideoIdentity> identity = folder.open_existing();
    VideoResult result;
    result.files.push_back(out);
    // A run that was killed after it had encoded the video has left some of its frames.
    const video::Container container = video::container_of(out);
    const std::string comment = video::comment_of_video(out, container);
    const bool complete = !video::stamp_in(comment).empty() && video::is_whole_video(out, container);
    if (complete && (!identity || comment == video::comment_of(*identity))) {
        if (identity) folder.remove();
        result.complete_before = true;
        return result;
    }
    if (!identity)
        throw UsageError(fmt::format("{}: no chunk of this video was rendered; render one with --chunk I/N",
                                     folder.path().string()));
    check_frames(folder, *identity, progress);
    const video::Delivery& delivery = identity->delivery;
    if (delivery.container != container)
        throw UsageError(
            fmt::format("{}: its chunks are those of a {}", out.string(), video::extension_of(delivery.container)));
    if (!delivery.audio.empty() && video::hash_of_file(delivery.audio) != delivery.audio_hash)
        throw InputError(delivery.audio.string(), "", "its sound is not the one with which the chunks were begun");
    video::check_encoder(delivery, progress);

    // Encode the video and remove the frames.
    result.size = identity->size;
    std::vector<fs::path> frames;
    for (int frame = identity->frames.first; frame <= identity->frames.last; ++frame) {
        frames.push_back(folder.file(frame));
        FrameRecord record;
        record.frame = frame;
        record.file = out;
        record.kept = true;
        result.frames.push_back(std::move(record));
    }
    video::encode_video(frames, identity->fps, out, progress, video::comment_of(*identity), delivery);
    folder.remove();
    return result;
}

}   // namespace gnomon
