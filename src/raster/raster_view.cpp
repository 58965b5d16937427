// SPDX-License-Identifier: Apache-2.0
#include "raster/raster_view.h"

#include <algorithm>
#include <cmath>

#include "scene/environment.h"

namespace gnomon::raster {

namespace {

constexpr float k_nearest = 1e-6f;   // scene units: where a perspective view without a near plane begins

}   // namespace

void frustum_planes(const scene::View& view, glm::vec4 (&planes)[6])
{
    // In units of the half extent: x is inside where |x - shift * reach| <= reach, and reach grows with distance or
    // is 1.
    const glm::vec3 x = view.right / glm::dot(view.right, view.right) - view.skew.x * view.forward;
    const glm::vec3 y = view.up / glm::dot(view.up, view.up) - view.skew.y * view.forward;
    const glm::vec3 reach = view.orthographic ? glm::vec3(0) : view.forward;
    const float constant = view.orthographic ? 1.0f : 0.0f;
    const auto plane = [&](const glm::vec3& n, float at_eye) { return glm::vec4(n, at_eye - glm::dot(n, view.eye)); };
    planes[0] = plane((1.0f - view.shift.x) * reach + x, (1.0f - view.shift.x) * constant);
    planes[1] = plane((1.0f + view.shift.x) * reach - x, (1.0f + view.shift.x) * constant);
    planes[2] = plane((1.0f - view.shift.y) * reach + y, (1.0f - view.shift.y) * constant);
    planes[3] = plane((1.0f + view.shift.y) * reach - y, (1.0f + view.shift.y) * constant);
    planes[4] = plane(view.forward, -view.near);
    planes[5] = std::isfinite(view.far) ? plane(-view.forward, view.far) : glm::vec4(0, 0, 0, 1);
}

shared::DrawPush draw_push(const scene::View& view, const glm::vec2& sample, float unlimited_far)
{
    const glm::vec3 x = view.right / glm::dot(view.right, view.right) - view.skew.x * view.forward;
    const glm::vec3 y = view.skew.y * view.forward - view.up / glm::dot(view.up, view.up);
    glm::vec4 rows[4] = {glm::vec4(x, 0), glm::vec4(y, 0), glm::vec4(0), glm::vec4(view.forward, 0)};
    if (view.orthographic) {
        const float far = std::isfinite(view.far) ? view.far : unlimited_far;
        rows[2] = glm::vec4(-view.forward, far) / (far - view.near);
        rows[3] = glm::vec4(0, 0, 0, 1);
    } else {
        const float near = std::max(view.near, k_nearest);
        rows[2] = std::isfinite(view.far) ? near / (view.far - near) * glm::vec4(-view.forward, view.far)
                                          : glm::vec4(0, 0, 0, near);
    }
    // Move the image against the lens shift, and against the sample's place in the pixel.
    rows[0] -= view.shift.x * rows[3];
    rows[1] += view.shift.y * rows[3];
    const glm::vec2 move = -2.0f * (sample - 0.5f) / glm::vec2(view.size.width, view.size.height);
    rows[0] += move.x * rows[3];
    rows[1] += move.y * rows[3];
    shared::DrawPush push{};
    push.clip_from_offset = glm::transpose(glm::mat4(rows[0], rows[1], rows[2], rows[3]));
    push.eye = view.eye;
    return push;
}

// The irradiance of a level surface by what lies beyond the scene, as rasterised frames light by it. 0 before one
// colour, unless that is not seen.
static glm::vec3 open_irradiance(const scene::Scene& scene, bool apart, const SurroundingLight* surroundings)
{
    const bool has_image = surroundings && surroundings->has_image();
    glm::vec3 sum(0);
    if (!apart && scene.background.kind == scene::Background::Kind::color) return sum;
    if (scene.background.kind == scene::Background::Kind::sky)
        sum += static_cast<float>(k_pi) * scene.background.ambient({0, 1, 0});
    if (has_image) sum += surroundings->open_irradiance({0, 1, 0});
    for (const scene::Light& light : scene.lights) {
        if (light.type != scene::LightType::directional || (has_image && light.of_environment)) continue;
        const glm::dvec3 back(scene.world_matrix(light.node, scene.timeline.start)[2]);
        sum += light.color * static_cast<float>(std::max(0.0, glm::normalize(back).y));
    }
    return sum;
}

shared::RasterFrame frame_constants(const scene::Scene& scene, const scene::View& view, bool stand_in, bool further,
                                    bool apart, const SurroundingLight* surroundings)
{
    const scene::Background& background = scene.background;
    shared::RasterFrame f{};
    f.eye = view.eye;
    f.orthographic = view.orthographic ? 1 : 0;
    f.right = view.right, f.up = view.up, f.forward = view.forward;
    f.shift = view.shift;
    f.width = static_cast<std::uint32_t>(view.size.width);
    f.height = static_cast<std::uint32_t>(view.size.height);
    f.pixel_spread = view.pixel_spread;
    f.pixel_width = view.pixel_width;
    f.background = static_cast<std::uint32_t>(background.kind);
    f.background_color = background.color;
    if (background.kind == scene::Background::Kind::sky && !further) f.background_color = glm::vec3(0);
    f.zenith = background.zenith, f.horizon = background.horizon, f.ground = background.ground;
    f.sun_direction = background.sun_direction, f.sun_radiance = background.sun_radiance;
    f.ambient = scene.ambient;
    f.stand_in = stand_in ? 1 : 0;
    f.open_irradiance = open_irradiance(scene, apart, surroundings);
    f.surroundings_apart = surroundings && surroundings->has_image() ? 1 : 0;
    f.backdrop_apart = apart ? 1 : 0;
    if (background.kind == scene::Background::Kind::image) {
        f.environment_width = static_cast<std::uint32_t>(background.environment->image().width);
        f.environment_height = static_cast<std::uint32_t>(background.environment->image().height);
        std::copy(background.environment->harmonics().begin(), background.environment->harmonics().end(), f.harmonics);
    }
    return f;
}

}   // namespace gnomon::raster
