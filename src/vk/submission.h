// SPDX-License-Identifier: Apache-2.0
#pragma once
// A command buffer that is recorded, sent and waited for, again and again; and timestamps.

#include "vk/device.h"

namespace gnomon::vk {

class Submission {
 public:
    explicit Submission(const std::shared_ptr<Device>& device);

    /// Begins to record anew.
    void begin();
    VkCommandBuffer buffer() const { return buffer_; }
    /// Ends recording, sends it, and waits.
    /// @throws MissingError  the device was lost, or has too little memory
    void submit();

 private:
    std::shared_ptr<Device> device_;
    Owned<VkCommandPool> pool_;
    Owned<VkFence> fence_;
    VkCommandBuffer buffer_ = VK_NULL_HANDLE;
};

/// Room for `count` timestamps; the device has some (Device::timestamp_period).
Owned<VkQueryPool> make_timestamps(const std::shared_ptr<Device>& device, std::uint32_t count);

}   // namespace gnomon::vk
