// SPDX-License-Identifier: Apache-2.0
#include "trace/sized_lighting.h"

#include <algorithm>

#include "base/interruption.h"
#include "shading/glossy.h"

namespace gnomon::trace {

namespace {

constexpr float k_sharp_roughness = 0.05f;     // up to here, reflected rays show lights
constexpr float k_blurred_roughness = 0.15f;   // from here on, lobes do

}   // namespace

float highlight_share(const shading::SurfacePoint& s)
{
    if (!shading::has_glossy_lobe(s)) return 0;
    const float t =
        std::clamp((s.roughness - k_sharp_roughness) / (k_blurred_roughness - k_sharp_roughness), 0.0f, 1.0f);
    return t * t * (3 - 2 * t);
}

void SizedLighting::light(const PointBatch& batch, const std::function<void(const TilePoint&, const glm::vec3&)>& add)
{
    visibility_->prepare(batch);
    highlight_.resize(batch.points.size());
    for (std::size_t p = 0; p < batch.points.size(); ++p) highlight_[p] = highlight_share(batch.points[p].surface);

    for (std::uint32_t l = 0; l < lights_.lights().size(); ++l) {
        interruption_point();
        const scene::SizedLight& light = lights_.lights()[l];
        // Find the points that the light reaches if nothing occludes it.
        asked_.clear(), arrives_.clear(), between_.clear();
        for (std::uint32_t p = 0; p < batch.points.size(); ++p) {
            const shading::SurfacePoint& s = batch.points[p].surface;
            const bool lobe = highlight_[p] > 0;
            if (s.model == scene::ShadingModel::unlit || (!lobe && s.diffuse == glm::vec3(0))) continue;
            const shading::UnshadowedLight arrives = shading::unshadowed(s, light, lobe);
            if (arrives.irradiance == glm::vec3(0) && arrives.lobe == glm::vec3(0)) continue;
            if (shading::is_partly_between(s, light)) {
                between_.push_back({p, arrives});
                continue;
            }
            asked_.push_back(p);
            arrives_.push_back(arrives);
        }

        // Find how much of it points see whose smooth horizon lies below that of their triangle.
        for (const Arriving& arriving : between_) {
            const TilePoint& point = batch.points[arriving.point];
            const shading::SurfacePoint& s = point.surface;
            const visibility::ShadowPoint& at = batch.shadow_points[arriving.point];
            const glm::vec3 origin = shading::smooth_origin(rays_.geometry(at.object), at.triangle, at.u, at.v, s);
            between_seen_.find(rays_, s, at.origin, origin, light);
            const float highlight = highlight_[arriving.point];
            const shading::VisibleShare share = shading::visible_share(
                s, light, between_seen_.places(), between_seen_.seen(), shading::SeenBetween::k_whole, highlight > 0);
            shading::UnshadowedLight light_here = arriving.light;
            light_here.irradiance *= share.irradiance, light_here.lobe *= share.lobe;
            if (passing_.any()) {
                const glm::vec3 passes = passing_.from_light(s, origin, light);
                light_here.irradiance *= passes, light_here.lobe *= passes;
            }
            add(point, reflect(point, highlight, light_here));
        }
        if (asked_.empty()) continue;

        // Find how much of it the others see, and reflect that.
        visibility_->find_visible(batch, l, asked_, visible_);
        for (std::size_t k = 0; k < asked_.size(); ++k) {
            if (visible_.answer[k] == SizedVisible::Answer::dark) continue;
            const TilePoint& point = batch.points[asked_[k]];
            const shading::SurfacePoint& s = point.surface;
            const float highlight = highlight_[asked_[k]];
            shading::UnshadowedLight light_here = arrives_[k];
            if (visible_.answer[k] == SizedVisible::Answer::partial) {
                const bool known = visible_.share[k] >= 0;
                if (!known || highlight > 0) {
                    const shading::VisibleShare share = shading::visible_share(
                        s, light, *visible_.places[k], visible_.seen_by(k), SizedVisible::k_whole, highlight > 0);
                    light_here.irradiance *= share.irradiance, light_here.lobe *= share.lobe;
                } else {
                    light_here.irradiance *= visible_.share[k];
                }
            }
            if (passing_.any()) {
                const glm::vec3 passes = passing_.from_light(s, batch.shadow_points[asked_[k]].origin, light);
                light_here.irradiance *= passes, light_here.lobe *= passes;
            }
            add(point, reflect(point, highlight, light_here));
        }
    }
}

glm::vec3 SizedLighting::reflect(const TilePoint& point, float highlight, const shading::UnshadowedLight& light) const
{
    const shading::SurfacePoint& s = point.surface;
    glm::vec3 radiance(0);
    if (highlight < 1)
        radiance += (1 - highlight) * shading::reflect_irradiance(s, point.next, glm::vec3(0), light.irradiance);
    if (highlight > 0) {
        // What the lobe does not reflect reaches the diffuse layer.
        const glm::vec3 below = glm::vec3(1) - shading::glossy_albedo(s);
        radiance +=
            highlight * (light.lobe + below * shading::reflect_irradiance(s, {}, glm::vec3(0), light.irradiance));
    }
    return radiance;
}

}   // namespace gnomon::trace
