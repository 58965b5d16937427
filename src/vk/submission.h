// SPDX-License-Identifier: Apache-2.0
#pragma once
// A command buffer that is recorded, submitted and waited for repeatedly; and timestamps.

#include "vk/device.h"

namespace gnomon::vk {

class Submission {
 public:
    explicit Submission(const std::shared_ptr<Device>& device);

    /// Begins a new recording.
    void begin();
    VkCommandBuffer buffer() const { return buffer_; }
    /// Ends the recording, submits it, and waits.
    /// @throws MissingError  the device was lost, or has too little memory
    void submit();

 private:
    std::shared_ptr<Device> device_;
    Owned<VkCommandPool> pool_;
    Owned<VkFence> fence_;
    VkCommandBuffer buffer_ = VK_NULL_HANDLE;
};

/// A pool of `count` timestamps; the device must support them (Device::timestamp_period).
Owned<VkQueryPool> make_timestamps(const std::shared_ptr<Device>& device, std::uint32_t count);

}   // namespace gnomon::vk
