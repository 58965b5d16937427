// SPDX-License-Identifier: Apache-2.0
#include "environment_light/lobe_tables.h"

#include <algorithm>
#include <cmath>

#include "base/folded_sphere.h"

namespace gnomon::environment_light {

namespace {

// Roughnesses of the tables of lobes, and widths of the Gaussians in radians, with the tables' sides.
constexpr std::array<float, 12> k_roughness = {0.1f,  0.15f, 0.19f, 0.23f, 0.28f, 0.33f,
                                               0.39f, 0.46f, 0.54f, 0.64f, 0.8f,  1.0f};
constexpr std::array<int, 12> k_lobe_side = {160, 128, 100, 68, 48, 36, 28, 24, 20, 16, 16, 16};
constexpr std::array<float, 9> k_width = {0.02f, 0.03f, 0.045f, 0.0675f, 0.1f, 0.15f, 0.225f, 0.34f, 0.5f};
constexpr std::array<int, 9> k_spot_side = {192, 132, 88, 60, 44, 32, 24, 20, 12};
constexpr int k_finest_side = 256;   // of the radiance that tables are gathered from
constexpr int k_coarsest_side = 4;
// A square that is gathered is at most as wide as these parts of a lobe's width, and of what it is away from that.
constexpr float k_of_width = 0.5f, k_of_distance = 0.4f;
constexpr float k_narrow_alpha = 0.06f, k_coarse = 2;   // below which so many times wider ones do
constexpr float k_gaussian_reach = 4;                   // widths from which on a Gaussian is left out
constexpr int k_directions = 32;                        // of a lobe at a slant
constexpr int k_core_directions = 16;                   // of one narrower than all tables
constexpr double k_golden = 2.399963229728653;          // angle, in radians
constexpr float k_overlap = 0.7f;                       // of the Gaussians around them
constexpr float k_least_cosine = 1e-3f;
constexpr float k_narrow = 0.12f, k_resolved = 0.2f;   // roughness of lobes from which on Gaussians do for them
// Cosines of the view: from the first on a lobe is round, up to the second it is summed from directions.
constexpr float k_round = 0.97f, k_slant = 0.85f;

// The masking term of a direction by its cosine, of microfacets in the form of Smith: 1 / (1 + the result).
float lambda(float cosine, float a2)
{
    return 0.5f * (std::sqrt(1 + a2 * (1 / (cosine * cosine) - 1)) - 1);
}

// The weight of light from a direction whose cosine to the mirror direction is c, for a lobe that is seen along the
// normal: the distribution of normals times shadowing, without constant factors.
float round_weight(float c, float a2)
{
    if (!(c > 0)) return 0;
    const float half2 = 0.5f * (1 + c), d = half2 * (a2 - 1) + 1;
    return 1 / (d * d * (1 + lambda(std::max(c, k_least_cosine), a2)));
}

// Places in the unit disc on a spiral by the golden angle, and the parts of the disc that they stand for: smaller ones
// towards the rim, where a lobe's directions are far apart.
struct Place {
    float x, y, part;
};
std::array<Place, k_directions> spiral()
{
    const auto inside = [](double i) { return 1 - (1 - i / k_directions) * (1 - i / k_directions); };
    std::array<Place, k_directions> places;
    for (std::size_t k = 0; k < places.size(); ++k) {
        const auto i = static_cast<double>(k);
        const double r = std::sqrt(inside(i + 0.5));
        places[k] = {static_cast<float>(r * std::cos(i * k_golden)), static_cast<float>(r * std::sin(i * k_golden)),
                     static_cast<float>(inside(i + 1) - inside(i))};
    }
    return places;
}

}   // namespace

LobeTables::LobeTables(const scene::Environment& environment) : environment_(environment)
{
    make_levels();
}

void LobeTables::make_levels()
{
    // The finest level: each square has the mean of a few samples, times its solid angle.
    Level& fine = levels_.emplace_back();
    fine.side = k_finest_side;
    const auto count = static_cast<std::size_t>(fine.side) * static_cast<std::size_t>(fine.side);
    fine.flux.resize(count), fine.direction.resize(count);
    const int texels = environment_.image().height * 2 / k_finest_side;
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
            flux += part * environment_.radiance(d), direction += part * d, angle += part;
        }
        fine.flux[i] = flux;
        fine.direction[i] = glm::vec4(glm::normalize(direction), angle);
    }
    while (levels_.back().side > k_coarsest_side) {
        const Level& from = levels_.back();
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
        levels_.push_back(std::move(to));
    }
}

// Gathers what a lobe sees, from squares that are small against its width and against their distance from its middle.
// @param width   of its core, in radians
// @param reach   from which on it sees nothing
// @param weight  by the cosine to its middle
template <class Weight>
glm::vec3 LobeTables::gather(const glm::vec3& around, float width, float reach, const Weight& weight) const
{
    glm::vec3 sum(0);
    float weights = 0;
    const auto visit = [&](const auto& self, std::size_t level, int x, int y) -> void {
        const Level& of = levels_[level];
        const auto i = static_cast<std::size_t>(y * of.side + x);
        const glm::vec4& d = of.direction[i];
        const float cosine = around.x * d.x + around.y * d.y + around.z * d.z;
        const float size = std::sqrt(d.w);
        const float sine = std::sqrt(std::max(0.0f, 1 - cosine * cosine));
        const float away = cosine > 0 ? sine : 2 - sine;   // about the angle
        if (cosine < -size || away - size > reach) return;
        if (level > 0 && size > k_of_width * width + k_of_distance * std::max(away - 0.5f * size - width, 0.0f)) {
            for (int q = 0; q < 4; ++q) self(self, level - 1, 2 * x + q % 2, 2 * y + q / 2);
            return;
        }
        const float w = weight(cosine);
        sum += w * of.flux[i];
        weights += w * d.w;
    };
    const std::size_t coarsest = levels_.size() - 1;
    for (int y = 0; y < levels_[coarsest].side; ++y)
        for (int x = 0; x < levels_[coarsest].side; ++x) visit(visit, coarsest, x, y);
    return weights > 0 ? sum / weights : glm::vec3(0);
}

const DirectionTable& LobeTables::lobe(std::size_t number)
{
    std::call_once(lobes_[number].made, [&] {
        const float alpha = k_roughness[number] * k_roughness[number], a2 = alpha * alpha;
        const float fine = alpha < k_narrow_alpha ? k_coarse : 1;
        DirectionTable table(k_lobe_side[number]);
        for (std::size_t e = 0; e < table.size(); ++e)
            table[e] =
                gather(table.direction(e), fine * alpha, k_infinity, [&](float c) { return round_weight(c, a2); });
        lobes_[number].values = std::move(table);
    });
    return lobes_[number].values;
}

const DirectionTable& LobeTables::spot(std::size_t number)
{
    std::call_once(spots_[number].made, [&] {
        // Nearly a Gaussian, that ends four widths away.
        const float width = k_width[number], inverse = 1 / (8 * width * width);
        DirectionTable table(k_spot_side[number]);
        for (std::size_t e = 0; e < table.size(); ++e)
            table[e] = gather(table.direction(e), k_coarse * width, k_gaussian_reach * width, [&](float c) {
                float w = std::max(1 - (1 - c) * inverse, 0.0f);
                w *= w, w *= w;
                return w * w;
            });
        spots_[number].values = std::move(table);
    });
    return spots_[number].values;
}

// A lobe that is narrower than all tables. Of the microfacets' normals, 1 / (1 + x) are farther than sqrt(x) alpha from
// the surface's. A wider lobe has t times as many that are far away, with t the ratio of the squares of alpha. Without
// these t of it, 1 / ((1 + x) (1 + t x)) of the others are farther: the core, with steep flanks.
glm::vec3 LobeTables::narrow(const glm::vec3& to_viewer, const glm::vec3& normal, const glm::vec3& mirrored,
                             float alpha)
{
    const float widest = k_roughness[0] * k_roughness[0];
    const float t = alpha * alpha / (widest * widest);
    glm::vec3 x, y, core(0);
    make_basis(normal, x, y);
    for (int k = 0; k < k_core_directions; ++k) {
        const float farther = (static_cast<float>(k) + 0.5f) / k_core_directions;
        // The solution of the quadratic equation, in a form that is exact where t is small.
        const float b = 1 + t, c = 1 / farther - 1;
        const float tangent = alpha * std::sqrt(2 * c / (b + std::sqrt(b * b + 4 * t * c)));
        const double phi = k * k_golden;
        const glm::vec3 h = glm::normalize(
            normal + tangent * (static_cast<float>(std::cos(phi)) * x + static_cast<float>(std::sin(phi)) * y));
        core += environment_.radiance(glm::normalize(2 * glm::dot(to_viewer, h) * h - to_viewer));
    }
    return glm::mix(core * (1.0f / k_core_directions), lobe(0).at(mirrored), t);
}

glm::vec3 LobeTables::along_normal(const glm::vec3& mirrored, float roughness)
{
    if (roughness < k_roughness[0]) return narrow(mirrored, mirrored, mirrored, roughness * roughness);
    std::size_t above = 1;
    while (above + 1 < k_lobes && k_roughness[above] < roughness) ++above;
    const float low = k_roughness[above - 1], high = k_roughness[above];
    // Far from its middle, a lobe's weight is in proportion to the fourth power of its roughness.
    const auto fourth = [](float x) { return x * x * x * x; };
    const float t = std::clamp((fourth(roughness) - fourth(low)) / (fourth(high) - fourth(low)), 0.0f, 1.0f);
    if (t <= 0 || t >= 1) return lobe(t <= 0 ? above - 1 : above).at(mirrored);
    return glm::mix(lobe(above - 1).at(mirrored), lobe(above).at(mirrored), t);
}

// The mean of a Gaussian around a direction.
glm::vec3 LobeTables::spot_at(const glm::vec3& direction, float width)
{
    std::size_t above = 1;
    while (above + 1 < k_spots && k_width[above] < width) ++above;
    const float low = k_width[above - 1], high = k_width[above];
    const float t = std::clamp((width - low) / (high - low), 0.0f, 1.0f);
    return glm::mix(spot(above - 1).at(direction), spot(above).at(direction), t);
}

glm::vec3 LobeTables::at_slant(const glm::vec3& to_viewer, const glm::vec3& normal, float alpha,
                               const Reflectance& reflectance)
{
    static const std::array<Place, k_directions> places = spiral();
    const float a2 = alpha * alpha;
    // Axes: the normal, the viewer's side, and across both.
    const float n_v = std::max(glm::dot(normal, to_viewer), k_least_cosine);
    const glm::vec3 side = to_viewer - glm::dot(normal, to_viewer) * normal;
    const float sine = std::max(glm::length(side), k_least_cosine);
    const glm::vec3 x = side / sine, y = glm::cross(normal, x);
    const float v_x = std::sqrt(std::max(1 - n_v * n_v, 0.0f)), of_viewer = lambda(n_v, a2);
    // Stretch the view as the microfacets are, and lay a disc across it [Heitz 2018, section 3].
    const float stretched = 1 / std::sqrt(a2 * v_x * v_x + n_v * n_v);
    const float s_x = alpha * v_x * stretched, s_z = n_v * stretched, s = 0.5f * (1 + s_z);
    glm::vec3 sum(0);
    float weights = 0;
    for (const Place& place : places) {
        const float across = place.x, along = (1 - s) * std::sqrt(1 - across * across) + s * place.y;
        const float rest = std::sqrt(std::max(1 - across * across - along * along, 0.0f));
        glm::vec3 h(alpha * (rest * s_x - along * s_z), alpha * across, std::max(rest * s_z + along * s_x, 0.0f));
        h *= 1 / std::sqrt(h.x * h.x + h.y * h.y + h.z * h.z);
        const float v_h = v_x * h.x + n_v * h.z;
        const glm::vec3 light = 2 * v_h * h - glm::vec3(v_x, 0, n_v);
        if (!(light.z > 0)) continue;
        const float away = 1 - std::clamp(v_h, 0.0f, 1.0f), square = away * away;
        const float fresnel = reflectance.f0 + (reflectance.f90 - reflectance.f0) * (square * square * away);
        const float weight =
            fresnel * place.part * (1 + of_viewer) / (1 + of_viewer + lambda(std::max(light.z, k_least_cosine), a2));
        // Spread it over the solid angle that the place stands for: parts are that far apart.
        const float d = h.z * h.z * (a2 - 1) + 1;
        const float angle = 4 * static_cast<float>(k_pi) * n_v * (1 + of_viewer) * d * d / a2 * place.part;
        const float width = std::sqrt(k_overlap * angle / static_cast<float>(k_pi));
        sum += weight * spot_at(glm::normalize(light.x * x + light.y * y + light.z * normal), width);
        weights += weight;
    }
    return weights > 0 ? sum / weights : glm::vec3(0);
}

glm::vec3 LobeTables::reflected(const glm::vec3& to_viewer, const glm::vec3& normal, const glm::vec3& mirrored,
                                float roughness, const Reflectance& reflectance)
{
    if (roughness < k_roughness[0]) return narrow(to_viewer, normal, mirrored, roughness * roughness);
    const float cosine = glm::dot(normal, to_viewer);
    const float t = std::clamp((k_round - cosine) / (k_round - k_slant), 0.0f, 1.0f);
    // The Gaussians do not resolve the narrowest lobes.
    const float resolved = std::clamp((roughness - k_narrow) / (k_resolved - k_narrow), 0.0f, 1.0f);
    const float slant = t * t * (3 - 2 * t) * resolved;
    if (slant == 0) return along_normal(mirrored, roughness);
    const glm::vec3 light = at_slant(to_viewer, normal, roughness * roughness, reflectance);
    return slant == 1 ? light : glm::mix(along_normal(mirrored, roughness), light, slant);
}

std::size_t LobeTables::bytes() const
{
    std::size_t bytes = 0;
    for (const Level& level : levels_) bytes += level.flux.size() * (sizeof(glm::vec3) + sizeof(glm::vec4));
    for (const Table& table : lobes_) bytes += table.values.size() * sizeof(glm::vec3);
    for (const Table& table : spots_) bytes += table.values.size() * sizeof(glm::vec3);
    return bytes;
}

}   // namespace gnomon::environment_light
