// SPDX-License-Identifier: Apache-2.0
#include "viewer/recorder.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <utility>

#include "gnomon/error.h"
#include "io/image/image_file.h"
#include "video/encoder.h"

namespace gnomon::viewer {

// Goes with the last job that needs it, however that ends.
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
    } catch (const std::exception&) {   // said by whoever called finish()
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

std::string Recorder::save(const Image8& image)
{
    std::string file = free_name(".png");
    queue([file, image] { io::write_png(file, image); });
    return file;
}

std::string Recorder::start(double fps)
{
    if (!video::have_ffmpeg()) return "recording needs the program ffmpeg";
    const auto path = std::filesystem::temp_directory_path() / fmt::format("gnomon-{}-{}", ::getpid(), taken_.size());
    std::error_code error;
    std::filesystem::create_directories(path, error);
    if (error) return fmt::format("{}: {}", path.string(), error.message());
    folder_ = std::make_shared<const FramesFolder>(path);
    fps_ = fps;
    frames_.clear();
    width_ = height_ = 0;
    recording_ = true;
    return {};
}

bool Recorder::add(const Image8& image)
{
    if (frames_.empty()) width_ = image.width, height_ = image.height;
    if (image.width != width_ || image.height != height_) return false;
    const std::filesystem::path file = folder_->path / fmt::format("{:06}.png", frames_.size());
    frames_.push_back(file);
    queue([file, image, folder = folder_] { io::write_png(file, image); });
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
    queue([video, frames = frames_, fps = fps_, folder] { video::encode_video(frames, fps, video); });
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
        std::exception_ptr trouble;
        try {
            job();
        } catch (...) {
            trouble = std::current_exception();
        }
        job = nullptr;   // a folder goes with it
        lock.lock();
        working_ = false;
        if (trouble && !trouble_) trouble_ = trouble;
        changed_.notify_all();
    }
}

void Recorder::finish()
{
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return jobs_.empty() && !working_; });
    if (trouble_) std::rethrow_exception(std::exchange(trouble_, nullptr));
}

}   // namespace gnomon::viewer
