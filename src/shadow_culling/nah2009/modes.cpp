// SPDX-License-Identifier: Apache-2.0
#include "shadow_culling/nah2009/modes.h"

#include <algorithm>
#include <atomic>

#include "base/check.h"

namespace gnomon::shadow_culling {

Modes::Modes(std::size_t primitives, int lights) : lights_(lights)
{
    GNOMON_CHECK_LE(0, lights);
    GNOMON_CHECK_LT(primitives, static_cast<std::size_t>(no_primitive));
    words_ = (static_cast<std::size_t>(lights) + 1 + 15) / 16;
    begun_.assign(primitives * words_, 0);
    noted_.assign(primitives * words_, 0);
    pixels_.assign(primitives, 0);
    most_pixels_.assign(primitives, 0);
    marked_.assign(primitives, 0);
}

std::size_t Modes::bytes() const
{
    return 4 * (begun_.size() + noted_.size() + pixels_.size() + most_pixels_.size()) + marked_.size();
}

void Modes::note_shadow(PrimitiveId primitive, int light, ShadowMode bits, std::vector<PrimitiveId>& touched)
{
    const auto set = [&](std::size_t word, std::uint32_t mask) {
        std::atomic_ref<std::uint32_t> noted(noted_[word]);
        // Most notes repeat known bits: read before writing, so that threads do not contend for the cache line.
        if ((noted.load(std::memory_order_relaxed) & mask) == mask) return mask;
        return noted.fetch_or(mask, std::memory_order_relaxed);
    };
    const std::size_t s = slot(light);
    set(word_of(primitive, s), static_cast<std::uint32_t>(bits) << shift_of(s));
    if ((set(word_of(primitive, 0), 1) & 1) == 0) touched.push_back(primitive);
}

void Modes::merge_shadow(PrimitiveId primitive)
{
    noted_[word_of(primitive, 0)] &= ~3u;   // the occlusion mode's slot: only the flag
    for (std::size_t w = primitive * words_; w < (primitive + 1) * words_; ++w) {
        begun_[w] |= noted_[w];
        noted_[w] = 0;
    }
}

void Modes::set_occlusion(PrimitiveId primitive, OcclusionMode mode)
{
    std::uint32_t& word = begun_[word_of(primitive, 0)];
    word = (word & ~3u) | static_cast<std::uint32_t>(mode);
}

void Modes::close_pixels(PrimitiveId primitive)
{
    most_pixels_[primitive] = std::max(most_pixels_[primitive], pixels_[primitive]);
    pixels_[primitive] = 0;
    marked_[primitive] = 0;
}

void Modes::forget_light(int light)
{
    const std::uint32_t keep = ~(3u << shift_of(slot(light)));
    for (std::size_t w = slot(light) / 16; w < begun_.size(); w += words_) begun_[w] &= keep;
}

void Modes::forget_shadow(PrimitiveId primitive)
{
    for (std::size_t w = primitive * words_; w < (primitive + 1) * words_; ++w)
        begun_[w] &= w == primitive * words_ ? 3u : 0u;
}

void Modes::forget(PrimitiveId primitive)
{
    forget_shadow(primitive);
    set_occlusion(primitive, OcclusionMode::init);
    most_pixels_[primitive] = 0;
}

}   // namespace gnomon::shadow_culling
