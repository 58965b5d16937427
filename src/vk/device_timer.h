// SPDX-License-Identifier: Apache-2.0
#pragma once
// Measures the device time of whole submits, with a timestamp before and one after, each in its own submit.
//
// Mesa's software driver writes a timestamp in a compute pass as soon as it is recorded, so times within a submit are
// too short; between submits they are correct. On hardware, the measured time includes the gaps between submits, some
// 10 us each.

#include "vk/submission.h"

namespace gnomon::vk {

class DeviceTimer {
 public:
    /// @throws MissingError  the device has no timestamps
    explicit DeviceTimer(const std::shared_ptr<Device>& device);

    void start() { stamp(0); }
    /// @return milliseconds since start()
    double stop();

 private:
    void stamp(std::uint32_t which);

    std::shared_ptr<Device> device_;
    Submission submission_;
    Owned<VkQueryPool> queries_;
};

}   // namespace gnomon::vk
