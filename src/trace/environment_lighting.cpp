// SPDX-License-Identifier: Apache-2.0
#include "trace/environment_lighting.h"

#include "base/interruption.h"
#include "shading/glossy.h"
#include "trace/sized_lighting.h"

namespace gnomon::trace {

void EnvironmentTechnique::begin_frame(const FrameContext& frame, std::size_t tiles)
{
    light_.follow(frame.state, frame.rays);
    if (version_ != light_.version() || memories_.size() != tiles) {
        memories_.clear();
        memories_.resize(tiles);
        version_ = light_.version();
    }
    for (environment_light::PointMemory& memory : memories_) memory.begin_frame();
}

std::size_t EnvironmentTechnique::bytes() const
{
    std::size_t bytes = light_.bytes();
    for (const environment_light::PointMemory& memory : memories_) bytes += memory.bytes();
    return bytes;
}

void EnvironmentLighting::light(const PointBatch& batch, std::size_t tile,
                                const std::function<void(const TilePoint&, const glm::vec3&)>& add)
{
    interruption_point();
    asked_.clear();
    for (std::uint32_t p = 0; p < batch.points.size(); ++p) {
        const shading::SurfacePoint& s = batch.points[p].surface;
        if (s.model == scene::ShadingModel::unlit) continue;
        if (s.diffuse == glm::vec3(0) && !shading::has_glossy_lobe(s)) continue;
        asked_.push_back(p);
    }
    if (asked_.empty()) return;
    const environment_light::EnvironmentLight& light = technique_.light();
    light.visibility().find(scratch_, batch.shadow_points, asked_, &technique_.memory(tile), seen_);

    for (std::size_t k = 0; k < asked_.size(); ++k) {
        const TilePoint& point = batch.points[asked_[k]];
        const shading::SurfacePoint& s = point.surface;
        const std::span<const std::uint64_t> seen = seen_.of(k);
        glm::vec3 radiance(0);
        const float highlight = highlight_share(s);
        const glm::vec3 albedo = highlight > 0 ? shading::glossy_albedo(s) : glm::vec3(0);
        if (s.diffuse != glm::vec3(0)) {
            const glm::vec3 irradiance = light.light().irradiance(s.normal, seen);
            if (highlight < 1)
                radiance += (1 - highlight) * shading::reflect_irradiance(s, point.next, glm::vec3(0), irradiance);
            // What the lobe does not reflect reaches the diffuse layer.
            if (highlight > 0)
                radiance += highlight * (glm::vec3(1) - albedo) *
                            shading::reflect_irradiance(s, {}, glm::vec3(0), irradiance);
        }
        const glm::vec3 weight =
            (1 - highlight) * point.next.unresolved_weight + highlight * s.coverage * albedo;
        if (weight != glm::vec3(0))
            radiance += weight * light.light().blurred(point.next.reflected, s.roughness) *
                        light.light().visible_share(point.next.reflected, s.roughness, s.geometric_normal, s.normal,
                                                    seen);
        add(point, radiance);
    }
}

}   // namespace gnomon::trace
