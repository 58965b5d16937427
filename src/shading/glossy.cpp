// SPDX-License-Identifier: Apache-2.0
#include "shading/glossy.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <mutex>

#include "shading/lobe_shared.h"

namespace gnomon::shading {

namespace {

constexpr float k_float_pi = static_cast<float>(k_pi);
constexpr float k_least_roughness = GNOMON_LOBE_LEAST_ROUGHNESS;
constexpr float k_least_cosine = GNOMON_LOBE_LEAST_VIEW;

float alpha_of(float roughness)
{
    return roughness * roughness;
}

// The surface's frame, in which its shading normal is z.
struct Frame {
    glm::vec3 x, y, z;
    explicit Frame(const glm::vec3& normal) : z(normal) { make_basis(normal, x, y); }
    glm::vec3 to_local(const glm::vec3& v) const { return {glm::dot(v, x), glm::dot(v, y), glm::dot(v, z)}; }
    glm::vec3 to_world(const glm::vec3& v) const { return v.x * x + v.y * y + v.z * z; }
};

// Smith's masking of one direction: 2 / (1 + sqrt(1 + a^2 tan^2)).
float masking(float cosine, float a2)
{
    return 2 * cosine / (cosine + std::sqrt(a2 + (1 - a2) * cosine * cosine));
}

// Height-correlated masking and shadowing over that of the view alone.
float shadowing(float n_v, float n_l, float a2)
{
    const float v = n_l * std::sqrt(a2 + (1 - a2) * n_v * n_v), l = n_v * std::sqrt(a2 + (1 - a2) * n_l * n_l);
    return 2 * n_v * n_l / (v + l) / masking(n_v, a2);
}

float distribution(float n_h, float a2)
{
    const float d = n_h * n_h * (a2 - 1) + 1;
    return a2 / (k_float_pi * d * d);
}

// A normal of the microfacets that are visible from a local direction [Heitz 2018].
glm::vec3 visible_normal(const glm::vec3& view, float alpha, float u, float v)
{
    const glm::vec3 stretched = glm::normalize(glm::vec3(alpha * view.x, alpha * view.y, view.z));
    const float flat = stretched.x * stretched.x + stretched.y * stretched.y;
    const glm::vec3 t1 = flat > 0 ? glm::vec3(-stretched.y, stretched.x, 0) / std::sqrt(flat) : glm::vec3(1, 0, 0);
    const glm::vec3 t2 = glm::cross(stretched, t1);
    const float r = std::sqrt(u), phi = 2 * k_float_pi * v;
    const float p1 = r * std::cos(phi), s = 0.5f * (1 + stretched.z);
    const float p2 = (1 - s) * std::sqrt(std::max(0.0f, 1 - p1 * p1)) + s * r * std::sin(phi);
    const glm::vec3 h = p1 * t1 + p2 * t2 + std::sqrt(std::max(0.0f, 1 - p1 * p1 - p2 * p2)) * stretched;
    return glm::normalize(glm::vec3(alpha * h.x, alpha * h.y, std::max(1e-6f, h.z)));
}

float schlick_part(float cosine)
{
    const float x = 1 - std::clamp(cosine, 0.0f, 1.0f), x2 = x * x;
    return x2 * x2 * x;
}

// Directional albedo of the lobe by cosine and roughness, in two parts: with reflectance f0 at normal incidence it is
// f0 * part[0] + part[1] [Karis 2013]. Integrated once, from a regular pattern.
class AlbedoTable {
 public:
    static constexpr int k_side = GNOMON_ALBEDO_SIDE, k_strata = 24;
    // Makes the row of a roughness when it is first needed: few materials have all. Thread-safe.
    const glm::vec2* row(int r)
    {
        const auto i = static_cast<std::size_t>(r);
        glm::vec2* const begin = parts_.data() + i * k_side;
        if (made_[i].load(std::memory_order_acquire)) return begin;
        const std::lock_guard lock(mutex_);
        if (made_[i].load(std::memory_order_relaxed)) return begin;
        for (int c = 0; c < k_side; ++c)
            begin[c] = integrate(std::max(static_cast<float>(c) / (k_side - 1), GNOMON_BENT_VIEW),
                                 alpha_of(static_cast<float>(std::max(r, 1)) / (k_side - 1)));
        made_[i].store(true, std::memory_order_release);
        return begin;
    }
    std::span<const glm::vec2> all()
    {
        for (int r = 0; r < k_side; ++r) row(r);
        return parts_;
    }
    static glm::vec2 integrate(float n_v, float alpha)
    {
        const glm::vec3 view(std::sqrt(1 - n_v * n_v), 0, n_v);
        glm::dvec2 sum(0);
        for (int i = 0; i < k_strata; ++i)
            for (int j = 0; j < k_strata; ++j) {
                const glm::vec3 h = visible_normal(view, alpha, (static_cast<float>(i) + 0.5f) / k_strata,
                                                   (static_cast<float>(j) + 0.5f) / k_strata);
                const float v_h = glm::dot(view, h), n_l = 2 * v_h * h.z - view.z;
                if (!(n_l > 0)) continue;
                const float weight = shadowing(n_v, n_l, alpha * alpha), part = schlick_part(v_h);
                sum += glm::dvec2(weight * (1 - part), weight * part);
            }
        return glm::vec2(sum / static_cast<double>(k_strata * k_strata));
    }
    glm::vec2 at(float n_v, float roughness)
    {
        const auto split = [](float x, int& low) {
            const float t = std::clamp(x, 0.0f, 1.0f) * (k_side - 1);
            low = std::min(static_cast<int>(t), k_side - 2);
            return t - static_cast<float>(low);
        };
        int above, column;
        const float down = split(roughness, above), across = split(n_v, column);
        const glm::vec2 *upper = row(above) + column, *lower = row(above + 1) + column;
        return glm::mix(glm::mix(upper[0], upper[1], across), glm::mix(lower[0], lower[1], across), down);
    }

 private:
    std::array<glm::vec2, k_side * k_side> parts_;   // by roughness, then cosine
    std::array<std::atomic<bool>, k_side> made_{};   // rows
    std::mutex mutex_;
};

AlbedoTable& albedo_table()
{
    static AlbedoTable table;
    return table;
}

// What multiplies the lobe so that light which is reflected between microfacets is not lost [Turquin 2019, eq. 16].
glm::vec3 given_back(const glm::vec3& f0, const glm::vec2& parts)
{
    const float kept = parts.x + parts.y;
    return glm::vec3(1) + f0 * ((1 - kept) / std::max(kept, 1e-3f));
}

}   // namespace

bool has_glossy_lobe(const SurfacePoint& s)
{
    return s.model == scene::ShadingModel::metallic_roughness && s.specular != glm::vec3(0) &&
           s.transmitted == glm::vec3(0) && s.roughness >= k_least_roughness &&
           glm::dot(s.normal, s.to_viewer) >= k_least_cosine;
}

glm::vec3 reflect_glossy(const SurfacePoint& s, const glm::vec3& to_light)
{
    const float n_l = glm::dot(s.normal, to_light), n_v = glm::dot(s.normal, s.to_viewer);
    if (n_l <= 0 || glm::dot(s.smooth_normal, to_light) <= 0) return glm::vec3(0);
    const glm::vec3 half = glm::normalize(to_light + s.to_viewer);
    const float n_h = std::clamp(glm::dot(s.normal, half), 0.0f, 1.0f), v_h = glm::dot(s.to_viewer, half);
    const float alpha = alpha_of(s.roughness), a2 = alpha * alpha;
    const glm::vec3 fresnel = s.specular + (glm::vec3(s.f90) - s.specular) * schlick_part(v_h);
    // F D G / (4 n_v n_l) n_l
    const float lobe = distribution(n_h, a2) * shadowing(n_v, n_l, a2) * masking(n_v, a2) / (4 * n_v);
    return fresnel * given_back(s.specular, albedo_table().at(n_v, s.roughness)) * (lobe * s.coverage);
}

glm::vec3 sample_glossy(const SurfacePoint& s, float u, float v)
{
    const Frame frame(s.normal);
    const glm::vec3 view = frame.to_local(s.to_viewer);
    const glm::vec3 h = visible_normal(view, alpha_of(s.roughness), u, v);
    return glm::normalize(frame.to_world(2 * glm::dot(view, h) * h - view));
}

float glossy_density(const SurfacePoint& s, const glm::vec3& direction)
{
    const glm::vec3 sum = direction + s.to_viewer;
    const float length = glm::length(sum), n_v = glm::dot(s.normal, s.to_viewer);
    if (!(length > 0)) return 0;
    const float n_h = glm::dot(s.normal, sum / length);
    if (n_h <= 0) return 0;
    const float alpha = alpha_of(s.roughness), a2 = alpha * alpha;
    return masking(n_v, a2) * distribution(n_h, a2) / (4 * n_v);
}

std::span<const glm::vec2> glossy_albedo_table()
{
    return albedo_table().all();
}

glm::vec3 mean_reflectance(const SurfacePoint& s)
{
    const glm::vec2 parts = albedo_table().at(glm::dot(s.normal, s.to_viewer), s.roughness);
    return (s.specular * parts.x + s.f90 * parts.y) / std::max(parts.x + parts.y, 1e-3f);
}

glm::vec3 glossy_albedo(const SurfacePoint& s)
{
    const glm::vec2 parts = albedo_table().at(glm::dot(s.normal, s.to_viewer), s.roughness);
    return glm::min((s.specular * parts.x + s.f90 * parts.y) * given_back(s.specular, parts), glm::vec3(1));
}

}   // namespace gnomon::shading
