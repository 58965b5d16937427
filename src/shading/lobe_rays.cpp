// SPDX-License-Identifier: Apache-2.0
#include "shading/lobe_rays.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/sobol.h"
#include "shading/glossy.h"

namespace gnomon::shading {

namespace {

float fraction(std::uint32_t bits)
{
    return static_cast<float>(bits >> 8) * 0x1p-24f;
}

// How much the shading normal turns per unit of distance, along the edge of a triangle where it turns most.
float curvature(const ray::ObjectGeometry& geometry, std::uint32_t triangle)
{
    if (!geometry.normals) return 0;
    glm::vec3 p[3], n[3];
    geometry.corners(triangle, p);
    const glm::uvec3 index = geometry.mesh->triangles[triangle];
    for (int i = 0; i < 3; ++i) {
        n[i] = geometry.normals[index[i]];
        if (geometry.normal_to_world) n[i] = *geometry.normal_to_world * n[i];
        const float length = glm::length(n[i]);
        if (!(length > 0)) return 0;
        n[i] /= length;
    }
    float most = 0;
    for (int i = 0; i < 3; ++i) {
        const glm::vec3 edge = p[(i + 1) % 3] - p[i], turn = n[(i + 1) % 3] - n[i];
        const float square = glm::dot(edge, edge);
        if (square > 0) most = std::max(most, glm::dot(turn, turn) / square);
    }
    return std::sqrt(most);
}

// How far the lobe's own axis, across normal and view, is turned from axes that follow the view alone, in turns.
// Heitz's disk is laid out from the lobe's axis, which turns once around where a surface faces the viewer: the
// pattern's error would turn with it, and show as a star there. From the view's axes it is laid out alike at all points
// around. They are those of Frisvad, whose singular direction is straight up: seen from below.
float turn_of_axis(const SurfacePoint& s)
{
    const glm::vec3 axis = glm::cross(s.normal, s.to_viewer), v = s.to_viewer;
    if (axis == glm::vec3(0)) return 0;
    const float a = 1 / std::max(1 + v.y, 1e-6f);
    const glm::vec3 e1(-v.z * v.x * a, -v.z, 1 - v.z * v.z * a), e2(1 - v.x * v.x * a, -v.x, -v.z * v.x * a);
    return std::atan2(glm::dot(axis, e2), glm::dot(axis, e1)) / (2 * static_cast<float>(k_pi));
}

}   // namespace

float lobe_share(const SurfacePoint& s)
{
    const float most = std::max({s.specular.x, s.specular.y, s.specular.z});
    if (!(most > k_lobe_reflectance_from) || !has_glossy_lobe(s)) return 0;
    const float t =
        std::min((most - k_lobe_reflectance_from) / (k_lobe_reflectance_to - k_lobe_reflectance_from), 1.0f);
    return t * t * (3 - 2 * t);
}

void reflect_by_lobe(const SurfacePoint& s, Continuation& next)
{
    const float share = lobe_share(s);
    if (share == 0) return;
    next.lobe_weight = share * s.coverage * glossy_albedo(s);
    next.reflected_weight *= 1 - share;
    next.unresolved_weight *= 1 - share;
}

std::size_t lobe_rays(const SurfacePoint& s, std::uint32_t first, const glm::uvec2& flip, bool random,
                      std::span<LobeRay> rays, float* counts)
{
    std::size_t count = 0;
    glm::vec3 sum(0);
    const float turn = turn_of_axis(s);
    for (std::uint32_t k = 0; k < rays.size(); ++k) {
        const std::uint32_t i = first + k;
        const float u = fraction(reversed_bits(i) ^ flip.x), around = fraction(second_dimension(i) ^ flip.y) - turn;
        const float v = around - std::floor(around);
        const glm::vec3 direction = sample_glossy(s, u, v);
        const float density = glossy_density(s, direction);
        // A ray below the triangle's plane would meet the triangle.
        if (!(density > 0) || glm::dot(s.geometric_normal, direction) <= 0) continue;
        const glm::vec3 weight = reflect_glossy(s, direction) / density;   // 0 below the shading normal's plane
        if (weight == glm::vec3(0)) continue;
        sum += weight;
        rays[count++] = {direction, weight, density};
    }
    // What the lobe reflects of light from everywhere is its albedo.
    const glm::vec3 albedo = s.coverage * glossy_albedo(s);
    if (counts) *counts = (sum.x + sum.y + sum.z) / (albedo.x + albedo.y + albedo.z);
    if (random) sum = static_cast<float>(rays.size()) * albedo;
    for (std::size_t k = 0; k < count; ++k)
        for (int c = 0; c < 3; ++c) rays[k].weight[c] = sum[c] > 0 ? rays[k].weight[c] / sum[c] : 0;
    return count;
}

std::size_t choose_lobe_ray(const SurfacePoint& s, std::uint32_t number, LobeRay& ray)
{
    constexpr std::uint32_t k_candidates = 8, k_golden = 0x9e3779b9u;
    std::array<LobeRay, k_candidates> rays;
    const std::size_t count = lobe_rays(s, number * k_candidates, glm::uvec2(0), false, rays);
    // Multiples of the golden section fill the unit interval evenly.
    float left = fraction(number * k_golden);
    for (std::size_t k = 0; k < count; ++k) {
        const glm::vec3& weight = rays[k].weight;   // all sum to 1
        const float share = (weight.x + weight.y + weight.z) / 3;
        left -= share;
        if (share > 0 && (left < 0 || k + 1 == count)) {
            ray = {rays[k].direction, weight / share, rays[k].density};
            return 1;
        }
    }
    return 0;
}

void widen_lobe(const ray::ObjectGeometry& geometry, std::uint32_t triangle, SurfacePoint& s)
{
    if (s.model != scene::ShadingModel::metallic_roughness || s.specular == glm::vec3(0)) return;
    // Less than a half of the angles, because neighbouring pixels add their rays to those of the lobe.
    constexpr float k_part = 0.2f;
    const float alpha = s.roughness * s.roughness, angle = k_part * s.cone.spread;
    const float turn = k_part * s.cone.width * curvature(geometry, triangle);
    s.roughness = std::min(std::sqrt(std::sqrt(alpha * alpha + angle * angle + turn * turn)), 1.0f);
}

std::uint32_t lobe_block(int x, int y)
{
    static_assert(k_lobe_interleave == 8);
    // Neighbours get blocks that are far apart, those of 2 x 2 pixels four that follow each other. Beyond these, the
    // order is shuffled: on a curved surface, what is bright moves from pixel to pixel through the pattern, and would
    // keep in step with one that is ordered.
    static constexpr std::array<std::uint8_t, 16> k_shuffled{36, 44, 52, 40, 48, 16, 8,  20,
                                                             24, 28, 32, 56, 0,  60, 12, 4};
    static constexpr std::array<std::uint8_t, 16> k_flipped{2, 1, 2, 3, 3, 1, 1, 2, 1, 0, 0, 1, 0, 3, 3, 2};
    const auto a = static_cast<std::uint32_t>(x), b = static_cast<std::uint32_t>(y);
    const auto digit = [&](int bit) { return ((a ^ b) >> bit & 1) << 1 | (b >> bit & 1); };
    const std::uint32_t upper = digit(1) | digit(2) << 2;
    return k_shuffled[upper] | (digit(0) ^ k_flipped[upper]);
}

float lobe_width(float roughness)
{
    return roughness * roughness;
}

}   // namespace gnomon::shading
