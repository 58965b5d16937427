// SPDX-License-Identifier: Apache-2.0
#pragma once
// What the steps of the lobe filter (lobe_filter.h) have in common: how much lobes differ, how densely a lobe casts
// rays to a place, and a tile with the pixels around it, by component.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <utility>
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

// How a lobe sees the place where a ray of another pixel ends. Microfacets reflect the viewer's direction there whose
// normal is h, the sum of both directions.
struct SeenPlace {
    float x, y, z;         // its direction
    float along, across;   // squares of the parts of h along the lobe's normal, and across
    float as_dense;   // rays there as the other pixel sees it, per steradian, for one of the lobe's; 0: it is hidden
};

// Turns a ray to start at a lobe: without branches, so that compilers use vectors.
// @param n, v, p  the lobe's normal, the direction to its viewer, and where it starts
// @param q, d     where the ray starts, and its direction
// @param near, f  LobeRay::nearness and facing_of()
[[gnu::always_inline]] inline SeenPlace place_seen(float nx, float ny, float nz, float vx, float vy, float vz, float px,
                                                   float py, float pz, float qx, float qy, float qz, float dx, float dy,
                                                   float dz, float near, float fx, float fy, float fz)
{
    const float ox = qx - px, oy = qy - py, oz = qz - pz;
    const float ux = dx + near * ox, uy = dy + near * oy, uz = dz + near * oz;
    const float inverse = 1 / std::sqrt(ux * ux + uy * uy + uz * uz), slant = 1 + (fx * ox + fy * oy + fz * oz);
    const float x = ux * inverse, y = uy * inverse, z = uz * inverse;
    const float hx = x + vx, hy = y + vy, hz = z + vz;
    const float along = nx * hx + ny * hy + nz * hz, above = nx * x + ny * y + nz * z;
    const float cx = ny * hz - nz * hy, cy = nz * hx - nx * hz, cz = nx * hy - ny * hx;
    const float as_dense = above > 0 && along > 0 && slant > 0 ? slant * inverse * inverse * inverse : 0.0f;
    return {x, y, z, along * along, cx * cx + cy * cy + cz * cz, as_dense};
}

// How densely a lobe casts rays to a place, but for its scale (LobePixel::set_lobe()).
inline float density_of(const SeenPlace& at, float a2)
{
    const float peak = (at.along + at.across) / (a2 * at.along + at.across);
    const float density = peak * peak * at.as_dense;
    return at.as_dense > 0 ? density : 0.0f;
}

// A tile and the pixels around it that count for its own, by component; and their rays.
struct LobeImage::Window {
    enum Of {
        px,
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
        lr,
        lg,
        lb,
        wr,
        wg,
        wb,
        k_values
    };
    enum OfRay { dx, dy, dz, near, fx, fy, fz, density, ray_lr, ray_lg, ray_lb, ray_wr, ray_wg, ray_wb, k_ray_values };
    int stride = 0, height = 0;
    std::vector<float> values[k_values];
    std::vector<std::vector<float>> ray_values;        // k_ray_values of each number of a ray
    std::vector<int> rays_of_row;                      // the most of a pixel
    std::vector<std::vector<std::uint64_t>> columns;   // by number of a ray and row: which pixels have it, a bit each
    std::vector<float> share, counted, found, covered, light[3], weight[3];   // of a row of the tile

    float* row(Of of, int y) { return values[of].data() + static_cast<std::size_t>(y * stride); }
    float* row(OfRay of, int ray, int y)
    {
        return ray_values[static_cast<std::size_t>(ray * k_ray_values + of)].data() +
               static_cast<std::size_t>(y * stride);
    }
    void clear(int side)
    {
        stride = height = side + 2 * k_half;
        for (auto& list : values) list.assign(static_cast<std::size_t>(stride * height), 0);
        for (auto& list : ray_values) list.assign(static_cast<std::size_t>(stride * height), 0);
        rays_of_row.assign(static_cast<std::size_t>(height), 0);
        for (auto& list : columns) list.assign(static_cast<std::size_t>(height), 0);
        for (auto* list : {&share, &counted, &found, &covered}) list->resize(static_cast<std::size_t>(side));
        for (auto* lists : {light, weight})
            for (int c = 0; c < 3; ++c) lists[c].resize(static_cast<std::size_t>(side));
    }
    /// Calls use(first, end) for the parts of a row of the tile, of whole eights of pixels, where some have a ray.
    /// @param column  of the window, of the tile's first pixel
    template <class Use>
    void for_each_run(int ray, int y, int column, int first, int end, const Use& use) const
    {
        const std::uint64_t bits = columns[static_cast<std::size_t>(ray)][static_cast<std::size_t>(y)];
        const std::uint64_t from_first = stride <= 64 ? bits >> column : bits;
        int from = -1;
        for (int x = first; x < end; x += 8) {
            const bool any = stride > 64 ? from_first != 0 : (from_first >> x & 0xff) != 0;
            if (any && from < 0) from = x;
            if (!any && from >= 0) use(std::exchange(from, -1), x);
        }
        if (from >= 0) use(from, end);
    }
    void clear_sums()
    {
        for (auto* sums : {light, weight})
            for (int c = 0; c < 3; ++c) std::fill(sums[c].begin(), sums[c].end(), 0.0f);
    }
    void take(int x, int y, const LobePixel& p, const glm::vec3& light_of)
    {
        const float all[k_values]{p.position.x, p.position.y, p.position.z, p.axis.x,      p.axis.y,      p.axis.z,
                                  p.normal.x,   p.normal.y,   p.normal.z,   p.to_viewer.x, p.to_viewer.y, p.to_viewer.z,
                                  p.width,      p.scale,      p.footprint,  p.rays,        light_of.x,    light_of.y,
                                  light_of.z,   p.weight.x,   p.weight.y,   p.weight.z};
        for (int k = 0; k < k_values; ++k) values[k][static_cast<std::size_t>(y * stride + x)] = all[k];
    }
    void take(int x, int y, std::span<const PackedLobeRay> list)
    {
        while (ray_values.size() < list.size() * k_ray_values)
            ray_values.emplace_back(static_cast<std::size_t>(stride * height), 0.0f);
        int& most = rays_of_row[static_cast<std::size_t>(y)];
        most = std::max(most, static_cast<int>(list.size()));
        while (columns.size() < list.size()) columns.emplace_back(static_cast<std::size_t>(height), 0);
        for (std::size_t i = 0; i < list.size(); ++i) {
            const LobeRay r = unpacked(list[i]);
            const glm::vec3 facing = facing_of(r);
            // Wider windows than a word has bits: all pixels may have it.
            columns[i][static_cast<std::size_t>(y)] |= stride <= 64 ? std::uint64_t{1} << x : ~std::uint64_t{0};
            const float all[k_ray_values]{r.direction.x, r.direction.y, r.direction.z, r.nearness, facing.x,
                                          facing.y,      facing.z,      r.density,     r.light.x,  r.light.y,
                                          r.light.z,     r.weight.x,    r.weight.y,    r.weight.z};
            for (int k = 0; k < k_ray_values; ++k) row(static_cast<OfRay>(k), static_cast<int>(i), y)[x] = all[k];
        }
    }
};

}   // namespace gnomon::trace
