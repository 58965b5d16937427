// SPDX-License-Identifier: Apache-2.0
#pragma once
// OUT.frames/: the frames of an unfinished video.
//
// A small manifest identifies the video, so that frames of another scene, size or option are never reused. Only our own
// files are ever removed; a folder with other files is rejected. While a video is made, its folder is locked (flock),
// so that two runs never mix or remove each other's frames; the chunks of one video share the lock. The lock ends with
// the process, however that ends. On a file system without locks, the folder is not locked.

#include <cstdint>
#include <filesystem>
#include <string>

#include "gnomon/video.h"

namespace gnomon::scene {
class Scene;
}

namespace gnomon::video {

/// Properties that all frames of a video have in common.
struct VideoIdentity {
    std::string scene;   // name, for messages
    Size size;
    std::uint64_t fingerprint = 0;   // of everything that pixels depend on, see fingerprint_of
    std::string version;             // of Gnomon, because another version may render differently
};

/// Hash of everything in the scene that affects images, without names. Cost: its vertices and texels, and at most a
/// thousand evaluations per track.
std::uint64_t fingerprint_of(const scene::Scene& scene);
/// Hash of that and of all options that affect images; the number of threads, for example, does not.
std::uint64_t fingerprint_of(const Scene& scene, const RenderOptions& options);

class FramesFolder {
 public:
    explicit FramesFolder(const std::filesystem::path& video);
    ~FramesFolder();
    FramesFolder(const FramesFolder&) = delete;
    FramesFolder& operator=(const FramesFolder&) = delete;

    /// Creates the folder, or opens an existing one.
    /// @param keep    keep frames of the same video; others are removed
    /// @param shared  other processes may use it at the same time: frames of another video are then an error, too
    /// @throws UsageError    it has frames of another video, or files that are not ours
    /// @throws MissingError  it cannot be written, or another run uses it
    void open(const VideoIdentity& identity, bool keep, bool shared);

    std::filesystem::path file(int frame) const;

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
};

}   // namespace gnomon::video
