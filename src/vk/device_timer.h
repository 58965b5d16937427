// SPDX-License-Identifier: Apache-2.0
#pragma once
// Time that the device takes for whole submits: a stamp before and one after, each in a submit of its own.
//
// Mesa's software driver stamps a compute pass as soon as it is recorded, and so tells too little inside a submit; from
// one submit to the next its stamps are right. On hardware the gap between submits is in the time: some 10 us each.

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
