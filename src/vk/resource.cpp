// SPDX-License-Identifier: Apache-2.0
#include "vk/resource.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/check.h"
#include "gnomon/error.h"

namespace gnomon::vk {

namespace {

template <class Handle>
std::uint64_t as_number(Handle handle)
{
    return reinterpret_cast<std::uint64_t>(handle);
}

}   // namespace

Buffer::Buffer(const std::shared_ptr<Device>& device, const std::string& name, VkDeviceSize bytes, Access access)
    : device_(device), name_(name), bytes_(std::max<VkDeviceSize>(bytes, 4))
{
    VkBufferCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO;
    info.size = bytes_;
    info.usage = VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT;
    if (access != Access::readback)
        info.usage |= VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_VERTEX_BUFFER_BIT |
                      VK_BUFFER_USAGE_INDEX_BUFFER_BIT | VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT |
                      VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT | VK_BUFFER_USAGE_UNIFORM_TEXEL_BUFFER_BIT;
    if (device->traces_rays() && access != Access::readback)
        info.usage |= VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT |
                      VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR |
                      VK_BUFFER_USAGE_SHADER_BINDING_TABLE_BIT_KHR;
    if (device->traces_rays() && access == Access::device)
        info.usage |= VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_STORAGE_BIT_KHR;
    VkBuffer buffer = VK_NULL_HANDLE;
    check(vkCreateBuffer(device->handle(), &info, nullptr, &buffer), fmt::format("creating buffer '{}'", name));
    handle_ = {device, buffer, [](const Device& d, VkBuffer b) { vkDestroyBuffer(d.handle(), b, nullptr); }};
    VkMemoryRequirements needs{};
    vkGetBufferMemoryRequirements(device->handle(), buffer, &needs);
    memory_ = device->memory().take(needs, access, false, fmt::format("buffer '{}'", name));
    check(vkBindBufferMemory(device->handle(), buffer, memory_.memory(), memory_.offset()),
          fmt::format("binding memory of buffer '{}'", name));
    device->name(VK_OBJECT_TYPE_BUFFER, as_number(buffer), name);
}

std::byte* Buffer::mapped() const
{
    std::byte* const at = memory_.mapped();
    GNOMON_CHECK(at);   // not for device-only memory
    return at;
}

VkDeviceAddress Buffer::address() const
{
    GNOMON_CHECK(device_->traces_rays());
    VkBufferDeviceAddressInfo info{};
    info.sType = VK_STRUCTURE_TYPE_BUFFER_DEVICE_ADDRESS_INFO;
    info.buffer = handle();
    return vkGetBufferDeviceAddress(device_->handle(), &info);
}

VkBufferView Buffer::texel_view(VkFormat format, VkDeviceSize texel_size) const
{
    if (texels_ && texel_format_ == format) return texels_.get();
    if (bytes_ / texel_size > device_->limits().maxTexelBufferElements)
        throw MissingError(fmt::format("Vulkan: '{}' has {} million texels, but the device supports only {}", name_,
                                       bytes_ / texel_size / 1'000'000,
                                       device_->limits().maxTexelBufferElements / 1'000'000));
    VkBufferViewCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_BUFFER_VIEW_CREATE_INFO;
    info.buffer = handle();
    info.format = format;
    info.range = bytes_ / texel_size * texel_size;
    VkBufferView view = VK_NULL_HANDLE;
    check(vkCreateBufferView(device_->handle(), &info, nullptr, &view),
          fmt::format("creating a view of buffer '{}'", name_));
    texels_ = {device_, view, [](const Device& d, VkBufferView v) { vkDestroyBufferView(d.handle(), v, nullptr); }};
    texel_format_ = format;
    return view;
}

Image::Image(const std::shared_ptr<Device>& device, const ImageDesc& desc) : device_(device), desc_(desc)
{
    VkImageCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO;
    info.imageType = VK_IMAGE_TYPE_2D;
    info.format = desc.format;
    info.extent = {desc.width, desc.height, 1};
    info.mipLevels = 1;
    info.arrayLayers = desc.layers;
    info.samples = VK_SAMPLE_COUNT_1_BIT;
    info.tiling = VK_IMAGE_TILING_OPTIMAL;
    info.usage = desc.usage | VK_IMAGE_USAGE_TRANSFER_SRC_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT;
    info.initialLayout = VK_IMAGE_LAYOUT_UNDEFINED;

    // Check support first, so that an unsupported size or format is reported as a limit of the device.
    VkImageFormatProperties can{};
    const VkResult known = vkGetPhysicalDeviceImageFormatProperties(device->physical(), info.format, info.imageType,
                                                                    info.tiling, info.usage, 0, &can);
    if (known != VK_SUCCESS) fail(known, fmt::format("creating image '{}'", desc.name));
    if (desc.width > can.maxExtent.width || desc.height > can.maxExtent.height || desc.layers > can.maxArrayLayers)
        throw MissingError(fmt::format("Vulkan: '{}' of {} x {} x {} exceeds the device's limit of {} x {} x {}",
                                       desc.name, desc.width, desc.height, desc.layers, can.maxExtent.width,
                                       can.maxExtent.height, can.maxArrayLayers));

    VkImage image = VK_NULL_HANDLE;
    check(vkCreateImage(device->handle(), &info, nullptr, &image), fmt::format("creating image '{}'", desc.name));
    handle_ = {device, image, [](const Device& d, VkImage i) { vkDestroyImage(d.handle(), i, nullptr); }};
    VkMemoryRequirements needs{};
    vkGetImageMemoryRequirements(device->handle(), image, &needs);
    memory_ = device->memory().take(needs, Access::device, true, fmt::format("image '{}'", desc.name));
    check(vkBindImageMemory(device->handle(), image, memory_.memory(), memory_.offset()),
          fmt::format("binding memory of image '{}'", desc.name));
    device->name(VK_OBJECT_TYPE_IMAGE, as_number(image), desc.name);
    constexpr VkImageUsageFlags viewed = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_STORAGE_BIT |
                                         VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT |
                                         VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT;
    if (!(desc.usage & viewed)) return;
    const bool array = desc.array || desc.layers > 1;
    view_ = make_view(array ? VK_IMAGE_VIEW_TYPE_2D_ARRAY : VK_IMAGE_VIEW_TYPE_2D, 0, desc.layers);
    layer_views_.resize(desc.layers);
}

VkImageAspectFlags Image::aspect() const
{
    return is_depth(desc_.format) ? VK_IMAGE_ASPECT_DEPTH_BIT : VK_IMAGE_ASPECT_COLOR_BIT;
}

Owned<VkImageView> Image::make_view(VkImageViewType type, std::uint32_t first, std::uint32_t count) const
{
    VkImageViewCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO;
    info.image = handle();
    info.viewType = type;
    info.format = desc_.format;
    info.subresourceRange = {aspect(), 0, 1, first, count};
    VkImageView view = VK_NULL_HANDLE;
    check(vkCreateImageView(device_->handle(), &info, nullptr, &view),
          fmt::format("creating a view of image '{}'", desc_.name));
    return {device_, view, [](const Device& d, VkImageView v) { vkDestroyImageView(d.handle(), v, nullptr); }};
}

VkImageView Image::layer_view(std::uint32_t layer) const
{
    GNOMON_CHECK_LT(layer, layer_views_.size());
    if (!layer_views_[layer]) layer_views_[layer] = make_view(VK_IMAGE_VIEW_TYPE_2D, layer, 1);
    return layer_views_[layer].get();
}

std::uint32_t texel_bytes(VkFormat format)
{
    switch (format) {
        case VK_FORMAT_R8_UNORM:
        case VK_FORMAT_R8_UINT:
            return 1;
        case VK_FORMAT_R16_SFLOAT:
        case VK_FORMAT_R16_UINT:
            return 2;
        case VK_FORMAT_R8G8B8A8_UNORM:
        case VK_FORMAT_R16G16_SFLOAT:
        case VK_FORMAT_R32_SFLOAT:
        case VK_FORMAT_R32_UINT:
        case VK_FORMAT_D32_SFLOAT:
            return 4;
        case VK_FORMAT_R16G16B16A16_SFLOAT:
        case VK_FORMAT_R32G32_SFLOAT:
        case VK_FORMAT_R32G32_UINT:
            return 8;
        case VK_FORMAT_R32G32B32_SFLOAT:
            return 12;
        case VK_FORMAT_R32G32B32A32_SFLOAT:
        case VK_FORMAT_R32G32B32A32_UINT:
            return 16;
        default:
            fail_check(__FILE__, __LINE__, fmt::format("a format of unknown size: {}", static_cast<int>(format)));
    }
}

bool is_depth(VkFormat format)
{
    return format == VK_FORMAT_D32_SFLOAT || format == VK_FORMAT_D16_UNORM;
}

Owned<VkSampler> make_sampler(const std::shared_ptr<Device>& device, const SamplerDesc& desc)
{
    VkSamplerCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_SAMPLER_CREATE_INFO;
    info.magFilter = info.minFilter = desc.filter;
    info.addressModeU = info.addressModeV = info.addressModeW = desc.address;
    info.maxLod = VK_LOD_CLAMP_NONE;
    VkSampler sampler = VK_NULL_HANDLE;
    check(vkCreateSampler(device->handle(), &info, nullptr, &sampler), "creating a sampler");
    return {device, sampler, [](const Device& d, VkSampler s) { vkDestroySampler(d.handle(), s, nullptr); }};
}

}   // namespace gnomon::vk
