// SPDX-License-Identifier: Apache-2.0
#pragma once
// Chooses how many pixels images in motion have, and how many rays they cast for bounced light, so that they come soon
// after the input that they show: the next image follows from what the ones before took.
//
// An image's time has parts that its pixels take, that new points of bounced light take, and that any image of this
// moment takes, such as moving objects and lights. Fewer pixels shorten the first part, and the second one by less,
// because few of its rays are cast for any one pixel. Where the last part is long, the others may therefore take a part
// of it more, because leaving them out would hardly be felt.

#include <array>
#include <cstddef>
#include <cstdint>

namespace gnomon::viewer {

class MotionSize {
 public:
    /// While the user moves the view: an input that is not shown by moving an image (reprojection.h) may wait for the
    /// image before its own, and then waits for its own.
    static constexpr double k_held_ms = 35;
    /// While an animation plays by itself.
    static constexpr double k_playing_ms = 40;
    static constexpr double k_more = 0.25;   // of the part that any image takes, for the others, at least
    /// Of the time allowed for pixels: what those of a finer image may be expected to take.
    static constexpr double k_spare = 0.85;
    static constexpr int k_calm = 2;         // images in a row that allow a finer one
    static constexpr int k_late = 2;         // images in a row that take too long, until the next one is coarser,
    static constexpr double k_much = 1.5;    // unless one takes this much of the allowed time
    static constexpr double k_light = 0.3;   // of the allowed time: for bounced light
    static constexpr std::uint64_t k_fewest_rays = 1u << 11, k_most_rays = 1u << 17, k_first_rays = 1u << 14;
    /// Width and height of an image in motion are those of the view divided by one of these.
    static constexpr std::array k_divisors{1, 2, 3, 4, 6, 8, 12};

    /// Of the next image.
    int divisor() const { return k_divisors[level_]; }
    /// The limit of the next image's rays for bounced light.
    std::uint64_t rays() const { return rays_; }

    /// What an image took.
    struct Cost {
        double ms = 0;            // whole, above 0
        double fixed_ms = 0;      // of it, whatever the number of pixels
        double light_ms = 0;      // of it, for bounced light
        std::uint64_t rays = 0;   // for bounced light
    };
    /// Notes what an image took. One of another size than that of now is left out.
    /// @param target_ms  that an image should take
    void add(int divisor, const Cost& cost, double target_ms);
    /// The next image shows something else, so that nothing is known of what it takes: it is coarse, and what it takes
    /// tells how fine the one after it is.
    void restart();

 private:
    std::size_t level_ = k_divisors.size() - 1;   // coarse, so that the first image is quick
    int calm_ = 0, late_ = 0;
    bool first_ = true;   // no image yet since it began
    std::uint64_t rays_ = k_first_rays;
};

}   // namespace gnomon::viewer
