// SPDX-License-Identifier: Apache-2.0
#include "shading/polygon_light.h"

#include <algorithm>
#include <optional>

#include "ray/origin.h"
#include "shading/glossy.h"
#include "shading/transformed_cosines.h"

namespace gnomon::shading {

namespace {

// A polygon relative to the point: at most four corners, each plane that clips it adds one.
struct Clipped {
    std::array<glm::dvec3, 8> corner;
    int count = 0;
};

// Keeps the part of a convex polygon on the inner side of a plane through the origin.
Clipped clip(const Clipped& from, const glm::dvec3& normal)
{
    Clipped to;
    for (int i = 0; i < from.count; ++i) {
        const glm::dvec3& a = from.corner[static_cast<std::size_t>(i)];
        const glm::dvec3& b = from.corner[static_cast<std::size_t>((i + 1) % from.count)];
        const double at_a = glm::dot(normal, a), at_b = glm::dot(normal, b);
        if (at_a >= 0) to.corner[static_cast<std::size_t>(to.count++)] = a;
        if ((at_a < 0) != (at_b < 0))
            to.corner[static_cast<std::size_t>(to.count++)] = a + (at_a / (at_a - at_b)) * (b - a);
    }
    return to;
}

// atan(t) / t by its series. @param z  t squared, up to .04
double arc_tangent_ratio(double z)
{
    if (z < 0.0025) return 1 - z * (1 / 3.0 - z * (1 / 5.0 - z * (1 / 7.0 - z * (1 / 9.0 - z * (1 / 11.0)))));
    double sum = 1 / 21.0;
    for (const double term :
         {1 / 19.0, 1 / 17.0, 1 / 15.0, 1 / 13.0, 1 / 11.0, 1 / 9.0, 1 / 7.0, 1 / 5.0, 1 / 3.0, 1.0})
        sum = term - z * sum;
    return sum;
}

// The angle between two directions over its sine times their lengths, from the square of that product, their scalar
// product and the product of their lengths. By the tangent of half the angle, which is halved until its series is
// short: many times as fast as an arc tangent that is right to the last bit.
double angle_over_sine(double sine2, double dot, double lengths)
{
    constexpr double k_short = 0.04;      // square of the tangent up to which the series is
    constexpr double k_straight = 1e-9;   // of the angle to a straight one, for which the tangent is too large
    const double adjacent = lengths + dot;
    if (!(adjacent > k_straight * lengths)) {
        const double sine = std::sqrt(sine2);
        return std::atan2(sine, dot) / sine;
    }
    const double inverse = 1 / adjacent;
    double z = sine2 * inverse * inverse;
    if (z <= k_short) return 2 * inverse * arc_tangent_ratio(z);
    double t = std::sqrt(z), factor = 2;
    while (z > k_short) t /= 1 + std::sqrt(1 + z), z = t * t, factor *= 2;
    return factor * t * arc_tangent_ratio(z) / std::sqrt(sine2);
}

// The form factor of a polygon above the horizon of `normal`, up to its sign: Lambert's sum over the edges.
double form_factor(const Clipped& polygon, const glm::dvec3& normal)
{
    std::array<double, 8> square;
    for (std::size_t i = 0; i < static_cast<std::size_t>(polygon.count); ++i)
        square[i] = glm::dot(polygon.corner[i], polygon.corner[i]);
    double sum = 0;
    for (int i = 0; i < polygon.count; ++i) {
        const auto from = static_cast<std::size_t>(i), to = static_cast<std::size_t>((i + 1) % polygon.count);
        const glm::dvec3 &a = polygon.corner[from], &b = polygon.corner[to];
        const glm::dvec3 cross = glm::cross(a, b);
        const double sine2 = glm::dot(cross, cross);
        if (sine2 > 0)
            sum +=
                angle_over_sine(sine2, glm::dot(a, b), std::sqrt(square[from] * square[to])) * glm::dot(normal, cross);
    }
    return std::abs(sum) / (2 * k_pi);
}

Clipped transformed(const Clipped& from, const glm::dmat3& matrix)
{
    Clipped to;
    to.count = from.count;
    for (int i = 0; i < from.count; ++i)
        to.corner[static_cast<std::size_t>(i)] = matrix * from.corner[static_cast<std::size_t>(i)];
    return to;
}

// What microfacets reflect from a direction of any length to the viewer [Schlick 1994].
glm::dvec3 reflectance(const PolygonLobe& lobe, const glm::dvec3& direction)
{
    // The cosine between the viewer and the normal that mirrors the direction.
    const double cosine = glm::dot(glm::dvec3(lobe.to_viewer), direction) / glm::length(direction);
    const double away = 1 - std::sqrt(std::clamp(0.5 * (1 + cosine), 0.0, 1.0)), square = away * away;
    const glm::dvec3 f0(lobe.f0);
    return f0 + (glm::dvec3(static_cast<double>(lobe.f90)) - f0) * (square * square * away);
}

// Lambert's sum as a vector: its part along the normal is the form factor, and it leads to the middle of what a cosine
// sees of the polygon.
glm::dvec3 form_vector(const Clipped& polygon)
{
    glm::dvec3 sum(0);
    for (int i = 0; i < polygon.count; ++i) {
        const glm::dvec3 &a = polygon.corner[static_cast<std::size_t>(i)],
                         &b = polygon.corner[static_cast<std::size_t>((i + 1) % polygon.count)];
        const glm::dvec3 cross = glm::cross(a, b);
        const double sine2 = glm::dot(cross, cross);
        if (sine2 > 0)
            sum += angle_over_sine(sine2, glm::dot(a, b), std::sqrt(glm::dot(a, a) * glm::dot(b, b))) * cross;
    }
    return sum * (1 / (2 * k_pi));
}

// What a lobe sees of a polygon, times its reflectance there by its mean.
glm::dvec3 share_of(const PolygonLobe& lobe, const Clipped& polygon)
{
    constexpr glm::dvec3 up(0, 0, 1);
    const glm::dvec3 form = form_vector(clip(transformed(polygon, lobe.to_cosine), up));
    const double share = std::min(1.0, lobe.scale * std::abs(form.z));
    if (!(share > 0)) return glm::dvec3(0);
    return share * lobe.by_mean(lobe.from_cosine * (form.z < 0 ? -form : form), share);
}

// Whether a face emits towards a point: the point is in front of it (or behind a two-sided one), and farther from its
// plane than rounding may put a point of the face itself.
bool emits_towards(const SurfacePoint& s, const scene::SizedFace& face)
{
    const float height = glm::dot(face.normal, s.position - face.corner[0]);
    float largest = 0;
    for (const glm::vec3& p : face.corner) largest = std::max({largest, std::abs(p.x), std::abs(p.y), std::abs(p.z)});
    const float least = std::max(s.offset, ray::k_lift_per_coordinate * largest);
    return face.two_sided ? std::abs(height) > least : height > least;
}

Clipped seen_from(const glm::vec3& position, const glm::vec3* corner, int count)
{
    Clipped result;
    result.count = count;
    for (int i = 0; i < count; ++i)
        result.corner[static_cast<std::size_t>(i)] = glm::dvec3(corner[i]) - glm::dvec3(position);
    return result;
}

// Clips at both horizons. Returns false if nothing is left.
bool clip_at_horizons(const SurfacePoint& s, Clipped& polygon)
{
    polygon = clip(polygon, glm::dvec3(s.smooth_normal));
    if (polygon.count < 3) return false;
    if (s.normal != s.smooth_normal) polygon = clip(polygon, glm::dvec3(s.normal));
    return polygon.count >= 3;
}

// Adds up what the parts of faces give.
class Sum {
 public:
    Sum(const SurfacePoint& s, const PolygonLobe* lobe) : s_(s), lobe_(lobe) {}
    void add(Clipped polygon, const glm::vec3& radiance)
    {
        if (radiance == glm::vec3(0) || !clip_at_horizons(s_, polygon)) return;
        irradiance_ += k_pi * form_factor(polygon, glm::dvec3(s_.normal)) * glm::dvec3(radiance);
        if (lobe_) reflected_ += share_of(*lobe_, polygon) * glm::dvec3(radiance);
    }
    // Adds a group of faces as a small disc, if that is what it is from here. Returns false if it must be opened.
    bool add(const scene::FaceNode& group, bool coarse)
    {
        const bool last = coarse && group.count > 0;   // do with the group, unless the point touches it
        if (group.normal_spread > (coarse ? k_coarse_spread : k_spread) && !last) return false;
        const float far = last ? 3 : coarse ? k_coarse_far : k_far;

        // Find the side from which all of it is seen.
        const glm::vec3 way = group.centre - s_.position;
        const float square = glm::dot(way, way), distance = std::sqrt(square);
        const float emitted = -glm::dot(group.normal, way);
        const float turned = distance * group.normal_spread + group.radius;
        if (last && !(distance > far * group.radius)) return false;
        if (emitted < (last ? 0 : -turned) && !group.two_sided) return true;
        if (!(std::abs(emitted) > turned) && !last) return false;

        // Compare it with both horizons.
        const float above = glm::dot(way, s_.normal), least_above = std::min(above, glm::dot(way, s_.smooth_normal));
        if (least_above < (last ? 0 : -group.radius)) return true;
        if (!(least_above > group.radius) && !last) return false;
        if (!(distance > far * group.radius)) return false;

        // Sum it up: from nearby, a disc subtends less than its area over the square of its distance.
        const glm::dvec3 radiance = glm::dvec3(group.power) / static_cast<double>(group.area);
        double lobe = 0;
        if (lobe_) {
            const auto radius = static_cast<double>(group.radius);
            const glm::dvec3 there = lobe_->to_cosine * glm::dvec3(way);
            const double there_square = glm::dot(there, there);
            if (!last) {
                const double least = static_cast<double>(far) * radius * lobe_->stretch;
                if (!(there_square > least * least && std::abs(there.z) > radius * lobe_->rise)) return false;
            }
            if (there.z > 0) {
                const glm::dvec3 area =
                    lobe_->areas_to_cosine * (static_cast<double>(group.area) * glm::dvec3(group.normal));
                lobe = lobe_->scale * std::abs(glm::dot(area, there)) * there.z /
                       (there_square * (k_pi * there_square + glm::length(area)));
            }
        }
        const float factor =
            std::abs(emitted) * group.area * above / (square * (square + group.area / static_cast<float>(k_pi)));
        irradiance_ += static_cast<double>(factor) * radiance;
        if (lobe > 0)
            reflected_ += std::min(1.0, lobe) * lobe_->by_mean(glm::dvec3(way), std::min(1.0, lobe)) * radiance;
        return true;
    }
    UnshadowedLight result() const
    {
        UnshadowedLight light;
        light.irradiance = glm::vec3(irradiance_);
        if (lobe_) light.lobe = lobe_->albedo * glm::vec3(reflected_);
        return light;
    }

 private:
    // Groups may have normals that differ by that much, and must be farther away than that many radii of their own.
    static constexpr float k_spread = 0.25f, k_coarse_spread = 0.5f;
    static constexpr float k_far = 4, k_coarse_far = 2;

    const SurfacePoint& s_;
    const PolygonLobe* lobe_;
    glm::dvec3 irradiance_{0}, reflected_{0};
};

// What the places of a light bring to a point, one by one.
class PlaceWeights {
 public:
    /// @param cone  whether the light's cone counts
    PlaceWeights(const SurfacePoint& s, const scene::SizedLight& light, bool lobe, float least_roughness,
                 bool cone = true)
        : s_(s), light_(light), lobe_(lobe), cone_(cone && light.cone.limits())
    {
        if (lobe_ && s.roughness < least_roughness) widened_ = s, widened_->roughness = least_roughness;
    }
    /// @return  false if the place brings nothing
    bool at(const scene::SizedPlace& place, glm::vec3& irradiance, glm::vec3& lobe) const
    {
        const glm::vec3 to_place = place.position - s_.position;
        const float square = glm::dot(to_place, to_place);
        if (!(square > 0)) return false;
        const glm::vec3 direction = to_place / std::sqrt(square);
        const float cosine = glm::dot(direction, s_.normal);
        if (!(cosine > 0) || !(glm::dot(direction, s_.smooth_normal) > 0)) return false;
        const scene::SizedFace& face = light_.faces[place.face];
        const float emitted = -glm::dot(direction, face.normal);
        if (!(face.two_sided ? std::abs(emitted) > 0 : emitted > 0)) return false;
        const float share = cone_ ? light_.cone.share(-direction) : 1;
        if (!(share > 0)) return false;
        const glm::vec3 radiance = place.radiance * (share * (std::abs(emitted) * place.area / square));
        irradiance = radiance * cosine;
        if (lobe_) lobe = radiance * reflect_glossy(widened_ ? *widened_ : s_, direction);
        return true;
    }

 private:
    const SurfacePoint& s_;
    const scene::SizedLight& light_;
    bool lobe_, cone_;
    std::optional<SurfacePoint> widened_;
};

glm::vec3 ratio(const glm::dvec3& part, const glm::dvec3& whole)
{
    glm::vec3 result(0);
    for (int i = 0; i < 3; ++i)
        if (whole[i] > 0) result[i] = static_cast<float>(std::min(part[i] / whole[i], 1.0));
    return result;
}

UnshadowedLight sum_of_places(const PlaceWeights& weights, std::span<const scene::SizedPlace> places)
{
    UnshadowedLight sum;
    glm::vec3 irradiance(0), reflected(0);
    for (const scene::SizedPlace& place : places)
        if (weights.at(place, irradiance, reflected)) sum.irradiance += irradiance, sum.lobe += reflected;
    return sum;
}

// How much of what a light without its cone would bring to a point it brings with it.
VisibleShare share_of_cone(const SurfacePoint& s, const scene::SizedLight& light, bool lobe,
                           const PolygonLightOptions& options)
{
    const UnshadowedLight part = sum_of_places(PlaceWeights(s, light, lobe, options.least_roughness), light.places),
                          whole =
                              sum_of_places(PlaceWeights(s, light, lobe, options.least_roughness, false), light.places);
    return {ratio(glm::dvec3(part.irradiance), glm::dvec3(whole.irradiance)),
            ratio(glm::dvec3(part.lobe), glm::dvec3(whole.lobe))};
}

// Light that reaches a point if nothing occludes it, and as if the light had no cone.
UnshadowedLight without_cone(const SurfacePoint& s, const scene::SizedLight& light, const PolygonLobe* lobe,
                             const PolygonLightOptions& options, const glm::vec3& to_centre)
{
    // Sum a distant light of many polygons over its places.
    const std::size_t polygons = std::max(light.faces.size(), light.cell_radiance.size());
    if (!(options.coarse && !light.tree.nodes.empty()) && polygons > light.places.size() &&
        glm::length(to_centre) > options.far * light.radius) {
        return sum_of_places(PlaceWeights(s, light, lobe != nullptr, 0, false), light.places);
    }

    // Sum up the faces of a light that has many of them by groups.
    if (!light.tree.nodes.empty()) {
        Sum sum(s, lobe);
        for (std::size_t n = 0; n < light.tree.nodes.size();) {
            const scene::FaceNode& node = light.tree.nodes[n];
            const bool added = sum.add(node, options.coarse);
            n = added || node.count > 0 ? node.next : n + 1;
            if (added) continue;
            for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
                const scene::SizedFace& face = light.faces[light.tree.order[i]];
                if (emits_towards(s, face))
                    sum.add(seen_from(s.position, face.corner.data(), face.corners), face.radiance);
            }
        }
        return sum.result();
    }

    std::optional<Sum> sum;
    for (const scene::SizedFace& face : light.faces) {
        if (!emits_towards(s, face)) continue;
        if (!sum) sum.emplace(s, lobe);
        if (light.cell_radiance.empty()) {
            sum->add(seen_from(s.position, face.corner.data(), face.corners), face.radiance);
            continue;
        }
        const float size = 1 / static_cast<float>(light.cells);
        for (int j = 0; j < light.cells; ++j)
            for (int i = 0; i < light.cells; ++i) {
                const float u = static_cast<float>(i) * size, v = static_cast<float>(j) * size;
                const glm::vec3 corner[4] = {face.at(u, v), face.at(u + size, v), face.at(u + size, v + size),
                                             face.at(u, v + size)};
                sum->add(seen_from(s.position, corner, 4),
                         light.cell_radiance[static_cast<std::size_t>(j) * static_cast<std::size_t>(light.cells) +
                                             static_cast<std::size_t>(i)]);
            }
    }
    return sum ? sum->result() : UnshadowedLight{};
}

}   // namespace

PolygonLobe::PolygonLobe(const SurfacePoint& s)
{
    const glm::dvec3 z(s.normal), view(s.to_viewer);
    const double n_v = glm::dot(z, view);
    glm::dvec3 x = view - n_v * z;
    const double length = glm::length(x);
    if (length > 1e-6) {
        x /= length;
    } else {
        glm::vec3 any, other;
        make_basis(s.normal, any, other);
        x = glm::normalize(glm::dvec3(any) - glm::dot(glm::dvec3(any), z) * z);
    }
    const TransformedCosine cosine = transformed_cosine(static_cast<float>(n_v), s.roughness);
    to_cosine = cosine.to_cosine * glm::transpose(glm::dmat3(x, glm::cross(z, x), z));
    areas_to_cosine = {glm::cross(to_cosine[1], to_cosine[2]), glm::cross(to_cosine[2], to_cosine[0]),
                       glm::cross(to_cosine[0], to_cosine[1])};
    stretch = std::sqrt(glm::dot(to_cosine[0], to_cosine[0]) + glm::dot(to_cosine[1], to_cosine[1]) +
                        glm::dot(to_cosine[2], to_cosine[2]));
    rise = glm::length(glm::dvec3(to_cosine[0].z, to_cosine[1].z, to_cosine[2].z));
    scale = cosine.scale;
    albedo = glossy_albedo(s) * s.coverage;
    from_cosine = glm::inverse(to_cosine);
    to_viewer = s.to_viewer, f0 = s.specular, f90 = s.f90;
    mean = glm::dvec3(mean_reflectance(s));
}

glm::dvec3 PolygonLobe::by_mean(const glm::dvec3& direction, double share) const
{
    const glm::dvec3 there = glm::mix(reflectance(*this, direction), mean, share * share);
    glm::dvec3 result(1);
    for (int c = 0; c < 3; ++c)
        if (mean[c] > 0) result[c] = there[c] / mean[c];
    return result;
}

UnshadowedLight unshadowed(const SurfacePoint& s, const scene::SizedLight& light, bool lobe,
                           const PolygonLightOptions& options)
{
    if (!lobe) return unshadowed(s, light, nullptr, options);
    const PolygonLobe own(s);
    return unshadowed(s, light, &own, options);
}

UnshadowedLight unshadowed(const SurfacePoint& s, const scene::SizedLight& light, const PolygonLobe* lobe,
                           const PolygonLightOptions& options)
{
    // Nothing of a light behind the horizon arrives.
    const glm::vec3 to_centre = light.centre - s.position;
    if (glm::dot(to_centre, s.smooth_normal) < -light.radius || glm::dot(to_centre, s.normal) < -light.radius)
        return {};
    // Of a light with a cone, find by its places how much of what it would bring without it leaves toward the point.
    if (light.cone.limits()) {
        const VisibleShare share = share_of_cone(s, light, lobe != nullptr, options);
        if (share.irradiance == glm::vec3(0) && share.lobe == glm::vec3(0)) return {};
        UnshadowedLight result = without_cone(s, light, lobe, options, to_centre);
        result.irradiance *= share.irradiance, result.lobe *= share.lobe;
        return result;
    }
    return without_cone(s, light, lobe, options, to_centre);
}

UnshadowedLight unshadowed_by_places(const SurfacePoint& s, const scene::SizedLight& light,
                                     std::span<const scene::SizedPlace> places, bool lobe)
{
    return sum_of_places(PlaceWeights(s, light, lobe, 0), places);
}

VisibleShare visible_share(const SurfacePoint& s, const scene::SizedLight& light,
                           std::span<const scene::SizedPlace> places, std::span<const std::uint8_t> seen, int whole,
                           bool lobe, const PolygonLightOptions& options)
{
    const PlaceWeights weights(s, light, lobe, options.least_roughness);
    glm::dvec3 part[2]{}, all[2]{};
    for (std::size_t i = 0; i < places.size(); ++i) {
        glm::vec3 irradiance(0), reflected(0);
        if (!weights.at(places[i], irradiance, reflected)) continue;
        all[0] += glm::dvec3(irradiance), all[1] += glm::dvec3(reflected);
        if (seen[i] == 0) continue;
        const double share = static_cast<double>(seen[i]) / whole;
        part[0] += share * glm::dvec3(irradiance), part[1] += share * glm::dvec3(reflected);
    }
    return {ratio(part[0], all[0]), ratio(part[1], all[1])};
}

}   // namespace gnomon::shading
