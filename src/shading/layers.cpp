// SPDX-License-Identifier: Apache-2.0
#include "shading/layers.h"

#include <algorithm>
#include <array>

namespace gnomon::shading {

namespace {

constexpr auto k_float_pi = static_cast<float>(k_pi);
constexpr float k_min_alpha = 2e-3f;         // as in shading.cpp
constexpr float k_coat_f0 = 0.04f;           // of index 1.5
constexpr float k_least_sheen = 0.1f;        // roughness: below it, the lobe is a line at the horizon
constexpr float k_sharp_roughness = 0.04f;   // up to here, transmission is sharp
constexpr int k_rough_rays = 16;             // of a rough surface
constexpr float k_ray_gap = 0.5f;            // growth of a rough ray's cone, per the angle between the rays

float pow5(float x)
{
    const float x2 = x * x;
    return x2 * x2 * x;
}

float schlick(float f0, float cosine)
{
    return f0 + (1 - f0) * pow5(1 - std::clamp(cosine, 0.0f, 1.0f));
}

// Distribution and visibility of GGX [glTF 2.0, B.3.2].
float ggx_lobe(const glm::vec3& normal, const glm::vec3& to_viewer, const glm::vec3& to_light, float roughness)
{
    const float n_l = glm::dot(normal, to_light), n_v = std::max(glm::dot(normal, to_viewer), 1e-4f);
    if (n_l <= 0) return 0;
    const float n_h = std::clamp(glm::dot(normal, glm::normalize(to_light + to_viewer)), 0.0f, 1.0f);
    const float alpha = std::max(roughness * roughness, k_min_alpha), a2 = alpha * alpha;
    const float d = n_h * n_h * (a2 - 1) + 1;
    const float visibility =
        0.5f / (n_l * std::sqrt(n_v * n_v * (1 - a2) + a2) + n_v * std::sqrt(n_l * n_l * (1 - a2) + a2));
    return a2 / (k_float_pi * d * d) * visibility;
}

// The lobe of fibres: distribution [Estevez and Kulla 2017] and visibility [Neubelt and Pettineo 2013].
float sheen_lobe(float n_h, float n_v, float n_l, float roughness)
{
    const float inverse = 1 / (roughness * roughness);
    const float sine2 = std::max(1 - n_h * n_h, 1e-6f);
    const float distribution = (2 + inverse) * std::pow(sine2, 0.5f * inverse) / (2 * k_float_pi);
    return distribution / std::max(4 * (n_l + n_v - n_l * n_v), 1e-4f);
}

// The albedo of white fibres, before it is limited to 1, by roughness and cosine of the view.
class SheenTable {
 public:
    SheenTable()
    {
        for (int r = 0; r < k_side; ++r)
            for (int c = 0; c < k_side; ++c)
                albedo_[static_cast<std::size_t>(r * k_side + c)] =
                    integrate(std::max(static_cast<float>(c) / (k_side - 1), 0.01f), roughness_of(r));
    }
    float at(float cosine, float roughness) const
    {
        const float row = std::clamp((roughness - k_least_sheen) / (1 - k_least_sheen), 0.0f, 1.0f) * (k_side - 1);
        const float column = std::clamp(cosine, 0.0f, 1.0f) * (k_side - 1);
        const int r = std::min(static_cast<int>(row), k_side - 2), c = std::min(static_cast<int>(column), k_side - 2);
        const auto cell = [&](int i, int j) { return albedo_[static_cast<std::size_t>((r + i) * k_side + c + j)]; };
        const float across = column - static_cast<float>(c);
        return glm::mix(glm::mix(cell(0, 0), cell(0, 1), across), glm::mix(cell(1, 0), cell(1, 1), across),
                        row - static_cast<float>(r));
    }

 private:
    static constexpr int k_side = 16, k_strata = 64;
    static float roughness_of(int row)
    {
        return k_least_sheen + (1 - k_least_sheen) * static_cast<float>(row) / (k_side - 1);
    }
    static float integrate(float n_v, float roughness)
    {
        const glm::vec3 view(std::sqrt(1 - n_v * n_v), 0, n_v);
        double sum = 0;
        for (int i = 0; i < k_strata; ++i)
            for (int j = 0; j < k_strata; ++j) {
                const float n_l = (static_cast<float>(i) + 0.5f) / k_strata;
                const float turn = k_float_pi * (static_cast<float>(j) + 0.5f) / k_strata;   // one half is the other
                const float flat = std::sqrt(1 - n_l * n_l);
                const glm::vec3 light(flat * std::cos(turn), flat * std::sin(turn), n_l);
                sum += sheen_lobe(glm::normalize(view + light).z, n_v, n_l, roughness) * n_l;
            }
        return static_cast<float>(sum * 2 * k_pi / (k_strata * k_strata));
    }
    std::array<float, k_side * k_side> albedo_;
};

float unlimited_sheen_albedo(float cosine, float roughness)
{
    static const SheenTable table;
    return table.at(cosine, roughness);
}

// What the eye makes of an interference of this path difference [Belcour and Barla 2017, eq. 10], linear RGB.
glm::vec3 sensitivity(float path_nanometres, const glm::vec3& shift)
{
    const double phase = 2 * k_pi * path_nanometres * 1e-9;
    constexpr double value[] = {5.4856e-13, 4.4201e-13, 5.2481e-13}, place[] = {1.6810e+06, 1.7953e+06, 2.2084e+06},
                     width[] = {4.3278e+09, 9.3046e+09, 6.6121e+09};
    double xyz[3];
    for (int i = 0; i < 3; ++i)
        xyz[i] = value[i] * std::sqrt(2 * k_pi * width[i]) *
                 std::cos(place[i] * phase + static_cast<double>(shift[i])) * std::exp(-phase * phase * width[i]);
    constexpr double k_second_width = 4.5282e+09;
    xyz[0] += 9.7470e-14 * std::sqrt(2 * k_pi * k_second_width) *
              std::cos(2.2399e+06 * phase + static_cast<double>(shift.x)) * std::exp(-k_second_width * phase * phase);
    for (double& x : xyz) x /= 1.0685e-7;
    return {static_cast<float>(3.2404542 * xyz[0] - 1.5371385 * xyz[1] - 0.4985314 * xyz[2]),
            static_cast<float>(-0.9692660 * xyz[0] + 1.8760108 * xyz[1] + 0.0415560 * xyz[2]),
            static_cast<float>(0.0556434 * xyz[0] - 0.2040259 * xyz[1] + 1.0572252 * xyz[2])};
}

float f0_of(float inside, float outside)
{
    const float r = (inside - outside) / (inside + outside);
    return r * r;
}

// The directions of light that a rough surface lets through, by microfacets that the viewer sees [Heitz 2018], in a
// pattern without chance: a spiral of golden angles.
glm::vec3 microfacet(const SurfacePoint& s, int i)
{
    glm::vec3 x, y;
    make_basis(s.normal, x, y);
    const float alpha = s.roughness * s.roughness;
    const glm::vec3 view(glm::dot(s.to_viewer, x), glm::dot(s.to_viewer, y), glm::dot(s.to_viewer, s.normal));
    const glm::vec3 stretched = glm::normalize(glm::vec3(alpha * view.x, alpha * view.y, std::max(view.z, 1e-4f)));
    const float flat = stretched.x * stretched.x + stretched.y * stretched.y;
    const glm::vec3 t1 = flat > 0 ? glm::vec3(-stretched.y, stretched.x, 0) / std::sqrt(flat) : glm::vec3(1, 0, 0);
    const glm::vec3 t2 = glm::cross(stretched, t1);
    constexpr float k_golden = 2.39996323f;
    const float r = std::sqrt((static_cast<float>(i) + 0.5f) / k_rough_rays), phi = k_golden * static_cast<float>(i);
    const float p1 = r * std::cos(phi), bend = 0.5f * (1 + stretched.z);
    const float p2 = (1 - bend) * std::sqrt(std::max(0.0f, 1 - p1 * p1)) + bend * r * std::sin(phi);
    const glm::vec3 h = p1 * t1 + p2 * t2 + std::sqrt(std::max(0.0f, 1 - p1 * p1 - p2 * p2)) * stretched;
    const glm::vec3 local = glm::normalize(glm::vec3(alpha * h.x, alpha * h.y, std::max(1e-6f, h.z)));
    return local.x * x + local.y * y + local.z * s.normal;
}

// A direction through a microfacet; the mean normal's where light cannot pass.
glm::vec3 bent(const SurfacePoint& s, const glm::vec3& half, float ior)
{
    const glm::vec3 direction = -s.to_viewer;
    glm::vec3 result;
    if (s.layers.thin) {
        // As the lobe of reflection, on the other side.
        const glm::vec3 mirrored = direction - 2 * glm::dot(direction, half) * half;
        result = mirrored - 2 * glm::dot(mirrored, s.normal) * s.normal;
    } else {
        const float ratio = s.front ? 1 / ior : ior;
        const float cosine = glm::dot(half, s.to_viewer);
        const float cos2 = 1 - ratio * ratio * (1 - cosine * cosine);
        if (cos2 < 0) return glm::vec3(0);
        result = ratio * direction + (ratio * cosine - std::sqrt(cos2)) * half;
    }
    if (const float below = glm::dot(result, s.geometric_normal); below >= 0)
        result -= (1e-3f + below) * s.geometric_normal;
    return glm::normalize(result);
}

}   // namespace

SurfacePoint coat_surface(const SurfacePoint& s)
{
    SurfacePoint coat = s;
    coat.normal = s.layers.coat_normal;
    coat.roughness = s.layers.coat_roughness;
    // Fresnel reflection is part of the coverage.
    coat.specular = glm::vec3(1);
    coat.f90 = 1;
    coat.coverage = s.layers.coat;
    coat.diffuse = coat.ambient = coat.emissive = coat.transmitted = glm::vec3(0);
    coat.layered = false;
    coat.layers = {};
    return coat;
}

float coat_fresnel(float cosine)
{
    return schlick(k_coat_f0, cosine);
}

float sheen_albedo(float cosine, float roughness)
{
    return std::min(unlimited_sheen_albedo(cosine, std::max(roughness, k_least_sheen)), 1.0f);
}

glm::vec3 reflect_layers(const SurfacePoint& s, const glm::vec3& to_light)
{
    const LayerPoint& layers = s.layers;
    glm::vec3 result(0);
    if (layers.coat > 0) {
        const float n_l = glm::dot(layers.coat_normal, to_light);
        if (n_l > 0)
            result += glm::vec3(layers.coat *
                                ggx_lobe(layers.coat_normal, s.to_viewer, to_light, layers.coat_roughness) * n_l);
    }
    if (layers.sheen != glm::vec3(0)) {
        const float n_l = glm::dot(s.normal, to_light), n_v = std::max(glm::dot(s.normal, s.to_viewer), 1e-4f);
        const float n_h = std::clamp(glm::dot(s.normal, glm::normalize(to_light + s.to_viewer)), 0.0f, 1.0f);
        const float roughness = std::max(layers.sheen_roughness, k_least_sheen);
        const float limit = std::max(unlimited_sheen_albedo(n_v, roughness), 1.0f);
        if (n_l > 0) result += layers.sheen * (sheen_lobe(n_h, n_v, n_l, roughness) * n_l / limit);
    }
    return result;
}

float anisotropic_lobe(const SurfacePoint& s, const glm::vec3& to_light)
{
    const glm::vec3 across = glm::cross(s.normal, s.layers.grain);
    const glm::vec3 half = glm::normalize(to_light + s.to_viewer);
    const float alpha = std::max(s.roughness * s.roughness, k_min_alpha);
    const float along_alpha = glm::mix(alpha, 1.0f, s.layers.anisotropy * s.layers.anisotropy);
    const auto local = [&](const glm::vec3& v) {
        return glm::vec3(glm::dot(v, s.layers.grain), glm::dot(v, across), glm::dot(v, s.normal));
    };
    const glm::vec3 h = local(half), v = local(s.to_viewer), l = local(to_light);
    const float n_v = std::max(v.z, 1e-4f), n_l = std::max(l.z, 1e-4f), a2 = along_alpha * alpha;
    const glm::vec3 f(alpha * h.x, along_alpha * h.y, a2 * h.z);
    const float w = a2 / glm::dot(f, f);
    const float distribution = a2 * w * w / k_float_pi;
    const float visibility = 0.5f / (n_l * glm::length(glm::vec3(along_alpha * v.x, alpha * v.y, n_v)) +
                                     n_v * glm::length(glm::vec3(along_alpha * l.x, alpha * l.y, n_l)));
    return distribution * visibility;
}

glm::vec3 mirror_normal(const SurfacePoint& s)
{
    if (!(s.layers.anisotropy > 0)) return s.normal;
    // The lobe is wide along the grain, so that the normals that mirror to the viewer lean that way.
    const glm::vec3 across = glm::cross(s.normal, s.layers.grain);
    const glm::vec3 leaning = s.to_viewer - across * glm::dot(across, s.to_viewer);
    const float square = glm::dot(leaning, leaning);
    if (!(square > 0)) return s.normal;
    const float keep = 1 - s.layers.anisotropy * (1 - s.roughness);
    glm::vec3 result = glm::mix(leaning / std::sqrt(square), s.normal, keep * keep * keep * keep);
    result = glm::normalize(result);
    return glm::dot(result, s.to_viewer) > 1e-3f ? result : s.normal;
}

glm::vec3 thin_film_reflectance(const glm::vec3& f0, float cosine, float thin_film_ior, float nanometres)
{
    // A thin film that vanishes is air.
    const float t = std::clamp(nanometres / 0.03f, 0.0f, 1.0f);
    const float thin_film = glm::mix(1.0f, thin_film_ior, t * t * (3 - 2 * t));
    const float sine2 = (1 - cosine * cosine) / (thin_film * thin_film);
    if (sine2 > 1) return glm::vec3(1);
    const float cos_inside = std::sqrt(1 - sine2);

    // Reflectances and phase shifts of the thin film's two sides.
    const float first = schlick(f0_of(thin_film, 1), cosine), through = 1 - first;
    const float first_shift = thin_film < 1 ? 0 : k_float_pi;   // seen from inside
    glm::vec3 second, shift;
    for (int c = 0; c < 3; ++c) {
        const float root = std::sqrt(std::clamp(f0[c], 0.0f, 0.9999f));
        const float base = (1 + root) / (1 - root);
        second[c] = schlick(f0_of(base, thin_film), cos_inside);
        shift[c] = first_shift + (base < thin_film ? k_float_pi : 0);
    }

    // Sum the reflections between them: the constant part, and two harmonics of the path difference.
    const float path = 2 * thin_film * nanometres * cos_inside;
    const glm::vec3 both = glm::clamp(first * second, 1e-5f, 0.9999f), amplitude = glm::sqrt(both);
    const glm::vec3 rest = through * through * second / (glm::vec3(1) - both);
    glm::vec3 result = glm::vec3(first) + rest, harmonic = rest - glm::vec3(through);
    for (int m = 1; m <= 2; ++m) {
        harmonic *= amplitude;
        result += harmonic * (2.0f * sensitivity(static_cast<float>(m) * path, static_cast<float>(m) * shift));
    }
    return glm::clamp(result, 0.0f, 1.0f);
}

void find_transmitted(const SurfacePoint& s, const Continuation& next, bool split, std::vector<TransmittedRay>& rays)
{
    rays.clear();
    if (next.refracted_weight == glm::vec3(0)) return;
    const bool rough = !split && s.roughness > k_sharp_roughness;
    const bool disperses = s.layers.dispersion > 0 && !s.layers.thin;
    if (!rough && !disperses) {
        rays.push_back({next.refracted, glm::vec3(1)});
        return;
    }
    // The index by channel [KHR_materials_dispersion].
    const float half_spread = disperses ? (s.ior - 1) * 0.025f * s.layers.dispersion : 0;
    const int count = rough ? k_rough_rays : 1;
    const float spread = rough ? k_ray_gap * s.roughness * s.roughness / std::sqrt(static_cast<float>(count)) : 0;
    for (int channel = 0; channel < (disperses ? 3 : 1); ++channel) {
        glm::vec3 part(1);
        if (disperses) part = glm::vec3(0), part[channel] = 1;
        if (next.refracted_weight * part == glm::vec3(0)) continue;
        const float ior = s.ior + half_spread * static_cast<float>(channel - 1);
        const std::size_t first = rays.size();
        for (int i = 0; i < count; ++i)
            if (const glm::vec3 direction = bent(s, rough ? microfacet(s, i) : s.normal, ior);
                direction != glm::vec3(0))
                rays.push_back({direction, part, spread});
        if (rays.size() == first) rays.push_back({next.refracted, part, spread});
        // Facets that let no light through leave theirs to the others.
        for (std::size_t r = first; r < rays.size(); ++r) rays[r].part /= static_cast<float>(rays.size() - first);
    }
}

glm::vec3 attenuation(const SurfacePoint& s, float distance)
{
    if (!s.layered || s.front || s.layers.thin || s.layers.absorption == glm::vec3(0)) return glm::vec3(1);
    return glm::exp(-s.layers.absorption * distance);
}

}   // namespace gnomon::shading
