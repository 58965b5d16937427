// SPDX-License-Identifier: Apache-2.0
#include "trace/sized_lighting.h"

#include <algorithm>

#include "base/interruption.h"
#include "shading/glossy.h"
#include "shading/layers.h"
#include "shading/lobe_rays.h"

namespace gnomon::trace {

namespace {

constexpr float k_sharp_roughness = 0.05f;     // up to here, reflected rays show lights
constexpr float k_blurred_roughness = 0.15f;   // from here on, lobes do
// Likewise, where rays of the lobe find out what hides an environment image: single ones would be bright dots beside
// what is bright in it.
constexpr float k_sharp_image = 0.02f, k_blurred_image = 0.05f;

// Light of many polygons is summed over places from nearer by where several rays show the mean of what they meet.
constexpr float k_far_of_divided = 1.5f;   // radii

constexpr std::size_t k_simple_places = 16;
constexpr float k_simple_distance = 3;       // of a light's middle, in radii, from which on places sum it up
constexpr float k_simple_roughness = 0.4f;   // of the surface, likewise

// Whether some places of a light do for its brightness at a point, without occlusion, if it turns out to be dim there.
bool is_simple(const shading::SurfacePoint& s, const scene::SizedLight& light, bool lobe, bool coat)
{
    if (coat || (lobe && s.roughness < k_simple_roughness)) return false;
    const glm::vec3 way = light.centre - s.position;
    const float least = k_simple_distance * light.radius;
    if (!(glm::dot(way, way) > least * least)) return false;
    // All of the light is above the horizons.
    return glm::dot(way, s.smooth_normal) > light.radius && glm::dot(way, s.normal) > light.radius;
}

// Rises from 0 to 1 between two roughnesses.
float share_between(float roughness, float from, float to)
{
    const float t = std::clamp((roughness - from) / (to - from), 0.0f, 1.0f);
    return t * t * (3 - 2 * t);
}

}   // namespace

float highlight_share(const shading::SurfacePoint& s)
{
    if (!shading::has_glossy_lobe(s)) return 0;
    return share_between(s.roughness, k_sharp_roughness, k_blurred_roughness);
}

float image_share(const shading::SurfacePoint& s)
{
    const float highlight = highlight_share(s), by_rays = s.layered ? 0 : shading::lobe_share(s);
    if (by_rays == 0) return highlight;
    return glm::mix(highlight, share_between(s.roughness, k_sharp_image, k_blurred_image), by_rays);
}

float coat_highlight_share(const shading::SurfacePoint& s)
{
    return s.layered && s.layers.coat > 0 ? highlight_share(shading::coat_surface(s)) : 0;
}

// What a point reflects of light that reaches it.
glm::vec3 SizedLighting::reflected(const PointBatch& batch, std::uint32_t point, const Arriving& light) const
{
    const shading::SurfacePoint& s = batch.points[point].surface;
    const shading::UnshadowedLight& base = light.base;
    const float highlight = highlight_[point];
    glm::vec3 radiance(0);
    if (highlight < 1)
        radiance +=
            (1 - highlight) * shading::reflect_irradiance(s, batch.points[point].next, glm::vec3(0), base.irradiance);
    if (highlight > 0) {
        // What the lobe does not reflect reaches the diffuse layer.
        const glm::vec3 below = glm::vec3(1) - shading::glossy_albedo(s);
        radiance += highlight * (base.lobe + below * shading::reflect_irradiance(s, {}, glm::vec3(0), base.irradiance));
    }
    return coat_highlight_[point] > 0 ? radiance + coat_highlight_[point] * light.coat : radiance;
}

// What is left of the light of a point that sees some of its places.
// The part of it that lobes reflect.
glm::vec3 SizedLighting::by_lobes(std::uint32_t point, const Arriving& light) const
{
    glm::vec3 radiance(0);
    if (highlight_[point] > 0) radiance += highlight_[point] * light.base.lobe;
    return coat_highlight_[point] > 0 ? radiance + coat_highlight_[point] * light.coat : radiance;
}

SizedLighting::Arriving SizedLighting::seen_of(const PointBatch& batch, const scene::SizedLight& light,
                                               const Asked& asked, std::span<const scene::SizedPlace> places,
                                               std::span<const std::uint8_t> seen, int whole) const
{
    const shading::SurfacePoint& s = batch.points[asked.point].surface;
    Arriving result = asked.arrives;
    const shading::VisibleShare share =
        shading::visible_share(s, light, places, seen, whole, highlight_[asked.point] > 0);
    result.base.irradiance *= share.irradiance, result.base.lobe *= share.lobe;
    if (coat_highlight_[asked.point] > 0)
        result.coat *= shading::visible_share(shading::coat_surface(s), light, places, seen, whole, true).lobe;
    return result;
}

// Adds what a point reflects of the light that it sees.
void SizedLighting::add_seen(const PointBatch& batch, const scene::SizedLight& light, const Asked& asked, Arriving seen,
                             const AddReflected& add)
{
    const TilePoint& point = batch.points[asked.point];
    if (passing_.any()) {
        const glm::vec3 passes = passing_.from_light(point.surface, batch.shadow_points[asked.point].origin, light);
        seen.base.irradiance *= passes, seen.base.lobe *= passes, seen.coat *= passes;
    }
    add(point, reflected(batch, asked.point, seen), by_lobes(asked.point, seen));
}

void SizedLighting::light(const PointBatch& batch, std::span<const float> image, const AddReflected& add)
{
    visibility_->prepare(batch);
    highlight_.resize(batch.points.size());
    coat_highlight_.resize(batch.points.size());
    lobes_.assign(batch.points.size(), std::nullopt);
    coat_lobes_.clear();
    for (std::size_t p = 0; p < batch.points.size(); ++p) {
        const shading::SurfacePoint& s = batch.points[p].surface;
        highlight_[p] = highlight_share(s);
        coat_highlight_[p] = coat_highlight_share(s);
        if (highlight_[p] > 0) lobes_[p].emplace(s);
        if (coat_highlight_[p] == 0) continue;
        coat_lobes_.resize(batch.points.size());
        coat_lobes_[p].emplace(shading::coat_surface(s));
    }

    for (std::uint32_t l = 0; l < lights_.lights().size(); ++l) {
        interruption_point();
        const scene::SizedLight& light = lights_.lights()[l];
        // Find the points that the light reaches if nothing occludes it.
        fine_.clear(), dim_.clear(), between_.clear(), points_.clear(), few_.clear();
        for (std::uint32_t p = 0; p < batch.points.size(); ++p) {
            const TilePoint& point = batch.points[p];
            const shading::SurfacePoint& s = point.surface;
            const bool lobe = highlight_[p] > 0, coat = coat_highlight_[p] > 0;
            if (s.model == scene::ShadingModel::unlit || (!lobe && !coat && s.diffuse == glm::vec3(0))) continue;
            Arriving arrives;
            std::size_t few = 0;
            // Of a dim light, the places to which rays go say how bright it is.
            if (!image.empty() && image[p] > 0 && is_simple(s, light, lobe, coat)) {
                arrives.base = shading::unshadowed_by_places(s, light, few_.some(l, k_simple_places), lobe);
                if (arrives.any())
                    few =
                        few_.count(l, point, luminance(reflected(batch, p, arrives)), image[p], batch.share_of(point));
            }
            if (few == 0 || few > k_simple_places) {
                const bool divided = point.parts > 1 || point.lobe.rays > 1;
                shading::PolygonLightOptions options;
                options.coarse = divided;
                if (divided && light.tree.nodes.empty()) options.far = k_far_of_divided;
                arrives = {shading::unshadowed(s, light, lobe ? &*lobes_[p] : nullptr, options)};
                if (coat)
                    arrives.coat = shading::unshadowed(shading::coat_surface(s), light, &*coat_lobes_[p], options).lobe;
                if (!arrives.any()) continue;
                few = image.empty() ? 0
                                    : few_.count(l, point, luminance(reflected(batch, p, arrives)), image[p],
                                                 batch.share_of(point));
            }
            if (few > 0) {
                dim_.push_back({p, arrives});
                few_.push(l, few, p, batch);
            } else if (shading::is_partly_between(s, light)) {
                between_.push_back({p, arrives});
            } else {
                fine_.push_back({p, arrives});
                points_.push_back(p);
            }
        }

        // Find how much of it they see, and reflect that.
        if (!fine_.empty()) visibility_->find_visible(batch, l, points_, visible_);
        for (std::size_t k = 0; k < fine_.size(); ++k) {
            if (visible_.answer[k] == SizedVisible::Answer::dark) continue;
            Arriving light_here = fine_[k].arrives;
            const bool lobe = highlight_[fine_[k].point] > 0 || coat_highlight_[fine_[k].point] > 0;
            if (visible_.answer[k] == SizedVisible::Answer::partial) {
                const bool known = visible_.share[k] >= 0;
                if (!known || lobe)
                    light_here = seen_of(batch, light, fine_[k], *visible_.places[k], visible_.seen_by(k),
                                         SizedVisible::k_whole);
                else
                    light_here.base.irradiance *= visible_.share[k];
            }
            add_seen(batch, light, fine_[k], light_here, add);
        }
        for (const Asked& asked : between_) {
            const shading::SurfacePoint& s = batch.points[asked.point].surface;
            const visibility::ShadowPoint& at = batch.shadow_points[asked.point];
            between_seen_.find(rays_, s, at.origin,
                               shading::smooth_origin(rays_.geometry(at.object), at.triangle, at.u, at.v, s), light);
            add_seen(batch, light, asked,
                     seen_of(batch, light, asked, between_seen_.places(), between_seen_.seen(),
                             shading::SeenBetween::k_whole),
                     add);
        }
        few_.trace();
        for (std::size_t k = 0; k < dim_.size(); ++k) {
            const Arriving light_here = seen_of(batch, light, dim_[k], few_.places(k), few_.seen(k), 1);
            if (light_here.any()) add_seen(batch, light, dim_[k], light_here, add);
        }
    }
}

}   // namespace gnomon::trace
