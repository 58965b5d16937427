// SPDX-License-Identifier: Apache-2.0
#pragma once
// Combines what neighbouring pixels found by the rays of their lobes (shading/lobe_rays.h).
//
// The patterns of 8 x 8 neighbouring pixels interleave. A window as large that slides over the image takes each of them
// once [Keller and Heidrich 2001; Segovia et al. 2006], so each pixel has the rays of 64, and no pattern shows.
//
// A neighbour's ray counts as often as the pixel's own lobe would meet the same place: by the density with which the
// pixel's lobe casts rays there, divided by that of all lobes of the window around the neighbour together, which is the
// balance heuristic [Veach and Guibas 1995; Bekaert et al. 2002] (lobe_reuse.cpp). So a pixel on a small ball takes of
// its neighbours' rays what it would show itself, and a smooth mirror keeps to itself.
//
// On flat parts of a surface, all lobes of the window are nearly the same, and would meet what is far away equally
// often. There rays count alike, and no densities are found: where lobes differ by less than even_alike widths,
// parallax included. From there to even_unlike widths, both ways fade into each other.
//
// Where few of the rays meet what is bright, the window's edges would show as a woven pattern: they pass over those
// rays one by one. Therefore pixels whose lobes are nearly the same share the means as well, which makes the window's
// edges soft.
//
// Under an environment image, a ray that leaves the scene shows the mean of the image over its pixel's lobe, which is
// without noise. Neighbours do not share that, but how much of their lobes is open: each pixel has its own mean of the
// image times the part of all rays, by their weights, that leave.
//
// Pixels cast as many rays as their neighbours do not have for them (rays_wanted()): few where all of the window
// counts, several on a small ball. Rays count by their weights, because a single ray says nothing about how much its
// lobe reflects on average.
//
// With a pixel filter that reaches beyond the pixel, the light of a lobe takes part in the pixels around, too, as that
// of the samples that show it: what a sample's lobe would bring of radiance 1 is kept as the pixel filter spreads it,
// and all of it then gets the pixel's filtered light.
//
// Cost: three times 81 neighbours for each pixel; and, where lobes of the window differ, twice 81 densities for each
// ray, a vector of pixels at once (lobe_sums.h). Memory: 148 bytes for each pixel of tiles that show lobes, 28 for each
// ray (packed_lobe_ray.h), of which a pixel has 16 at most, and 108 where it is spread.

#include <array>
#include <memory>
#include <span>
#include <vector>

#include "base/image.h"
#include "base/tasks.h"
#include "image/pixel_filter.h"
#include "scene/view.h"

namespace gnomon::trace {

/// A ray of a pixel's lobe.
struct LobeRay {
    glm::vec3 direction{0};
    float nearness = 0;    // of what it meets: one divided by the distance; 0: it leaves the scene
    glm::vec3 normal{0};   // of what it meets, towards where it starts
    glm::vec3 light{0};    // what it brings
    glm::vec3 weight{0};   // what it would bring of radiance 1
    float density = 0;     // of the rays of the window around, where it ends, a pixel; LobeImage finds it
    float counts = 1;      // as how many rays those of its sample count; the same for all of these
};

struct PackedLobeRay;   // as it is kept

struct LobePixel {
    glm::vec3 light{0};    // what its lobe rays bring, as those of all of its samples
    glm::vec3 weight{0};   // what they would bring of radiance 1 from everywhere; 0: it has no lobe
    // What its lobe would bring of radiance that its rays show where they leave the scene, if all did: rays do not
    // bring it, because it is the pixel's own. And what those rays that do would bring of radiance 1.
    glm::vec3 open{0}, left{0};
    // Of the first sample; a width of 0: it has no lobe.
    glm::vec3 position{0}, axis{0};      // where the lobe starts, and its direction
    glm::vec3 normal{0}, to_viewer{0};   // that it is reflected by, and from
    float width = 0;                     // shading::lobe_width()
    float scale = 0;                     // see set_lobe()
    float footprint = 0;                 // of the pixel on the surface, its longer axis
    float rays = 1;                      // as which those that found `light` count, of all samples
    float cast = 1;                      // part of `weight` that is of samples with rays
    // Of its light, what counts for neighbours without asking their lobes, which are the same for its rays; and of its
    // rays, what counts by their densities: LobeImage finds them.
    float even = 0, uneven = 1;
    // What its own and its neighbours' rays bring; and the mean of it: see LobeImage::add_to().
    glm::vec3 gathered{0}, filtered{0};

    /// Sets the lobe of a surface point.
    /// @param density  of its rays in the direction of `axis`, per steradian
    void set_lobe(const glm::vec3& own_normal, const glm::vec3& viewer, float own_width, float density)
    {
        const float square = own_width * own_width;
        normal = own_normal, to_viewer = viewer, width = own_width, scale = density * square * square;
    }
    /// @param same              how far the lobes of its window are the same for its rays, 0 to 1
    /// @param covered, counted  how many pixels of the window count, and as how many rays
    void set_evenness(float same, float covered, float counted)
    {
        even = counted > 0 ? same * cast * (covered / counted) : 0;
        uneven = 1 - same;
    }
};

struct LobeFilterOptions {
    // Difference of two lobes, in widths, up to which a neighbour counts fully, and from which on it does not: for its
    // rays; for how many rays a pixel casts; for the mean of what pixels gathered.
    float rays_alike = 3, rays_unlike = 6, wanted_alike = 1, wanted_unlike = 4, means_alike = 0.1f, means_unlike = 0.3f;
    // Difference, with the parallax of what a pixel's rays meet, up to which the lobes of its window are the same for
    // them, and from which on they are not.
    float even_alike = 0.15f, even_unlike = 0.3f;
    // Rays that a pixel should have with its neighbours; and, where these are as different as a lobe is wide, by
    // itself. Where they are more different, a narrower lobe shows less within a pixel: it needs fewer rays, but not
    // below the last.
    float rays = 96, least_rays = 4, rays_across = 8, own_rays = 16;
    // Where lobes turn from pixel to pixel, what is bright moves through the pattern. Each width that they turn asks
    // for this many times as many of the least rays, up to twice as many.
    float least_by_turn = 8;
    float near = 12;   // distance of a neighbour's surface, in footprints, from which on it does not count
};

/// The pixels of an image, in square tiles, of which those without lobes take no memory.
class LobeImage {
 public:
    /// @param side  of a tile
    explicit LobeImage(Size size, int side = 32);
    LobeImage(LobeImage&& other) noexcept;
    LobeImage(const LobeImage&) = delete;
    LobeImage& operator=(const LobeImage&) = delete;
    LobeImage& operator=(LobeImage&&) = delete;
    ~LobeImage();
    /// Pixels of different tiles may be written by different threads.
    LobePixel& at(int x, int y);
    /// Thread-safe beside others that read.
    const LobePixel& at(int x, int y) const;
    /// How many rays of its lobe a pixel should have, so that with those of its neighbours there are enough. Reads the
    /// neighbours in a rectangle, in which it lies.
    float rays_wanted(int x, int y, int left, int top, int width, int height,
                      const LobeFilterOptions& options = {}) const;
    /// Hands over the rays of a tile's pixels, once. Those of a sample bring together what its lobe would bring of
    /// radiance 1. From here on, they bring that part of a pixel's sum which they count for: few rays say little about
    /// how much their lobe reflects on average. Samples that have none get the light of those that do.
    /// @param left, top  of the tile
    /// @param pixels     by ray: its pixel, of the tile
    void set_rays(int left, int top, std::span<const std::uint32_t> pixels, std::span<const LobeRay> rays);
    /// How the weights of a pixel's samples take part in the pixels around it, row by row. As at().
    std::array<glm::vec3, 9>& spread(int x, int y);
    /// Adds each pixel's light, filtered and times `scale`, to an image of the same size, and keeps it.
    void add_to(ImageF& color, float scale, Tasks& tasks, const LobeFilterOptions& options = {});
    /// Adds it to sums of the same tiles instead, as spread() has it.
    void add_to(image::SampleSums& sums, Tasks& tasks, const LobeFilterOptions& options = {});
    /// What the rays of a pixel and its neighbours bring, and the mean of what such pixels gathered: the references for
    /// the steps of add_to().
    glm::vec3 gathered(int x, int y, const LobeFilterOptions& options = {}) const;
    glm::vec3 mean(int x, int y, const LobeFilterOptions& options = {}) const;
    /// Frees the memory of the rays, once they are filtered.
    void drop_rays();
    /// Bytes of the rays.
    std::size_t bytes_of_rays() const;

    struct Window;   // of the filter (lobe_window.h)

 private:
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
    struct Rays {
        std::vector<std::uint32_t> first;   // by pixel of the tile, and one more; empty: there are none
        std::vector<PackedLobeRay> rays;
    };
    std::span<const PackedLobeRay> rays_of(int x, int y) const;
    float nearest_of(int x, int y) const;
    LobePixel with_evenness(int x, int y, const LobeFilterOptions& options) const;
    float density_around(int x, int y, const LobeRay& ray, const LobeFilterOptions& options) const;
    void fill(int left, int top, glm::vec3 LobePixel::*found, bool with_rays, Window& window) const;
    template <class Row>
    void for_each_row(int left, int top, const Row& row);
    static void set_found(int first, int end, bool open, glm::vec3 LobePixel::*to, LobePixel* pixels,
                          const Window& window);
    // The steps of the filter, for a tile.
    void find_densities(int left, int top, Window& window, const LobeFilterOptions& options);
    void gather(int left, int top, Window& window, const LobeFilterOptions& options);
    void share_means(int left, int top, Window& window, const LobeFilterOptions& options);

    // Filters all pixels, and calls done(x, y) for those of tiles that show lobes.
    template <class Done>
    void filter(Tasks& tasks, const LobeFilterOptions& options, const Done& done);

    using Spread = std::array<glm::vec3, 9>;
    Size size_;
    int side_, columns_;
    std::vector<std::unique_ptr<LobePixel[]>> tiles_;   // null: no lobe
    std::vector<Rays> rays_;                            // by tile
    std::vector<std::unique_ptr<Spread[]>> spread_;     // null: not asked for
};

}   // namespace gnomon::trace
