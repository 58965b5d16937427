// SPDX-License-Identifier: Apache-2.0
#pragma once
// The modes that shadow culling stores for every triangle [Nah 2009, 2.2].
//
// Two bits store whether all of the triangle was seen (occlusion mode), two bits per light what its shadow rays hit
// (shadow mode): 2 + 2 L bits, in as many 32-bit words as needed. Two counters store how many pixels showed it.
//
// Invariants: modes are read as they were when the frame began. New results are noted separately and merged at the end
// of the frame. Notes only set bits, so that the result depends neither on their order nor on threads.
//
// Cost: a look-up reads one word; the merge visits only the triangles with notes.

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace gnomon::shadow_culling {

using PrimitiveId = std::uint32_t;   // a triangle: its object's first id plus its index in the mesh
inline constexpr PrimitiveId no_primitive = 0xffffffffu;

/// Whether all of the triangle was seen.
/// Erratum: 2.2 glosses FULLY_RENDERED as 'completely occluded'; it means completely rendered.
enum class OcclusionMode : std::uint8_t { init = 0, partially_occluded = 1, fully_rendered = 2, dynamic = 3 };

/// What the shadow rays from a triangle to a light hit: bits that are only set, until all are cleared.
enum class ShadowMode : std::uint8_t { init = 0, full_shadow = 1, non_shadow = 2, partial_shadow = 3 };

class Modes {
 public:
    Modes() = default;
    /// All INIT; counters 0.
    Modes(std::size_t primitives, int lights);

    std::size_t size() const { return most_pixels_.size(); }
    int lights() const { return lights_; }
    std::size_t bytes() const;

    // The modes as they were when the frame began; with set_shadow_now(), as they are.
    OcclusionMode occlusion(PrimitiveId primitive) const
    {
        return static_cast<OcclusionMode>(begun_[word_of(primitive, 0)] & 3u);
    }
    ShadowMode shadow(PrimitiveId primitive, int light) const
    {
        return static_cast<ShadowMode>(begun_[word_of(primitive, slot(light))] >> shift_of(slot(light)) & 3u);
    }
    /// The largest number of pixels that showed it in one of the past frames.
    std::uint32_t most_pixels(PrimitiveId primitive) const { return most_pixels_[primitive]; }

    // The results of this frame. Thread-safe, because bits are set atomically.
    /// @param touched  the caller's own list; the primitive is appended at its first note in this frame
    void note_shadow(PrimitiveId primitive, int light, ShadowMode bits, std::vector<PrimitiveId>& touched);

    /// ORs shadow bits into the modes at once; by one thread. Excludes note_shadow().
    void set_shadow_now(PrimitiveId primitive, int light, ShadowMode bits)
    {
        begun_[word_of(primitive, slot(light))] |= static_cast<std::uint32_t>(bits) << shift_of(slot(light));
    }

    // The same for primary hits; by one thread, in the order of the image.
    /// Counts a pixel that shows the primitive.
    void note_pixel(PrimitiveId primitive, std::vector<PrimitiveId>& rendered)
    {
        if (pixels_[primitive]++ == 0) rendered.push_back(primitive);
    }
    /// Replaces the mode of the beginning of the frame by PARTIALLY_OCCLUDED or DYNAMIC. DYNAMIC has precedence.
    void mark(PrimitiveId primitive, OcclusionMode mode)
    {
        marked_[primitive] = static_cast<std::uint8_t>(marked_[primitive] | static_cast<std::uint8_t>(mode));
    }
    /// As marked in this frame, or INIT.
    OcclusionMode marked(PrimitiveId primitive) const { return static_cast<OcclusionMode>(marked_[primitive]); }
    /// The number of pixels that show it in this frame.
    std::uint32_t pixels(PrimitiveId primitive) const { return pixels_[primitive]; }

    // Merging, by one thread, at the end of the frame.
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
    // Slot 0 is the occlusion mode, slot 1 + l is light l. A word has 16 slots, so none straddles two words.
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
