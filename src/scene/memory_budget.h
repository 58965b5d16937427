// SPDX-License-Identifier: Apache-2.0
#pragma once
// Bounds the memory that a scene file asks for, all in all: textures, keys of animations, meshes by name.
//
// Textures are halved until they fit, the largest first (of equal ones the first): by dropping the finest level. So
// what a file becomes depends on the file and the budget alone, not on the machine. All else is refused before memory
// is taken.
//
// Cost: a step in a heap for each texture, and for each time that one is halved.

#include <cstdint>
#include <queue>
#include <string>
#include <vector>

#include "scene/shared_list.h"
#include "scene/texture.h"

namespace gnomon::scene {

class MemoryBudget {
 public:
    static constexpr std::uint64_t k_usual = 2048ull << 20;   // bytes

    explicit MemoryBudget(std::uint64_t bytes = k_usual) : bytes_(bytes) {}

    /// Counts memory that is about to be taken for anything but textures.
    /// @param file, place  where it is asked for, for the message
    /// @param what         takes it: "the keys of its animations"
    /// @throws InputError  there is not so much left
    void take(std::uint64_t bytes, const std::string& file, const std::string& place, const std::string& what);

    /// Halves textures until all fit beside what was taken. Call after textures were appended, and at the end.
    void fit(SharedList<Texture>& textures);

    /// Says which textures were halved; empty: none.
    std::string warning(const SharedList<Texture>& textures) const;

 private:
    struct Size {
        std::uint64_t bytes;
        std::size_t texture;
        bool operator<(const Size& other) const
        {
            return bytes != other.bytes ? bytes < other.bytes : texture > other.texture;
        }
    };
    std::uint64_t bytes_, taken_ = 0;
    std::uint64_t in_textures_ = 0;
    std::priority_queue<Size> largest_;
    std::vector<int> halved_;   // by texture: how often
};

}   // namespace gnomon::scene
