// SPDX-License-Identifier: Apache-2.0
// Finds the bounds of every dynamic object on a light's plane.
#include <algorithm>

#include "shadow_culling/dynamic_mask/parts.h"

namespace gnomon::shadow_culling {

namespace {

// Largest ratio of a print's width to its depth; objects nearer to the light's plane are not drawn.
constexpr double k_widest = 20;

float largest_coordinate(const Box3& box)
{
    float largest = 0;
    for (int axis = 0; axis < 3 && !box.empty(); ++axis)
        largest = std::max({largest, std::abs(box.low[axis]), std::abs(box.high[axis])});
    return largest;
}

// A box as its matrix leaves it: around a middle, three half edges.
struct Placed {
    glm::dvec3 middle, half[3], reach;   // reach: of the world box
    float coordinate;                    // largest; 0: nothing to see

    Box3 world() const { return {glm::vec3(middle - reach), glm::vec3(middle + reach)}; }
};

Placed place_box(const Box3& own, const glm::dmat4& to_world)
{
    Placed placed;
    const glm::dvec3 middle = 0.5 * (glm::dvec3(own.low) + glm::dvec3(own.high));
    const glm::dvec3 half = 0.5 * (glm::dvec3(own.high) - glm::dvec3(own.low));
    placed.middle = transform_point(to_world, middle);
    placed.reach = glm::dvec3(0);
    for (int axis = 0; axis < 3; ++axis) {
        placed.half[axis] = half[axis] * glm::dvec3(to_world[axis]);
        placed.reach += glm::abs(placed.half[axis]);
    }
    placed.coordinate = largest_coordinate(placed.world());
    return placed;
}

// Whether the world box around a placed box lies farther than `room` from the pyramid of a face of a point light.
bool far_from_face(const Placed& placed, const glm::dvec3& from_light, std::uint32_t face, double room)
{
    const int axis = static_cast<int>(face / 2);
    const double out = face & 1 ? -from_light[axis] : from_light[axis];
    const double furthest = out + placed.reach[axis];
    if (furthest < -room) return true;
    for (int other = 0; other < 3; ++other)
        if (other != axis && std::abs(from_light[other]) - placed.reach[other] > furthest + room) return true;
    return false;
}

// Whether all corners, in a face's space, lie farther than `room` outside of one side of its pyramid.
bool outside_pyramid(const glm::dvec3 (&corners)[8], double room)
{
    for (int side = 0; side < 4; ++side) {
        bool outside = true;
        for (const glm::dvec3& q : corners) {
            const double across = side & 1 ? q.x : q.y;
            outside = outside && q.z + (side & 2 ? across : -across) < -room;
        }
        if (outside) return true;
    }
    return false;
}

}   // namespace

// Bounds every dynamic object on the light's plane, from its box.
void DynamicMask::place_prints(LightMask& mask, std::uint32_t light)
{
    const scene::LightState& at = state_->light(light);
    visibility::LightPoint to;
    to.directional = state_->scene().lights[light].type == scene::LightType::directional;
    to.place = to.directional ? glm::normalize(-glm::dvec3(at.direction)) : glm::dvec3(at.position);

    static thread_local std::vector<Placed> placed;
    placed.resize(units_.size());
    Box3 bounds = triangles_.bounds();
    for (std::size_t u = 0; u < units_.size(); ++u) {
        const Unit& unit = *units_[u];
        placed[u].coordinate = 0;
        if (!state_->object_visible(unit.object) || rays_->meeting(unit.object) == ray::Meeting::never) continue;
        const ray::ObjectGeometry& geometry = rays_->geometry(unit.object);
        Box3 own = unit.own;
        if (unit.deforming) {
            own = Box3{};
            for (const glm::uvec3& t : geometry.mesh->triangles)
                for (int i = 0; i < 3; ++i) own.add(geometry.positions[t[i]]);
        }
        if (own.empty()) continue;
        placed[u] = place_box(own, geometry.to_world ? glm::dmat4(*geometry.to_world) : glm::dmat4(1));
        bounds.add(placed[u].world());
    }
    float coordinate = largest_coordinate(bounds);
    if (!to.directional)
        for (int axis = 0; axis < 3; ++axis)
            coordinate = std::max(coordinate, static_cast<float>(std::abs(to.place[axis])));
    mask.margin = options_.margin * static_cast<double>(coordinate);
    // The plane of a directional light is fixed by the static scene; objects outside it are not drawn.
    const LightSpace space(to, triangles_.bounds());
    forget_static_unless(mask, space, coordinate);
    mask.space = space;

    mask.prints.clear();
    for (std::size_t u = 0; u < units_.size(); ++u) {
        if (!(placed[u].coordinate > 0)) continue;
        const glm::dvec3 from_light = placed[u].middle - to.place;
        const bool anywhere = rays_->meeting(units_[u]->object) == ray::Meeting::roughly;
        for (std::uint32_t face = 0; face < mask.space.faces(); ++face) {
            if (anywhere) {
                Print print;
                print.unit = static_cast<std::uint32_t>(u);
                print.face = face;
                print.blind = true;
                mask.prints.push_back(print);
                continue;
            }
            const double room = 2 * mask.margin;
            if (!to.directional && far_from_face(placed[u], from_light, face, room)) continue;   // most are
            glm::dvec3 p[8];
            double near = k_infinity, far = -near, widest = 0;
            for (int c = 0; c < 8; ++c) {
                p[c] = mask.space.in_face(face, placed[u].middle + (c & 1 ? 1.0 : -1.0) * placed[u].half[0] +
                                                    (c & 2 ? 1.0 : -1.0) * placed[u].half[1] +
                                                    (c & 4 ? 1.0 : -1.0) * placed[u].half[2]);
                near = std::min(near, p[c].z), far = std::max(far, p[c].z);
                widest = std::max({widest, std::abs(p[c].x), std::abs(p[c].y)});
            }
            Print print;
            print.unit = static_cast<std::uint32_t>(u);
            print.face = face;
            print.between = static_cast<float>(options_.depth_margin * static_cast<double>(placed[u].coordinate));
            const auto between = static_cast<double>(print.between);
            if (!to.directional) {
                if (far < -room || outside_pyramid(p, room)) continue;
                if (!(k_widest * near > widest) || !(near > 10 * (mask.margin + between))) {
                    print.blind = true;
                    mask.prints.push_back(print);
                    continue;
                }
            }
            const double widen = mask.space.on_plane(mask.margin, near);
            print.low_x = print.low_y = k_infinity, print.high_x = print.high_y = -k_infinity;
            for (const glm::dvec3& q : p) {
                const OnFace on = mask.space.on_face(q);
                print.low_x = std::min(print.low_x, static_cast<float>(on.x - widen));
                print.low_y = std::min(print.low_y, static_cast<float>(on.y - widen));
                print.high_x = std::max(print.high_x, static_cast<float>(on.x + widen));
                print.high_y = std::max(print.high_y, static_cast<float>(on.y + widen));
            }
            if (print.high_x < 0 || print.high_y < 0 || print.low_x > 1 || print.low_y > 1) continue;
            mask.prints.push_back(print);
        }
    }
    mask.outlines.resize(std::max(mask.outlines.size(), mask.prints.size()));
    mask.outlined = std::make_unique<std::once_flag[]>(mask.prints.size());
}

// Forgets the depths of static geometry if the light moved or the margin grew.
void DynamicMask::forget_static_unless(LightMask& mask, const LightSpace& space, float coordinate) const
{
    constexpr double k_room = 1.5;             // so that the margin seldom grows when dynamic objects appear
    constexpr std::size_t k_most = 1u << 16;   // blocks
    const bool same = mask.static_margin >= mask.margin && mask.space.light().place == space.light().place &&
                      mask.static_begins.size() < k_most;
    if (same) return;
    mask.static_begins.clear();
    mask.static_margin = k_room * mask.margin;
    mask.static_between = k_room * options_.depth_margin * static_cast<double>(coordinate);
}

// Sorts the prints into a coarse grid over their common bounds.
void DynamicMask::fill_bins(LightMask& mask) const
{
    float low[2] = {1, 1}, high[2] = {0, 0};
    for (const Print& print : mask.prints) {
        low[0] = std::min(low[0], print.low_x), low[1] = std::min(low[1], print.low_y);
        high[0] = std::max(high[0], print.high_x), high[1] = std::max(high[1], print.high_y);
    }
    for (int axis = 0; axis < 2; ++axis) low[axis] = std::max(low[axis], 0.0f), high[axis] = std::min(high[axis], 1.0f);
    mask.bins_low_x = low[0], mask.bins_low_y = low[1];
    mask.bins_scale_x = high[0] > low[0] ? k_bins / (high[0] - low[0]) : 0;
    mask.bins_scale_y = high[1] > low[1] ? k_bins / (high[1] - low[1]) : 0;
    const auto bin = [](float at, float from, float scale) {
        return static_cast<std::uint32_t>(std::clamp((at - from) * scale, 0.0f, static_cast<float>(k_bins - 1)));
    };
    mask.bin_begin.assign(k_bins * k_bins + 1, 0);
    for (const bool count : {true, false}) {
        for (std::uint32_t p = 0; p < mask.prints.size(); ++p) {
            const Print& print = mask.prints[p];
            const std::uint32_t x0 = bin(print.low_x, low[0], mask.bins_scale_x),
                                x1 = bin(print.high_x, low[0], mask.bins_scale_x),
                                y0 = bin(print.low_y, low[1], mask.bins_scale_y),
                                y1 = bin(print.high_y, low[1], mask.bins_scale_y);
            for (std::uint32_t y = y0; y <= y1; ++y)
                for (std::uint32_t x = x0; x <= x1; ++x) {
                    std::uint32_t& entry = mask.bin_begin[y * k_bins + x];
                    if (count)
                        ++entry;
                    else
                        mask.binned[--entry] = p;
                }
        }
        if (!count) break;
        for (std::size_t b = 1; b < mask.bin_begin.size(); ++b) mask.bin_begin[b] += mask.bin_begin[b - 1];
        mask.binned.resize(mask.bin_begin.back());
    }
}

}   // namespace gnomon::shadow_culling
