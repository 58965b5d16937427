// SPDX-License-Identifier: Apache-2.0
#include "vk/memory.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>

#include "base/check.h"
#include "gnomon/error.h"

namespace gnomon::vk {

struct MemoryPiece::Block {
    VkDeviceMemory memory = VK_NULL_HANDLE;
    std::byte* mapped = nullptr;
    VkDeviceSize size = 0, used = 0;
    std::uint64_t pieces = 0;
    std::uint32_t type = 0;
    bool image = false, alone = false;
    std::map<VkDeviceSize, VkDeviceSize> free;   // offset to size
};

namespace {

// The machine's memory in bytes.
VkDeviceSize machine_memory()
{
    const long pages = sysconf(_SC_PHYS_PAGES), page = sysconf(_SC_PAGE_SIZE);
    return pages > 0 && page > 0 ? static_cast<VkDeviceSize>(pages) * static_cast<VkDeviceSize>(page)
                                 : ~VkDeviceSize{0};
}

}   // namespace

MemoryPiece& MemoryPiece::operator=(MemoryPiece&& other) noexcept
{
    std::swap(owner_, other.owner_);
    std::swap(block_, other.block_);
    std::swap(offset_, other.offset_);
    std::swap(size_, other.size_);
    return *this;
}

MemoryPiece::~MemoryPiece()
{
    if (owner_) owner_->give_back(*this);
}

VkDeviceMemory MemoryPiece::memory() const
{
    return block_->memory;
}

std::byte* MemoryPiece::mapped() const
{
    return block_->mapped ? block_->mapped + offset_ : nullptr;
}

Memory::Memory(VkPhysicalDevice physical, VkDevice device, bool addresses, bool marked)
    : device_(device), addresses_(addresses), marked_(marked)
{
    vkGetPhysicalDeviceMemoryProperties(physical, &properties_);
    VkPhysicalDeviceProperties2 all{};
    all.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2;
    vkGetPhysicalDeviceProperties2(physical, &all);
    if (all.properties.deviceType == VK_PHYSICAL_DEVICE_TYPE_CPU) most_ = machine_memory() / 8 * 7;
}

Memory::~Memory()
{
    for (const auto& block : blocks_) vkFreeMemory(device_, block->memory, nullptr);
}

// Chooses the first type with all preferred properties, else the first with the required ones.
std::uint32_t Memory::type_for(std::uint32_t allowed, Access access, const std::string& what) const
{
    constexpr VkMemoryPropertyFlags host = VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
    VkMemoryPropertyFlags wanted[2] = {VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT, 0};
    if (access == Access::upload) wanted[0] = wanted[1] = host;
    if (access == Access::readback) wanted[0] = host | VK_MEMORY_PROPERTY_HOST_CACHED_BIT, wanted[1] = host;
    for (const VkMemoryPropertyFlags flags : wanted)
        for (std::uint32_t t = 0; t < properties_.memoryTypeCount; ++t)
            if ((allowed >> t & 1) && (properties_.memoryTypes[t].propertyFlags & flags) == flags) return t;
    throw MissingError(fmt::format("Vulkan: no memory type for {}", what));
}

MemoryPiece::Block* Memory::new_block(VkDeviceSize size, std::uint32_t type, bool image, const std::string& what)
{
    VkMemoryAllocateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO;
    VkMemoryAllocateFlagsInfo flags{};
    flags.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_FLAGS_INFO;
    flags.flags = VK_MEMORY_ALLOCATE_DEVICE_ADDRESS_BIT;
    if (addresses_ && !image) info.pNext = &flags;
    info.allocationSize = size;
    info.memoryTypeIndex = type;
    auto block = std::make_unique<MemoryPiece::Block>();
    // A heap's size may not be exceeded. Software drivers report more memory than the machine has.
    const VkDeviceSize heap = properties_.memoryHeaps[properties_.memoryTypes[type].heapIndex].size;
    const VkDeviceSize left = most_ - std::min(most_, counts().bytes_allocated);
    const VkResult result = size > std::min(heap, left) ? VK_ERROR_OUT_OF_DEVICE_MEMORY
                                                        : vkAllocateMemory(device_, &info, nullptr, &block->memory);
    if (result != VK_SUCCESS) fail(result, fmt::format("allocating {} MiB for {}", (size + (1 << 20) - 1) >> 20, what));
    block->size = size;
    block->type = type;
    block->image = image;
    block->free[0] = size;
    if (properties_.memoryTypes[type].propertyFlags & VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT) {
        void* mapped = nullptr;
        const VkResult seen = vkMapMemory(device_, block->memory, 0, VK_WHOLE_SIZE, 0, &mapped);
        if (seen != VK_SUCCESS) {
            vkFreeMemory(device_, block->memory, nullptr);
            fail(seen, fmt::format("mapping memory for {}", what));
        }
        block->mapped = static_cast<std::byte*>(mapped);
    }
    return blocks_.emplace_back(std::move(block)).get();
}

MemoryPiece Memory::take(const VkMemoryRequirements& needs, Access access, bool image, const std::string& what)
{
    const std::uint32_t type = type_for(needs.memoryTypeBits, access, what);
    const bool alone = needs.size >= k_block_bytes / 2;
    MemoryPiece piece;

    // Allocate from the first free range that is large enough, with alignment.
    const auto cut_from = [&](MemoryPiece::Block& block) {
        for (auto range = block.free.begin(); range != block.free.end(); ++range) {
            const auto [begin, size] = *range;
            const VkDeviceSize at = (begin + needs.alignment - 1) / needs.alignment * needs.alignment;
            if (at + needs.size > begin + size) continue;
            block.free.erase(range);
            if (at > begin) block.free[begin] = at - begin;
            if (at + needs.size < begin + size) block.free[at + needs.size] = begin + size - at - needs.size;
            piece.owner_ = this;
            piece.block_ = &block;
            piece.offset_ = at;
            piece.size_ = needs.size;
            block.used += needs.size;
            ++block.pieces;
            if (marked_ && block.mapped) std::memset(block.mapped + at, k_unwritten, needs.size);
            return true;
        }
        return false;
    };
    if (!alone)
        for (const auto& block : blocks_)
            if (block->type == type && block->image == image && !block->alone && cut_from(*block)) return piece;
    MemoryPiece::Block* const block = new_block(alone ? needs.size : k_block_bytes, type, image, what);
    block->alone = alone;
    GNOMON_CHECK(cut_from(*block));
    return piece;
}

void Memory::give_back(MemoryPiece& piece)
{
    MemoryPiece::Block& block = *piece.block_;
    block.used -= piece.size_;
    if (--block.pieces == 0) {
        // Return an empty block to the driver, because the next allocation may need another type.
        vkFreeMemory(device_, block.memory, nullptr);
        std::erase_if(blocks_, [&](const auto& b) { return b.get() == &block; });
        return;
    }
    auto range = block.free.emplace(piece.offset_, piece.size_).first;
    if (const auto next = std::next(range); next != block.free.end() && range->first + range->second == next->first) {
        range->second += next->second;
        block.free.erase(next);
    }
    if (range != block.free.begin())
        if (const auto before = std::prev(range); before->first + before->second == range->first) {
            before->second += range->second;
            block.free.erase(range);
        }
}

MemoryCounts Memory::counts() const
{
    MemoryCounts counts;
    counts.blocks = blocks_.size();
    for (const auto& block : blocks_) {
        counts.bytes_allocated += block->size;
        counts.bytes_used += block->used;
        counts.pieces += block->pieces;
    }
    return counts;
}

}   // namespace gnomon::vk
