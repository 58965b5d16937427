// SPDX-License-Identifier: Apache-2.0
#include "shadow_textures/lookup.h"

#include <algorithm>
#include <cmath>
#include <optional>

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

namespace {

// The place of a point in a view, in texels.
struct Place {
    glm::vec2 at{0};
    float own = 0;                // distance of the point along the view
    std::optional<float> known;   // the result where no texel is needed
};

Place place_of(const ViewProjection& view, const glm::vec3& point, const glm::vec3& normal)
{
    Place place;
    const glm::vec3 to_light = view.perspective ? view.origin - point : -view.forward;
    const glm::vec4 clip = view.clip_from_world * glm::vec4(point, 1);
    const auto size = static_cast<float>(view.size);
    place.at = (0.5f * glm::vec2(clip.x, clip.y) / clip.w + 0.5f) * size;
    place.own = view.perspective ? clip.w : glm::dot(point - view.origin, view.forward);
    if (glm::dot(normal, to_light) <= 0)
        place.known = 0.0f;
    else if (clip.w <= 0 || !(place.at.x >= 0 && place.at.y >= 0 && place.at.x < size && place.at.y < size))
        place.known = 1.0f;
    return place;
}

// Filters with a box around a place; each texel is weighted by the area that the box covers.
// @param lit  of a texel, within the view
template <class Lit>
float filtered(const glm::vec2& at, float filter, int size, const Lit& lit_at)
{
    const auto lit = [&](int x, int y) { return lit_at(std::clamp(x, 0, size - 1), std::clamp(y, 0, size - 1)); };
    if (filter <= 0) return lit(static_cast<int>(at.x), static_cast<int>(at.y)) ? 1.0f : 0.0f;
    const glm::vec2 low = at - 0.5f * filter, high = at + 0.5f * filter;
    float sum = 0;
    for (int y = static_cast<int>(std::floor(low.y)); static_cast<float>(y) < high.y; ++y)
        for (int x = static_cast<int>(std::floor(low.x)); static_cast<float>(x) < high.x; ++x) {
            const auto fx = static_cast<float>(x), fy = static_cast<float>(y);
            const float cover =
                (std::min(fx + 1, high.x) - std::max(fx, low.x)) * (std::min(fy + 1, high.y) - std::max(fy, low.y));
            if (cover > 0 && lit(x, y)) sum += cover;
        }
    return std::min(sum / (filter * filter), 1.0f);
}

}   // namespace

float visibility(const ViewProjection& view, const SoftwareBuffer& buffer, const glm::vec3& point,
                 const glm::vec3& normal, scene::ObjectId object, const LookupOptions& options)
{
    const Place place = place_of(view, point, normal);
    if (place.known) return *place.known;

    // Compute the width of a texel at the point, and the point's height above the view's origin along the normal.
    const auto size = static_cast<float>(view.size);
    const float own = place.own;
    const float texel = 2 * glm::length(view.across) / size * (view.perspective ? own : 1.0f);
    const float above = glm::dot(normal, point - view.origin);

    // Compare distances at each texel's centre.
    return filtered(place.at, options.filter, view.size, [&](int x, int y) {
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
    });
}

float visibility_as_printed(const ViewProjection& view, const ReceiverTexture& texture, const glm::vec3& point,
                            const glm::vec3& normal, const LookupOptions& options)
{
    const Place place = place_of(view, point, normal);
    if (place.known) return *place.known;
    return filtered(place.at, options.filter, view.size, [&](int x, int y) { return texture.lit(x, y); });
}

}   // namespace gnomon::shadow_textures
