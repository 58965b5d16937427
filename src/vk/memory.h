// SPDX-License-Identifier: Apache-2.0
#pragma once
// Allocates device memory in large blocks and divides them, because drivers allow few allocations and each is slow.
//
// A block belongs to one memory type and to either buffers or images, so the granularity between them does not matter.
// Pieces are allocated first-fit from a list of free ranges sorted by offset, and merged with neighbouring ranges when
// freed. Resources of half a block or more get a block of their own. Host-visible blocks stay mapped. Cost: linear in
// the free ranges of the blocks of one type; no driver call for a small piece.

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "vk/api.h"

namespace gnomon::vk {

/// Whether host or device access a resource.
enum class Access : std::uint8_t {
    device,     // device only
    upload,     // written by the host, read by the device
    readback,   // written by the device, read by the host
};

class Memory;

/// A piece of a block, freed with its owner.
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
    std::uint64_t blocks = 0;            // live driver allocations
    std::uint64_t bytes_allocated = 0;   // of these blocks
    std::uint64_t bytes_used = 0;        // of live pieces
    std::uint64_t pieces = 0;            // live
};

class Memory {
 public:
    static constexpr VkDeviceSize k_block_bytes = 32 << 20;
    static constexpr int k_unwritten = 0xff;   // every byte: numbers that are not finite, indices beyond everything

    /// @param addresses  whether buffers get device addresses (for ray tracing)
    /// @param marked  whether new pieces that the host sees are filled with k_unwritten, so that reading what nothing
    ///     wrote shows: graphics cards give memory with old contents, software drivers zeros
    Memory(VkPhysicalDevice physical, VkDevice device, bool addresses, bool marked);
    ~Memory();
    Memory(const Memory&) = delete;
    Memory& operator=(const Memory&) = delete;

    /// @param what  name for the error message
    /// @throws MissingError  too little memory, or no suitable memory type
    MemoryPiece take(const VkMemoryRequirements& needs, Access access, bool image, const std::string& what);
    MemoryCounts counts() const;

 private:
    friend class MemoryPiece;
    std::uint32_t type_for(std::uint32_t allowed, Access access, const std::string& what) const;
    MemoryPiece::Block* new_block(VkDeviceSize size, std::uint32_t type, bool image, const std::string& what);
    void give_back(MemoryPiece& piece);

    VkDevice device_;
    bool addresses_, marked_;
    VkPhysicalDeviceMemoryProperties properties_{};
    VkDeviceSize most_ = ~VkDeviceSize{0};   // limit on all blocks together
    std::vector<std::unique_ptr<MemoryPiece::Block>> blocks_;
};

}   // namespace gnomon::vk
