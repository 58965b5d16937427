// SPDX-License-Identifier: Apache-2.0
#pragma once
// What shadow culling remembers of every triangle [Nah 2009, 2.2].
//
// Two bits say whether all of the triangle was seen (occlusion mode), two bits a light what its shadow rays met (shadow
// mode), and two counters how many pixels showed it: 2 + 2 L bits, in as many 32-bit words as they take.
//
// Invariants: modes are read as they stood when the frame began. What a frame learns is noted beside them and merged
// when it ends; noting only ever sets bits, so the result does not depend on the order of the notes, nor on threads.
// Cost: a look-up reads one word; the merge visits what the frame noted, and nothing else.

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace gnomon::shadow_culling {

using PrimitiveId = std::uint32_t;   // a triangle of an object: the object's first id + the triangle's number
inline constexpr PrimitiveId no_primitive = 0xffffffffu;

/// Was all of the triangle seen?
/// Erratum: 2.2 glosses FULLY_RENDERED as 'completely occluded'; it means completely rendered.
enum class OcclusionMode : std::uint8_t { init = 0, partially_occluded = 1, fully_rendered = 2, dynamic = 3 };

/// What the shadow rays from a triangle to a light met: bits that are only ever set, until all are cleared.
enum class ShadowMode : std::uint8_t { init = 0, full_shadow = 1, non_shadow = 2, partial_shadow = 3 };

class Modes {
 public:
    Modes() = default;
    /// All INIT; counters 0.
    Modes(std::size_t primitives, int lights);

    std::size_t size() const { return most_pixels_.size(); }
    int lights() const { return lights_; }
    std::size_t bytes() const;

    // As they stood when the frame began.
    OcclusionMode occlusion(PrimitiveId primitive) const
    {
        return static_cast<OcclusionMode>(begun_[word_of(primitive, 0)] & 3u);
    }
    ShadowMode shadow(PrimitiveId primitive, int light) const
    {
        return static_cast<ShadowMode>(begun_[word_of(primitive, slot(light))] >> shift_of(slot(light)) & 3u);
    }
    /// Most pixels that showed it in any frame that ended.
    std::uint32_t most_pixels(PrimitiveId primitive) const { return most_pixels_[primitive]; }

    // What this frame learned. Thread-safe: bits are set atomically.
    /// @param touched  the caller's own list; gets the primitive if nothing was noted of it in this frame before
    void note_shadow(PrimitiveId primitive, int light, ShadowMode bits, std::vector<PrimitiveId>& touched);

    // The same for primary hits; by one thread, in the order of the image.
    /// Counts a pixel that shows the primitive.
    void note_pixel(PrimitiveId primitive, std::vector<PrimitiveId>& rendered)
    {
        if (pixels_[primitive]++ == 0) rendered.push_back(primitive);
    }
    /// Overrules the mode of the frame's beginning: PARTIALLY_OCCLUDED or DYNAMIC. DYNAMIC overrules both.
    void mark(PrimitiveId primitive, OcclusionMode mode)
    {
        marked_[primitive] = static_cast<std::uint8_t>(marked_[primitive] | static_cast<std::uint8_t>(mode));
    }
    /// As marked in this frame, or INIT.
    OcclusionMode marked(PrimitiveId primitive) const { return static_cast<OcclusionMode>(marked_[primitive]); }
    /// Pixels that show it in this frame.
    std::uint32_t pixels(PrimitiveId primitive) const { return pixels_[primitive]; }

    // Merging, by one thread, when the frame ends.
    /// ORs the noted shadow bits into the modes and clears the notes.
    void merge_shadow(PrimitiveId primitive);
    void set_occlusion(PrimitiveId primitive, OcclusionMode mode);
    /// Raises most_pixels, and clears this frame's pixels and mark.
    void close_pixels(PrimitiveId primitive);

    // Forgetting, between frames.
    /// One pass over all primitives.
    void forget_light(int light);
    void forget_shadow(PrimitiveId primitive);
    /// Modes and counters.
    void forget(PrimitiveId primitive);

 private:
    // Slot 0 is the occlusion mode, slot 1 + l is light l. 16 slots a word: none straddles two.
    static std::size_t slot(int light) { return static_cast<std::size_t>(light) + 1; }
    static unsigned shift_of(std::size_t slot) { return static_cast<unsigned>(2 * (slot % 16)); }
    std::size_t word_of(PrimitiveId primitive, std::size_t slot) const { return primitive * words_ + slot / 16; }

    int lights_ = 0;
    std::size_t words_ = 1;              // per primitive
    std::vector<std::uint32_t> begun_;   // the modes
    std::vector<std::uint32_t> noted_;   // this frame's shadow bits; slot 0: 1 where any is set
    std::vector<std::uint32_t> pixels_, most_pixels_;
    std::vector<std::uint8_t> marked_;
};

}   // namespace gnomon::shadow_culling
