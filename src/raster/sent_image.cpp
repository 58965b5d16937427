// SPDX-License-Identifier: Apache-2.0
#include "raster/sent_image.h"

namespace gnomon::raster {

void SentImage::send(vk::Commands& commands, std::span<const glm::vec4> pixels, const vk::Image& image)
{
    if (sent_.bytes() != pixels.size_bytes()) sent_ = vk::Buffer(commands.device(), image.name(), pixels.size_bytes());
    const vk::Upload upload = vk::upload_of(sent_, pixels);
    commands.upload("send " + image.name(), {&upload, 1});
    commands.pass(image.name() + " to image")
        .reads(sent_, vk::Use::copy_source)
        .writes(image, vk::Use::copy_target)
        .copy([&](vk::Recorder& r) {
            VkBufferImageCopy all{};
            all.imageSubresource = {image.aspect(), 0, 0, 1};
            all.imageExtent = {image.width(), image.height(), 1};
            r.copy(sent_, image, {&all, 1});
        });
}

}   // namespace gnomon::raster
