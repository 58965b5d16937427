// SPDX-License-Identifier: Apache-2.0
// Room around what is placed by an instance.
//
// Embree tests the boxes of instances by its fast test, not by the robust one, whatever the scene's flags say. A ray
// that passes within rounding of such a box may miss it, and with it the triangles at its rim; whether it does depends
// on which rays share its packet, since packets and single rays round otherwise. Far from the origin that was one ray
// in ten thousand. So the boxes get a margin that no rounding spans: two triangles without size, at opposite corners of
// a larger box, which no ray meets. Inside, the robust test decides as ever.
#include <algorithm>
#include <cmath>

#include "ray/embree/impl.h"
#include "ray/embree/packets.h"

namespace gnomon::ray {

namespace {

// Share of the largest coordinate around. Bounds, rays and inverse matrices of instances are off by some ten units in
// the last place each.
constexpr float k_margin_per_coordinate = 3e-6f;

// Numbers below 1.2e-38 are zeros to Embree.
constexpr float k_least_size = 1e-36f;

constexpr unsigned k_corners[2][3] = {{0, 0, 0}, {1, 1, 1}};

// Embree leaves out triangles with larger coordinates (1.8e18), and has no boxes for them.
constexpr float k_largest_met = 1e18f;

float largest(const glm::vec3& v)
{
    const glm::vec3 a = glm::abs(v);
    return is_finite(v) ? std::max({a.x, a.y, a.z}) : k_infinity;
}

}   // namespace

float reach_of(const Box3& box, const glm::mat4& to_world)
{
    float reach = largest(glm::vec3(to_world[3]));
    if (box.empty()) return reach;
    for (int corner = 0; corner < 8; ++corner)
        reach = std::max(reach, largest(transform_point(to_world, glm::vec3(corner & 1 ? box.high.x : box.low.x,
                                                                            corner & 2 ? box.high.y : box.low.y,
                                                                            corner & 4 ? box.high.z : box.low.z))));
    return reach;
}

float margin_of(float reach, const glm::mat4& to_world)
{
    // Of the matrix's inverse, the largest stretch or more.
    const glm::mat3 inverse = glm::inverse(glm::mat3(to_world));
    const float stretch = std::sqrt(glm::dot(inverse[0], inverse[0]) + glm::dot(inverse[1], inverse[1]) +
                                    glm::dot(inverse[2], inverse[2]));
    const float wanted = k_margin_per_coordinate * reach * stretch;
    if (!(wanted > 0 && wanted < k_largest_met)) return 0;
    return std::exp2(std::ceil(std::log2(wanted)));   // in steps, so that trees are seldom made anew
}

Box3 box_of(const std::vector<glm::vec3>& positions, const scene::Mesh& mesh)
{
    Box3 box;
    for (const glm::uvec3& triangle : mesh.triangles)
        for (int i = 0; i < 3; ++i)
            if (const glm::vec3& p = positions[triangle[i]]; largest(p) < k_largest_met) box.add(p);
    return box;
}

bool has_points(const std::vector<glm::vec3>& positions, const scene::Mesh& mesh)
{
    return std::any_of(mesh.triangles.begin(), mesh.triangles.end(), [&](const glm::uvec3& triangle) {
        const glm::vec3 &a = positions[triangle[0]], &b = positions[triangle[1]], &c = positions[triangle[2]];
        return largest(b - a) < k_least_size && largest(c - a) < k_least_size;
    });
}

bool can_be_met(const std::vector<glm::vec3>& positions)
{
    return std::all_of(positions.begin(), positions.end(),
                       [](const glm::vec3& p) { return largest(p) < k_largest_met; });
}

void Solid::attach_margin(RTCDevice device)
{
    margin_geometry = GeometryHandle(rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE));
    rtcSetSharedGeometryBuffer(margin_geometry.get(), RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                               margin_corners.data(), 0, sizeof(glm::vec3), 2);
    rtcSetSharedGeometryBuffer(margin_geometry.get(), RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, k_corners, 0,
                               sizeof k_corners[0], 2);
    rtcSetGeometryMask(margin_geometry.get(), 0);
    rtcSetGeometryBuildQuality(margin_geometry.get(), RTC_BUILD_QUALITY_MEDIUM);
    set_margin(margin);
    rtcAttachGeometryByID(tree.get(), margin_geometry.get(), static_cast<unsigned>(records.size()));
}

void Solid::set_margin(float wanted)
{
    margin = wanted;
    margin_corners[0] = box.empty() ? glm::vec3(0) : box.low - margin;
    margin_corners[1] = box.empty() ? glm::vec3(0) : box.high + margin;
    rtcUpdateGeometryBuffer(margin_geometry.get(), RTC_BUFFER_TYPE_VERTEX, 0);
    rtcCommitGeometry(margin_geometry.get());
}

// Largest coordinate of everything that rays come to.
float RayScene::Impl::present_reach() const
{
    float reach = still_reach;
    for (const Solid& solid : solids)
        if (solid.visible && solid.has_volume && solid.reach <= k_largest_coordinate)
            reach = std::max(reach, solid.reach);
    return reach;
}

// From the present alone, so that a scene that was followed has the trees of a new one.
void RayScene::Impl::follow_margins()
{
    const float reach = present_reach();
    for (Solid& solid : solids) {
        if (!solid.has_volume) continue;
        const float margin = margin_of(reach, solid.to_world);
        if (margin == solid.margin) continue;
        solid.set_margin(margin);
        device.commit(solid.tree.get());
        rtcCommitGeometry(solid.instance.get());
    }
}

}   // namespace gnomon::ray
