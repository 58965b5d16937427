// SPDX-License-Identifier: Apache-2.0
#include "shadow_textures/vulkan/texture_arena.h"

#include <bit>

#include "base/check.h"

namespace gnomon::shadow_textures {

unsigned TextureArena::size_class(std::uint32_t words)
{
    GNOMON_CHECK_LE(1u, words);
    return static_cast<unsigned>(std::bit_width(words - 1));
}

std::uint32_t TextureArena::take(std::uint32_t words)
{
    const unsigned c = size_class(words);
    if (!free_[c].empty()) {
        const std::uint32_t place = free_[c].back();
        free_[c].pop_back();
        return place;
    }
    const auto place = static_cast<std::uint32_t>(end_);
    end_ += std::uint64_t{1} << c;
    return place;
}

void TextureArena::give_back(std::uint32_t first_word, std::uint32_t words)
{
    free_[size_class(words)].push_back(first_word);
}

void TextureArena::clear()
{
    for (auto& list : free_) list.clear();
    end_ = 0;
}

}   // namespace gnomon::shadow_textures
