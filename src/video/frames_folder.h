// SPDX-License-Identifier: Apache-2.0
#pragma once
// OUT.frames/: the frames of an unfinished video.
//
// A small manifest identifies the video, and each frame carries a stamp of what it shows and what rendered it, so that
// frames of another scene, size, option, version or instruction set are never reused. Only our own files are ever
// removed; a folder with other files is rejected. While a video is made, its folder is locked (flock), so that two runs
// never mix or remove each other's frames; the chunks of one video share the lock. The lock ends with the process,
// however that ends. On a file system without locks, the folder is not locked.

#include <filesystem>
#include <optional>
#include <string>

#include "gnomon/video.h"
#include "video/identity.h"

namespace gnomon::video {

class FramesFolder {
 public:
    explicit FramesFolder(const std::filesystem::path& video);
    ~FramesFolder();
    FramesFolder(const FramesFolder&) = delete;
    FramesFolder& operator=(const FramesFolder&) = delete;

    /// Creates the folder, or opens an existing one.
    /// @param keep    keep existing frames; their stamps say which of them can be reused
    /// @param shared  other processes may use it at the same time, so that no frame is removed
    /// @throws UsageError    to be kept or shared, it has frames of the same scene with other options; or chunks of
    ///         another video are at work there; or it has files that are not ours
    /// @throws MissingError  it cannot be written, or another run uses it
    void open(const VideoIdentity& identity, bool keep, bool shared);

    /// Opens an existing folder alone and keeps its frames. Returns what its manifest says; nothing if there is no
    /// folder, or no manifest in it.
    /// @throws MissingError  another run uses it
    std::optional<VideoIdentity> open_existing();

    /// The exposure of the clip, if an earlier run, or another one at work, has found it for this video.
    std::optional<double> exposure() const { return exposure_; }
    /// Notes the exposure in the manifest of the open folder.
    /// @throws MissingError  it cannot be written
    void note_exposure(VideoIdentity identity, double exposure);

    std::filesystem::path file(int frame) const;
    /// Why a frame has to be rendered: it is not there or not complete (nothing), else how it differs.
    struct Found {
        std::string stamp;   // empty if it has none
        Difference difference = Difference::none;
    };
    std::optional<Found> find(int frame, const VideoIdentity& identity) const;

    /// Removes our files, and the folder if it is empty then; errors are ignored. Not for a shared folder, because its
    /// files also belong to others.
    void remove();
    bool has_frames() const;
    const std::filesystem::path& path() const { return folder_; }

 private:
    void make_and_lock(bool shared);
    void let_others_in();
    void unlock();

    std::filesystem::path folder_;
    int lock_ = -1;       // descriptor of the folder
    bool alone_ = true;   // the lock is exclusive
    bool made_ = false;   // this object created the folder
    std::optional<double> exposure_;
};

}   // namespace gnomon::video
