// SPDX-License-Identifier: Apache-2.0
#include "patches/surroundings.h"

#include <algorithm>
#include <cmath>

#include "scene/environment.h"

namespace gnomon::patches {

namespace {

constexpr int k_columns = 32, k_rows = 16;   // of an image's cells: 11 degrees

}   // namespace

Surroundings::Surroundings(const scene::Background& background) : background_(background)
{
    background_.sun_radiance = glm::vec3(0);
    any_ = background.kind == scene::Background::Kind::sky;
    if (background.kind != scene::Background::Kind::image) return;

    // Average the image over the cells, by solid angle.
    const ImageF& image = background.environment->image();
    std::vector<glm::dvec3> sum(static_cast<std::size_t>(k_columns) * k_rows, glm::dvec3(0));
    std::vector<double> weight(sum.size(), 0);
    const int rows = std::max(image.height, k_rows), columns = std::max(image.width, k_columns);
    for (int y = 0; y < rows; ++y) {
        const double v = (y + 0.5) / rows, solid = std::sin(k_pi * v);
        for (int x = 0; x < columns; ++x) {
            const double u = (x + 0.5) / columns;
            const auto cell =
                static_cast<std::size_t>(static_cast<int>(v * k_rows) * k_columns + static_cast<int>(u * k_columns));
            // At texel centres, an image's own values.
            const glm::vec3 radiance = background.environment->radiance(scene::Environment::direction_at(u, v));
            sum[cell] += solid * glm::dvec3(radiance), weight[cell] += solid;
        }
    }
    for (std::size_t c = 0; c < sum.size(); ++c) {
        cells_.push_back(weight[c] > 0 ? glm::vec3(sum[c] / weight[c]) : glm::vec3(0));
        any_ = any_ || cells_.back() != glm::vec3(0);
    }
}

glm::vec3 Surroundings::radiance(const glm::vec3& direction) const
{
    if (cells_.empty()) return any_ ? background_.radiance(direction) : glm::vec3(0);
    // The inverse of Environment::direction_at.
    const double u = 0.5 + std::atan2(static_cast<double>(direction.x), -static_cast<double>(direction.z)) / (2 * k_pi);
    const double v = std::acos(std::clamp(static_cast<double>(direction.y), -1.0, 1.0)) / k_pi;
    const int column = std::clamp(static_cast<int>(u * k_columns), 0, k_columns - 1);
    const int row = std::clamp(static_cast<int>(v * k_rows), 0, k_rows - 1);
    return cells_[static_cast<std::size_t>(row * k_columns + column)];
}

}   // namespace gnomon::patches
