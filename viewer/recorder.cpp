// SPDX-License-Identifier: Apache-2.0
#include "viewer/recorder.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <utility>

#include "gnomon/error.h"
#include "gnomon/video.h"

namespace gnomon::viewer {

// A temporary folder for the frames of a recording, removed with the last job that uses it.
struct Recorder::FramesFolder {
    explicit FramesFolder(std::filesystem::path at) : path(std::move(at)) {}
    ~FramesFolder()
    {
        std::error_code ignored;
        std::filesystem::remove_all(path, ignored);
    }
    FramesFolder(const FramesFolder&) = delete;
    FramesFolder& operator=(const FramesFolder&) = delete;
    std::filesystem::path path;
};

Recorder::Recorder() : thread_([this](const std::stop_token& stop) { work(stop); }) {}

Recorder::~Recorder()
{
    try {
        finish();
    } catch (const std::exception&) {   // a destructor must not throw; callers of finish() get the error
    }
}

std::string Recorder::free_name(const std::string& extension)
{
    for (int number = 1;; ++number) {
        std::string name = fmt::format("gnomon-{:04}{}", number, extension);
        if (std::filesystem::exists(name) || std::find(taken_.begin(), taken_.end(), name) != taken_.end()) continue;
        taken_.push_back(name);
        return name;
    }
}

std::string Recorder::save(const Frame& frame)
{
    std::string file = free_name(".png");
    queue([file, frame] { frame.write(file); });
    return file;
}

std::string Recorder::start(double fps)
{
    if (!can_encode_video()) return "recording needs ffmpeg; install it so that it is found in PATH";
    const auto path = std::filesystem::temp_directory_path() / fmt::format("gnomon-{}-{}", ::getpid(), taken_.size());
    std::error_code error;
    std::filesystem::create_directories(path, error);
    if (error) return fmt::format("{}: {}", path.string(), error.message());
    folder_ = std::make_shared<const FramesFolder>(path);
    fps_ = fps;
    frames_.clear();
    size_ = {};
    recording_ = true;
    return {};
}

bool Recorder::add(const Frame& frame)
{
    if (frames_.empty()) size_ = frame.size;
    if (!(frame.size == size_)) return false;
    const std::filesystem::path file = folder_->path / fmt::format("{:06}.png", frames_.size());
    frames_.push_back(file);
    queue([file, frame, folder = folder_] { frame.write(file); });
    return true;
}

bool Recorder::behind() const
{
    const std::lock_guard lock(mutex_);
    return jobs_.size() >= k_most_waiting;
}

std::string Recorder::stop()
{
    recording_ = false;
    const auto folder = std::exchange(folder_, nullptr);
    if (frames_.empty()) return {};
    std::string video = free_name(".mp4");
    queue([video, frames = frames_, fps = fps_, folder] { encode_video(frames, fps, video); });
    return video;
}

void Recorder::queue(std::function<void()> job)
{
    const std::lock_guard lock(mutex_);
    jobs_.push_back(std::move(job));
    changed_.notify_all();
}

void Recorder::work(const std::stop_token& stop)
{
    std::unique_lock lock(mutex_);
    while (changed_.wait(lock, stop, [&] { return !jobs_.empty(); })) {
        std::function<void()> job = std::move(jobs_.front());
        jobs_.pop_front();
        working_ = true;
        lock.unlock();
        std::exception_ptr error;
        try {
            job();
        } catch (...) {
            error = std::current_exception();
        }
        job = nullptr;   // may remove the folder of frames
        lock.lock();
        working_ = false;
        if (error && !error_) error_ = error;
        changed_.notify_all();
    }
}

void Recorder::finish()
{
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return jobs_.empty() && !working_; });
    if (error_) std::rethrow_exception(std::exchange(error_, nullptr));
}

}   // namespace gnomon::viewer
