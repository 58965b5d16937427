// SPDX-License-Identifier: Apache-2.0
#pragma once
// What the steps of the lobe filter (lobe_filter.h) have in common: how much lobes differ, and a tile with the pixels
// around it, by component.

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "shading/lobe_rays.h"
#include "trace/lobe_filter.h"
#include "trace/packed_lobe_ray.h"

namespace gnomon::trace {

inline constexpr int k_half = shading::k_lobe_interleave / 2;
inline constexpr float k_apart = 1000;               // a difference of lobes that have nothing in common
inline constexpr float k_least_cosine_met = 1e-3f;   // of a ray and the normal of what it meets

// The normal of what a ray meets, times its nearness, divided by the cosine.
inline glm::vec3 facing_of(const LobeRay& ray)
{
    const float cosine =
        -(ray.normal.x * ray.direction.x + ray.normal.y * ray.direction.y + ray.normal.z * ray.direction.z);
    return ray.normal * (-ray.nearness / std::max(cosine, k_least_cosine_met));
}

// What a ray's count is multiplied by instead of divided by its density; 0: no lobe of the window casts rays there.
inline float rarity_of(const LobeRay& ray)
{
    return ray.density > 0 ? 1 / ray.density : 0;
}

// The first and the last column, and row, of the window have the same patterns: each counts half.
inline float part_at(int offset)
{
    return offset == -k_half || offset == k_half ? 0.5f : 1.0f;
}

// The square of how much two lobes differ, in widths.
inline float difference(const LobePixel& a, const LobePixel& b, const LobeFilterOptions& options)
{
    const glm::vec3 apart = b.position - a.position, turn = b.axis - a.axis;
    const float square = apart.x * apart.x + apart.y * apart.y + apart.z * apart.z;
    const float footprint = std::max(a.footprint, b.footprint);
    if (!(b.width > 0) || !(square < options.near * options.near * (footprint * footprint))) return k_apart;
    const float width = std::min(a.width, b.width), wider = std::max(a.width, b.width) - width;
    return (turn.x * turn.x + turn.y * turn.y + turn.z * turn.z + wider * wider) / (width * width);
}

// How far a neighbour's lobe is like the pixel's own, 0 to 1, by the square of the difference.
struct Likeness {
    float unlike, slope;
    Likeness(float alike_below, float unlike_from)
        : unlike(unlike_from * unlike_from), slope(1 / (unlike_from * unlike_from - alike_below * alike_below))
    {
    }
    float operator()(float difference) const
    {
        const float t = std::min(std::max((unlike - difference) * slope, 0.0f), 1.0f);
        return t * t * (3 - 2 * t);
    }
};

// A tile and the pixels around it that count for its own, by component; and their rays. Vectors of pixels may be read
// from any of its pixels on, also beyond the end of a row: `count` says which pixels have which rays.
struct LobeImage::Window {
    enum Of {
        px,   // as those of LobePixel
        py,
        pz,
        ax,
        ay,
        az,
        nx,
        ny,
        nz,
        vx,
        vy,
        vz,
        width,
        scale,
        footprint,
        rays,
        even,
        nearest,   // of the pixel's rays: the largest nearness
        count,     // rays in the list
        lr,        // light
        lg,
        lb,
        wr,   // weight
        wg,
        wb,
        open_r,   // weight of the rays that leave the scene
        open_g,
        open_b,
        k_values
    };
    enum OfRay { dx, dy, dz, near, fx, fy, fz, rarity, ray_lr, ray_lg, ray_lb, ray_wr, ray_wg, ray_wb, k_ray_values };
    static constexpr int k_most_lanes = 16;

    int stride = 0, height = 0, padded = 0;   // of the window; a row of sums, in whole vectors
    std::vector<float> values;                // k_values of each row
    std::vector<float> ray_values;            // k_ray_values of each row and number of a ray
    std::vector<std::size_t> first_of_row;    // of ray_values
    std::vector<int> rays_of_row;             // the most of a pixel
    // Of a row of the tile: how far all lobes around are the same for a pixel's rays, 0 to 1; sums: how many neighbours
    // count, and as how many rays; the densities, by number of a ray; light, weight, and weight of rays that leave.
    std::vector<float> same, covered, counted, density, light[3], weight[3], open[3];

    const float* row(Of of, int y) const
    {
        return values.data() + static_cast<std::size_t>((y * k_values + of) * stride);
    }
    const float* row(OfRay of, int ray, int y) const
    {
        return ray_values.data() + first_of_row[static_cast<std::size_t>(y)] +
               static_cast<std::size_t>((ray * k_ray_values + of) * stride);
    }
    void resize(int side)
    {
        stride = height = side + 2 * k_half;
        padded = (side + k_most_lanes - 1) / k_most_lanes * k_most_lanes;
        values.resize(static_cast<std::size_t>(k_values * stride * height + k_most_lanes));
        first_of_row.assign(static_cast<std::size_t>(height), 0);
        rays_of_row.assign(static_cast<std::size_t>(height), 0);
        for (auto* list : {&same, &covered, &counted}) list->resize(static_cast<std::size_t>(padded));
        for (auto* lists : {light, weight, open})
            for (int c = 0; c < 3; ++c) lists[c].resize(static_cast<std::size_t>(padded));
    }
    void set(Of of, int x, int y, float value)
    {
        values[static_cast<std::size_t>((y * k_values + of) * stride + x)] = value;
    }
    void take(int x, int y, const LobePixel& p, const glm::vec3& light_of)
    {
        const float all[k_values]{p.position.x,
                                  p.position.y,
                                  p.position.z,
                                  p.axis.x,
                                  p.axis.y,
                                  p.axis.z,
                                  p.normal.x,
                                  p.normal.y,
                                  p.normal.z,
                                  p.to_viewer.x,
                                  p.to_viewer.y,
                                  p.to_viewer.z,
                                  p.width,
                                  p.scale,
                                  p.footprint,
                                  p.rays,
                                  p.even,
                                  0,
                                  0,
                                  light_of.x,
                                  light_of.y,
                                  light_of.z,
                                  p.weight.x,
                                  p.weight.y,
                                  p.weight.z,
                                  p.left.x,
                                  p.left.y,
                                  p.left.z};
        for (int k = 0; k < k_values; ++k) set(static_cast<Of>(k), x, y, all[k]);
    }
    /// Makes room for the rays of a row, whose pixels have up to `most`.
    void begin_rays(int y, int most)
    {
        const auto at = static_cast<std::size_t>(y);
        const auto floats = [&](int of_each) { return static_cast<std::size_t>(of_each * k_ray_values * stride); };
        if (y > 0) first_of_row[at] = first_of_row[at - 1] + floats(rays_of_row[at - 1]);
        rays_of_row[at] = most;
        const std::size_t end = first_of_row[at] + floats(most) + k_most_lanes;
        if (ray_values.size() < end) ray_values.resize(end);
    }
    /// Takes rays that count by their densities, as this part of themselves.
    void take(int x, int y, std::span<const PackedLobeRay> list, float uneven)
    {
        set(count, x, y, static_cast<float>(list.size()));
        float* to = ray_values.data() + first_of_row[static_cast<std::size_t>(y)] + x;
        for (const PackedLobeRay& kept : list) {
            const LobeRay r = unpacked(kept);
            const glm::vec3 facing = facing_of(r);
            const float all[k_ray_values]{
                r.direction.x,         r.direction.y, r.direction.z, r.nearness, facing.x,   facing.y,   facing.z,
                rarity_of(r) * uneven, r.light.x,     r.light.y,     r.light.z,  r.weight.x, r.weight.y, r.weight.z};
            for (int k = 0; k < k_ray_values; ++k, to += stride) *to = all[k];
        }
    }
};

}   // namespace gnomon::trace
