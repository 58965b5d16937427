// SPDX-License-Identifier: Apache-2.0
#include "scene/builtin/patterns.h"

#include <algorithm>

namespace gnomon::scene {

namespace {

float lattice(std::uint32_t x, std::uint32_t y, std::uint32_t seed)
{
    std::uint32_t h = x * 0x8da6b343u ^ y * 0xd8163841u ^ seed * 0xcb1ab31fu;
    h = (h ^ (h >> 16)) * 0x7feb352du;
    h = (h ^ (h >> 15)) * 0x846ca68bu;
    return static_cast<float>((h ^ (h >> 16)) >> 8) * 0x1p-24f;
}

float smooth_step(float low, float high, float x)
{
    const float t = std::clamp((x - low) / (high - low), 0.0f, 1.0f);
    return t * t * (3 - 2 * t);
}

// Writes a texel. Colours are mixed in linear space and encoded here.
void write(Image8& image, int x, int y, const glm::vec3& linear)
{
    // Encode by a table of 4096 steps, because the exact curve is slow. The table's error is below one step of 8
    // bits.
    static const std::vector<std::uint8_t> encode = [] {
        std::vector<std::uint8_t> table(4097);
        for (std::size_t i = 0; i < table.size(); ++i)
            table[i] = static_cast<std::uint8_t>(255 * srgb_from_linear(static_cast<float>(i) / 4096) + 0.5f);
        return table;
    }();
    for (int c = 0; c < 3; ++c)
        image.pixel(x, y)[c] = encode[static_cast<std::size_t>(std::clamp(linear[c], 0.0f, 1.0f) * 4096)];
}

template <class Shade>
Image8 paint(int size, Shade&& shade)
{
    Image8 image(size, size, 3);
    const float scale = 1.0f / static_cast<float>(size);
    for (int y = 0; y < size; ++y)
        for (int x = 0; x < size; ++x)
            write(image, x, y,
                  shade(glm::vec2((static_cast<float>(x) + 0.5f) * scale, (static_cast<float>(y) + 0.5f) * scale)));
    return image;
}

}   // namespace

TiledNoise::TiledNoise(int cells, int octaves, std::uint32_t seed)
{
    for (int octave = 0; octave < octaves; ++octave, cells *= 2) {
        Octave next{cells, {}};
        next.value.reserve(static_cast<std::size_t>(cells) * cells);
        for (int y = 0; y < cells; ++y)
            for (int x = 0; x < cells; ++x)
                next.value.push_back(lattice(static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y),
                                             seed + static_cast<std::uint32_t>(octave)));
        octaves_.push_back(std::move(next));
    }
}

float TiledNoise::operator()(glm::vec2 p) const
{
    p -= glm::floor(p);
    float sum = 0, weight = 0.5f, total = 0;
    for (const Octave& octave : octaves_) {
        const float x = p.x * static_cast<float>(octave.cells), y = p.y * static_cast<float>(octave.cells);
        // Rounding may turn the fraction of a number just below one into one.
        const int ix = std::min(static_cast<int>(x), octave.cells - 1);
        const int iy = std::min(static_cast<int>(y), octave.cells - 1);
        const int jx = ix + 1 < octave.cells ? ix + 1 : 0, jy = iy + 1 < octave.cells ? iy + 1 : 0;
        float tx = x - static_cast<float>(ix), ty = y - static_cast<float>(iy);
        tx = tx * tx * (3 - 2 * tx), ty = ty * ty * (3 - 2 * ty);
        const float *row = octave.value.data() + iy * octave.cells, *next = octave.value.data() + jy * octave.cells;
        const float top = row[ix] + (row[jx] - row[ix]) * tx;
        const float bottom = next[ix] + (next[jx] - next[ix]) * tx;
        sum += weight * (top + (bottom - top) * ty);
        total += weight;
        weight *= 0.5f;
    }
    return sum / total;
}

Image8 stone_pattern(int size, const glm::vec3& light, const glm::vec3& dark, float pores, std::uint32_t seed)
{
    const TiledNoise cloud_noise(4, 5, seed), grain_noise(64, 2, seed + 77), pit_noise(110, 1, seed + 154);
    return paint(size, [&](glm::vec2 p) {
        const float clouds = cloud_noise(p), grain = grain_noise(p);
        const float pit = smooth_step(0.82f, 0.90f, pit_noise(p));
        const glm::vec3 color = glm::mix(dark, light, smooth_step(0.2f, 0.8f, clouds));
        return color * (0.86f + 0.28f * grain) * (1 - pores * pit);
    });
}

Image8 plaster_pattern(int size, const glm::vec3& color, std::uint32_t seed)
{
    const TiledNoise patch_noise(3, 5, seed), grain_noise(48, 3, seed + 31), streak_noise(9, 3, seed + 62);
    return paint(size, [&](glm::vec2 p) {
        const float patches = smooth_step(0.35f, 0.65f, patch_noise(p)), grain = grain_noise(p);
        // Streaks run down the wall.
        const float streak = smooth_step(0.55f, 0.8f, streak_noise({p.x * 3, p.y * 0.34f}));
        return color * (0.80f + 0.22f * patches) * (0.90f + 0.2f * grain) * (1 - 0.16f * streak);
    });
}

Image8 marble_pattern(int size, std::uint32_t seed)
{
    const TiledNoise bend_x(3, 4, seed), bend_y(3, 4, seed + 9), vein_noise(4, 4, seed + 18),
        cloud_noise(4, 4, seed + 27);
    return paint(size, [&](glm::vec2 p) {
        const glm::vec2 bent = p + 0.22f * glm::vec2(bend_x(p), bend_y(p));
        const float vein = 1 - smooth_step(0.0f, 0.10f, std::abs(2 * vein_noise(bent) - 1));
        const float clouds = cloud_noise(p);
        const glm::vec3 body = glm::mix(glm::vec3(0.62f, 0.60f, 0.57f), glm::vec3(0.78f, 0.76f, 0.72f), clouds);
        return glm::mix(body, glm::vec3(0.36f, 0.36f, 0.38f), 0.55f * vein);
    });
}

Image8 dial_pattern(int size)
{
    const glm::vec2 foot(0.5f, 0.22f);   // where the gnomon begins; noon runs down from it
    const glm::vec3 ink(0.05f, 0.045f, 0.05f), bronze(0.42f, 0.25f, 0.09f);
    constexpr float k_hour_angle = static_cast<float>(k_pi) / 12;
    constexpr float k_latitude_sine = 0.72f;
    constexpr float k_outer = 0.455f, k_inner = 0.385f;   // the chapter ring

    // Hour and half-hour lines: tan(angle from noon) = sin(latitude) tan(hour angle).
    std::vector<glm::vec2> lines;
    constexpr int halves = 11;
    for (int half = -halves; half <= halves; ++half) {
        const float hour = k_hour_angle * 0.5f * static_cast<float>(half);
        lines.push_back(glm::normalize(glm::vec2(k_latitude_sine * std::sin(hour), std::cos(hour))));
    }
    const TiledNoise cloud_noise(4, 5, 5);
    return paint(size, [&](glm::vec2 p) {
        glm::vec3 color = glm::mix(glm::vec3(0.60f, 0.55f, 0.46f), glm::vec3(0.80f, 0.76f, 0.68f), cloud_noise(p));
        const float radius = glm::length(p - glm::vec2(0.5f));
        const auto line = [](float distance, float width) {
            return 1 - smooth_step(width, width + 0.003f, std::abs(distance));
        };
        float mark = std::max(line(radius - k_outer, 0.0045f), line(radius - k_inner, 0.0035f));
        mark = std::max(mark, line(radius - k_inner + 0.014f, 0.0015f));
        const glm::vec2 d = p - foot;
        for (int i = 0; i < static_cast<int>(lines.size()) && radius < k_outer; ++i) {
            const glm::vec2 along = lines[static_cast<std::size_t>(i)];
            const float forward = glm::dot(d, along), off = std::abs(d.x * along.y - d.y * along.x);
            const bool whole = (i - halves) % 2 == 0;
            if (forward < 0.09f || off > 0.03f || (!whole && radius < k_inner)) continue;
            mark = std::max(mark, line(off, whole ? 0.0042f : 0.0022f));
            // A lozenge at each whole hour.
            if (whole && radius > k_inner)
                mark = std::max(mark, 1 - smooth_step(0.9f, 1.1f, off / 0.015f + std::abs(radius - 0.42f) / 0.026f));
        }
        color = glm::mix(color, ink, 0.9f * mark);
        // A small sun around the gnomon's foot.
        const float from_foot = glm::length(d);
        if (from_foot > 0.1f) return color;
        const float ray = 0.060f + 0.018f * std::cos(16 * std::atan2(d.x, d.y));
        return glm::mix(color, bronze, 1 - smooth_step(ray, ray + 0.004f, from_foot));
    });
}

Image8 ramp_pattern(float top)
{
    Image8 image(256, 1, 1);
    for (int x = 0; x < 256; ++x) image.pixel(x, 0)[0] = static_cast<std::uint8_t>(top * static_cast<float>(x) + 0.5f);
    return image;
}

}   // namespace gnomon::scene
