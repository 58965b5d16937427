// SPDX-License-Identifier: Apache-2.0
#include "shadow_textures/lookup.h"

namespace gnomon::shadow_textures {

using light_views::LightView;
using light_views::SoftwareBuffer;
using light_views::ViewProjection;

const LightView* view_of(std::span<const LightView> views, const glm::vec3& point, int border)
{
    if (views.size() == 1) return &views[0];
    if (views.size() == 2) {
        const ViewProjection& dense = views[0].projection;
        const glm::vec4 clip = dense.clip_from_world * glm::vec4(point, 1);
        const float inside = 1 - 2 * static_cast<float>(border) / static_cast<float>(dense.size);
        return &views[std::abs(clip.x) <= inside && std::abs(clip.y) <= inside ? 0 : 1];
    }
    const glm::vec3 d = point - views[0].projection.origin, size = glm::abs(d);
    const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    const int face = 2 * axis + (d[axis] < 0);
    return &views[static_cast<std::size_t>(face)];
}

float visibility(const ViewProjection& view, const SoftwareBuffer& buffer, const glm::vec3& point,
                 const glm::vec3& normal, scene::ObjectId object, const LookupOptions& options)
{
    const glm::vec3 to_light = view.perspective ? view.origin - point : -view.forward;
    if (glm::dot(normal, to_light) <= 0) return 0;
    const glm::vec4 clip = view.clip_from_world * glm::vec4(point, 1);
    if (clip.w <= 0) return 1;
    const auto size = static_cast<float>(view.size);
    const glm::vec2 at = (0.5f * glm::vec2(clip.x, clip.y) / clip.w + 0.5f) * size;
    if (!(at.x >= 0 && at.y >= 0 && at.x < size && at.y < size)) return 1;

    const float own = view.perspective ? clip.w : glm::dot(point - view.origin, view.forward);
    // Compute the width of a texel at the point, and the point's height above the view's origin along the normal.
    const float texel = 2 * glm::length(view.across) / size * (view.perspective ? own : 1.0f);
    const float above = glm::dot(normal, point - view.origin);

    // Returns whether the receiver is lit at a texel's centre.
    const auto lit = [&](int x, int y) {
        x = std::clamp(x, 0, view.size - 1), y = std::clamp(y, 0, view.size - 1);
        const std::size_t i = buffer.at(x, y);
        const float nearest = view.distance_of(buffer.depth[i]);
        const float cx = 2 * (static_cast<float>(x) + 0.5f) / size - 1,
                    cy = 2 * (static_cast<float>(y) + 0.5f) / size - 1;
        const glm::vec3 offset = cx * view.across + cy * view.down;
        const glm::vec3 ray = view.perspective ? view.forward + offset : view.forward;
        const float plane = (above - (view.perspective ? 0 : glm::dot(normal, offset))) / glm::dot(normal, ray);
        const float here = plane > 0 && plane < own ? plane : own;
        const float margin = texel * (buffer.item[i] == object + 1 ? options.self_margin : options.other_margin);
        return nearest >= here - margin;
    };
    if (options.filter <= 0) return lit(static_cast<int>(at.x), static_cast<int>(at.y)) ? 1.0f : 0.0f;

    // Filter with a box around the point; each texel is weighted by the area that the box covers.
    const glm::vec2 low = at - 0.5f * options.filter, high = at + 0.5f * options.filter;
    float sum = 0;
    for (int y = static_cast<int>(std::floor(low.y)); static_cast<float>(y) < high.y; ++y)
        for (int x = static_cast<int>(std::floor(low.x)); static_cast<float>(x) < high.x; ++x) {
            const auto fx = static_cast<float>(x), fy = static_cast<float>(y);
            const float cover =
                (std::min(fx + 1, high.x) - std::max(fx, low.x)) * (std::min(fy + 1, high.y) - std::max(fy, low.y));
            if (cover > 0 && lit(x, y)) sum += cover;
        }
    return std::min(sum / (options.filter * options.filter), 1.0f);
}

}   // namespace gnomon::shadow_textures
