// SPDX-License-Identifier: Apache-2.0
#include "trace/lobe_filter.h"

#include <algorithm>
#include <cmath>

#include "base/check.h"
#include "base/interruption.h"
#include "shading/lobe_rays.h"

namespace gnomon::trace {

namespace {

constexpr int k_half = shading::k_lobe_interleave / 2;

constexpr float k_apart = 1000;   // a difference of lobes that have nothing in common

// How much two neighbours' lobes differ, in widths.
float difference(const LobePixel& a, const LobePixel& b, const LobeFilterOptions& options)
{
    const glm::vec3 apart = b.position - a.position, turn = b.axis - a.axis;
    const float square = glm::dot(apart, apart), reach = options.near * std::max(a.footprint, b.footprint);
    if (!(b.width > 0) || !(square < reach * reach)) return k_apart;
    const float width = std::min(a.width, b.width), wider = std::max(a.width, b.width);
    return (std::sqrt(glm::dot(turn, turn)) + (wider - width)) / width;
}

// How far a neighbour's rays could be the pixel's own, 0 to 1.
float likeness(float difference, const LobeFilterOptions& options)
{
    const float t = std::clamp((options.unlike - difference) / (options.unlike - options.alike), 0.0f, 1.0f);
    return t * t * (3 - 2 * t);
}

}   // namespace

glm::vec3 LobeImage::filtered(int x, int y, const LobeFilterOptions& options) const
{
    const LobePixel& own = at(x, y);
    if (own.weight == glm::vec3(0)) return glm::vec3(0);
    if (!(own.width > 0)) return own.light;
    glm::vec3 light(0), weight(0);
    for (int dy = -k_half; dy <= k_half; ++dy)
        for (int dx = -k_half; dx <= k_half; ++dx) {
            const int nx = x + dx, ny = y + dy;
            if (nx < 0 || ny < 0 || nx >= size_.width || ny >= size_.height) continue;
            const LobePixel& other = at(nx, ny);
            if (!(other.width > 0)) continue;
            // The first and the last column, and row, of the window have the same patterns: each counts half.
            float share = likeness(difference(own, other, options), options) * other.rays;
            if (dx == -k_half || dx == k_half) share *= 0.5f;
            if (dy == -k_half || dy == k_half) share *= 0.5f;
            light += share * other.light, weight += share * other.weight;
        }
    glm::vec3 result(0);
    for (int c = 0; c < 3; ++c) result[c] = weight[c] > 0 ? own.weight[c] * (light[c] / weight[c]) : own.light[c];
    return result;
}

float LobeImage::rays_wanted(int x, int y, int left, int top, int width, int height,
                             const LobeFilterOptions& options) const
{
    // Of each ring of neighbours, ask four.
    const LobePixel& own = at(x, y);
    float alike = 1, step = k_apart;
    for (int ring = 1; ring <= k_half; ++ring) {
        int asked = 0;
        float sum = 0;
        for (int k = 0; k < 4; ++k) {
            // Along the axes and the diagonals, in turn.
            const int dx = ring % 2 == 1 ? (k % 2 == 0 ? ring * (1 - k) : 0) : ring * (k % 2 == 0 ? 1 : -1);
            const int dy = ring % 2 == 1 ? (k % 2 == 1 ? ring * (2 - k) : 0) : ring * (k < 2 ? 1 : -1);
            const int nx = x + dx, ny = y + dy;
            if (nx < left || ny < top || nx >= left + width || ny >= top + height) continue;
            const float apart = difference(own, at(nx, ny), options);
            if (ring == 1) step = std::min(step, apart);
            sum += likeness(apart, options), ++asked;
        }
        const float pixels = ring == k_half ? 4 * k_half - 1 : 8 * ring;   // those of the last ring count half
        if (asked > 0) alike += pixels * sum / static_cast<float>(asked);
    }
    // Where neighbours are far apart, a narrow lobe shows little within one pixel.
    const float few = step < k_apart ? std::max(options.own_rays / step, 1.0f) : options.rays;
    return std::min(options.rays / alike, few);
}

void LobeImage::add_to(ImageF& color, float scale, Tasks& tasks, const LobeFilterOptions& options)
{
    GNOMON_CHECK(color.width == size_.width && color.height == size_.height);
    const auto for_each_row = [&](const auto& body) {
        tasks.for_each(static_cast<std::size_t>(size_.height), [&](std::size_t row, int) {
            interruption_point();
            body(static_cast<int>(row));
        });
    };
    LobeImage once = *this;
    for_each_row([&](int y) {
        for (int x = 0; x < size_.width; ++x) once.at(x, y).light = filtered(x, y, options);
    });
    for_each_row([&](int y) {
        for (int x = 0; x < size_.width; ++x) {
            at(x, y).filtered = once.filtered(x, y, options);
            const glm::vec3 light = scale * at(x, y).filtered;
            float* const to = color.pixel(x, y);
            for (int c = 0; c < 3; ++c) to[c] += light[c];
        }
    });
}

}   // namespace gnomon::trace
