// SPDX-License-Identifier: Apache-2.0
#include "frame/frame_memory.h"

#include <mutex>

namespace gnomon::frame {

std::size_t bytes_of(const shading::FrameBuffers& buffers)
{
    std::size_t bytes = 0;
    for (const ImageF* image :
         {&buffers.color, &buffers.depth, &buffers.normal, &buffers.albedo, &buffers.direct, &buffers.indirect,
          &buffers.shadow, &buffers.variance, &buffers.irradiance, &buffers.irradiance_variance})
        bytes += image->data.size() * sizeof(float);
    bytes += buffers.motion.data.size() * sizeof(float) + buffers.ids.data.size() * sizeof(std::uint32_t);
    return bytes;
}

// The memory that came back last. A host that keeps many frames and drops them all leaves no more than this.
struct FrameMemory::Returned {
    std::mutex mutex;
    std::unique_ptr<shading::FrameBuffers> last;
};

FrameMemory::FrameMemory() : returned_(std::make_shared<Returned>()) {}

std::shared_ptr<shading::FrameBuffers> FrameMemory::take()
{
    std::unique_ptr<shading::FrameBuffers> buffers;
    {
        const std::lock_guard lock(returned_->mutex);
        buffers = std::move(returned_->last);
    }
    if (!buffers) buffers = std::make_unique<shading::FrameBuffers>();
    return {buffers.release(), [to = std::weak_ptr(returned_)](shading::FrameBuffers* pointer) {
                std::unique_ptr<shading::FrameBuffers> dropped(pointer);
                const std::shared_ptr<Returned> returned = to.lock();
                if (!returned) return;
                const std::lock_guard lock(returned->mutex);
                std::swap(returned->last, dropped);   // what was there is freed after the lock
            }};
}

}   // namespace gnomon::frame
