// SPDX-License-Identifier: Apache-2.0
// This file is compiled once per instruction set: Highway includes it repeatedly.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "light_quadtree/gather.cpp"
#include <hwy/foreach_target.h>   // must be the first include of Highway

#include <hwy/highway.h>

#include "light_quadtree/gather.h"
#include "light_quadtree/kernel-inl.h"

HWY_BEFORE_NAMESPACE();
namespace gnomon::light_quadtree::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// Processes two vectors of receivers at once, so that a cluster is loaded once for both.
void gather_of(const Clusters& clusters, Receivers& receivers, std::size_t begin, std::size_t end)
{
    const Real real;
    const std::size_t lanes = hn::Lanes(real), lights = clusters.size();
    for (std::size_t k = begin; k < end; k += 2 * lanes) {
        const Receiver one = load_receiver(receivers, k), two = load_receiver(receivers, k + lanes);
        Sum sum_one = nothing(), sum_two = nothing();
        for (std::size_t c = 0; c < lights; ++c) {
            const Light light{hn::Set(real, clusters.x[c]),    hn::Set(real, clusters.y[c]),
                              hn::Set(real, clusters.z[c]),    hn::Set(real, clusters.nx[c]),
                              hn::Set(real, clusters.ny[c]),   hn::Set(real, clusters.nz[c]),
                              hn::Set(real, clusters.disk[c]), hn::Set(real, clusters.r[c]),
                              hn::Set(real, clusters.g[c]),    hn::Set(real, clusters.b[c])};
            add(light, one, sum_one);
            add(light, two, sum_two);
        }
        store(sum_one, receivers, k);
        store(sum_two, receivers, k + lanes);
    }
}

}   // namespace gnomon::light_quadtree::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include <algorithm>
#include <cmath>

#include "base/check.h"

namespace gnomon::light_quadtree {

HWY_EXPORT(gather_of);

void Receivers::resize(std::size_t count)
{
    count_ = count;
    const std::size_t padded = (count + k_receiver_step - 1) / k_receiver_step * k_receiver_step;
    for (auto* lane : {&x, &y, &z, &nx, &ny, &nz, &r, &g, &b}) lane->resize(padded);
    for (std::size_t i = count; i < padded; ++i) set(i, glm::vec3(0), glm::vec3(0));
}

double nrmse(const Receivers& test, const Receivers& truth)
{
    double error = 0, mean = 0;
    for (std::size_t i = 0; i < truth.size(); ++i) {
        const glm::dvec3 t(truth.irradiance(i)), d = glm::dvec3(test.irradiance(i)) - t;
        error += glm::dot(d, d);
        mean += t.x + t.y + t.z;
    }
    const auto count = static_cast<double>(3 * truth.size());
    return std::sqrt(error / count) / (mean / count);
}

void Receivers::set(std::size_t i, const glm::vec3& position, const glm::vec3& normal)
{
    x[i] = position.x, y[i] = position.y, z[i] = position.z;
    nx[i] = normal.x, ny[i] = normal.y, nz[i] = normal.z;
}

void gather(const Clusters& clusters, Receivers& receivers, std::size_t begin, std::size_t end)
{
    GNOMON_CHECK(begin % k_receiver_step == 0 && end % k_receiver_step == 0 && end <= receivers.x.size());
    HWY_DYNAMIC_DISPATCH(gather_of)(clusters, receivers, begin, end);
}

void add_light(const Clusters& clusters, std::size_t c, const glm::vec3& position, const glm::vec3& normal,
               glm::vec3& irradiance)
{
    const float x = clusters.x[c] - position.x, y = clusters.y[c] - position.y, z = clusters.z[c] - position.z;
    const float square = (x * x + y * y) + z * z;
    const float there = -((x * clusters.nx[c] + y * clusters.ny[c]) + z * clusters.nz[c]);
    const float here = (x * normal.x + y * normal.y) + z * normal.z;
    const float weight =
        std::max(there, 0.0f) * std::max(here, 0.0f) / (square * (square + clusters.disk[c]) + k_least_square);
    irradiance.x += weight * clusters.r[c];
    irradiance.y += weight * clusters.g[c];
    irradiance.z += weight * clusters.b[c];
}

glm::vec3 gather_one(const Clusters& clusters, const glm::vec3& position, const glm::vec3& normal)
{
    glm::vec3 irradiance(0);
    for (std::size_t c = 0; c < clusters.size(); ++c) add_light(clusters, c, position, normal, irradiance);
    return irradiance;
}

glm::vec3 gather_as_printed(const LightMap& map, const CutLevels& levels, const glm::vec3& position,
                            const glm::vec3& normal, std::uint64_t* nodes_looked_at)
{
    GNOMON_CHECK(!map.options().separate_trees);
    const int start = grid_of_paper_level(levels.start), limit = grid_of_paper_level(levels.limit);
    glm::vec3 irradiance(0);
    Clusters light;
    for (int grid = start; grid <= limit; ++grid)
        for (const LightMap::View& view : map.views()) {
            if (!view.on || grid > view.levels) continue;
            const bool last = grid == std::min(limit, view.levels);
            // Visit nodes in the order of the cut: four children in sequence, in the order of their parents.
            for (std::uint32_t top = 0; top < 1u << (2 * start); ++top)
                for (std::uint32_t path = 0; path < 1u << (2 * (grid - start)); ++path) {
                    int x = static_cast<int>(top & ((1u << start) - 1)), y = static_cast<int>(top >> start);
                    float rest = 1;
                    // Check that all ancestors from the start level on are invalid.
                    for (int level = start; level < grid && rest > 0; ++level) {
                        rest *= left_by(map.share(view.node(level, x, y)));
                        const std::uint32_t child = (path >> (2 * (grid - 1 - level))) & 3;
                        x = 2 * x + static_cast<int>(child % 2), y = 2 * y + static_cast<int>(child / 2);
                    }
                    if (nodes_looked_at) ++*nodes_looked_at;
                    if (!(rest > 0)) continue;
                    const std::size_t id = view.node(grid, x, y);
                    const Share share = last ? k_whole_share : map.share(id);
                    if (share == 0) continue;
                    light.clear();
                    light.push(map.node(id), id, grid, rest * taken_by(share));
                    add_light(light, 0, position, normal, irradiance);
                }
        }
    return irradiance;
}

}   // namespace gnomon::light_quadtree
#endif
