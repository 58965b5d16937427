// SPDX-License-Identifier: Apache-2.0
#pragma once
// Allocates the shadow textures of all receivers in one buffer of words. A texture keeps its place while its size class
// does not change; freed places are reused within their class.
//
// Sizes are rounded up to powers of two. Cost of each call: constant.

#include <array>
#include <cstdint>
#include <vector>

namespace gnomon::shadow_textures {

class TextureArena {
 public:
    static constexpr std::uint32_t k_nowhere = 0xffffffffu;

    /// @param words  at least 1
    std::uint32_t take(std::uint32_t words);
    void give_back(std::uint32_t first_word, std::uint32_t words);
    void clear();
    /// Largest number of words that were allocated at once, which is the required size of the buffer. Places beyond
    /// 2^32 words are wrong, but no device has such a buffer.
    std::uint64_t words() const { return end_; }

    /// log2 of the words allocated for a texture with this number of words.
    static unsigned size_class(std::uint32_t words);

 private:
    std::array<std::vector<std::uint32_t>, 32> free_;
    std::uint64_t end_ = 0;
};

}   // namespace gnomon::shadow_textures
