// SPDX-License-Identifier: Apache-2.0
#include "ray/embree/embree.h"

#include <fmt/format.h>
#include <oneapi/tbb/task_arena.h>

#include <string>

#include "base/instruction_set.h"
#include "base/interruption.h"
#include "gnomon/error.h"

namespace gnomon::ray {

struct EmbreeDevice::Arena {
    tbb::task_arena one_thread{1};
};

namespace {

std::string configuration()
{
    if (!instruction_set_is_limited()) return "set_affinity=0";
    return fmt::format("set_affinity=0,isa={}", name_of(instruction_set()));
}

}   // namespace

EmbreeDevice::EmbreeDevice() : arena_(std::make_unique<Arena>()), device_(rtcNewDevice(configuration().c_str()))
{
    if (!device_) {
        const RTCError error = rtcGetDeviceError(nullptr);
        if (error == RTC_ERROR_OUT_OF_MEMORY) throw MissingError("not enough memory for the ray tracer to start");
        throw MissingError(fmt::format("Embree does not start (error {})", static_cast<int>(error)));
    }
    rtcSetDeviceMemoryMonitorFunction(device_, &EmbreeDevice::count_memory, this);
}

EmbreeDevice::~EmbreeDevice()
{
    rtcReleaseDevice(device_);
}

// Embree calls this before or after it allocates or frees memory: false, before, makes it fail.
bool EmbreeDevice::count_memory(void* self, ssize_t bytes, bool post)
{
    auto& device = *static_cast<EmbreeDevice*>(self);
    if (bytes > 0 && !post && !device.limit_.allows(device.bytes_ + static_cast<std::size_t>(bytes))) {
        device.refused_ = true;
        return false;
    }
    device.bytes_ += static_cast<std::size_t>(bytes);
    return true;
}

// Embree calls this while it builds: false cancels the build.
bool EmbreeDevice::go_on(void* interruption, double)
{
    return !static_cast<Interruption*>(interruption)->requested();
}

void EmbreeDevice::commit(RTCScene scene) const
{
    Interruption* const interruption = Interruption::current();
    if (interruption) rtcSetSceneProgressMonitorFunction(scene, &go_on, interruption);
    arena_->one_thread.execute([scene] { rtcCommitScene(scene); });
    if (refused_) check();
    if (!interruption) return;
    rtcSetSceneProgressMonitorFunction(scene, nullptr, nullptr);
    // A cancelled build is an error of the device, and the scene of no use.
    if (interruption->requested()) interruption->raise();
}

void EmbreeDevice::check() const
{
    const RTCError error = rtcGetDeviceError(device_);
    if (refused_.exchange(false)) limit_.refuse("the ray tracing trees");
    if (error == RTC_ERROR_NONE) return;
    if (error == RTC_ERROR_OUT_OF_MEMORY) throw MissingError("not enough memory for the ray tracing trees");
    throw InternalError(fmt::format("Embree reports error {}", static_cast<int>(error)));
}

}   // namespace gnomon::ray
