// SPDX-License-Identifier: Apache-2.0
#include "scene/environment.h"

#include <algorithm>

#include "base/check.h"
#include "scene/direction_grid.h"

namespace gnomon::scene {

namespace {
constexpr float k_brightest = 1e9f;             // radiance; sums of squares stay finite
constexpr int k_columns = 1024, k_rows = 512;   // largest size of the grid that is cut
constexpr int k_most_lights = 1024;

float sane(float value)
{
    return value > 0 ? std::min(value, k_brightest) : 0.0f;   // NaN compares false
}

// The nine real spherical harmonics up to order 2.
std::array<double, 9> basis(const glm::dvec3& d)
{
    return {0.282095,
            0.488603 * d.y,
            0.488603 * d.z,
            0.488603 * d.x,
            1.092548 * d.x * d.y,
            1.092548 * d.y * d.z,
            0.315392 * (3 * d.z * d.z - 1),
            1.092548 * d.x * d.z,
            0.546274 * (d.x * d.x - d.y * d.y)};
}
}   // namespace

struct Environment::Part {
    int x0, x1, y0, y1;   // cells, ends excluded
};

Environment::Environment(ImageF radiance) : image_(std::move(radiance))
{
    GNOMON_CHECK(!image_.empty() && image_.channels == 3);
    for (float& value : image_.data) value = sane(value);
    gather();
    project();
}

glm::vec3 Environment::direction_at(double u, double v)
{
    const double longitude = (u - 0.5) * 2 * k_pi, polar = v * k_pi;
    const double across = std::sin(polar);
    return glm::vec3(glm::dvec3(across * std::sin(longitude), std::cos(polar), -across * std::cos(longitude)));
}

DirectionGrid::DirectionGrid(int columns, int rows)
{
    for (int x = 0; x < columns; ++x) {
        const double longitude = ((x + 0.5) / columns - 0.5) * 2 * k_pi;
        columns_.push_back({longitude, std::sin(longitude), std::cos(longitude)});
    }
    for (int y = 0; y < rows; ++y) {
        const double polar = (y + 0.5) / rows * k_pi;
        rows_.emplace_back(std::sin(polar), std::cos(polar));
    }
}

glm::vec3 Environment::radiance(const glm::vec3& direction) const
{
    constexpr auto pi = static_cast<float>(k_pi);
    const float longitude = std::atan2(direction.x, -direction.z);
    const float v = std::acos(std::clamp(direction.y, -1.0f, 1.0f)) / pi;
    if (!std::isfinite(longitude) || !std::isfinite(v)) return glm::vec3(0);
    return radiance_at(image_, longitude, v);
}

glm::vec3 radiance_at(const ImageF& image, float longitude, float v)
{
    constexpr auto pi = static_cast<float>(k_pi);
    const float u = 0.5f + longitude / (2 * pi);
    const float x = u * static_cast<float>(image.width) - 0.5f, y = v * static_cast<float>(image.height) - 0.5f;
    const float left = std::floor(x), top = std::floor(y);
    // Columns are at most one beyond a side, where the image meets its other side.
    const int c = static_cast<int>(left), r = static_cast<int>(top), width = image.width;
    const int columns[2] = {c < 0 ? c + width : c, c + 1 < width ? c + 1 : c + 1 - width};
    const auto texel = [&](int column, int row) {
        const float* p = image.pixel(columns[column], std::clamp(row, 0, image.height - 1));
        return glm::vec3(p[0], p[1], p[2]);
    };
    return glm::mix(glm::mix(texel(0, r), texel(1, r), x - left), glm::mix(texel(0, r + 1), texel(1, r + 1), x - left),
                    y - top);
}

// Sums texels into cells. A texel's solid angle is exact: its range of longitude times the difference of the sines
// of its latitudes.
void Environment::gather()
{
    columns_ = std::min(image_.width, k_columns), rows_ = std::min(image_.height, k_rows);
    cells_.resize(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_));
    const double width = image_.width, height = image_.height;
    const DirectionGrid directions(image_.width, image_.height);
    for (int y = 0; y < image_.height; ++y) {
        const double above = std::cos(y / height * k_pi), below = std::cos((y + 1) / height * k_pi);
        const double solid_angle = 2 * k_pi / width * (above - below);
        const auto row = static_cast<std::size_t>(static_cast<std::int64_t>(y) * rows_ / image_.height);
        for (int x = 0; x < image_.width; ++x) {
            const float* p = image_.pixel(x, y);
            const auto column = static_cast<std::size_t>(static_cast<std::int64_t>(x) * columns_ / image_.width);
            Cell& cell = cells_[row * static_cast<std::size_t>(columns_) + column];
            const glm::dvec3 flux = solid_angle * glm::dvec3(p[0], p[1], p[2]);
            const double light = luminance(flux);
            cell.flux += flux;
            cell.light += light;
            cell.weighted += light * glm::dvec3(directions.at(x, y));
        }
    }
    const Cell all = sum_of({0, columns_, 0, rows_});
    flux_ = glm::vec3(all.flux);
}

// Projects radiance on the harmonics and folds it with the cosine lobe [Ramamoorthi and Hanrahan 2001, eq. 8].
void Environment::project()
{
    constexpr double fold[9] = {1, 2.0 / 3, 2.0 / 3, 2.0 / 3, 0.25, 0.25, 0.25, 0.25, 0.25};   // A_l / pi
    std::array<glm::dvec3, 9> sums{};
    const DirectionGrid directions(columns_, rows_);
    for (int y = 0; y < rows_; ++y)
        for (int x = 0; x < columns_; ++x) {
            const Cell& cell =
                cells_[static_cast<std::size_t>(y) * static_cast<std::size_t>(columns_) + static_cast<std::size_t>(x)];
            const auto b = basis(glm::dvec3(directions.at(x, y)));
            for (std::size_t i = 0; i < b.size(); ++i) sums[i] += b[i] * cell.flux;
        }
    for (std::size_t i = 0; i < sums.size(); ++i) harmonics_[i] = glm::vec3(fold[i] * sums[i]);
}

glm::vec3 Environment::ambient(const glm::vec3& normal) const
{
    const auto b = basis(glm::dvec3(normal));
    glm::vec3 sum(0);
    for (std::size_t i = 0; i < b.size(); ++i) sum += static_cast<float>(b[i]) * harmonics_[i];
    return glm::max(sum, glm::vec3(0));
}

glm::vec3 Environment::irradiance(const glm::vec3& normal) const
{
    glm::dvec3 sum(0);
    for (const Cell& cell : cells_)
        if (cell.light > 0) sum += std::max(glm::dot(cell.weighted / cell.light, glm::dvec3(normal)), 0.0) * cell.flux;
    return glm::vec3(sum);
}

Environment::Cell Environment::sum_of(const Part& part) const
{
    Cell sum;
    for (int y = part.y0; y < part.y1; ++y)
        for (int x = part.x0; x < part.x1; ++x) {
            const Cell& cell =
                cells_[static_cast<std::size_t>(y) * static_cast<std::size_t>(columns_) + static_cast<std::size_t>(x)];
            sum.flux += cell.flux, sum.weighted += cell.weighted, sum.light += cell.light;
        }
    return sum;
}

std::vector<EnvironmentLight> Environment::lights(int count) const
{
    GNOMON_CHECK(count >= 1 && count <= k_most_lights && (count & (count - 1)) == 0);
    std::vector<EnvironmentLight> result;
    cut({0, columns_, 0, rows_}, count, result);
    return result;
}

void Environment::cut(const Part& part, int count, std::vector<EnvironmentLight>& lights) const
{
    const Cell sum = sum_of(part);
    if (!(sum.light > 0)) return;
    const int across = part.x1 - part.x0, down = part.y1 - part.y0;
    if (count == 1 || (across == 1 && down == 1)) {
        // DEVIATION(Debevec 2005, 3): the light is as strong as the part's vector irradiance, not as its flux. A wide
        // part then lights a surface that sees all of it exactly as the image does, and energy is conserved.
        const double length = glm::length(sum.weighted);
        if (!(length > 0)) return;
        lights.push_back(
            {glm::vec3(sum.weighted / length), glm::vec3(sum.flux * (length / sum.light)), glm::vec3(sum.flux)});
        return;
    }
    // Cut across the longer side, as measured on the sphere [Debevec 2005, 2: scaled by the cosine of the latitude].
    const double polar = 0.5 * (part.y0 + part.y1) / rows_ * k_pi;
    const double width = 2 * k_pi * across / columns_ * std::sin(polar), height = k_pi * down / rows_;
    const bool by_column = down == 1 || (across > 1 && width >= height);

    // Cut where the sum is nearest to a half, leaving cells on both sides.
    const auto [begin, end] = by_column ? std::pair(part.x0, part.x1) : std::pair(part.y0, part.y1);
    const auto line = [&](int at) {
        return by_column ? Part{at, at + 1, part.y0, part.y1} : Part{part.x0, part.x1, at, at + 1};
    };
    int place = begin + 1;
    double before = sum_of(line(begin)).light;
    while (place < end - 1) {
        const double next = before + sum_of(line(place)).light;
        if (std::abs(next - 0.5 * sum.light) >= std::abs(before - 0.5 * sum.light) && next > 0.5 * sum.light) break;
        before = next;
        ++place;
    }
    Part first = part, second = part;
    (by_column ? first.x1 : first.y1) = place;
    (by_column ? second.x0 : second.y0) = place;
    cut(first, count / 2, lights);
    cut(second, count / 2, lights);
}

}   // namespace gnomon::scene
