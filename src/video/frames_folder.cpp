// SPDX-License-Identifier: Apache-2.0
#include "video/frames_folder.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>
#include <thread>
#include <vector>

#include "io/file/atomic_file.h"
#include "io/image/image_file.h"

namespace gnomon::video {

namespace fs = std::filesystem;

namespace {
constexpr const char* k_manifest = "manifest.json";
constexpr std::uintmax_t k_manifest_limit = 1 << 16;   // bytes
// A chunk locks the folder exclusively while it inspects it and writes the manifest; others wait this long.
constexpr auto k_chunk_patience = std::chrono::seconds(5);
constexpr auto k_chunk_step = std::chrono::milliseconds(5);

bool is_frame_name(const std::string& name)
{
    return name.starts_with("frame-") && name.ends_with(".png");
}

bool is_ours(const std::string& name)
{
    return is_frame_name(name) || name == k_manifest || name.starts_with(io::k_temporary_prefix);
}

std::vector<fs::path> entries(const fs::path& folder, std::error_code& error)
{
    std::vector<fs::path> found;
    for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error))
        found.push_back(it->path());
    return found;
}

std::vector<fs::path> entries(const fs::path& folder)
{
    std::error_code error;
    std::vector<fs::path> found = entries(folder, error);
    if (error) throw MissingError(fmt::format("cannot read {}: {}", folder.string(), error.message()));
    return found;
}

std::optional<VideoIdentity> read_manifest_file(const fs::path& file)
{
    std::error_code error;
    if (fs::file_size(file, error) > k_manifest_limit || error) return std::nullopt;
    std::ifstream in(file);
    auto manifest = nlohmann::ordered_json::parse(in, nullptr, false);
    if (!manifest.is_object()) return std::nullopt;
    return read_manifest(manifest);
}

void write_manifest(const fs::path& folder, const VideoIdentity& identity)
{
    io::AtomicFile out(folder / k_manifest);
    out.write(manifest_of(identity).dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n");
    out.commit();
}

// How chunks of another video differ, which are at work in the same folder.
std::string difference_at_work(const VideoIdentity& theirs, const VideoIdentity& ours)
{
    const std::string stamp = stamp_of(theirs);
    const Difference difference = difference_of(stamp, ours);
    if (difference != Difference::none)
        return fmt::format("chunks of another video are at work there, whose frames are {}",
                           describe(difference, stamp, ours));
    return fmt::format("chunks of another video are at work there, of frames {}-{} at {:g} per second{}",
                       theirs.frames.first, theirs.frames.last, theirs.fps,
                       theirs.delivery == ours.delivery ? "" : ", encoded otherwise");
}
}   // namespace

FramesFolder::FramesFolder(const fs::path& video) : folder_(video)
{
    folder_ += ".frames";
}

FramesFolder::~FramesFolder()
{
    unlock();
}

void FramesFolder::unlock()
{
    if (lock_ >= 0) ::close(lock_);
    lock_ = -1;
}

void FramesFolder::make_and_lock(bool shared)
{
    const auto until = std::chrono::steady_clock::now() + k_chunk_patience;
    for (;;) {
        unlock();
        std::error_code error;
        made_ = fs::create_directory(folder_, error);
        if (!error && made_) error.assign(io::sync_folder(folder_.parent_path()), std::generic_category());
        if (error) throw MissingError(fmt::format("cannot create {}: {}", folder_.string(), error.message()));
        lock_ = ::open(folder_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
        if (lock_ < 0 && errno == ENOENT) continue;   // a run that finished its video has removed the folder
        alone_ = ::flock(lock_, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK;
        const bool mine = alone_ || (shared && ::flock(lock_, LOCK_SH | LOCK_NB) == 0);
        struct stat locked {
        }, there{};
        const bool gone = mine && lock_ >= 0 &&
                          (::stat(folder_.c_str(), &there) != 0 || ::fstat(lock_, &locked) != 0 ||
                           there.st_dev != locked.st_dev || there.st_ino != locked.st_ino);
        if (mine && !gone) return;
        if (!gone && (!shared || std::chrono::steady_clock::now() > until))
            throw MissingError(fmt::format("another run is using {}", folder_.string()));
        std::this_thread::sleep_for(k_chunk_step);
    }
}

void FramesFolder::let_others_in()
{
    if (alone_ && ::flock(lock_, LOCK_SH | LOCK_NB) != 0 && errno == EWOULDBLOCK)
        throw MissingError(fmt::format("another run is using {}", folder_.string()));
}

fs::path FramesFolder::file(int frame) const
{
    return folder_ / fmt::format("frame-{:06}.png", frame);
}

void FramesFolder::open(const VideoIdentity& identity, bool keep, bool shared)
{
    make_and_lock(shared);
    bool frames = false;
    for (const fs::path& entry : entries(folder_)) {
        const std::string name = entry.filename().string();
        if (!is_ours(name))
            throw UsageError(fmt::format("{} contains '{}', which is not a frame of a video: move it elsewhere",
                                         folder_.string(), name));
        frames |= is_frame_name(name);
    }

    const std::optional<VideoIdentity> found = read_manifest_file(folder_ / k_manifest);
    VideoIdentity ours = identity;
    ours.exposure = found ? found->exposure : std::nullopt;
    const bool same = found && manifest_of(*found) == manifest_of(ours);
    if (same && (keep || shared)) exposure_ = found->exposure;
    // Other runs may not have written frames yet; theirs will match their manifest.
    if (!alone_ && found && !same)
        throw UsageError(fmt::format("{}: {}", folder_.string(), difference_at_work(*found, identity)));
    // The same scene with other options is taken for a mistake. Frames of another scene, version or instruction set are
    // outdated, and are rendered again one by one.
    if (frames && (keep || shared) && found && difference_of(stamp_of(*found), identity) == Difference::options)
        throw UsageError(fmt::format("{} contains frames of another size or set of options: remove it{}",
                                     folder_.string(), keep && !shared ? ", or leave out --resume" : ""));
    std::error_code error;
    if (!keep && !shared)
        for (const fs::path& entry : entries(folder_)) fs::remove(entry, error);
    if (same && (keep || shared)) {
        if (shared) let_others_in();
        return;
    }
    try {
        write_manifest(folder_, identity);
    } catch (...) {
        if (made_ && !shared) fs::remove(folder_, error);   // a full disk; the folder stays if it is not empty
        throw;
    }
    if (shared) let_others_in();
}

void FramesFolder::note_exposure(VideoIdentity identity, double exposure)
{
    identity.exposure = exposure_ = exposure;
    write_manifest(folder_, identity);
}

std::optional<VideoIdentity> FramesFolder::open_existing()
{
    std::error_code error;
    if (!fs::is_directory(folder_, error)) return std::nullopt;
    make_and_lock(false);
    return read_manifest_file(folder_ / k_manifest);
}

std::optional<FramesFolder::Found> FramesFolder::find(int frame, const VideoIdentity& identity) const
{
    const std::optional<std::string> stamp =
        io::comment_of_whole_png(file(frame), identity.size.width, identity.size.height);
    if (!stamp) return std::nullopt;
    return Found{*stamp, difference_of(*stamp, identity)};
}

void FramesFolder::remove()
{
    // Remove the manifest last, so that frames left by a run that is killed here are still known as its own.
    std::error_code ignored;
    for (const fs::path& entry : entries(folder_, ignored))
        if (is_ours(entry.filename().string()) && entry.filename() != k_manifest) fs::remove(entry, ignored);
    fs::remove(folder_ / k_manifest, ignored);
    fs::remove(folder_, ignored);
}

bool FramesFolder::has_frames() const
{
    std::error_code ignored;
    for (const fs::path& entry : entries(folder_, ignored))
        if (is_frame_name(entry.filename().string())) return true;
    return false;
}

}   // namespace gnomon::video
