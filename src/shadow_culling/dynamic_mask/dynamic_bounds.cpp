// SPDX-License-Identifier: Apache-2.0
#include "shadow_culling/dynamic_mask/dynamic_bounds.h"

#include <algorithm>

#include "base/volume.h"

namespace gnomon::shadow_culling {

namespace {

// Boxes are widened by this fraction of their largest coordinate, and of those between which a ray goes: rays are
// traced in single precision.
constexpr float k_widen = 1e-5f;

float largest_of(const glm::vec3& p)
{
    return std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)});
}

Box3 widened(Box3 box)
{
    if (box.empty()) return box;
    const float largest = std::max(largest_of(box.low), largest_of(box.high));
    box.low -= k_widen * largest;
    box.high += k_widen * largest;
    return box;
}

// Where something is that rays meet, by the box of its corners.
Box3 met(const Box3& box, ray::Meeting meeting)
{
    if (box.empty() || meeting == ray::Meeting::never) return Box3{};
    if (meeting == ray::Meeting::truly) return widened(box);
    return {glm::vec3(-k_largest_coordinate), glm::vec3(k_largest_coordinate)};
}

Box3 transformed(const Box3& box, const glm::mat4& m)
{
    Box3 result;
    for (int corner = 0; corner < 8; ++corner)
        result.add(
            transform_point(m, glm::vec3(corner & 1 ? box.high.x : box.low.x, corner & 2 ? box.high.y : box.low.y,
                                         corner & 4 ? box.high.z : box.low.z)));
    return result;
}

Box3 bounds_of(const ray::ObjectGeometry& geometry)
{
    Box3 box;
    for (const glm::uvec3& t : geometry.mesh->triangles)
        for (int i = 0; i < 3; ++i) box.add(geometry.positions[t[i]]);
    return box;
}

// Narrows [first, last] to the t for which low + t * slope_low <= high_box and high + t * slope_high >= low_box: the
// moving interval and the box's interval overlap.
bool narrow(float low, float slope_low, float high, float slope_high, float box_low, float box_high, float& first,
            float& last)
{
    const auto at_most = [&](float a, float slope, float limit) {   // a + t slope <= limit
        if (slope == 0) return a <= limit;
        const float t = (limit - a) / slope;
        if (slope > 0)
            last = std::min(last, t);
        else
            first = std::max(first, t);
        return first <= last;
    };
    return at_most(low, slope_low, box_high) && at_most(-high, -slope_high, -box_low);
}

}   // namespace

MoverBounds::MoverBounds(const scene::SceneState& state, const ray::RayScene& rays)
{
    const scene::Scene& scene = state.scene();
    by_group_.assign(scene.groups.size(), scene::none);
    by_object_.assign(scene.objects.size(), scene::none);
    for (scene::GroupId g = 0; g < scene.groups.size(); ++g) {
        by_group_[g] = static_cast<std::uint32_t>(movers_.size());
        Mover mover{scene::none, g, {}, {}, 0};
        for (const scene::ObjectId o : scene.groups[g].objects)
            if (!rays.stands_alone(o)) mover.own.add(bounds_of(rays.geometry(o)));
        movers_.push_back(mover);
    }
    for (scene::ObjectId o = 0; o < scene.objects.size(); ++o) mover_of(o, scene, rays);
    for (Mover& mover : movers_) place(mover, state, rays);
    grow_tree();
}

// Takes in movers that are new.
void MoverBounds::grow_tree()
{
    if (tree_.size() == movers_.size()) return;
    std::vector<Box3> boxes;
    boxes.reserve(movers_.size());
    for (const Mover& mover : movers_) boxes.push_back(mover.world);
    tree_ = BoxTree(boxes);
}

// An object's own mover, or its group's; none for what stands still.
std::uint32_t MoverBounds::mover_of(scene::ObjectId object, const scene::Scene& scene, const ray::RayScene& rays)
{
    if (!rays.stands_alone(object)) {
        const scene::GroupId group = scene.objects[object].group;
        return group != scene::none ? by_group_[group] : scene::none;
    }
    if (by_object_[object] == scene::none) {
        by_object_[object] = static_cast<std::uint32_t>(movers_.size());
        movers_.push_back({object, scene::none, {}, {}, 0});
    }
    return by_object_[object];
}

void MoverBounds::place(Mover& mover, const scene::SceneState& state, const ray::RayScene& rays)
{
    mover.world = Box3{};
    if (mover.group != scene::none) {
        const scene::RigidGroup& group = state.scene().groups[mover.group];
        const auto o = std::find_if(group.objects.begin(), group.objects.end(),
                                    [&](scene::ObjectId object) { return !rays.stands_alone(object); });
        if (o != group.objects.end() && state.group_visible(mover.group))
            mover.world = met(transformed(mover.own, glm::mat4(state.world(group.anchor))), rays.meeting(*o));
    } else if (state.object_visible(mover.object)) {
        const ray::ObjectGeometry& geometry = rays.geometry(mover.object);
        const Box3 own = bounds_of(geometry);
        mover.world = met(geometry.to_world ? transformed(own, *geometry.to_world) : own, rays.meeting(mover.object));
    }
    const auto index = static_cast<std::uint32_t>(&mover - movers_.data());
    if (index < tree_.size()) tree_.move(index, mover.world);
}

void MoverBounds::update(const scene::SceneState& state, const ray::RayScene& rays)
{
    const scene::FrameChanges& changes = state.changes();
    const scene::Scene& scene = state.scene();
    ++updates_;
    const auto follow = [&](std::uint32_t m) {
        if (m == scene::none || movers_[m].placed_at == updates_) return;
        movers_[m].placed_at = updates_;
        place(movers_[m], state, rays);
    };
    for (const scene::GroupId g : changes.groups_moved) follow(by_group_[g]);
    for (const auto* list : {&changes.vanished, &changes.appeared, &changes.deformed, &changes.moved})
        for (const scene::ObjectId o : *list) follow(mover_of(o, scene, rays));
    grow_tree();
}

// Monotone: what it says of a box it says of every larger one around it. Rounding keeps order, so this holds to the
// bit.
bool may_shadow(const Box3& blocker, const Box3& points, const glm::vec3& light, bool directional)
{
    const glm::vec3 slope_low = directional ? light : light - points.low;
    const glm::vec3 slope_high = directional ? light : light - points.high;
    const float room =
        k_widen * std::max({largest_of(points.low), largest_of(points.high), directional ? 0 : largest_of(light)});
    float first = 0, last = directional ? k_infinity : 1;
    for (int axis = 0; axis < 3; ++axis)
        if (!narrow(points.low[axis], slope_low[axis], points.high[axis], slope_high[axis], blocker.low[axis] - room,
                    blocker.high[axis] + room, first, last))
            return false;
    return true;
}

std::size_t MoverBounds::select(const Box3& points, const glm::vec3& light, bool directional,
                                std::vector<Box3>& selected) const
{
    selected.clear();
    return tree_.find([&](const Box3& box) { return may_shadow(box, points, light, directional); },
                      [&](std::uint32_t mover) { selected.push_back(movers_[mover].world); });
}

void MoverBounds::select_of_all(const Box3& points, const glm::vec3& light, bool directional,
                                std::vector<Box3>& selected) const
{
    selected.clear();
    for (const Mover& mover : movers_)
        if (!mover.world.empty() && may_shadow(mover.world, points, light, directional))
            selected.push_back(mover.world);
}

bool segment_meets(const Box3& box, const glm::vec3& origin, const glm::vec3& direction, float end)
{
    const bool endless = !(end < k_infinity);
    const float room = k_widen * std::max(largest_of(origin), endless ? 0 : largest_of(origin + direction));
    float first = 0, last = end;
    for (int axis = 0; axis < 3; ++axis)
        if (!narrow(origin[axis], direction[axis], origin[axis], direction[axis], box.low[axis] - room,
                    box.high[axis] + room, first, last))
            return false;
    return true;
}

}   // namespace gnomon::shadow_culling
