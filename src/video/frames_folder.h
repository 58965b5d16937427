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
    std::uint64_t fingerprint = 0;   // of the scene, see fingerprint_of
    std::string version;             // of Gnomon, because another version may render differently
    std::uint64_t options = 0;       // fingerprint_of_options
    std::string isa = "auto";        // what images depend on: nothing, or "native" with the instruction set
};

/// Hash of everything in the scene that affects images, without names. Cost: its vertices and texels, and at most a
/// thousand evaluations per track.
std::uint64_t fingerprint_of(const scene::Scene& scene);
/// Hash of all options that affect images; the number of threads, for example, does not. The instruction set, which
/// VideoIdentity names, is no part of it.
std::uint64_t fingerprint_of_options(const Scene& scene, const RenderOptions& options);
/// Hash of everything that images depend on: the scene, the options and, with Arithmetic::native, the instruction set.
std::uint64_t fingerprint_of(const Scene& scene, const RenderOptions& options);

class FramesFolder {
 public:
    explicit FramesFolder(const std::filesystem::path& video);
    ~FramesFolder();
    FramesFolder(const FramesFolder&) = delete;
    FramesFolder& operator=(const FramesFolder&) = delete;

    /// Creates the folder, or opens an existing one.
    /// @param keep    keep frames of the same video, and remove those that another version, instruction set or scene
    ///                gave; without it, remove all
    /// @param shared  other processes may use it at the same time: frames of another video are then an error
    /// @return        what made the frames that were removed although `keep` was given: "another scene"; else empty
    /// @throws UsageError    it has frames of another size or with other options, or files that are not ours
    /// @throws MissingError  it cannot be written, or another run uses it
    std::string open(const VideoIdentity& identity, bool keep, bool shared);

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
