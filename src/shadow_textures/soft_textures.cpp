// SPDX-License-Identifier: Apache-2.0
#include "shadow_textures/soft_textures.h"

#include <algorithm>
#include <cmath>

#include "shadow_textures/lookup.h"

namespace gnomon::shadow_textures {

using light_views::Casters;
using light_views::Item;
using light_views::Rect;
using light_views::SoftwareBuffer;
using light_views::ViewPlan;
using light_views::ViewProjection;

namespace {

// Sums of a mask over boxes with fractional borders. Whole numbers, so that the order of summing does not matter.
class MaskSums {
 public:
    explicit MaskSums(const Rect& rect)
        : rect_(rect),
          sums_(static_cast<std::size_t>(rect.width() + 1) * static_cast<std::size_t>(rect.height() + 1), 0u)
    {
    }
    template <class Inside>
    void fill(const Inside& inside)
    {
        for (int y = rect_.y0; y < rect_.y1; ++y) {
            std::uint32_t row = 0;
            for (int x = rect_.x0; x < rect_.x1; ++x) {
                row += inside(x, y) ? 1u : 0u;
                sums_[at(x + 1, y + 1)] = sums_[at(x + 1, y)] + row;
            }
        }
    }
    /// Over a box in texels, clipped to the mask's rectangle.
    double over(const glm::dvec2& low, const glm::dvec2& high) const
    {
        const glm::dvec2 first(rect_.x0, rect_.y0), last(rect_.x1, rect_.y1);
        const glm::dvec2 a = glm::clamp(low, first, last), b = glm::clamp(high, first, last);
        return corner(b.x, b.y) - corner(a.x, b.y) - corner(b.x, a.y) + corner(a.x, a.y);
    }

 private:
    std::size_t at(int x, int y) const
    {
        return static_cast<std::size_t>(y - rect_.y0) * static_cast<std::size_t>(rect_.width() + 1) +
               static_cast<std::size_t>(x - rect_.x0);
    }
    // The integral of the mask from its first corner: bilinear within a texel, because the mask is constant there.
    double corner(double x, double y) const
    {
        const int ix = std::min(static_cast<int>(x), rect_.x1 - 1), iy = std::min(static_cast<int>(y), rect_.y1 - 1);
        const double fx = x - ix, fy = y - iy;
        const double top = (1 - fx) * sums_[at(ix, iy)] + fx * sums_[at(ix + 1, iy)],
                     bottom = (1 - fx) * sums_[at(ix, iy + 1)] + fx * sums_[at(ix + 1, iy + 1)];
        return (1 - fy) * top + fy * bottom;
    }

    Rect rect_;
    std::vector<std::uint32_t> sums_;
};

// What one occluder hides of a receiver from the light's centre.
struct Shadow {
    Rect rect;
    std::uint64_t texels = 0;
    double occluder = 0, receiver = 0;   // sums of distances along the view
    void add(int x, int y, double nearer, double farther)
    {
        const Rect here{x, y, x + 1, y + 1};
        rect = texels ? around(rect, here) : here;
        ++texels;
        occluder += nearer, receiver += farther;
    }
};

// Half of the light's image on a receiver, in texels along the view's axes: at least half a texel.
glm::dvec2 half_image(const ViewProjection& view, const SoftLight& light, const Shadow& shadow)
{
    const double near = shadow.occluder / static_cast<double>(shadow.texels),
                 far = shadow.receiver / static_cast<double>(shadow.texels);
    const double scale = view.perspective ? std::max(far - near, 0.0) / (near * far) : 0.0;
    const auto extent = [&](const glm::vec3& axis) {
        const glm::dvec3 a(axis);
        const double along =
            std::abs(glm::dot(glm::dvec3(light.half_s), a)) + std::abs(glm::dot(glm::dvec3(light.half_t), a));
        return std::max(0.5, 0.5 * view.size * scale * along / glm::dot(a, a));
    };
    return {extent(view.across), extent(view.down)};
}

}   // namespace

SoftTexture soft_texture(const ViewProjection& view, const SoftwareBuffer& everything, const scene::SceneState& state,
                         scene::ObjectId receiver, const Rect& rect, const SoftLight& light, SoftScale scale)
{
    // Draw the receiver alone.
    SoftwareBuffer own(view.size);
    draw_object(own, view, state, receiver, rect);
    SoftTexture texture{rect, {}, {}};
    const std::size_t texels = static_cast<std::size_t>(rect.width()) * static_cast<std::size_t>(rect.height());
    texture.visible.assign(texels, 1.0f);
    texture.depth.resize(texels);

    // Find its shadows: by occluder, or all as one.
    const auto shadow_of = [&](int x, int y) -> Item {
        const std::size_t i = own.at(x, y);
        const bool hidden = own.item[i] != 0 && everything.depth[i] > own.depth[i];
        if (!hidden) return 0;
        return scale == SoftScale::receiver ? 1 : everything.item[i];
    };
    MaskSums covered(rect);
    covered.fill([&](int x, int y) { return own.item[own.at(x, y)] != 0; });
    std::map<Item, Shadow> shadows;
    for (int y = rect.y0; y < rect.y1; ++y)
        for (int x = rect.x0; x < rect.x1; ++x) {
            const std::size_t i = own.at(x, y);
            texture.depth[texture.at(x, y)] = own.depth[i];
            if (const Item item = shadow_of(x, y))
                shadows[item].add(x, y, static_cast<double>(view.distance_of(everything.depth[i])),
                                  static_cast<double>(view.distance_of(own.depth[i])));
        }

    // Convolve each with the light's image, and subtract it where that reaches.
    for (const auto& [item, shadow] : shadows) {
        const glm::dvec2 half = half_image(view, light, shadow);
        MaskSums mask(shadow.rect);
        mask.fill([&, item = item](int x, int y) { return shadow_of(x, y) == item; });
        const int reach_x = static_cast<int>(std::min(std::ceil(half.x), 1e6)),
                  reach_y = static_cast<int>(std::min(std::ceil(half.y), 1e6));
        const Rect reached = intersection(rect, Rect{shadow.rect.x0 - reach_x, shadow.rect.y0 - reach_y,
                                                     shadow.rect.x1 + reach_x, shadow.rect.y1 + reach_y});
        for (int y = reached.y0; y < reached.y1; ++y)
            for (int x = reached.x0; x < reached.x1; ++x) {
                const glm::dvec2 middle(x + 0.5, y + 0.5);
                const double hidden = mask.over(middle - half, middle + half);
                if (hidden <= 0) continue;
                float& visible = texture.visible[texture.at(x, y)];
                visible -= static_cast<float>(hidden / covered.over(middle - half, middle + half));
            }
    }
    for (float& visible : texture.visible) visible = std::max(visible, 0.0f);
    return texture;
}

void CoherentSoftTextures::update(const light_views::LightView& view, const SoftwareBuffer& everything,
                                  const Casters& casters, const scene::SceneState& state, const SoftLight& light)
{
    updated_ = 0;
    const ViewPlan& plan = view.plan;
    if (plan.kind == ViewPlan::Kind::whole || plan.kind == ViewPlan::Kind::restless) textures_.clear();
    for (const scene::ObjectId object : plan.departed) textures_.erase(object);
    const auto make = [&](scene::ObjectId object, SoftTexture& texture) {
        const Rect rect = casters.footprint(view.projection, state, object);
        texture = soft_texture(view.projection, everything, state, object, rect, light, scale_);
        ++updated_;
    };
    if (light_ && *light_ == light) {
        for (const scene::ObjectId object : plan.receivers) make(object, textures_[object]);
        return;
    }
    // Make all of them, for a light of another size.
    light_ = light;
    for (const scene::ObjectId object : plan.receivers) textures_[object];
    for (auto& [object, texture] : textures_) make(object, texture);
}

float soft_visibility(const ViewProjection& view, const SoftTexture& texture, const glm::vec3& point,
                      const glm::vec3& normal, float self_margin)
{
    const ViewPlace place = place_in_view(view, point, normal);
    if (place.known) return *place.known;
    const Rect& rect = texture.rect;
    const int last_x = rect.x1 - 1, last_y = rect.y1 - 1;

    // Whether the receiver hides the point from the light's centre.
    const int x = std::clamp(static_cast<int>(place.at.x), rect.x0, last_x),
              y = std::clamp(static_cast<int>(place.at.y), rect.y0, last_y);
    const SurfaceInView surface(view, place, point, normal);
    if (view.distance_of(texture.depth[texture.at(x, y)]) < surface.distance_at(x, y) - self_margin * surface.texel())
        return 0;

    // Interpolate between the middles of four texels.
    const float tx = place.at.x - 0.5f, ty = place.at.y - 0.5f;
    const int ix = static_cast<int>(std::floor(tx)), iy = static_cast<int>(std::floor(ty));
    const float fx = tx - static_cast<float>(ix), fy = ty - static_cast<float>(iy);
    const auto value = [&](int dx, int dy) {
        return texture.visible[texture.at(std::clamp(ix + dx, rect.x0, last_x), std::clamp(iy + dy, rect.y0, last_y))];
    };
    return (1 - fy) * ((1 - fx) * value(0, 0) + fx * value(1, 0)) + fy * ((1 - fx) * value(0, 1) + fx * value(1, 1));
}

}   // namespace gnomon::shadow_textures
