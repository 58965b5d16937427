// SPDX-License-Identifier: Apache-2.0
#pragma once
// Finds the pixels that one sample does not show well: those in which something ends.
//
// No result of this renderer is noisy, so a pixel needs more samples only where it and its neighbours differ: at edges
// of objects, at edges of shadows, in highlights and mirror images. Neighbours on one surface are compared by their
// light, each as if it had the pixel's own reflectance, because textures are filtered over the pixel as it is. An even
// change over three neighbours needs no further sample either: a filter of the pixels shows it.
//
// Differences are measured as a display shows them, so that the bounds are those of the eye: see shown().
//
// The pixels that are found depend on the image of one sample a pixel alone. Cost: 4 comparisons for each pixel,
// because each pair of neighbours is compared once.

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "base/image.h"
#include "base/math.h"
#include "gnomon/types.h"

namespace gnomon::shading {

/// What the sample at a pixel's centre met.
struct CentreSample {
    glm::vec3 position{0}, normal{0};
    // What its light is taken to be in proportion to: its diffuse reflectance, and its specular one as far as that
    // reflects what is around it at large.
    glm::vec3 reflectance{1};
    glm::vec3 mirror{0};                                        // the rest of its specular reflectance
    glm::vec3 mirrored{0};                                      // radiance that the rest brings from other surfaces
    glm::vec3 bounced{0};                                       // radiance of bounced light that it reflects
    float width = 0;                                            // of the pixel at the surface, across the view
    std::uint32_t object = 0xffffffff, material = 0xffffffff;   // the highest number: it met nothing
    std::uint32_t triangle = 0;                                 // of the object
    bool textured = false;                                      // its reflectance may vary within a pixel
    bool apart = false;                                         // what it mirrors does not follow its reflectance
    bool mirrors = false;   // part of its light comes from other surfaces, which it mirrors or lets through
};

struct RefineOptions {
    float exposure = 1;            // factor that makes the image as bright as a display shows it
    float edge = 0.03f;            // difference of neighbouring surfaces, as shown() has it, that one sample may hide
    float light = 0.04f;           // likewise, of light on one surface
    float agree = 0.03f;           // difference of light on one surface within which samples share it
    float agree_bounced = 0.06f;   // likewise, of bounced light
    // How far away pixels may be, by row and column, whose bounced light a sample takes. 0: none.
    int bounced_reach = 8;
    float spread = 0.15f;   // difference of a pixel's samples of several surfaces from which on it has all of them
    float light_spread = 0.12f;   // likewise, of samples of one surface
    float same_normal = 0.9f;     // cosine between normals of neighbours on one surface
    int texture_samples = 8;      // of a texture that differs from pixel to pixel; at most scene::k_refined_samples
    float texture = 0.01f;        // difference by a neighbour's reflectance that one sample of a texture may hide
    float off_plane = 1.0f;   // distance of a neighbour's position from the plane of a surface, in widths of the pixel
};

/// A colour as the eye compares it: 0 for black, 0.7 for light as bright as the display's white, below 1 for any light.
inline glm::vec3 shown(const glm::vec3& color, float exposure)
{
    const glm::vec3 x = glm::max(color * exposure, glm::vec3(0));
    return glm::sqrt(x / (glm::vec3(1) + x));
}

/// The largest difference of three channels.
inline float difference(const glm::vec3& a, const glm::vec3& b)
{
    const glm::vec3 d = glm::abs(a - b);
    return std::max({d.x, d.y, d.z});
}

/// Reflectance below which light is not divided by it.
inline constexpr float k_least_reflectance = 0.02f;

/// Light on a surface of reflectance `from`, on one of reflectance `to`.
inline glm::vec3 relit(const glm::vec3& color, const glm::vec3& from, const glm::vec3& to)
{
    return color * ((to + k_least_reflectance) / (from + k_least_reflectance));
}

/// The light of a sample, on a surface of reflectance `to`: what it mirrors stays as it is.
inline glm::vec3 relit(const glm::vec3& color, const CentreSample& sample, const glm::vec3& to)
{
    return relit(color - sample.mirrored, sample.reflectance, to) + sample.mirrored;
}

/// Whether two samples show one surface, over which light changes without a step.
bool same_surface(const CentreSample& a, const CentreSample& b, const RefineOptions& options);

/// The samples at the pixels' centres, row by row.
class CentreSamples {
 public:
    /// Nothing is met.
    explicit CentreSamples(Size size) { begin(size); }
    /// For begin().
    CentreSamples() = default;

    /// Begins another image in the memory of the last one. Each of its pixels must be set, or cleared.
    void begin(Size size)
    {
        size_ = size;
        samples_.resize(static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height));
    }
    /// Lets the pixels [begin, end) of a row meet nothing.
    void clear(int y, int begin, int end) { std::fill(&at(begin, y), &at(begin, y) + (end - begin), CentreSample{}); }
    CentreSample& at(int x, int y) { return samples_[index(x, y)]; }
    const CentreSample& at(int x, int y) const { return samples_[index(x, y)]; }
    bool inside(int x, int y) const { return x >= 0 && y >= 0 && x < size_.width && y < size_.height; }
    Size size() const { return size_; }
    std::size_t bytes() const { return samples_.capacity() * sizeof(CentreSample); }

    /// Finds the pixels of some rows that need more samples.
    /// @param begin, end  of the rows; those beside them are read, too, so that few at a time cost more
    /// @param color       3 channels: the light of the samples
    /// @param more        out: by pixel of the rows, 1 or 0
    void find_more(int begin, int end, const ImageF& color, const RefineOptions& options,
                   std::span<std::uint8_t> more) const;

    /// Whether a pixel or one around it shows what lies behind the scene, and another does not: alpha differs there,
    /// whatever their light is.
    bool covered_in_part(int x, int y) const;

    /// Whether a pixel shows a texture that differs from pixel to pixel, so that one sample of it is not its mean.
    /// @param color  as above
    bool varies(int x, int y, const ImageF& color, const RefineOptions& options) const;

 private:
    class Rows;
    std::size_t index(int x, int y) const
    {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(size_.width) + static_cast<std::size_t>(x);
    }
    Size size_{};
    std::vector<CentreSample> samples_;
};

}   // namespace gnomon::shading
