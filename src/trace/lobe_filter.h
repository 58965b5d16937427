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
// Cost: twice up to 81 neighbours for each pixel that has a lobe.

#include <vector>

#include "base/image.h"
#include "base/tasks.h"
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
    glm::vec3 filtered{0};            // `light`, filtered twice: see LobeImage::add_to()
};

struct LobeFilterOptions {
    // Difference of two lobes, in widths, up to which a neighbour counts fully, and from which on it does not.
    float alike = 0.5f, unlike = 1;
    // Rays that a pixel and its neighbours should have together, and a pixel of a lobe as wide as the difference to its
    // neighbours.
    float rays = 24, own_rays = 8;
    float near = 12;   // distance of a neighbour's surface, in footprints, from which on it does not count
};

/// The pixels of an image, row by row.
class LobeImage {
 public:
    explicit LobeImage(Size size)
        : size_(size), pixels_(static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height))
    {
    }
    LobePixel& at(int x, int y) { return pixels_[index(x, y)]; }
    const LobePixel& at(int x, int y) const { return pixels_[index(x, y)]; }
    /// Adds each pixel's light, filtered twice and times `scale`, to an image of the same size, and keeps it.
    void add_to(ImageF& color, float scale, Tasks& tasks, const LobeFilterOptions& options = {});
    /// How many rays of its lobe a pixel should have, so that with those of its neighbours there are enough. Reads the
    /// neighbours in a rectangle, in which it lies.
    float rays_wanted(int x, int y, int left, int top, int width, int height,
                      const LobeFilterOptions& options = {}) const;
    /// A pixel's light, filtered once.
    glm::vec3 filtered(int x, int y, const LobeFilterOptions& options = {}) const;

 private:
    std::size_t index(int x, int y) const
    {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(size_.width) + static_cast<std::size_t>(x);
    }
    Size size_;
    std::vector<LobePixel> pixels_;
};

}   // namespace gnomon::trace
