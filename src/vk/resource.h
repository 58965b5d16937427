// SPDX-License-Identifier: Apache-2.0
#pragma once
// Buffers and images. Each owns its handle, its views and its piece of memory, and stores its last use, from which
// passes derive barriers (see commands.h).

#include <cstddef>
#include <span>
#include <string>

#include "vk/device.h"

namespace gnomon::vk {

/// The last use of a resource. Updated by commands.cpp.
struct UseState {
    VkPipelineStageFlags2 write_stages = 0;   // of the last write
    VkAccessFlags2 write_access = 0;
    VkPipelineStageFlags2 read_stages = 0;   // of reads since then
    VkPipelineStageFlags2 seen_stages = 0;   // the last write is visible to these stages ...
    VkAccessFlags2 seen_access = 0;          // ... by these accesses
    VkImageLayout layout = VK_IMAGE_LAYOUT_UNDEFINED;
};

class Buffer {
 public:
    Buffer() = default;
    /// A buffer allows every use: vertices, indices, indirect draws, storage, texels, copies; on devices with ray
    /// tracing also as input of acceleration structure builds and, in device-only memory, as their storage. At least 4
    /// bytes are allocated.
    /// @throws MissingError  too little memory
    Buffer(const std::shared_ptr<Device>& device, const std::string& name, VkDeviceSize bytes,
           Access access = Access::device);

    VkBuffer handle() const { return handle_.get(); }
    const Device& device() const { return *device_; }
    VkDeviceSize bytes() const { return bytes_; }
    const std::string& name() const { return name_; }
    explicit operator bool() const { return static_cast<bool>(handle_); }

    /// Host memory of an upload or readback buffer. Data that the device wrote is valid after Commands::submit().
    template <class T>
    std::span<T> as() const
    {
        return {reinterpret_cast<T*>(mapped()), static_cast<std::size_t>(bytes_) / sizeof(T)};
    }
    std::byte* mapped() const;

    /// The device address, for builds and traces. @pre the device supports ray tracing; not for readback
    VkDeviceAddress address() const;

    /// A view of the buffer as texels of a format (`samplerBuffer`).
    /// @throws MissingError  more texels than the device can address
    VkBufferView texel_view(VkFormat format, VkDeviceSize texel_bytes) const;

    UseState& state() const { return state_; }

 private:
    std::shared_ptr<Device> device_;
    std::string name_;
    VkDeviceSize bytes_ = 0;
    MemoryPiece memory_;
    Owned<VkBuffer> handle_;
    mutable Owned<VkBufferView> texels_;
    mutable VkFormat texel_format_ = VK_FORMAT_UNDEFINED;
    mutable UseState state_;
};

struct ImageDesc {
    std::string name;
    std::uint32_t width = 1, height = 1;
    std::uint32_t layers = 1;
    VkFormat format = VK_FORMAT_R8G8B8A8_UNORM;
    VkImageUsageFlags usage = 0;   // copies are always allowed in addition
    bool array = false;            // shaders see an array, even with one layer
};

class Image {
 public:
    Image() = default;
    /// @throws MissingError  too little memory, or the device does not support the size or format
    Image(const std::shared_ptr<Device>& device, const ImageDesc& desc);

    VkImage handle() const { return handle_.get(); }
    const ImageDesc& desc() const { return desc_; }
    const std::string& name() const { return desc_.name; }
    std::uint32_t width() const { return desc_.width; }
    std::uint32_t height() const { return desc_.height; }
    VkFormat format() const { return desc_.format; }
    VkImageAspectFlags aspect() const;
    explicit operator bool() const { return static_cast<bool>(handle_); }

    /// All layers, for shaders.
    VkImageView view() const { return view_.get(); }
    /// One layer, as a render target.
    VkImageView layer_view(std::uint32_t layer) const;

    UseState& state() const { return state_; }

 private:
    Owned<VkImageView> make_view(VkImageViewType type, std::uint32_t first, std::uint32_t count) const;

    std::shared_ptr<Device> device_;
    ImageDesc desc_;
    MemoryPiece memory_;
    Owned<VkImage> handle_;
    Owned<VkImageView> view_;
    mutable std::vector<Owned<VkImageView>> layer_views_;
    mutable UseState state_;
};

/// Bytes per texel of the formats that we use.
std::uint32_t texel_bytes(VkFormat format);
bool is_depth(VkFormat format);

struct SamplerDesc {
    VkFilter filter = VK_FILTER_NEAREST;
    VkSamplerAddressMode address = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE;
};
Owned<VkSampler> make_sampler(const std::shared_ptr<Device>& device, const SamplerDesc& desc);

}   // namespace gnomon::vk
