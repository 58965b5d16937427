// SPDX-License-Identifier: Apache-2.0
#pragma once
// Device memory in blocks, cut into pieces: drivers allow few allocations, and each costs.
//
// A block belongs to one memory type and to either buffers or images, so that their granularity never meets. Pieces are
// found first-fit in a list of free ranges by offset, and merge with their neighbours when given back. What needs half
// a block or more gets a block of its own. Host-visible blocks stay mapped.
// Cost: the free ranges of the blocks of one type; never a driver call for a small piece.

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "vk/api.h"

namespace gnomon::vk {

/// Who touches a resource.
enum class Access : std::uint8_t {
    device,     // the device alone
    upload,     // written by the host, read by the device
    readback,   // written by the device, read by the host
};

class Memory;

/// A piece of a block; given back with its owner.
class MemoryPiece {
 public:
    MemoryPiece() = default;
    MemoryPiece(MemoryPiece&& other) noexcept { *this = std::move(other); }
    MemoryPiece& operator=(MemoryPiece&& other) noexcept;
    ~MemoryPiece();
    VkDeviceMemory memory() const;
    VkDeviceSize offset() const { return offset_; }
    /// Null unless host-visible.
    std::byte* mapped() const;

 private:
    friend class Memory;
    struct Block;
    Memory* owner_ = nullptr;
    Block* block_ = nullptr;
    VkDeviceSize offset_ = 0, size_ = 0;
};

struct MemoryCounts {
    std::uint64_t blocks = 0;            // allocations of the driver alive
    std::uint64_t bytes_allocated = 0;   // of these blocks
    std::uint64_t bytes_used = 0;        // of pieces alive
    std::uint64_t pieces = 0;            // alive
};

class Memory {
 public:
    static constexpr VkDeviceSize k_block_bytes = 32 << 20;

    /// @param addresses  what buffers are placed in may have addresses that shaders and builds know (ray tracing)
    Memory(VkPhysicalDevice physical, VkDevice device, bool addresses);
    ~Memory();
    Memory(const Memory&) = delete;
    Memory& operator=(const Memory&) = delete;

    /// @param what  for the message
    /// @throws MissingError  too little memory, or no memory type fits
    MemoryPiece take(const VkMemoryRequirements& needs, Access access, bool image, const std::string& what);
    MemoryCounts counts() const;

 private:
    friend class MemoryPiece;
    std::uint32_t type_for(std::uint32_t allowed, Access access, const std::string& what) const;
    MemoryPiece::Block* new_block(VkDeviceSize size, std::uint32_t type, bool image, const std::string& what);
    void give_back(MemoryPiece& piece);

    VkDevice device_;
    bool addresses_;
    VkPhysicalDeviceMemoryProperties properties_{};
    VkDeviceSize most_ = ~VkDeviceSize{0};   // of all blocks together
    std::vector<std::unique_ptr<MemoryPiece::Block>> blocks_;
};

}   // namespace gnomon::vk
