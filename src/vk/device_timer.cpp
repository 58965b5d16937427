// SPDX-License-Identifier: Apache-2.0
#include "vk/device_timer.h"

#include "gnomon/error.h"

namespace gnomon::vk {

DeviceTimer::DeviceTimer(const std::shared_ptr<Device>& device) : device_(device), submission_(device)
{
    if (device->timestamp_period() <= 0) throw MissingError("Vulkan: the device has no timestamps");
    queries_ = make_timestamps(device, 2);
}

void DeviceTimer::stamp(std::uint32_t which)
{
    submission_.begin();
    vkCmdResetQueryPool(submission_.buffer(), queries_.get(), which, 1);
    vkCmdWriteTimestamp2(submission_.buffer(), VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, queries_.get(), which);
    submission_.submit();
}

double DeviceTimer::stop()
{
    stamp(1);
    std::uint64_t stamps[2];
    check(vkGetQueryPoolResults(device_->handle(), queries_.get(), 0, 2, sizeof stamps, stamps, 8,
                                VK_QUERY_RESULT_64_BIT | VK_QUERY_RESULT_WAIT_BIT),
          "reading timestamps");
    return static_cast<double>(stamps[1] - stamps[0]) * device_->timestamp_period() * 1e-6;
}

}   // namespace gnomon::vk
