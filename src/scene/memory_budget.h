// SPDX-License-Identifier: Apache-2.0
#pragma once
// Bounds the memory that a scene file asks for, all in all and at every moment: textures, images while they are
// decoded, keys of animations, meshes by name.
//
// Textures are halved until they fit, the largest first (of equal ones the first): by dropping the finest level. One
// that is about to be made counts among them, so that it is made no finer than it may stay. What a file becomes depends
// on the file and the budget alone, not on the machine. All else is refused before memory is taken.
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
    using Expected = std::size_t;                             // a texture from before it is made

    explicit MemoryBudget(std::uint64_t bytes = k_usual) : bytes_(bytes) {}

    /// Who asks for memory, for the message of an error.
    struct Asker {
        std::string file, place;
        std::string what;   // takes the memory: "the keys of its animations"
    };

    /// Counts memory that is about to be taken for anything but textures, and makes room for it.
    /// @throws InputError  there is not so much left
    void take(std::uint64_t bytes, SharedList<Texture>& textures, const Asker& asker);

    /// Counts a texture that is about to be made, of an image of this size. Call make_room() and then make() and
    /// made(), or left_out().
    Expected expect(int width, int height);
    void made(Expected texture, TextureId id);
    void left_out(Expected texture);

    /// Halves textures, those that are expected among them, until they fit beside what was taken and beside `bytes`
    /// that are needed for a moment.
    /// @throws InputError  they cannot be halved so far
    void make_room(std::uint64_t bytes, SharedList<Texture>& textures, const Asker& asker);

    /// Whether so many bytes are left beside what was taken and all textures, without halving one.
    bool has_room(std::uint64_t bytes) const
    {
        const std::uint64_t used = taken_ + in_textures_;
        return used <= bytes_ && bytes <= bytes_ - used;
    }

    /// The texture that the image of an expected one becomes. Threads may make different ones.
    Texture make(Expected texture, std::string name, const Image8& image, bool srgb, const Sampler& sampler,
                 bool without_alpha = false) const;

    /// Says which textures were halved; empty: none.
    std::string warning(const SharedList<Texture>& textures) const;

 private:
    struct Entry {
        int width, height;
        int halvings = 0;
        TextureId id = none;   // until it is made
        bool counts = true;
        std::uint64_t bytes() const;
    };
    struct Size {
        std::uint64_t bytes;
        Expected entry;
        bool operator<(const Size& other) const
        {
            return bytes != other.bytes ? bytes < other.bytes : entry > other.entry;
        }
    };
    [[noreturn]] void refuse(const Asker& asker) const;

    std::uint64_t bytes_, taken_ = 0;
    std::uint64_t in_textures_ = 0;
    std::vector<Entry> entries_;
    std::priority_queue<Size> largest_;   // of entries that count
};

}   // namespace gnomon::scene
