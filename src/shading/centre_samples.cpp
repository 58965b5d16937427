// SPDX-License-Identifier: Apache-2.0
#include "shading/centre_samples.h"

#include <algorithm>

namespace gnomon::shading {

namespace {

glm::vec3 color_at(const ImageF& image, int x, int y)
{
    const float* const c = image.pixel(x, y);
    return {c[0], c[1], c[2]};
}

}   // namespace

bool same_surface(const CentreSample& a, const CentreSample& b, const RefineOptions& options)
{
    if (a.object != b.object || a.material != b.material) return false;
    if (a.width == 0 && b.width == 0) return true;   // both show the background
    if (!(glm::dot(a.normal, b.normal) > options.same_normal)) return false;
    const glm::vec3 apart = b.position - a.position;
    const float reach = options.off_plane * std::max(a.width, b.width);
    return std::abs(glm::dot(apart, a.normal)) < reach || std::abs(glm::dot(apart, b.normal)) < reach;
}

bool CentreSamples::needs_more(int x, int y, const ImageF& color, const RefineOptions& options) const
{
    const CentreSample& own = at(x, y);
    const glm::vec3 here = shown(color_at(color, x, y), options.exposure);

    // Compare the pixel with each pair of opposite neighbours.
    constexpr int k_ways[4][2] = {{1, 0}, {0, 1}, {1, 1}, {1, -1}};
    for (const auto& way : k_ways) {
        glm::vec3 light[2];
        int same = 0;
        for (int side = 0; side < 2; ++side) {
            const int nx = side == 0 ? x - way[0] : x + way[0], ny = side == 0 ? y - way[1] : y + way[1];
            if (!inside(nx, ny)) continue;
            const CentreSample& other = at(nx, ny);
            if (same_surface(own, other, options)) {
                light[same++] = shown(relit(color_at(color, nx, ny), other, own.reflectance), options.exposure);
                continue;
            }
            // Something ends between the two.
            if (difference(here, shown(color_at(color, nx, ny), options.exposure)) > options.edge) return true;
        }
        // On one surface, light may change evenly. A step makes half of its height of a difference.
        if (same == 2 && 2 * difference(here, 0.5f * (light[0] + light[1])) > options.light) return true;
        if (same == 1 && difference(here, light[0]) > 2 * options.light) return true;
    }
    return false;
}

bool CentreSamples::covered_in_part(int x, int y) const
{
    const bool own = at(x, y).width > 0;
    for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx)
            if (inside(x + dx, y + dy) && (at(x + dx, y + dy).width > 0) != own) return true;
    return false;
}

bool CentreSamples::varies(int x, int y, const ImageF& color, const RefineOptions& options) const
{
    const CentreSample& own = at(x, y);
    if (!own.textured) return false;
    const glm::vec3 light = color_at(color, x, y), here = shown(light, options.exposure);
    for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx) {
            if (!inside(x + dx, y + dy)) continue;
            const CentreSample& other = at(x + dx, y + dy);
            if (other.object != own.object || other.material != own.material) continue;
            const glm::vec3 there = shown(relit(light, own, other.reflectance), options.exposure);
            if (difference(here, there) > options.texture) return true;
        }
    return false;
}

}   // namespace gnomon::shading
