// SPDX-License-Identifier: Apache-2.0
#include "light_views/projection.h"

#include <array>

#include "base/bits.h"
#include "base/check.h"

namespace gnomon::light_views {

namespace {

// Clip-space rows (x, y, depth, w) from an orthonormal basis; `forward` is the direction of the view.
glm::dmat4 view_matrix(const glm::dvec3& right, const glm::dvec3& down, const glm::dvec3& forward,
                       const glm::dvec3& eye)
{
    glm::dmat4 m(1);
    const glm::dvec3 rows[] = {right, down, forward};
    for (int r = 0; r < 3; ++r) {
        for (int c = 0; c < 3; ++c) m[c][r] = rows[r][c];
        m[3][r] = -glm::dot(rows[r], eye);
    }
    return m;
}

// x and y scaled by 1 / tangents; depth = near / w; w = distance along the axis.
ViewProjection perspective(const glm::dvec3& right, const glm::dvec3& down, const glm::dvec3& forward,
                           const glm::dvec3& eye, const glm::dvec2& tangents, double near, int size)
{
    glm::dmat4 p(0);
    p[0][0] = 1 / tangents.x, p[1][1] = 1 / tangents.y;
    p[3][2] = near;
    p[2][3] = 1;
    ViewProjection view;
    view.clip_from_world = glm::mat4(p * view_matrix(right, down, forward, eye));
    view.origin = glm::vec3(eye);
    view.forward = glm::vec3(forward);
    view.across = glm::vec3(tangents.x * right);
    view.down = glm::vec3(tangents.y * down);
    view.reach = static_cast<float>(near);
    view.size = size;
    return view;
}

// The half space before a light, as half of a cube. The sides are seen at a slant, so that none of a view lies behind.
std::vector<ViewProjection> half_cube(const glm::vec3& direction, const glm::dvec3& eye, double stretch, double near,
                                      int size)
{
    glm::vec3 s, t;
    make_basis(direction, s, t);
    const glm::dvec3 axes[] = {glm::dvec3(s), glm::dvec3(t)}, top(direction);
    std::vector<ViewProjection> views{perspective(axes[0], axes[1], top, eye, glm::dvec2(stretch), near, size)};
    const double slant = k_pi / 8;   // half of the 45 degrees from the horizon to the top
    const glm::dvec2 tangents(1 / std::cos(slant), std::tan(slant));
    for (int side = 0; side < 4; ++side) {
        const glm::dvec3 out = (side % 2 ? -1.0 : 1.0) * axes[side / 2];
        const glm::dvec3 forward = std::cos(slant) * out + std::sin(slant) * top,
                         down = std::cos(slant) * top - std::sin(slant) * out;
        views.push_back(perspective(axes[1 - side / 2], down, forward, eye, stretch * tangents, near, size));
    }
    return views;
}

struct Extent {
    glm::dvec3 low{std::numeric_limits<double>::infinity()}, high{-std::numeric_limits<double>::infinity()};
};

// The extent of a box along three axes.
Extent extent_of(const Box3& box, const glm::dvec3& right, const glm::dvec3& down, const glm::dvec3& forward)
{
    Extent extent;
    for (int corner = 0; corner < 8; ++corner) {
        const glm::dvec3 p(corner & 1 ? box.high.x : box.low.x, corner & 2 ? box.high.y : box.low.y,
                           corner & 4 ? box.high.z : box.low.z);
        const glm::dvec3 q(glm::dot(right, p), glm::dot(down, p), glm::dot(forward, p));
        extent.low = glm::min(extent.low, q), extent.high = glm::max(extent.high, q);
    }
    return extent;
}

// A view that covers `seen` across, and `bounds` from one end to the other in depth.
ViewProjection orthographic(const glm::vec3& direction, const Box3& seen, const Box3& bounds, double stretch, int size)
{
    glm::vec3 s, t;
    make_basis(direction, s, t);
    const glm::dvec3 right(s), down(t), forward(direction);
    Extent extent = extent_of(seen, right, down, forward);
    const Extent all = extent_of(bounds, right, down, forward);
    glm::dvec3 &low = extent.low, &high = extent.high;
    low.z = all.low.z, high.z = all.high.z;
    const glm::dvec3 middle = 0.5 * (low + high);
    // Enlarge the bounds slightly, so that objects that touch them are inside; never zero.
    constexpr double k_room = 1.0001, k_smallest = 1e-6;
    const double half = std::max({high.x - low.x, high.y - low.y, k_smallest}) / 2 * k_room * stretch;
    const double half_depth = std::max(high.z - low.z, k_smallest) / 2 * k_room;
    glm::dmat4 p(1);
    p[0][0] = p[1][1] = 1 / half;
    p[3][0] = -middle.x / half;
    p[3][1] = -middle.y / half;
    p[2][2] = -0.5 / half_depth;   // depth 1 at the end towards the light, 0 at the other
    p[3][2] = 0.5 + 0.5 * middle.z / half_depth;
    ViewProjection view;
    view.clip_from_world = glm::mat4(p * view_matrix(right, down, forward, glm::dvec3(0)));
    view.origin = glm::vec3(middle.x * right + middle.y * down + (middle.z - half_depth) * forward);
    view.forward = direction;
    view.across = glm::vec3(half * right);
    view.down = glm::vec3(half * down);
    view.reach = static_cast<float>(2 * half_depth);
    view.perspective = false;
    view.size = size;
    return view;
}

}   // namespace

bool ViewProjection::same_bits(const ViewProjection& other) const
{
    return gnomon::same_bits(clip_from_world, other.clip_from_world) && size == other.size;
}

int view_count(const scene::Light& light, const SceneBounds& bounds, const ProjectionOptions& options)
{
    switch (light.type) {
        case scene::LightType::point:
            return 6;
        case scene::LightType::spot:
            if (static_cast<double>(light.outer_angle) <= options.widest_spot) return 1;
            return options.half_cubes ? 5 : 6;
        case scene::LightType::directional:
            break;
    }
    const auto whole = static_cast<double>(bounds.whole.diagonal()),
               dense = static_cast<double>(bounds.dense.diagonal());
    if (!(dense > 0 && whole > options.dense_gain * dense)) return 1;
    if (!(options.widening > 1) || whole <= options.widening * dense) return 2;
    constexpr double k_most_views = 6;
    return 1 + static_cast<int>(
                   std::min(std::ceil(std::log(whole / dense) / std::log(options.widening)), k_most_views - 1));
}

std::vector<ViewProjection> project(const scene::Light& light, const scene::LightState& state,
                                    const SceneBounds& bounds, int size, const ProjectionOptions& options)
{
    GNOMON_CHECK_LT(2 * options.border, size);
    const double stretch = static_cast<double>(size) / (size - 2 * options.border);
    const int count = view_count(light, bounds, options);
    // A directional light: one view of everything, or several, each wider than the one before by the same factor.
    if (light.type == scene::LightType::directional) {
        const ViewProjection everything = orthographic(state.direction, bounds.whole, bounds.whole, stretch, size);
        if (count == 1) return {everything};
        std::vector<ViewProjection> views;
        const float wider = bounds.whole.diagonal() / bounds.dense.diagonal();
        for (int v = 0; v + 1 < count; ++v) {
            const float factor = std::pow(wider, static_cast<float>(v) / static_cast<float>(count - 1));
            const glm::vec3 margin(v == 0 ? 0.0f : 0.5f * (factor - 1) * bounds.dense.diagonal());
            const Box3 seen{glm::max(bounds.dense.low - margin, bounds.whole.low),
                            glm::min(bounds.dense.high + margin, bounds.whole.high)};
            views.push_back(orthographic(state.direction, v == 0 ? bounds.dense : seen, bounds.whole, stretch, size));
        }
        views.push_back(everything);
        return views;
    }

    const Box3& whole = bounds.whole;
    const double diagonal = whole.empty() ? 1.0 : std::max(static_cast<double>(whole.diagonal()), 1e-6);
    const double near = options.near_fraction * diagonal;
    const glm::dvec3 eye(state.position);
    std::vector<ViewProjection> views;
    // A spot light: one perspective view.
    if (count == 1) {
        glm::vec3 s, t;
        make_basis(state.direction, s, t);
        const double tangent = std::tan(static_cast<double>(light.outer_angle)) * stretch;
        views.push_back(perspective(glm::dvec3(s), glm::dvec3(t), glm::dvec3(state.direction), eye,
                                    glm::dvec2(std::max(tangent, 1e-4)), near, size));
        return views;
    }
    if (count == 5) return half_cube(state.direction, eye, stretch, near, size);
    // A point light: six faces of a cube.
    for (int face = 0; face < 6; ++face) {
        const int axis = face / 2;
        glm::dvec3 forward(0), right(0), down(0);
        forward[axis] = face % 2 ? -1 : 1;
        right[(axis + 1) % 3] = 1;
        down[(axis + 2) % 3] = 1;
        views.push_back(perspective(right, down, forward, eye, glm::dvec2(stretch), near, size));
    }
    return views;
}

Rect footprint(const ViewProjection& view, const glm::mat4& to_world, const Box3& box)
{
    if (box.empty()) return {};
    const glm::dmat4 world(to_world), clip(view.clip_from_world), matrix = clip * world;
    // Transform absolute values as well, to bound the rounding error of vertices on the device.
    glm::dmat4 world_abs, clip_abs;
    for (int c = 0; c < 4; ++c) world_abs[c] = glm::abs(world[c]), clip_abs[c] = glm::abs(clip[c]);
    const glm::dmat4 magnitude = clip_abs * world_abs;
    constexpr double k_rounding = 0x1p-20;   // 16 roundings of a float
    struct Corner {
        glm::dvec4 at, error;
    };
    std::array<Corner, 8> corners;
    int behind = 0;
    const double w_least = view.perspective ? 0.5 * static_cast<double>(view.reach) : 0.0;
    for (int i = 0; i < 8; ++i) {
        const glm::dvec4 p(i & 1 ? box.high.x : box.low.x, i & 2 ? box.high.y : box.low.y,
                           i & 4 ? box.high.z : box.low.z, 1);
        corners[static_cast<std::size_t>(i)] = {matrix * p, k_rounding * (magnitude * glm::abs(p))};
        behind += corners[static_cast<std::size_t>(i)].at.w < w_least;
    }
    if (behind == 8) return {};

    double low[2] = {1e30, 1e30}, high[2] = {-1e30, -1e30};
    const auto add = [&](const glm::dvec4& at, const glm::dvec4& error) {
        for (int axis = 0; axis < 2; ++axis) {
            const double p = at[axis] / at.w;
            const double room = (error[axis] + std::abs(p) * error.w) / at.w;
            low[axis] = std::min(low[axis], p - room);
            high[axis] = std::max(high[axis], p + room);
        }
    };
    for (const Corner& corner : corners)
        if (corner.at.w >= w_least) add(corner.at, corner.error);
    // Clip edges at the plane in front of the eye.
    if (behind > 0)
        for (int i = 0; i < 8; ++i)
            for (const int bit : {1, 2, 4}) {
                const Corner &a = corners[static_cast<std::size_t>(i)], &b = corners[static_cast<std::size_t>(i ^ bit)];
                if ((i & bit) || (a.at.w < w_least) == (b.at.w < w_least)) continue;
                const double s = (w_least - a.at.w) / (b.at.w - a.at.w);
                glm::dvec4 cut = a.at + s * (b.at - a.at);
                cut.w = w_least;
                add(cut, glm::max(a.error, b.error));
            }

    // Add one texel on each side, for sample positions and the driver's snapping of vertices.
    constexpr double k_margin = 1;
    const auto texel = [&](double p, double side) {
        const double t = (0.5 * p + 0.5) * view.size + side * k_margin;
        return static_cast<int>(
            std::clamp(side < 0 ? std::floor(t) : std::ceil(t), 0.0, static_cast<double>(view.size)));
    };
    const Rect rect{texel(low[0], -1), texel(low[1], -1), texel(high[0], 1), texel(high[1], 1)};
    return rect.empty() ? Rect{} : rect;
}

DistanceRange distance_range(const ViewProjection& view, const glm::mat4& to_world, const Box3& box)
{
    constexpr float k_rounding = 0x1p-19f;   // of the sum: 32 roundings
    const auto size = [](const glm::vec3& p) { return std::abs(p.x) + std::abs(p.y) + std::abs(p.z); };
    const float fixed = size(view.origin) + (view.perspective ? 0 : view.reach);
    DistanceRange range;
    for (int corner = 0; corner < 8; ++corner) {
        const glm::vec3 p(corner & 1 ? box.high.x : box.low.x, corner & 2 ? box.high.y : box.low.y,
                          corner & 4 ? box.high.z : box.low.z);
        const glm::vec3 world = transform_point(to_world, p);
        const float along = glm::dot(world - view.origin, view.forward), error = k_rounding * (size(world) + fixed);
        range.nearest = std::min(range.nearest, along - error);
        range.farthest = std::max(range.farthest, along + error);
    }
    return range;
}

}   // namespace gnomon::light_views
