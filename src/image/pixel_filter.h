// SPDX-License-Identifier: Apache-2.0
#pragma once
// Makes the pixels of an image of their samples, by a filter that may reach beyond the pixel.
//
// A sample counts by its distance from a pixel's centre, so that it takes part in up to 3 x 3 pixels. A pixel may have
// any number of samples: together they stand for its area, whatever their number is. All weights are at least 0, and a
// pixel's weights are divided by their sum, so the filter neither rings nor changes an even area.
//
// Light above the display's white counts less, the brighter the less [after Karis 2013, "Tone mapping"]: otherwise, one
// sample of a light in 16 would make the whole pixel white, and the edge of the emitter would have stairs. Light that
// the display can show is averaged as it is.
//
// Tiles may be filled by different threads: each has sums of its own, with a border of one pixel, and a pixel adds
// those of up to four tiles in a fixed order.
//
// Cost: up to 9 multiplications for each sample and channel. Memory: all channels and two weights, 1.13 times.

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "base/math.h"
#include "gnomon/types.h"

namespace gnomon::image {

/// Distance from a pixel's centre along an axis from which on a sample does not count, in pixels.
inline constexpr float k_filter_radius = 1.5f;

/// The filter itself, or that which an automatic one stands for.
PixelFilter chosen_filter(PixelFilter filter, bool adaptive);

/// Weight of a sample along one axis, not normalised.
/// @param filter    not automatic
/// @param distance  from the pixel's centre, in pixels
float filter_weight(PixelFilter filter, float distance);

/// A place along an axis such that the places of evenly spread numbers are as dense as the filter has weight: samples
/// there make a pixel by their mean.
/// @param number  0 to 1
/// @return  from the pixel's centre, in pixels
float filter_place(PixelFilter filter, float number);

/// The weights of samples at one position in their pixels, in the columns and rows before, here and after.
struct SampleWeights {
    float across[3]{}, down[3]{};
};
/// @param offset  position in the pixel, 0 to 1
SampleWeights sample_weights(PixelFilter filter, const glm::vec2& offset);

/// The weights of a pixel's only sample, at its centre, so that pixels of one sample are blurred as much as those of
/// many: the columns and rows before and after have half of the filter's variance each. A filter that is sampled at
/// pixels' centres alone is narrower than it is [in the sense of the second moment], and would leave textures that have
/// one sample a pixel sharper than the mean of many.
SampleWeights lone_sample_weights(PixelFilter filter);

/// How light above the display's white counts: less, as above, or as it is.
enum class LightWeight : std::uint8_t { shown, linear };

class SampleSums {
 public:
    /// @param tile      pixels a side
    /// @param channels  of a sample, the colour's three first
    /// @param white     luminance from which on light counts less; infinite: all light counts as it is
    SampleSums(Size size, int tile, int channels, float white);
    /// For begin().
    SampleSums() = default;

    /// Begins another image, as the constructor does, in the memory of the last one. Each tile must be cleared before a
    /// sample is added to it.
    void begin(Size size, int tile, int channels, float white);
    /// Forgets the samples of a tile.
    void clear(std::size_t tile);

    /// Adds a sample. One thread at a time for each tile.
    /// @param tile    its number, row by row
    /// @param x, y    pixel in the tile
    /// @param share   of the pixel's area that it stands for
    /// @return  by what its light counts, 0 to 1
    float add(std::size_t tile, int x, int y, const SampleWeights& weights, float share, const float* values,
              LightWeight light = LightWeight::shown);

    /// Adds light to what samples of a pixel have brought that were added before.
    /// @param light  for the pixel and those around it, row by row: times their weights and times what add() returned
    void add_light(std::size_t tile, int x, int y, const std::array<glm::vec3, 9>& light);

    /// Calls sink(x, y, values) for each pixel of a tile, in image coordinates, once all samples are added.
    void resolve(std::size_t tile, const std::function<void(int x, int y, const float* values)>& sink) const;

    int channels() const { return channels_; }
    std::size_t bytes() const { return sums_.capacity() * sizeof(float); }

 private:
    const float* sums_of(int column, int row, int x, int y) const;

    Size size_{};
    int side_ = 0, columns_ = 0, rows_ = 0, channels_ = 0;
    float white_ = 0;
    std::size_t stride_ = 0;        // floats of a pixel: the channels, and the weights of colour and of the others
    std::size_t tile_floats_ = 0;   // of a tile and its border
    std::vector<float> sums_;
};

}   // namespace gnomon::image
