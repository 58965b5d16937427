// SPDX-License-Identifier: Apache-2.0
#include "environment_light/cell_light.h"

#include <algorithm>
#include <bit>

#include "base/check.h"
#include "environment_light/cell_sums.h"

namespace gnomon::environment_light {

namespace {

constexpr double k_units = 1 << 29;   // of all flux of a colour

constexpr float k_least_seen = 0.02f;   // of a lobe: from less, the mean of what is visible is not known

}   // namespace

CellLight::CellLight(const DirectionCells& cells, const scene::Environment* environment,
                     const CellLightOptions& options)
    : cells_(cells), environment_(environment), options_(options), exists_(cells.words(), 0), normals_(options.normals)
{
    const std::size_t padded = 64 * cells.words();
    angle_.assign(padded, 0);
    angle_units_.assign(padded, 0);
    for (std::size_t leaf = 0; leaf < cells.leaves(); ++leaf) {
        angle_[leaf] = cells.angle(leaf);
        angle_units_[leaf] = static_cast<float>(static_cast<double>(angle_[leaf]) / k_pi * k_units);
    }
    for (int axis = 0; axis < 3; ++axis) {
        const auto a = static_cast<std::size_t>(axis);
        for (auto* list : {&mean_[a], &flux_[a], &units_[a]}) list->assign(padded, 0);
        const double total = static_cast<double>(cells.total_flux()[axis]);
        unit_[axis] = static_cast<float>(total / k_units);
        for (std::size_t leaf = 0; leaf < cells.leaves(); ++leaf) {
            mean_[a][leaf] = cells.mean(leaf)[axis];
            flux_[a][leaf] = cells.flux(leaf)[axis];
            units_[a][leaf] =
                total > 0 ? static_cast<float>(static_cast<double>(cells.flux(leaf)[axis]) / total * k_units) : 0;
        }
    }
    for (std::size_t leaf = 0; leaf < cells.leaves(); ++leaf) exists_[leaf / 64] |= std::uint64_t{1} << (leaf % 64);
    for (std::size_t entry = 0; entry < normals_.size(); ++entry) {
        const CosineSums sums = sum(normals_.direction(entry), exists_, 0);
        for (int c = 0; c < 3; ++c)
            normals_[entry][c] = static_cast<float>(sums.flux[static_cast<std::size_t>(c)]) * unit_[c];
    }
}

CellLight::~CellLight() = default;

// Adds what cells of a mask bring, in units.
// @param flip  all bits: the cells that are not in the mask
CosineSums CellLight::sum(const glm::vec3& normal, std::span<const std::uint64_t> mask, std::uint64_t flip) const
{
    return cosine_sums(normal,
                       {{mean_[0].data(), mean_[1].data(), mean_[2].data()},
                        {units_[0].data(), units_[1].data(), units_[2].data()},
                        angle_units_.data()},
                       mask, exists_, flip);
}

glm::vec3 CellLight::irradiance(const glm::vec3& normal) const
{
    return normals_.at(normal);
}

FromCells CellLight::from_cells(const glm::vec3& normal, std::span<const std::uint64_t> seen,
                                std::span<const PartialCell> partial) const
{
    // What shares bring beyond the bits.
    glm::vec3 more(0);
    float opened = 0;
    for (const PartialCell& cell : partial) {
        const float whole = (seen[cell.leaf / 64] >> (cell.leaf % 64) & 1) != 0 ? 1.0f : 0.0f;
        const float cosine =
            normal.x * mean_[0][cell.leaf] + normal.y * mean_[1][cell.leaf] + normal.z * mean_[2][cell.leaf];
        more += (cell.share - whole) * std::max(cosine, 0.0f) * cells_.flux(cell.leaf);
        opened += (cell.share - whole) * std::max(cosine, 0.0f) * angle_[cell.leaf] / static_cast<float>(k_pi);
    }
    std::size_t visible = 0;
    for (const std::uint64_t word : seen) visible += static_cast<std::size_t>(std::popcount(word));
    // About half of the cells lie above any surface.
    glm::vec3 result;
    if (4 * visible > cells_.leaves()) {
        const CosineSums hidden = sum(normal, seen, ~std::uint64_t{0});
        for (int c = 0; c < 3; ++c) result[c] = static_cast<float>(hidden.flux[static_cast<std::size_t>(c)]) * unit_[c];
        return {glm::max(irradiance(normal) - result + more, glm::vec3(0)),
                static_cast<float>(static_cast<double>(hidden.angle) / k_units) - opened};
    }
    const CosineSums sums = sum(normal, seen, 0);
    for (int c = 0; c < 3; ++c) result[c] = static_cast<float>(sums.flux[static_cast<std::size_t>(c)]) * unit_[c];
    const float open = static_cast<float>(static_cast<double>(sums.angle) / k_units) + opened;
    return {partial.empty() ? result : glm::max(result + more, glm::vec3(0)), 1 - open};
}

LobeTables& CellLight::lobes() const
{
    GNOMON_CHECK(environment_);
    std::call_once(lobes_made_, [&] { lobes_ = std::make_unique<LobeTables>(*environment_); });
    return *lobes_;
}

glm::vec3 CellLight::blurred(const glm::vec3& direction, float roughness) const
{
    return lobes().along_normal(direction, roughness);
}

SeenByLobe CellLight::seen_by(const Lobe& lobe, std::span<const std::uint64_t> seen,
                              std::span<const PartialCell> partial) const
{
    const float roughness = std::max(lobe.roughness, options_.least_roughness);
    const float alpha = roughness * roughness, a2 = alpha * alpha;
    const float n_v = std::max(glm::dot(lobe.normal, lobe.to_viewer), 1e-3f);
    const WeightedLobe weighted{
        lobe.to_viewer, lobe.normal, lobe.horizon, a2, n_v, std::sqrt(a2 + (1 - a2) * n_v * n_v), lobe.f0, lobe.f90};
    // By lane, so that the sums have a fixed order.
    const LobeSums sums = lobe_sums(weighted,
                                    {{mean_[0].data(), mean_[1].data(), mean_[2].data()},
                                     {flux_[0].data(), flux_[1].data(), flux_[2].data()},
                                     angle_.data()},
                                    seen);
    float angle = 0, visible_angle = 0;
    for (std::size_t i = 0; i < k_sum_lanes; ++i) angle += sums.angles[i], visible_angle += sums.visible_angles[i];
    glm::vec3 share(0), mean(0), more(0);
    for (const PartialCell& cell : partial) {
        const float whole = (seen[cell.leaf / 64] >> (cell.leaf % 64) & 1) != 0 ? 1.0f : 0.0f;
        const float weight = (cell.share - whole) *
                             lobe_weight(weighted, {mean_[0][cell.leaf], mean_[1][cell.leaf], mean_[2][cell.leaf]});
        more += weight * cells_.flux(cell.leaf), visible_angle += weight * angle_[cell.leaf];
    }
    for (int colour = 0; colour < 3; ++colour) {
        const auto c = static_cast<std::size_t>(colour);
        float whole = 0, part = 0;
        for (std::size_t i = 0; i < k_sum_lanes; ++i) whole += sums.all[c][i], part += sums.visible[c][i];
        share[colour] = whole > 0 ? std::clamp((part + more[colour]) / whole, 0.0f, 1.0f) : 0;
        mean[colour] = angle > 0 ? whole / angle : 0;
    }
    // Of few cells the mean is uncertain: it fades into that of all.
    const float visible = angle > 0 ? std::clamp(visible_angle / angle, 0.0f, 1.0f) : 0;
    SeenByLobe result;
    result.open = (mean * share + k_least_seen * mean) / (visible + k_least_seen);
    const auto by_cells_between = [&](float tables, float cells) {
        return std::clamp((lobe.roughness - tables) / (cells - tables), 0.0f, 1.0f);
    };
    const float by_cells = by_cells_between(options_.by_tables, options_.by_cells),
                open_by_cells = by_cells_between(options_.open_by_tables, options_.open_by_cells);
    if (by_cells < 1) {
        const glm::vec3 by_table = lobe.round ? blurred(lobe.mirrored, lobe.roughness)
                                              : lobes().reflected(lobe.to_viewer, lobe.normal, lobe.mirrored,
                                                                  lobe.roughness, {lobe.f0, lobe.f90});
        mean = glm::mix(by_table, mean, by_cells), result.open = glm::mix(by_table, result.open, open_by_cells);
    }
    result.light = mean * share;
    const float all = luminance(mean);
    if (all > 0) result.share = luminance(result.light) / all;
    return result;
}

std::size_t CellLight::bytes() const
{
    std::size_t bytes = 10 * mean_[0].size() * sizeof(float) + normals_.size() * sizeof(glm::vec3);
    if (lobes_) bytes += lobes_->bytes();
    return bytes;
}

}   // namespace gnomon::environment_light
