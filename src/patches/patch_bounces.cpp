// SPDX-License-Identifier: Apache-2.0
#include "patches/patch_bounces.h"

#include <algorithm>
#include <cmath>

#include "base/interruption.h"

namespace gnomon::patches {

double total_flux(const PatchSurfaces& surfaces, std::span<const glm::vec3> exitance)
{
    double sum = 0;
    for (std::size_t p = 0; p < exitance.size(); ++p)
        sum += static_cast<double>(surfaces.area[p]) * std::abs(static_cast<double>(luminance(exitance[p])));
    return sum;
}

std::vector<glm::vec3> bounce(const PatchLinks& links, const PatchSurfaces& surfaces, std::span<const glm::vec3> direct,
                              double all, const BounceOptions& options, Tasks& tasks,
                              std::span<const BlockedLink> blocked)
{
    constexpr double k_most_ratio = 0.98;
    const std::size_t count = direct.size();
    std::vector<glm::vec3> added(count, glm::vec3(0)), last(direct.begin(), direct.end()), next(count);
    double before = total_flux(surfaces, direct), sum = before;
    if (!(before > 0)) return added;
    for (int sweep = 0; sweep < options.sweeps; ++sweep) {
        interruption_point();
        gather_links(links, last, next, tasks);
        for (const BlockedLink& link : blocked) next[link.from] -= link.weight * last[link.target];
        for (std::size_t p = 0; p < count; ++p) {
            next[p] *= surfaces.albedo[p];
            added[p] += next[p];
        }
        last.swap(next);
        const double flux = total_flux(surfaces, last);
        sum += flux;
        if (flux < options.stop * (all > 0 ? all : sum) || sweep + 1 == options.sweeps) {
            // Further sweeps add a geometric series.
            const auto ratio = static_cast<float>(std::min(flux / before, k_most_ratio));
            if (options.endless)
                for (std::size_t p = 0; p < count; ++p) added[p] += ratio / (1 - ratio) * last[p];
            break;
        }
        before = flux;
    }
    return added;
}

}   // namespace gnomon::patches
