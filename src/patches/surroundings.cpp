// SPDX-License-Identifier: Apache-2.0
#include "patches/surroundings.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "scene/direction_grid.h"
#include "scene/environment.h"

namespace gnomon::patches {

namespace {

constexpr int k_columns = 32, k_rows = 16;   // of an image's cells: 11 degrees
constexpr int k_halves = 2;                  // directions along a side of a cell, of which irradiance is the sum
constexpr int k_normals = 32;                // a side, of the table over normals

// The arc cosine, within k_error [Abramowitz and Stegun 1964, 4.4.45].
float rough_acos(float x)
{
    const float a = std::abs(x);
    const float angle = std::sqrt(1 - a) * (1.5707288f + a * (-0.2121144f + a * (0.0742610f - 0.0187293f * a)));
    return x < 0 ? static_cast<float>(k_pi) - angle : angle;
}

// The arc tangent of y / x in the quadrant of (x, y), within k_error [ibid., 4.4.49].
float rough_atan2(float y, float x)
{
    const float up = std::abs(y), right = std::abs(x), t = std::min(up, right) / std::max(up, right), z = t * t;
    float angle = t * (0.9998660f + z * (-0.3302995f + z * (0.1801410f + z * (-0.0851330f + z * 0.0208351f))));
    if (right < up) angle = static_cast<float>(k_pi / 2) - angle;
    if (x < 0) angle = static_cast<float>(k_pi) - angle;
    return y < 0 ? -angle : angle;
}

constexpr float k_error = 1e-4f;   // radians

// The cell that a coordinate lies in; none (-1) if it is too near to an end of it, for how well the coordinate is
// known.
// @param size  of a cell, radians
int cell_for_certain(float angle, float size)
{
    const float at = angle / size, slack = k_error / size;
    if (!(at >= 0 && at < static_cast<float>(k_columns))) return -1;   // above and below, no longitude is known
    const int cell = static_cast<int>(at);
    const float in = at - static_cast<float>(cell);
    return in > slack && in < 1 - slack ? cell : -1;
}

// The cell of an image that a direction lies in.
std::size_t cell_of(const glm::vec3& direction)
{
    // Few directions are so near to an end of a cell that their angles must be known well.
    const float polar = rough_acos(std::clamp(direction.y, -1.0f, 1.0f)),
                turned = static_cast<float>(k_pi) + rough_atan2(direction.x, -direction.z);
    const int row_at = cell_for_certain(polar, static_cast<float>(k_pi / k_rows));
    const int column_at = cell_for_certain(turned, static_cast<float>(2 * k_pi / k_columns));
    if (row_at >= 0 && column_at >= 0) return static_cast<std::size_t>(row_at * k_columns + column_at);

    // The inverse of Environment::direction_at.
    const double u = 0.5 + std::atan2(static_cast<double>(direction.x), -static_cast<double>(direction.z)) / (2 * k_pi);
    const double v = std::acos(std::clamp(static_cast<double>(direction.y), -1.0, 1.0)) / k_pi;
    const int column = std::clamp(static_cast<int>(u * k_columns), 0, k_columns - 1);
    const int row = std::clamp(static_cast<int>(v * k_rows), 0, k_rows - 1);
    return static_cast<std::size_t>(row * k_columns + column);
}

// The solid angle of a cell in a row of some that divide the sphere.
double solid_angle(int row, int rows, int columns)
{
    return 2 * k_pi / columns * (std::cos(k_pi * row / rows) - std::cos(k_pi * (row + 1) / rows));
}

}   // namespace

Surroundings::Surroundings(const scene::Background& background) : background_(background)
{
    background_.sun_radiance = glm::vec3(0);
    any_ = is_sky();
    if (background.kind != scene::Background::Kind::image) {
        find_irradiance();
        return;
    }

    // Average the image over the cells, by solid angle.
    const ImageF& image = background.environment->image();
    std::vector<glm::dvec3> sum(static_cast<std::size_t>(k_columns) * k_rows, glm::dvec3(0)), direction = sum;
    std::vector<double> weight(sum.size(), 0);
    const int rows = std::max(image.height, k_rows), columns = std::max(image.width, k_columns);
    const scene::DirectionGrid directions(columns, rows);
    for (int y = 0; y < rows; ++y) {
        const double v = (y + 0.5) / rows, solid = std::sin(k_pi * v);
        const float down = std::acos(std::clamp(directions.at(0, y).y, -1.0f, 1.0f)) / static_cast<float>(k_pi);
        for (int x = 0; x < columns; ++x) {
            const double u = (x + 0.5) / columns;
            const auto cell =
                static_cast<std::size_t>(static_cast<int>(v * k_rows) * k_columns + static_cast<int>(u * k_columns));
            // At texel centres, an image's own values.
            const float longitude = directions.longitude(x, y, directions.at(x, y));
            const glm::vec3 radiance = scene::radiance_at(image, longitude, down);
            sum[cell] += solid * glm::dvec3(radiance), weight[cell] += solid;
            direction[cell] += solid * static_cast<double>(luminance(radiance)) * glm::dvec3(directions.at(x, y));
        }
    }
    std::vector<glm::vec3> mean_direction;
    for (std::size_t c = 0; c < sum.size(); ++c) {
        cells_.push_back(weight[c] > 0 ? glm::vec3(sum[c] / weight[c]) : glm::vec3(0));
        mean_direction.emplace_back(direction[c]);
        any_ = any_ || cells_.back() != glm::vec3(0);
    }
    find_spots(mean_direction);
    find_irradiance();
}

// @param direction  by cell: the mean one of its light, of any length
void Surroundings::find_spots(std::span<const glm::vec3> direction)
{
    constexpr double k_brighter = 4;    // than the mean over the sphere
    constexpr double k_least = 0.005;   // of all light
    const auto light = [&](std::size_t c) {
        return static_cast<double>(luminance(cells_[c])) *
               solid_angle(static_cast<int>(c) / k_columns, k_rows, k_columns);
    };
    double all = 0;
    for (std::size_t c = 0; c < cells_.size(); ++c) all += light(c);
    std::vector<std::size_t> bright;
    for (std::size_t c = 0; c < cells_.size(); ++c)
        if (static_cast<double>(luminance(cells_[c])) > k_brighter * all / (4 * k_pi) && light(c) > k_least * all)
            bright.push_back(c);
    std::ranges::stable_sort(bright, std::greater<>(), light);
    if (bright.size() > k_most_spots) bright.resize(k_most_spots);
    beside_spots_ = cells_;
    for (const std::size_t c : bright) {
        const double solid = solid_angle(static_cast<int>(c) / k_columns, k_rows, k_columns);
        spots_.push_back({glm::normalize(direction[c]), static_cast<float>(solid) * cells_[c]});
        beside_spots_[c] = glm::vec3(0);
    }
}

void Surroundings::find_irradiance()
{
    irradiance_ = DirectionTable(k_normals);
    if (!any_) return;
    constexpr int k_rows_of = k_halves * k_rows, k_columns_of = k_halves * k_columns;
    std::vector<glm::vec3> direction, radiance;
    std::vector<float> solid;
    for (int y = 0; y < k_rows_of; ++y)
        for (int x = 0; x < k_columns_of; ++x) {
            direction.push_back(scene::Environment::direction_at((x + 0.5) / k_columns_of, (y + 0.5) / k_rows_of));
            radiance.push_back(radiance_beside_spots(direction.back()));
            solid.push_back(static_cast<float>(solid_angle(y, k_rows_of, k_columns_of)));
        }
    for (std::size_t entry = 0; entry < irradiance_.size(); ++entry) {
        const glm::vec3 normal = irradiance_.direction(entry);
        glm::vec3 sum(0);
        float weights = 0;   // pi, up to how far the directions are apart
        for (std::size_t i = 0; i < direction.size(); ++i) {
            const float weight = std::max(glm::dot(direction[i], normal), 0.0f) * solid[i];
            sum += weight * radiance[i], weights += weight;
        }
        irradiance_[entry] = static_cast<float>(k_pi) / weights * sum;
    }
}

glm::vec3 Surroundings::radiance(const glm::vec3& direction) const
{
    if (cells_.empty()) return any_ ? background_.radiance(direction) : glm::vec3(0);
    return cells_[cell_of(direction)];
}

glm::vec3 Surroundings::radiance_beside_spots(const glm::vec3& direction) const
{
    return cells_.empty() ? radiance(direction) : beside_spots_[cell_of(direction)];
}

}   // namespace gnomon::patches
