// SPDX-License-Identifier: Apache-2.0
#include "ray/embree.h"

#include <fmt/format.h>

#include "gnomon/error.h"

namespace gnomon::ray {

EmbreeDevice::EmbreeDevice() : device_(rtcNewDevice("threads=1,set_affinity=0"))
{
    if (!device_)
        throw MissingError(
            fmt::format("Embree does not start (error {})", static_cast<int>(rtcGetDeviceError(nullptr))));
    rtcSetDeviceMemoryMonitorFunction(device_, &EmbreeDevice::count_memory, this);
}

EmbreeDevice::~EmbreeDevice()
{
    rtcReleaseDevice(device_);
}

bool EmbreeDevice::count_memory(void* self, ssize_t bytes, bool)
{
    static_cast<EmbreeDevice*>(self)->bytes_ += static_cast<std::size_t>(bytes);
    return true;
}

void EmbreeDevice::check() const
{
    const RTCError error = rtcGetDeviceError(device_);
    if (error == RTC_ERROR_NONE) return;
    if (error == RTC_ERROR_OUT_OF_MEMORY) throw MissingError("not enough memory for the ray tracing trees");
    throw InternalError(fmt::format("Embree reports error {}", static_cast<int>(error)));
}

}   // namespace gnomon::ray
