// SPDX-License-Identifier: Apache-2.0
#include "bench/culling/images.h"

#include <algorithm>
#include <cmath>

namespace gnomon::bench {

namespace {

constexpr float k_ambient = 0.06f;                // of the brightest pixels, so that objects in shadows are visible
constexpr double k_overexposed_fraction = 0.02;   // of the pixels may be overexposed
constexpr float k_faded = 0.35f;                  // of the light, where no result is wrong
constexpr std::uint8_t k_wrong_color[3] = {255, 32, 64};

void put(Image8& image, int x, int y, const glm::vec3& linear)
{
    for (int c = 0; c < 3; ++c)
        image.pixel(x, y)[c] =
            static_cast<std::uint8_t>(std::lround(255 * srgb_from_linear(std::clamp(linear[c], 0.0f, 1.0f))));
}

}   // namespace

WrongImages wrong_images(const scene::SceneState& state, Size size, const std::vector<CullingTile>& tiles,
                         const CullingFrame& frame)
{
    const scene::Scene& scene = state.scene();
    struct Pixel {
        glm::vec3 off, paper;
        bool wrong;
    };

    // Light every primary hit with the results of both methods.
    std::vector<std::vector<Pixel>> lit(tiles.size());
    std::vector<float> brightness;
    for (std::size_t t = 0; t < tiles.size(); ++t) {
        const CullingTile& tile = tiles[t];
        for (std::size_t p = 0; p < tile.primary; ++p) {
            Pixel pixel{};
            for (std::size_t l = 0; l < scene.lights.size(); ++l) {
                const std::size_t at = l * tile.points.size() + p;
                if (!tile.facing[at]) continue;
                const scene::LightSample light = scene::illuminate(
                    scene.lights[l], state.light(static_cast<scene::LightId>(l)), tile.points[p].origin);
                const glm::vec3 radiance = tile.diffuse[p] * light.irradiance *
                                           std::max(0.0f, glm::dot(light.to_light, tile.points[p].normal));
                if (!tile.off[at]) pixel.off += radiance;
                if (!tile.paper[at]) pixel.paper += radiance;
                pixel.wrong = pixel.wrong || tile.off[at] != tile.paper[at];
            }
            lit[t].push_back(pixel);
            brightness.push_back(luminance(pixel.off));
        }
    }

    // Expose for all but the brightest pixels.
    float white = 1;
    if (!brightness.empty()) {
        const auto rank =
            static_cast<std::ptrdiff_t>((1 - k_overexposed_fraction) * static_cast<double>(brightness.size() - 1));
        std::nth_element(brightness.begin(), brightness.begin() + rank, brightness.end());
        if (const float at_rank = brightness[static_cast<std::size_t>(rank)]; at_rank > 0) white = at_rank;
    }

    // Fill in the three images.
    WrongImages images{frame.frame, frame.paper.wrong, Image8(size.width, size.height, 3),
                       Image8(size.width, size.height, 3), Image8(size.width, size.height, 3)};
    for (std::size_t t = 0; t < tiles.size(); ++t)
        for (std::size_t p = 0; p < tiles[t].primary; ++p) {
            const int x = tiles[t].pixels[p].x, y = tiles[t].pixels[p].y;
            const Pixel& pixel = lit[t][p];
            const glm::vec3 ambient = k_ambient * tiles[t].diffuse[p];
            put(images.off, x, y, pixel.off / white + ambient);
            put(images.paper, x, y, pixel.paper / white + ambient);
            put(images.difference, x, y, k_faded * glm::vec3(luminance(pixel.off / white + ambient)));
            if (pixel.wrong) std::copy_n(k_wrong_color, 3, images.difference.pixel(x, y));
        }
    return images;
}

}   // namespace gnomon::bench
