// SPDX-License-Identifier: Apache-2.0
#pragma once
// Memory for the layers of frames, which frames share with their renderer without a copy.
//
// A frame's memory is used again once nothing holds it any more, so that a host that drops each frame before it renders
// the next one needs memory for one frame, and a host that keeps the last frame needs memory for two.

#include <memory>

#include "shading/frame_buffers.h"

namespace gnomon::frame {

/// Bytes of the values of a frame's buffers.
std::size_t bytes_of(const shading::FrameBuffers& buffers);

class FrameMemory {
 public:
    FrameMemory();

    /// Returns memory that nothing else holds, with the contents of some earlier frame or none. It comes back when the
    /// last pointer to it is destroyed, on any thread, also after this object.
    std::shared_ptr<shading::FrameBuffers> take();

 private:
    struct Returned;
    std::shared_ptr<Returned> returned_;
};

}   // namespace gnomon::frame
