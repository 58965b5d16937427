// SPDX-License-Identifier: Apache-2.0
#include "io/gltf/specular_glossiness.h"

#include <algorithm>
#include <cmath>

#include "base/interruption.h"

namespace gnomon::io::gltf {

namespace {

constexpr float k_dielectric = 0.04f;   // reflectance of a dielectric at normal incidence
constexpr float k_epsilon = 1e-6f;

float brightness(const glm::vec3& c)
{
    return std::sqrt(0.299f * c.x * c.x + 0.587f * c.y * c.y + 0.114f * c.z * c.z);
}

float greatest(const glm::vec3& c)
{
    return std::max({c.x, c.y, c.z});
}

// Solves for metallic: the base colour b has diffuse = b (1 - metallic) and specular = 0.04 + (b - 0.04) metallic.
float solve_metallic(float diffuse, float specular, float one_minus_specular)
{
    if (specular < k_dielectric) return 0;
    const float a = k_dielectric;
    const float b = diffuse * one_minus_specular / (1 - k_dielectric) + specular - 2 * k_dielectric;
    const float c = k_dielectric - specular;
    const float root = std::sqrt(std::max(b * b - 4 * a * c, 0.0f));
    return std::clamp((-b + root) / (2 * a), 0.0f, 1.0f);
}

std::uint8_t code(float value)
{
    return static_cast<std::uint8_t>(std::lround(255 * std::clamp(value, 0.0f, 1.0f)));
}

// The nearest texel of an image for a texel of a larger one.
struct Texel {
    glm::vec3 color{1};   // linear
    float alpha = 1;
};
Texel texel(const Image8& image, int x, int y, int width, int height)
{
    Texel result;
    if (image.empty()) return result;
    const auto scaled = [](int i, int size, int whole) { return static_cast<int>(std::int64_t{i} * size / whole); };
    const std::uint8_t* p = image.pixel(scaled(x, image.width, width), scaled(y, image.height, height));
    const float* linear = linear_from_srgb8();
    const bool grey = image.channels < 3;
    for (int c = 0; c < 3; ++c) result.color[c] = linear[p[grey ? 0 : c]];
    if (image.channels % 2 == 0) result.alpha = static_cast<float>(p[image.channels - 1]) / 255;
    return result;
}

}   // namespace

MetallicRoughness metallic_from_specular(const glm::vec3& diffuse, const glm::vec3& specular)
{
    MetallicRoughness result;
    const float one_minus_specular = 1 - greatest(specular);
    result.metallic = solve_metallic(brightness(diffuse), brightness(specular), one_minus_specular);
    const float m = result.metallic;
    const glm::vec3 of_diffuse = diffuse * (one_minus_specular / ((1 - k_dielectric) * std::max(1 - m, k_epsilon)));
    const glm::vec3 of_specular = (specular - glm::vec3(k_dielectric * (1 - m))) / std::max(m, k_epsilon);
    result.base_color = glm::clamp(glm::mix(of_diffuse, of_specular, m * m), glm::vec3(0), glm::vec3(1));
    return result;
}

ConvertedImages metallic_from_specular(const Image8& diffuse, const Image8& specular_glossiness,
                                       const glm::vec3& diffuse_factor, const glm::vec3& specular_factor,
                                       float glossiness_factor)
{
    const int width = std::max(diffuse.width, specular_glossiness.width);
    const int height = std::max(diffuse.height, specular_glossiness.height);
    const bool has_alpha = !diffuse.empty() && diffuse.channels % 2 == 0;
    ConvertedImages result{Image8(width, height, has_alpha ? 4 : 3), Image8(width, height, 3)};
    for (int y = 0; y < height; ++y) {
        interruption_point();
        for (int x = 0; x < width; ++x) {
            const Texel d = texel(diffuse, x, y, width, height);
            const Texel s = texel(specular_glossiness, x, y, width, height);
            const MetallicRoughness m = metallic_from_specular(d.color * diffuse_factor, s.color * specular_factor);
            std::uint8_t* const base = result.base_color.pixel(x, y);
            for (int c = 0; c < 3; ++c) base[c] = code(srgb_from_linear(m.base_color[c]));
            if (has_alpha) base[3] = code(d.alpha);
            std::uint8_t* const rough = result.metallic_roughness.pixel(x, y);
            rough[0] = 0, rough[1] = code(1 - s.alpha * glossiness_factor), rough[2] = code(m.metallic);
        }
    }
    return result;
}

}   // namespace gnomon::io::gltf
