// SPDX-License-Identifier: Apache-2.0
#include "trace/bounced_places.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace gnomon::trace {

namespace {

constexpr int k_least_level = -40, k_most_level = 60;
constexpr float k_least_square = 1e-4f;   // of a distance, in reaches

// The level whose cells are wider than two reaches and at most four of them.
int level_of(float reach)
{
    int level = 0;
    std::frexp(reach, &level);
    ++level;
    return std::clamp(level, k_least_level, k_most_level);
}

std::uint64_t key_of(std::uint32_t object, int level, const glm::ivec3& cell)
{
    std::uint64_t h = object * 0x9e3779b97f4a7c15ull + static_cast<std::uint64_t>(level - k_least_level + 1);
    for (int axis = 0; axis < 3; ++axis) {
        h ^= static_cast<std::uint32_t>(cell[axis]);
        h *= 0xbf58476d1ce4e5b9ull;
        h ^= h >> 29;
    }
    return h == 0 ? 1 : h;
}

glm::ivec3 cell_at(const glm::vec3& position, int level)
{
    const glm::vec3 scaled = glm::clamp(glm::floor(position * std::ldexp(1.0f, -level)), -1e9f, 1e9f);
    return glm::ivec3(scaled);
}

}   // namespace

void BouncedPlaces::begin(std::span<const std::uint32_t> moving)
{
    places_.clear(), cells_.clear(), used_ = 0;
    moving_.clear();
    for (const std::uint32_t object : moving) {
        if (object >= moving_.size()) moving_.resize(object + std::size_t{1}, 0);
        moving_[object] = 1;
    }
}

const BouncedPlaces::Cell* BouncedPlaces::cell(std::uint64_t key) const
{
    for (std::size_t i = key & (cells_.size() - 1);; i = (i + 1) & (cells_.size() - 1)) {
        if (cells_[i].key == key) return &cells_[i];
        if (cells_[i].key == 0) return nullptr;
    }
}

BouncedPlaces::Cell& BouncedPlaces::cell_for(std::uint64_t key)
{
    if (2 * (used_ + 1) > cells_.size()) grow();
    std::size_t i = key & (cells_.size() - 1);
    while (cells_[i].key != 0 && cells_[i].key != key) i = (i + 1) & (cells_.size() - 1);
    if (cells_[i].key == 0) cells_[i].key = key, ++used_;
    return cells_[i];
}

void BouncedPlaces::grow()
{
    std::vector<Cell> before(std::max<std::size_t>(1024, 2 * cells_.size()));
    std::swap(before, cells_);
    for (const Cell& cell : before) {
        if (cell.key == 0) continue;
        std::size_t i = cell.key & (cells_.size() - 1);
        while (cells_[i].key != 0) i = (i + 1) & (cells_.size() - 1);
        cells_[i] = cell;
    }
}

void BouncedPlaces::add(std::span<const BouncedPlace> places)
{
    for (const BouncedPlace& place : places) {
        const float reach = options_.reach * place.width;
        if (!(reach > 0 && reach < k_infinity)) continue;
        const int level = level_of(reach);
        Cell& cell = cell_for(key_of(place.object, level, cell_at(place.position, level)));
        if (cell.count == k_most) continue;
        const float thinned = options_.thinned * reach;
        bool needless = false;
        for (std::uint32_t i = 0; i < cell.count; ++i) {
            const BouncedPlace& other = places_[cell.places[i]];
            const glm::vec3 apart = other.position - place.position;
            needless = needless || (glm::dot(apart, apart) < thinned * thinned &&
                                    glm::dot(other.normal, place.normal) > options_.same_normal);
        }
        if (needless) continue;
        cell.places[cell.count++] = static_cast<std::uint32_t>(places_.size());
        places_.push_back(place);
    }
}

std::optional<BouncedPlaces::Found> BouncedPlaces::find(const BouncedPlace& at) const
{
    const float reach = options_.reach * at.width;
    if (!(reach > 0 && reach < k_infinity) || cells_.empty()) return {};

    // Look at the cells within reach, of widths like the place's own.
    constexpr int k_nearest = 4;   // places that must agree, and whose mean is taken
    std::array<std::pair<float, std::uint32_t>, k_nearest> nearest;
    nearest.fill({k_infinity, 0});
    int found = 0;
    const int own = level_of(reach);
    for (int level = own - 1; level <= own + 1; ++level) {
        const float radius = std::min(reach, std::ldexp(0.5f, level));
        const glm::ivec3 low = cell_at(at.position - radius, level), high = cell_at(at.position + radius, level);
        for (int z = low.z; z <= high.z; ++z)
            for (int y = low.y; y <= high.y; ++y)
                for (int x = low.x; x <= high.x; ++x) {
                    const Cell* const cell = this->cell(key_of(at.object, level, {x, y, z}));
                    if (!cell) continue;
                    for (std::uint32_t i = 0; i < cell->count; ++i) {
                        const BouncedPlace& other = places_[cell->places[i]];
                        if (other.object != at.object) continue;
                        const glm::vec3 apart = other.position - at.position;
                        const float square = glm::dot(apart, apart);
                        if (!(square < radius * radius) || !(square < nearest.back().first)) continue;
                        if (!(glm::dot(other.normal, at.normal) > options_.same_normal)) continue;
                        if (std::abs(glm::dot(apart, at.plane)) > options_.off_plane * reach) continue;
                        nearest.back() = {square, cell->places[i]};
                        for (std::size_t k = k_nearest - 1; k > 0 && nearest[k].first < nearest[k - 1].first; --k)
                            std::swap(nearest[k], nearest[k - 1]);
                        found = std::min(found + 1, k_nearest);
                    }
                }
    }
    const float alone = options_.lone * reach;
    if (found == 0 || (found == 1 && nearest[0].first > alone * alone)) return {};
    Found result{glm::vec3(0), glm::vec3(k_infinity), glm::vec3(0)};
    float sum = 0;
    for (std::size_t k = 0; k < static_cast<std::size_t>(found); ++k) {
        const glm::vec3& irradiance = places_[nearest[k].second].irradiance;
        const float weight = 1 / (nearest[k].first + k_least_square * reach * reach);
        result.mean += weight * irradiance, sum += weight;
        result.low = glm::min(result.low, irradiance), result.high = glm::max(result.high, irradiance);
    }
    result.mean /= sum;
    return result;
}

std::size_t BouncedPlaces::bytes() const
{
    return places_.capacity() * sizeof(BouncedPlace) + cells_.capacity() * sizeof(Cell);
}

}   // namespace gnomon::trace
