// SPDX-License-Identifier: Apache-2.0
#pragma once
// Combines what neighbouring pixels found by the rays of their lobes (shading/lobe_rays.h).
//
// The patterns of 8 x 8 neighbouring pixels interleave. A window as large that slides over the image takes each of them
// once [Keller and Heidrich 2001; Segovia et al. 2006], so each pixel has the rays of 64, and no pattern shows. A
// neighbour's rays count as far as they could be the pixel's own: as far as its lobe points to the same surroundings,
// compared with the lobe's width. A smooth mirror or a small sphere therefore keeps to itself.
//
// Where few of the rays meet what is bright, the window's edges would show as a woven pattern: they pass over those
// rays one by one. The window therefore slides twice, which makes its edges soft.
//
// Pixels cast as many rays as their neighbours do not have for them (rays_wanted()): one where all of the window
// counts, several on a small ball. A neighbour counts by the weights of its rays, not by their number, because a single
// ray says nothing about how much its lobe reflects on average.
//
// With a pixel filter that reaches beyond the pixel, the light of a lobe takes part in the pixels around, too, as that
// of the samples that show it: what a sample's lobe would bring of radiance 1 is kept as the pixel filter spreads it,
// and all of it then gets the pixel's filtered light.
//
// Cost: twice up to 81 neighbours for each pixel that has a lobe, several pixels at once. Memory: some 80 bytes for
// each pixel of tiles that show lobes, and 108 where it is spread.

#include <array>
#include <memory>
#include <vector>

#include "base/image.h"
#include "base/tasks.h"
#include "image/pixel_filter.h"
#include "scene/view.h"

namespace gnomon::trace {

struct LobePixel {
    glm::vec3 light{0};    // what its lobe rays bring
    glm::vec3 weight{0};   // what they would bring of radiance 1 from everywhere; 0: it has no lobe
    // Of the first sample; a width of 0: it has no lobe.
    glm::vec3 position{0}, axis{0};   // where the lobe starts, and its direction
    float width = 0;                  // shading::lobe_width()
    float footprint = 0;              // of the pixel on the surface, its longer axis
    float rays = 1;                   // as which those that found `light` count
    // `light`, filtered once and twice: see LobeImage::add_to().
    glm::vec3 once{0}, filtered{0};
};

struct LobeFilterOptions {
    // Difference of two lobes, in widths, up to which a neighbour counts fully, and from which on it does not.
    float alike = 0.5f, unlike = 1;
    // Rays that a pixel should have with its neighbours; and, where these are as different as a lobe is wide, by
    // itself. Where they are more different, a narrower lobe shows less within a pixel: it needs fewer rays, but not
    // below the last.
    float rays = 96, least_rays = 4, rays_across = 8, own_rays = 16;
    float near = 12;   // distance of a neighbour's surface, in footprints, from which on it does not count
};

/// The pixels of an image, in square tiles, of which those without lobes take no memory.
class LobeImage {
 public:
    /// @param side  of a tile
    explicit LobeImage(Size size, int side = 32);
    /// Pixels of different tiles may be written by different threads.
    LobePixel& at(int x, int y);
    /// Thread-safe beside others that read.
    const LobePixel& at(int x, int y) const;
    /// How many rays of its lobe a pixel should have, so that with those of its neighbours there are enough. Reads the
    /// neighbours in a rectangle, in which it lies.
    float rays_wanted(int x, int y, int left, int top, int width, int height,
                      const LobeFilterOptions& options = {}) const;
    /// How the weights of a pixel's samples take part in the pixels around it, row by row. As at().
    std::array<glm::vec3, 9>& spread(int x, int y);
    /// Adds each pixel's light, filtered twice and times `scale`, to an image of the same size, and keeps it.
    void add_to(ImageF& color, float scale, Tasks& tasks, const LobeFilterOptions& options = {});
    /// Adds it to sums of the same tiles instead, as spread() has it.
    void add_to(image::SampleSums& sums, Tasks& tasks, const LobeFilterOptions& options = {});
    /// A pixel's light, filtered once: the reference for add_to().
    glm::vec3 filtered(int x, int y, const LobeFilterOptions& options = {}) const;

 private:
    struct Window;
    std::size_t tile_of(int x, int y) const
    {
        return static_cast<std::size_t>(y / side_) * static_cast<std::size_t>(columns_) +
               static_cast<std::size_t>(x / side_);
    }
    std::size_t in_tile(int x, int y) const
    {
        return static_cast<std::size_t>(y % side_) * static_cast<std::size_t>(side_) +
               static_cast<std::size_t>(x % side_);
    }
    void filter_tile(int left, int top, glm::vec3 LobePixel::*from, glm::vec3 LobePixel::*to, Window& window,
                     const LobeFilterOptions& options);

    // Filters all pixels, and calls done(x, y) for those of tiles that show lobes.
    template <class Done>
    void filter(Tasks& tasks, const LobeFilterOptions& options, const Done& done);

    using Spread = std::array<glm::vec3, 9>;
    Size size_;
    int side_, columns_;
    std::vector<std::unique_ptr<LobePixel[]>> tiles_;   // null: no lobe
    std::vector<std::unique_ptr<Spread[]>> spread_;     // null: not asked for
};

}   // namespace gnomon::trace
