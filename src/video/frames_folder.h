// SPDX-License-Identifier: Apache-2.0
#pragma once
// OUT.frames/: the frames of a video that is not whole yet.
//
// A small manifest says what the frames are of, so that frames of another scene, size or option are never taken for
// these. Only files of ours are ever removed; a folder that holds others is refused. While a video is made, its folder
// is locked (flock), so that two runs at once never mix their frames or take each other's away; the chunks of one video
// share the lock. It goes with its process, however that ends. Where a file system has no locks, nothing is locked.

#include <cstdint>
#include <filesystem>
#include <string>

#include "gnomon/video.h"

namespace gnomon::video {

/// What the frames of one video have in common.
struct VideoIdentity {
    std::string scene;   // its name: for people
    Size size;
    std::uint64_t fingerprint = 0;   // of everything that pixels depend on, see fingerprint_of
    std::string version;             // ours: another one may paint otherwise
};

/// Hash of all that shapes an image of the scene: everything but names. Cost: its vertices and texels, and what each
/// track says at a thousand times at most.
std::uint64_t fingerprint_of(const scene::Scene& scene);
/// Of that, and of all options but those that change no image, such as the number of threads.
std::uint64_t fingerprint_of(const Scene& scene, const RenderOptions& options);

class FramesFolder {
 public:
    explicit FramesFolder(const std::filesystem::path& video);
    ~FramesFolder();
    FramesFolder(const FramesFolder&) = delete;
    FramesFolder& operator=(const FramesFolder&) = delete;

    /// Makes the folder, or takes over one that is there.
    /// @param keep    frames stay, if they are of the same video; otherwise they are removed
    /// @param shared  other processes may be at work on it: frames of another video are then refused too
    /// @throws UsageError if it holds frames of another video, or files that are not ours; MissingError, also while
    ///         another run is at work on it
    void open(const VideoIdentity& identity, bool keep, bool shared);

    std::filesystem::path file(int frame) const;

    /// Removes our files and the folder, if nothing else is in it; what cannot be removed stays. Not for a shared
    /// folder, whose files are others', too.
    void remove();
    bool has_frames() const;
    const std::filesystem::path& path() const { return folder_; }

 private:
    void make_and_lock(bool shared);
    void let_others_in();
    void unlock();

    std::filesystem::path folder_;
    int lock_ = -1;       // the folder, open
    bool alone_ = true;   // nobody else has it
    bool made_ = false;   // by us
};

}   // namespace gnomon::video
