// SPDX-License-Identifier: Apache-2.0
#include "reference/environment_sampler.h"

#include <algorithm>

namespace gnomon::reference {

namespace {

constexpr int k_columns = 1024, k_rows = 512;   // of the grid, at most

// Returns the solid angle of one of `columns` cells between two rows' edges.
double solid_angle(int row, int rows, int columns)
{
    const double above = std::cos(k_pi * row / rows), below = std::cos(k_pi * (row + 1) / rows);
    return 2 * k_pi / columns * (above - below);
}

// Finds the entry of a list of running sums that contains a fraction of the total, and the position within it.
std::pair<int, double> find_part(const double* sums, int count, double share)
{
    const double wanted = share * sums[count - 1];
    const auto at = std::min<std::ptrdiff_t>(std::upper_bound(sums, sums + count, wanted) - sums, count - 1);
    const double before = at > 0 ? sums[at - 1] : 0;
    const double own = sums[at] - before;
    return {static_cast<int>(at), own > 0 ? std::clamp((wanted - before) / own, 0.0, 1.0) : 0.5};
}

}   // namespace

EnvironmentSampler::EnvironmentSampler(const scene::Environment& environment)
{
    const ImageF& image = environment.image();
    width_ = std::min(image.width, k_columns), height_ = std::min(image.height, k_rows);
    const auto columns = static_cast<std::size_t>(width_), rows = static_cast<std::size_t>(height_);

    // Sum luminance times solid angle over each cell's texels.
    cells_.assign(columns * rows, 0);
    for (int y = 0; y < image.height; ++y) {
        const double weight = solid_angle(y, image.height, image.width);
        const auto row = static_cast<std::size_t>(static_cast<std::int64_t>(y) * height_ / image.height);
        for (int x = 0; x < image.width; ++x) {
            const float* p = image.pixel(x, y);
            const auto column = static_cast<std::size_t>(static_cast<std::int64_t>(x) * width_ / image.width);
            cells_[row * columns + column] += weight * static_cast<double>(luminance(glm::vec3(p[0], p[1], p[2])));
        }
    }

    // Accumulate the sums.
    for (std::size_t y = 0; y < rows; ++y) {
        for (std::size_t x = 1; x < columns; ++x) cells_[y * columns + x] += cells_[y * columns + x - 1];
        total_ += cells_[y * columns + columns - 1];
        rows_.push_back(total_);
    }
}

float EnvironmentSampler::cell_density(int x, int y) const
{
    const std::size_t at = static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x);
    const double own = cells_[at] - (x > 0 ? cells_[at - 1] : 0);
    return static_cast<float>(own / (total_ * solid_angle(y, height_, width_)));
}

glm::vec3 EnvironmentSampler::sample(float u, float v, float& density) const
{
    const auto [y, down] = find_part(rows_.data(), height_, static_cast<double>(v));
    const double* row = cells_.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(width_);
    const auto [x, across] = find_part(row, width_, static_cast<double>(u));
    density = cell_density(x, y);

    // Sample the cell uniformly by solid angle: uniformly in longitude and in height.
    const double above = std::cos(k_pi * y / height_), below = std::cos(k_pi * (y + 1) / height_);
    const double height = above + down * (below - above);
    return scene::Environment::direction_at((x + across) / width_, std::acos(std::clamp(height, -1.0, 1.0)) / k_pi);
}

float EnvironmentSampler::density(const glm::vec3& direction) const
{
    const double u = 0.5 + std::atan2(static_cast<double>(direction.x), -static_cast<double>(direction.z)) / (2 * k_pi);
    const double v = std::acos(std::clamp(static_cast<double>(direction.y), -1.0, 1.0)) / k_pi;
    if (!std::isfinite(u) || !std::isfinite(v)) return 0;
    return cell_density(std::clamp(static_cast<int>(u * width_), 0, width_ - 1),
                        std::clamp(static_cast<int>(v * height_), 0, height_ - 1));
}

}   // namespace gnomon::reference
