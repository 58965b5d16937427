// SPDX-License-Identifier: Apache-2.0
#pragma once
// Screenshots and recordings of the viewer: gnomon-0001.png, gnomon-0002.mp4, ... in the current folder, never over a
// file that is there. Written by a thread of its own.

#include <condition_variable>
#include <deque>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "base/image.h"

namespace gnomon::viewer {

class Recorder {
 public:
    Recorder();
    ~Recorder();

    /// @return the file that will be written
    std::string save(const Image8& image);

    bool recording() const { return recording_; }
    /// @return why it cannot; else empty
    std::string start(double fps);
    /// @return false if it is not of the first one's size; then it is left out
    bool add(const Image8& image);
    /// So many images wait to be written that the next had better come later: each holds its memory until then.
    bool behind() const;
    /// @return the video that will be written; empty if there was no image
    std::string stop();
    /// Waits until all is written. @throws what went wrong first
    void finish();

 private:
    struct FramesFolder;
    void work(const std::stop_token& stop);
    static constexpr std::size_t k_most_waiting = 4;
    void queue(std::function<void()> job);
    std::string free_name(const std::string& extension);

    bool recording_ = false;
    double fps_ = 24;
    int width_ = 0, height_ = 0;
    std::shared_ptr<const FramesFolder> folder_;   // of the recording under way
    std::vector<std::filesystem::path> frames_;
    std::vector<std::string> taken_;   // names given away, perhaps not written yet

    mutable std::mutex mutex_;
    std::condition_variable_any changed_;
    std::deque<std::function<void()>> jobs_;
    bool working_ = false;
    std::exception_ptr trouble_;
    std::jthread thread_;   // last
};

}   // namespace gnomon::viewer
