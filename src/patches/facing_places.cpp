// SPDX-License-Identifier: Apache-2.0
#include "patches/facing_places.h"

#include <hwy/highway.h>

#include <algorithm>
#include <limits>

namespace gnomon::patches {

namespace hn = hwy::HWY_NAMESPACE;   // of the least instruction set

namespace {

using Four = hn::FixedTag<float, 4>;
constexpr std::uint32_t k_lanes = 4;
constexpr float k_none = std::numeric_limits<float>::infinity();

}   // namespace

// The squares of distances to a point; infinite for places that face another way.
struct FacingPlaces::Squares {
    const float *x, *y, *z, *nx, *ny, *nz;
    const glm::vec3 p, n;

    Squares(const FacingPlaces& of, const glm::vec3& point, const glm::vec3& normal)
        : x(of.at_[0].data()),
          y(of.at_[1].data()),
          z(of.at_[2].data()),
          nx(of.at_[3].data()),
          ny(of.at_[4].data()),
          nz(of.at_[5].data()),
          p(point),
          n(normal)
    {
    }
    float at(std::uint32_t i) const
    {
        const float dx = x[i] - p.x, dy = y[i] - p.y, dz = z[i] - p.z;
        const float square = dx * dx + dy * dy + dz * dz, cosine = nx[i] * n.x + ny[i] * n.y + nz[i] * n.z;
        return cosine > k_same_facing ? square : k_none;
    }
    // The same for four places.
    hn::Vec<Four> from(std::uint32_t i) const
    {
        const Four d;
        const auto sum = [](auto a, auto b, auto c) { return hn::Add(hn::Add(a, b), c); };
        const auto away = [&](const float* list, float to) {
            const auto way = hn::Sub(hn::LoadU(d, list + i), hn::Set(d, to));
            return hn::Mul(way, way);
        };
        const auto along = [&](const float* list, float by) { return hn::Mul(hn::LoadU(d, list + i), hn::Set(d, by)); };
        const auto cosine = sum(along(nx, n.x), along(ny, n.y), along(nz, n.z));
        return hn::IfThenElse(hn::Gt(cosine, hn::Set(d, k_same_facing)), sum(away(x, p.x), away(y, p.y), away(z, p.z)),
                              hn::Set(d, k_none));
    }
};

void FacingPlaces::clear()
{
    for (std::vector<float>& list : at_) list.clear();
}

void FacingPlaces::push(const glm::vec3& place, const glm::vec3& normal)
{
    for (int axis = 0; axis < 3; ++axis) {
        at_[static_cast<std::size_t>(axis)].push_back(place[axis]);
        at_[static_cast<std::size_t>(3 + axis)].push_back(normal[axis]);
    }
}

float FacingPlaces::least(std::uint32_t first, std::uint32_t last, const glm::vec3& p, const glm::vec3& normal) const
{
    const Squares squares(*this, p, normal);
    const Four d;
    auto least = hn::Set(d, k_none);
    for (; first + k_lanes <= last; first += k_lanes) least = hn::Min(squares.from(first), least);
    std::array<float, k_lanes> lanes;
    hn::StoreU(least, d, lanes.data());
    for (; first < last; ++first)
        if (const float square = squares.at(first); square < lanes[0]) lanes[0] = square;
    return *std::min_element(lanes.begin(), lanes.end());
}

std::uint32_t FacingPlaces::next(std::uint32_t first, std::uint32_t last, const glm::vec3& p, const glm::vec3& normal,
                                 float square) const
{
    if (square == k_none) return last;
    const Squares squares(*this, p, normal);
    const auto wanted = hn::Set(Four(), square);
    while (first + k_lanes <= last && hn::AllFalse(Four(), hn::Eq(squares.from(first), wanted))) first += k_lanes;
    while (first < last && squares.at(first) != square) ++first;
    return first;
}

}   // namespace gnomon::patches
