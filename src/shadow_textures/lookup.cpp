// SPDX-License-Identifier: Apache-2.0
#include "shadow_textures/lookup.h"

#include <algorithm>
#include <cmath>

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
    const glm::vec3 d = point - views[0].projection.origin;
    if (views.size() == 5) {
        // Half of a cube: the top, then +s -s +t -t (light_views/projection.h).
        const ViewProjection& top = views[0].projection;
        const float s = glm::dot(d, glm::normalize(top.across)), t = glm::dot(d, glm::normalize(top.down));
        if (std::max(std::abs(s), std::abs(t)) <= glm::dot(d, top.forward)) return &views[0];
        return &views[std::abs(s) >= std::abs(t) ? (s >= 0 ? 1 : 2) : (t >= 0 ? 3 : 4)];
    }
    const glm::vec3 size = glm::abs(d);
    const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    const int face = 2 * axis + (d[axis] < 0);
    return &views[static_cast<std::size_t>(face)];
}

ViewPlace place_in_view(const ViewProjection& view, const glm::vec3& point, const glm::vec3& normal)
{
    ViewPlace place;
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

SurfaceInView::SurfaceInView(const ViewProjection& view, const ViewPlace& place, const glm::vec3& point,
                             const glm::vec3& normal)
    : view_(view),
      normal_(normal),
      own_(place.own),
      texel_(2 * glm::length(view.across) / static_cast<float>(view.size) * (view.perspective ? place.own : 1.0f)),
      above_(glm::dot(normal, point - view.origin))
{
}

float SurfaceInView::distance_at(int x, int y) const
{
    const auto size = static_cast<float>(view_.size);
    const float cx = 2 * (static_cast<float>(x) + 0.5f) / size - 1, cy = 2 * (static_cast<float>(y) + 0.5f) / size - 1;
    const glm::vec3 offset = cx * view_.across + cy * view_.down;
    const glm::vec3 ray = view_.perspective ? view_.forward + offset : view_.forward;
    const float plane = (above_ - (view_.perspective ? 0 : glm::dot(normal_, offset))) / glm::dot(normal_, ray);
    return plane > 0 && plane < own_ ? plane : own_;
}

namespace {

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
    const ViewPlace place = place_in_view(view, point, normal);
    if (place.known) return *place.known;

    // Compare distances at each texel's centre.
    const SurfaceInView surface(view, place, point, normal);
    return filtered(place.at, options.filter, view.size, [&](int x, int y) {
        const std::size_t i = buffer.at(x, y);
        const float margin = buffer.item[i] == object + 1 ? options.self_margin : options.other_margin;
        return view.distance_of(buffer.depth[i]) >= surface.distance_at(x, y) - surface.texel() * margin;
    });
}

float visibility_as_printed(const ViewProjection& view, const ReceiverTexture& texture, const glm::vec3& point,
                            const glm::vec3& normal, const LookupOptions& options)
{
    const ViewPlace place = place_in_view(view, point, normal);
    if (place.known) return *place.known;
    return filtered(place.at, options.filter, view.size, [&](int x, int y) { return texture.lit(x, y); });
}

}   // namespace gnomon::shadow_textures
