// SPDX-License-Identifier: Apache-2.0
#include "light_views/software.h"

#include <array>

#include "base/check.h"

namespace gnomon::light_views {

namespace {

// Products of two snapped coordinates need more than 64 bits near the eye.
__extension__ typedef __int128 Int128;

struct ClipVertex {
    glm::dvec4 at;
    glm::dvec2 uv;
};

// Clips a triangle to w >= near (perspective): 0, 3 or 4 corners remain.
int clip_near(const std::array<ClipVertex, 3>& in, double near, std::array<ClipVertex, 4>& out)
{
    int count = 0;
    for (std::size_t i = 0; i < 3; ++i) {
        const ClipVertex &a = in[i], &b = in[(i + 1) % 3];
        if (a.at.w >= near) out[static_cast<std::size_t>(count++)] = a;
        if ((a.at.w >= near) == (b.at.w >= near)) continue;
        const double s = (near - a.at.w) / (b.at.w - a.at.w);
        ClipVertex cut{a.at + s * (b.at - a.at), a.uv + s * (b.uv - a.uv)};
        cut.at.w = near;
        out[static_cast<std::size_t>(count++)] = cut;
    }
    return count;
}

struct ScreenVertex {
    std::int64_t x = 0, y = 0;   // 1/256 texel
    double depth = 0, inverse_w = 0;
    glm::dvec2 uv_over_w{0};
};

constexpr std::int64_t k_subtexels = 256;

ScreenVertex to_screen(const ClipVertex& v, int size)
{
    const auto snap = [&](double p) {
        const double t = (0.5 * p / v.at.w + 0.5) * size;
        return static_cast<std::int64_t>(std::clamp(std::nearbyint(t * k_subtexels), -0x1p60, 0x1p60));
    };
    return {snap(v.at.x), snap(v.at.y), v.at.z / v.at.w, 1 / v.at.w, v.uv / v.at.w};
}

// Twice the signed area of (a, b, p), exact.
template <class Wide>
Wide edge(const ScreenVertex& a, const ScreenVertex& b, std::int64_t x, std::int64_t y)
{
    return static_cast<Wide>(b.x - a.x) * (y - a.y) - static_cast<Wide>(b.y - a.y) * (x - a.x);
}

// Whether texels exactly on the edge belong to the triangle.
bool owns(const ScreenVertex& a, const ScreenVertex& b)
{
    return a.y == b.y ? b.x > a.x : b.y < a.y;
}

// Calls body(x, y, weights) for the texels of a triangle within a rectangle.
template <class Wide, class Body>
void walk_texels(std::array<ScreenVertex, 3> v, const Rect& clip, const Body& body)
{
    Wide area = edge<Wide>(v[0], v[1], v[2].x, v[2].y);
    if (area == 0) return;
    if (area < 0) std::swap(v[1], v[2]), area = -area;
    const auto [x_low, x_high] = std::minmax({v[0].x, v[1].x, v[2].x});
    const auto [y_low, y_high] = std::minmax({v[0].y, v[1].y, v[2].y});
    const auto from = [](std::int64_t low, int least) {
        return static_cast<int>(std::clamp<std::int64_t>(low / k_subtexels - 1, least, 1 << 20));
    };
    const auto to = [](std::int64_t high, int most) {
        return static_cast<int>(std::clamp<std::int64_t>(high / k_subtexels + 1, -1, most - 1));
    };
    const bool own[3] = {owns(v[1], v[2]), owns(v[2], v[0]), owns(v[0], v[1])};
    for (int y = from(y_low, clip.y0); y <= to(y_high, clip.y1); ++y)
        for (int x = from(x_low, clip.x0); x <= to(x_high, clip.x1); ++x) {
            const std::int64_t px = x * k_subtexels + k_subtexels / 2, py = y * k_subtexels + k_subtexels / 2;
            const Wide e[3] = {edge<Wide>(v[1], v[2], px, py), edge<Wide>(v[2], v[0], px, py),
                               edge<Wide>(v[0], v[1], px, py)};
            bool inside = true;
            for (int i = 0; i < 3; ++i) inside &= e[i] > 0 || (e[i] == 0 && own[i]);
            if (!inside) continue;
            const double total = static_cast<double>(area);
            body(x, y, v,
                 glm::dvec3(static_cast<double>(e[0]), static_cast<double>(e[1]), static_cast<double>(e[2])) / total);
        }
}

template <class Body>
void for_each_texel(const std::array<ScreenVertex, 3>& v, const Rect& clip, const Body& body)
{
    constexpr std::int64_t k_short = std::int64_t{1} << 28;   // products of differences fit 64 bits
    bool fits = true;
    for (const ScreenVertex& p : v) fits &= std::max(std::abs(p.x), std::abs(p.y)) < k_short;
    fits ? walk_texels<std::int64_t>(v, clip, body) : walk_texels<Int128>(v, clip, body);
}

}   // namespace

SoftwareBuffer::SoftwareBuffer(int side)
    : size(side),
      depth(static_cast<std::size_t>(side) * static_cast<unsigned>(side), 0.0f),
      item(static_cast<std::size_t>(side) * static_cast<unsigned>(side), 0u)
{
}

void SoftwareBuffer::empty(const Rect& rect)
{
    for (int y = rect.y0; y < rect.y1; ++y)
        for (int x = rect.x0; x < rect.x1; ++x) depth[at(x, y)] = 0, item[at(x, y)] = 0;
}

void SoftwareBuffer::copy(const SoftwareBuffer& from, const Rect& rect)
{
    for (int y = rect.y0; y < rect.y1; ++y)
        for (int x = rect.x0; x < rect.x1; ++x) {
            depth[at(x, y)] = from.depth[at(x, y)];
            item[at(x, y)] = from.item[at(x, y)];
        }
}

void draw_object(SoftwareBuffer& buffer, const ViewProjection& view, const scene::SceneState& state,
                 scene::ObjectId object, const Rect& clip, const SoftwareBuffer* statics)
{
    const scene::Scene& scene = state.scene();
    const scene::Object& o = scene.objects[object];
    const scene::Mesh& mesh = scene.meshes[o.mesh];
    const auto& positions = o.deforming ? state.deformed(object).positions : mesh.positions;
    const glm::dmat4 matrix = glm::dmat4(view.clip_from_world) * glm::dmat4(state.object_matrix(object));
    const Item item = object + 1;

    for (const scene::MeshPart& part : mesh.parts) {
        const scene::Material& material = scene.materials[part.material];
        if (material.surface_class() == scene::SurfaceClass::transparent) continue;
        const scene::TextureUse& use = material.base_color_texture;
        const bool masked = material.surface_class() == scene::SurfaceClass::masked;
        const auto* texcoords =
            masked && use.used() && !mesh.texcoords[use.texcoord].empty() ? &mesh.texcoords[use.texcoord] : nullptr;

        for (std::uint32_t t = part.first_triangle; t < part.first_triangle + part.triangle_count; ++t) {
            // Transform the triangle, and clip it at the near plane.
            std::array<ClipVertex, 3> corners;
            for (int i = 0; i < 3; ++i) {
                const std::uint32_t index = mesh.triangles[t][i];
                corners[static_cast<std::size_t>(i)] = {matrix * glm::dvec4(glm::dvec3(positions[index]), 1),
                                                        texcoords ? glm::dvec2((*texcoords)[index]) : glm::dvec2(0)};
            }
            std::array<ClipVertex, 4> polygon;
            int count = 3;
            if (view.perspective)
                count = clip_near(corners, static_cast<double>(view.reach), polygon);
            else
                std::copy(corners.begin(), corners.end(), polygon.begin());
            // Rasterise the clipped polygon as a fan.
            for (int k = 2; k < count; ++k) {
                const std::array<ScreenVertex, 3> screen{to_screen(polygon[0], view.size),
                                                         to_screen(polygon[static_cast<std::size_t>(k - 1)], view.size),
                                                         to_screen(polygon[static_cast<std::size_t>(k)], view.size)};
                for_each_texel(screen, clip, [&](int x, int y, const auto& v, const glm::dvec3& b) {
                    const float depth = static_cast<float>(
                        std::clamp(b.x * v[0].depth + b.y * v[1].depth + b.z * v[2].depth, 0.0, 1.0));
                    const std::size_t at = buffer.at(x, y);
                    if (depth < buffer.depth[at]) return;
                    // Discard texels where the material's alpha is below its cutoff.
                    if (masked) {
                        float alpha = material.alpha;
                        if (texcoords) {
                            const double w = b.x * v[0].inverse_w + b.y * v[1].inverse_w + b.z * v[2].inverse_w;
                            const glm::dvec2 uv =
                                (b.x * v[0].uv_over_w + b.y * v[1].uv_over_w + b.z * v[2].uv_over_w) / w;
                            alpha *= scene.textures[use.texture].alpha(use.apply(glm::vec2(uv)));
                        }
                        if (alpha < material.alpha_cutoff) return;
                    }
                    buffer.depth[at] = depth;
                    buffer.item[at] = statics && statics->depth[at] == depth ? std::max(item, statics->item[at]) : item;
                });
            }
        }
    }
}

void SoftwareView::execute(const ViewPlan& plan, const ViewProjection& view, const scene::SceneState& state)
{
    GNOMON_CHECK_EQ(view.size, rendering_.size);
    if (plan.kind == ViewPlan::Kind::idle) return;
    const bool restless = plan.kind == ViewPlan::Kind::restless;
    if (restless) rendering_.empty(view.whole());

    // Step 1: erase dynamic objects.
    for (const Rect& rect : plan.erase) rendering_.copy(statics_, rect);
    // Steps 2 to 4: rebuild the rectangles that static objects left.
    for (const Rect& rect : plan.rebuild) rendering_.empty(rect);
    for (const ViewPlan::Redraw& redraw : plan.redraw)
        draw_object(rendering_, view, state, redraw.object, plan.rebuild[redraw.rect]);
    for (const Rect& rect : plan.rebuild) statics_.copy(rendering_, rect);
    // Steps 5 and 6: add objects that came to rest.
    for (const ViewPlan::Settle& settle : plan.settle)
        draw_object(rendering_, view, state, settle.object, view.whole(), &statics_);
    for (const ViewPlan::Settle& settle : plan.settle) statics_.copy(rendering_, settle.rect);
    // Step 7: draw dynamic objects.
    for (const scene::ObjectId object : plan.dynamics)
        draw_object(rendering_, view, state, object, view.whole(), restless ? nullptr : &statics_);
}

}   // namespace gnomon::light_views
