// SPDX-License-Identifier: Apache-2.0
#include "environment_light/cell_light.h"

#include <algorithm>
#include <bit>

#include "base/check.h"
#include "base/folded_sphere.h"
#include "environment_light/cell_sums.h"

namespace gnomon::environment_light {

namespace {

constexpr double k_units = 1 << 29;   // of all flux of a colour

// Roughnesses of the tables of lobes, and their sides.
constexpr std::size_t k_lobes = 7;
constexpr std::array<float, k_lobes> k_roughness = {0.1f, 0.15f, 0.22f, 0.32f, 0.45f, 0.65f, 1.0f};
constexpr std::array<int, k_lobes> k_lobe_side = {160, 128, 96, 64, 48, 32, 24};
constexpr int k_finest_side = 256;   // of the radiance that lobes are gathered from
constexpr int k_coarsest_side = 4;
constexpr float k_least_seen = 0.02f;   // of a lobe: from less, the mean of what is visible is not known
constexpr float k_accuracy = 0.5f;      // a cell that lobes are gathered from is at most this fraction of their width

// The weight of light from a direction whose cosine to the mirror direction is c, for a lobe that is seen along the
// normal: the distribution of normals times the cosine [Karis 2013], without constant factors.
float lobe_weight(float c, float a2)
{
    if (!(c > 0)) return 0;
    const float half2 = 0.5f * (1 + c);
    const float d = half2 * (a2 - 1) + 1;
    return c / (d * d);
}

}   // namespace

// Radiance over the sphere in a pyramid of means, and the blurred tables.
struct CellLight::Lobes {
    struct Level {
        int side = 0;   // squares
        std::vector<glm::vec3> flux;
        std::vector<glm::vec4> direction;   // unit mean direction; w: solid angle
    };
    std::vector<Level> levels;   // from the finest
    std::array<DirectionTable, k_lobes> tables;
    std::array<std::once_flag, k_lobes> made;

    explicit Lobes(const scene::Environment& environment)
    {
        // The finest level: each square has the mean of a few samples, times its solid angle.
        Level& fine = levels.emplace_back();
        fine.side = k_finest_side;
        const auto count = static_cast<std::size_t>(fine.side) * static_cast<std::size_t>(fine.side);
        fine.flux.resize(count), fine.direction.resize(count);
        const int texels = environment.image().height * 2 / k_finest_side;
        const int samples = std::clamp(texels, 2, 8);
        for (std::size_t i = 0; i < count; ++i) {
            const glm::vec2 at(static_cast<float>(i % k_finest_side), static_cast<float>(i / k_finest_side));
            glm::vec3 flux(0), direction(0);
            float angle = 0;
            for (int s = 0; s < samples * samples; ++s) {
                const glm::vec2 in((static_cast<float>(s % samples) + 0.5f) / static_cast<float>(samples),
                                   (static_cast<float>(s / samples) + 0.5f) / static_cast<float>(samples));
                const glm::vec2 p = (at + in) * (2.0f / k_finest_side) - 1.0f;
                const glm::vec3 d = unfold(p);
                // The solid angle of the octahedron's surface falls with the cube of its distance.
                const float sum = std::abs(d.x) + std::abs(d.y) + std::abs(d.z);
                const float part =
                    4.0f / (k_finest_side * k_finest_side) / static_cast<float>(samples * samples) * sum * sum * sum;
                flux += part * environment.radiance(d), direction += part * d, angle += part;
            }
            fine.flux[i] = flux;
            fine.direction[i] = glm::vec4(glm::normalize(direction), angle);
        }
        while (levels.back().side > k_coarsest_side) {
            const Level& from = levels.back();
            Level to;
            to.side = from.side / 2;
            for (int y = 0; y < to.side; ++y)
                for (int x = 0; x < to.side; ++x) {
                    glm::vec3 flux(0), direction(0);
                    float angle = 0;
                    for (int q = 0; q < 4; ++q) {
                        const auto i = static_cast<std::size_t>((2 * y + q / 2) * from.side + 2 * x + q % 2);
                        flux += from.flux[i], angle += from.direction[i].w;
                        direction += from.direction[i].w * glm::vec3(from.direction[i]);
                    }
                    to.flux.push_back(flux);
                    to.direction.emplace_back(glm::normalize(direction), angle);
                }
            levels.push_back(std::move(to));
        }
    }

    // Makes a table when it is first asked for. Thread-safe.
    const DirectionTable& table(std::size_t r)
    {
        std::call_once(made[r], [&] {
            DirectionTable table(k_lobe_side[r]);
            for (std::size_t e = 0; e < table.size(); ++e) table[e] = gather(table.direction(e), k_roughness[r]);
            tables[r] = std::move(table);
        });
        return tables[r];
    }

    // Gathers what a lobe sees, from squares that are small against its width and against their distance from its
    // middle.
    glm::vec3 gather(const glm::vec3& around, float roughness) const
    {
        const float alpha = roughness * roughness, a2 = alpha * alpha;
        glm::vec3 sum(0);
        float weights = 0;
        const auto visit = [&](const auto& self, std::size_t level, int x, int y) -> void {
            const Level& of = levels[level];
            const auto i = static_cast<std::size_t>(y * of.side + x);
            const glm::vec4& d = of.direction[i];
            const float cosine = around.x * d.x + around.y * d.y + around.z * d.z;
            const float size = std::sqrt(d.w);
            const float sine = std::sqrt(std::max(0.0f, 1 - cosine * cosine));
            const float away = cosine > 0 ? sine : 2 - sine;   // about the angle
            if (cosine < -size) return;
            if (level > 0 && size > k_accuracy * (2 * alpha + std::max(away - 0.5f * size, 0.0f))) {
                for (int q = 0; q < 4; ++q) self(self, level - 1, 2 * x + q % 2, 2 * y + q / 2);
                return;
            }
            const float weight = lobe_weight(cosine, a2);
            sum += weight * of.flux[i];
            weights += weight * d.w;
        };
        const std::size_t coarsest = levels.size() - 1;
        for (int y = 0; y < levels[coarsest].side; ++y)
            for (int x = 0; x < levels[coarsest].side; ++x) visit(visit, coarsest, x, y);
        return weights > 0 ? sum / weights : glm::vec3(0);
    }
};

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

glm::vec3 CellLight::blurred(const glm::vec3& direction, float roughness) const
{
    GNOMON_CHECK(environment_);
    std::call_once(lobes_made_, [&] { lobes_ = std::make_unique<Lobes>(*environment_); });
    std::size_t above = 1;
    while (above + 1 < k_roughness.size() && k_roughness[above] < roughness) ++above;
    const float low = k_roughness[above - 1], high = k_roughness[above];
    const float t = std::clamp((roughness - low) / (high - low), 0.0f, 1.0f);
    if (t <= 0 || t >= 1) return lobes_->table(t <= 0 ? above - 1 : above).at(direction);
    return glm::mix(lobes_->table(above - 1).at(direction), lobes_->table(above).at(direction), t);
}

SeenByLobe CellLight::seen_by(const Lobe& lobe, std::span<const std::uint64_t> seen,
                              std::span<const PartialCell> partial) const
{
    const float roughness = std::max(lobe.roughness, options_.least_roughness);
    const float alpha = roughness * roughness, a2 = alpha * alpha;
    const float n_v = std::max(glm::dot(lobe.normal, lobe.to_viewer), 1e-3f);
    const WeightedLobe weighted{
        lobe.to_viewer, lobe.normal, lobe.horizon, a2, n_v, std::sqrt(a2 + (1 - a2) * n_v * n_v)};
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
    const float by_cells =
        std::clamp((lobe.roughness - options_.by_tables) / (options_.by_cells - options_.by_tables), 0.0f, 1.0f);
    if (by_cells < 1) {
        const glm::vec3 by_table = blurred(lobe.mirrored, lobe.roughness);
        mean = glm::mix(by_table, mean, by_cells), result.open = glm::mix(by_table, result.open, by_cells);
    }
    result.light = mean * share;
    const float all = luminance(mean);
    if (all > 0) result.share = luminance(result.light) / all;
    return result;
}

std::size_t CellLight::bytes() const
{
    std::size_t bytes = 10 * mean_[0].size() * sizeof(float) + normals_.size() * sizeof(glm::vec3);
    if (lobes_) {
        for (const Lobes::Level& level : lobes_->levels) bytes += level.flux.size() * (sizeof(glm::vec3) + 16);
        for (const DirectionTable& table : lobes_->tables) bytes += table.size() * sizeof(glm::vec3);
    }
    return bytes;
}

}   // namespace gnomon::environment_light
