// SPDX-License-Identifier: Apache-2.0
#pragma once
// Writes the viewer's screenshots and recordings: gnomon-0001.png, gnomon-0002.mp4, ... in the current folder. It never
// overwrites a file. A background thread does the writing.

#include <condition_variable>
#include <deque>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "gnomon/frame.h"

namespace gnomon::viewer {

class Recorder {
 public:
    Recorder();
    ~Recorder();

    /// Queues a screenshot. @return the name of the file that will be written
    std::string save(const Frame& frame);

    bool recording() const { return recording_; }
    /// Starts a recording. @return empty, or the reason why recording is not possible
    std::string start(double fps);
    /// Adds a frame to the recording. @return false, without adding it, if its size differs from the first frame's
    bool add(const Frame& frame);
    /// Whether so many images wait to be written that adding more should be delayed, because each occupies memory.
    bool behind() const;
    /// Ends the recording. @return the name of the video that will be written; empty if it has no frames
    std::string stop();
    /// Waits until everything is written. @throws the first error of the background thread
    void finish();

 private:
    struct FramesFolder;
    void work(const std::stop_token& stop);
    static constexpr std::size_t k_most_waiting = 4;
    void queue(std::function<void()> job);
    std::string free_name(const std::string& extension);

    bool recording_ = false;
    double fps_ = 24;
    Size size_{};
    std::shared_ptr<const FramesFolder> folder_;   // of the current recording
    std::vector<std::filesystem::path> frames_;
    std::vector<std::string> taken_;   // file names in use, including those not written yet

    mutable std::mutex mutex_;
    std::condition_variable_any changed_;
    std::deque<std::function<void()>> jobs_;
    bool working_ = false;
    std::exception_ptr error_;
    std::jthread thread_;   // last, so that it stops before the other members are destroyed
};

}   // namespace gnomon::viewer
