// SPDX-License-Identifier: Apache-2.0
// Margins around the boxes of instances.
//
// Embree tests the boxes of instances with its fast test instead of the robust one, whatever the scene's flags are. A
// ray that passes such a box within rounding may miss it, and with it the triangles at its border. Whether it does
// depends on the other rays of its packet, because packets and single rays round differently. Far from the origin this
// affected one ray in ten thousand. Therefore the boxes get a margin larger than any rounding: two degenerate triangles
// at opposite corners of a larger box, which no ray hits. Inside the box, the robust test decides.
#include <algorithm>
#include <cmath>

#include "ray/embree/impl.h"
#include "ray/embree/packets.h"

namespace gnomon::ray {

namespace {

// Fraction of the largest coordinate in the scene. Bounds, rays and inverse matrices of instances each have an error of
// some ten units in the last place.
constexpr float k_margin_per_coordinate = 3e-6f;

// Embree treats numbers below 1.2e-38 as zero.
constexpr float k_least_size = 1e-36f;

constexpr float k_least_box = 1e-6f;   // half the width of the box of an object that is a point

constexpr unsigned k_corners[2][3] = {{0, 0, 0}, {1, 1, 1}};

// Embree ignores triangles with larger coordinates (above 1.8e18), and makes no boxes for them.
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

namespace {

// A margin without steps, in a scene with coordinates up to `reach`.
float wanted_margin(float reach, const glm::mat4& to_world)
{
    // An upper bound of the scale of the inverse matrix.
    const glm::mat3 inverse = glm::inverse(glm::mat3(to_world));
    const float stretch = std::sqrt(glm::dot(inverse[0], inverse[0]) + glm::dot(inverse[1], inverse[1]) +
                                    glm::dot(inverse[2], inverse[2]));
    return k_margin_per_coordinate * reach * stretch;
}

}   // namespace

float margin_of(float reach, const glm::mat4& to_world)
{
    const float wanted = wanted_margin(reach, to_world);
    if (!(wanted > 0 && wanted < k_largest_met)) return 0;
    return std::exp2(std::ceil(std::log2(wanted)));   // in steps, so that trees are rarely rebuilt
}

ReachRange range_of(float margin, float reach, const glm::mat4& to_world)
{
    constexpr float k_rounding = 1e-4f;
    const ReachRange alone{reach, reach};
    if (!(margin > 0)) return alone;
    // The margin without steps is in proportion to the reach, and the step ends where that is half the margin, or all.
    const float wanted = wanted_margin(reach, to_world);
    const ReachRange range{reach * (0.5f * margin / wanted) * (1 + k_rounding),
                           reach * (margin / wanted) * (1 - k_rounding)};
    return range.contains(reach) ? range : alone;
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
    // Embree asserts that boxes of instances are not all the same point, which those of a point, or of anything that is
    // small and far away, can be in float.
    if (margin_corners[0] == margin_corners[1]) {
        const float wide = std::max(k_least_box, k_margin_per_coordinate * largest(margin_corners[0]));
        margin_corners[0] -= wide;
        margin_corners[1] += wide;
    }
    rtcUpdateGeometryBuffer(margin_geometry.get(), RTC_BUFFER_TYPE_VERTEX, 0);
    rtcCommitGeometry(margin_geometry.get());
}

void Largest::resize(std::size_t count)
{
    std::size_t leaves = 1;
    while (leaves < count) leaves *= 2;
    tree_.assign(2 * leaves, 0.0f);
}

void Largest::set(std::size_t index, float value)
{
    std::size_t at = tree_.size() / 2 + index;
    tree_[at] = value;
    for (at /= 2; at > 0; at /= 2) tree_[at] = std::max(tree_[2 * at], tree_[2 * at + 1]);
}

// Largest coordinate of everything that rays can hit.
float RayScene::Impl::present_reach() const
{
    return std::max(still_reach, reaches.value());
}

void RayScene::Impl::note_reach(std::uint32_t s)
{
    const Solid& solid = solids[s];
    const bool counts = solid.visible && solid.has_volume && solid.reach <= k_largest_coordinate;
    reaches.set(s, counts ? solid.reach : 0);
}

void RayScene::Impl::note_all_reaches()
{
    reaches.resize(solids.size());
    for (std::uint32_t s = 0; s < solids.size(); ++s) note_reach(s);
}

// The reach that the margins of shared meshes are made for: that of the static scene times k_room, doubled until it
// holds everything, because the static scene is costly to commit again.
float RayScene::Impl::reach_of_shared() const
{
    constexpr float k_room = 4;
    const float present = present_reach();
    float reach = still_reach > 0 ? k_room * still_reach : present;
    while (reach < present) reach *= 2;
    return reach;
}

// A mesh that many static objects share has one BLAS, with the margin of its most shrunken instance.
float RayScene::Impl::shared_margin(const Solid& shared) const
{
    float margin = 0;
    for (const Placed& placed : still_instances)
        if (placed.shared == &shared && !placed.taken)
            margin = std::max(margin, margin_of(shared_reach, placed.to_world));
    return margin;
}

void RayScene::Impl::follow_shared_margins()
{
    if (shared_meshes.empty() || portable) return;
    const float reach = reach_of_shared();
    if (reach == shared_reach && !shared_taken) return;
    shared_reach = reach;
    shared_taken = false;
    bool changed = false;
    for (const auto& [mesh, shared] : shared_meshes) {
        const float margin = shared_margin(*shared);
        if (margin == shared->margin) continue;
        shared->set_margin(margin);
        device.commit(shared->tree.get());
        for (const Placed& placed : still_instances)
            if (placed.shared == shared.get())
                for (const unsigned id : still_ids[placed.object]) rtcCommitGeometry(rtcGetGeometry(still.get(), id));
        changed = true;
    }
    if (changed) device.commit(still.get());
}

void RayScene::Impl::follow_margin(Solid& solid, float reach)
{
    if (!solid.has_volume) return;
    // Its own reach counts even while it is hidden.
    const float own = std::max(reach, solid.reach);
    const float margin = margin_of(own, solid.to_world);
    ReachRange range = range_of(margin, own, solid.to_world);
    if (own > reach) range.low = 0;   // the present reach has no part in it
    same_margins = {std::max(same_margins.low, range.low), std::min(same_margins.high, range.high)};
    if (margin == solid.margin) return;
    solid.set_margin(margin);
    if (!portable) device.commit(solid.tree.get());
    rtcCommitGeometry(solid.instance.get());
}

// Margins depend on the present state only, so that an updated scene has the same trees as a new one.
void RayScene::Impl::follow_margins(bool all)
{
    if (all)
        note_all_reaches();
    else
        for (const std::uint32_t s : touched) note_reach(s);
    const float reach = present_reach();
    if (all || !same_margins.contains(reach)) {
        same_margins = {};
        for (Solid& solid : solids)
            if (solid.is_there()) follow_margin(solid, reach);
    } else {
        for (const std::uint32_t s : touched) follow_margin(solids[s], reach);
    }
    follow_shared_margins();
}

}   // namespace gnomon::ray
