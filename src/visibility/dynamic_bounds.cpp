// SPDX-License-Identifier: Apache-2.0
#include "visibility/dynamic_bounds.h"

#include <algorithm>

#include "base/volume.h"

namespace gnomon::visibility {

namespace {

// Boxes are widened by this fraction of their own largest coordinate and of those of a ray's ends, because rays are
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

// The box in which rays may hit an object, from the box of its vertices.
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

DynamicBounds::DynamicBounds(const scene::SceneState& state, const ray::RayScene& rays)
{
    const scene::Scene& scene = state.scene();
    by_group_.assign(scene.groups.size(), scene::none);
    by_object_.assign(scene.objects.size(), scene::none);
    for (scene::GroupId g = 0; g < scene.groups.size(); ++g) measure_group(g, state, rays);
    for (const scene::ObjectId o : state.dynamic_objects())
        if (!scene.objects[o].removed) dynamic_of(o, state);
    for (DynamicObject& dynamic_object : dynamic_) place(dynamic_object, state, rays);
    grow_tree();
}

// Measures a group in its anchor's space, and makes its entry if it has none yet.
void DynamicBounds::measure_group(scene::GroupId group, const scene::SceneState& state, const ray::RayScene& rays)
{
    if (by_group_[group] == scene::none) {
        by_group_[group] = static_cast<std::uint32_t>(dynamic_.size());
        dynamic_.push_back({scene::none, group, {}, {}, 0});
    }
    Box3& own = dynamic_[by_group_[group]].own;
    own = Box3{};
    for (const scene::ObjectId o : state.scene().groups[group].objects)
        if (state.group_of(o) == group) own.add(bounds_of(rays.geometry(o)));
}

// Rebuilds the tree if there are new boxes.
void DynamicBounds::grow_tree()
{
    if (tree_.size() == dynamic_.size()) return;
    std::vector<Box3> boxes;
    boxes.reserve(dynamic_.size());
    for (const DynamicObject& dynamic_object : dynamic_) boxes.push_back(dynamic_object.world);
    tree_ = BoxTree(boxes);
}

// Returns the entry of a dynamic object or of its group; makes it if the object has none yet.
std::uint32_t DynamicBounds::dynamic_of(scene::ObjectId object, const scene::SceneState& state)
{
    if (const scene::GroupId group = state.group_of(object); group != scene::none) return by_group_[group];
    if (by_object_[object] == scene::none) {
        by_object_[object] = static_cast<std::uint32_t>(dynamic_.size());
        dynamic_.push_back({object, scene::none, {}, {}, 0});
    }
    return by_object_[object];
}

void DynamicBounds::place(DynamicObject& dynamic_object, const scene::SceneState& state, const ray::RayScene& rays)
{
    dynamic_object.world = Box3{};
    if (dynamic_object.group != scene::none) {
        const scene::RigidGroup& group = state.scene().groups[dynamic_object.group];
        const auto o = std::find_if(group.objects.begin(), group.objects.end(), [&](scene::ObjectId member) {
            return state.group_of(member) == dynamic_object.group;
        });
        if (o != group.objects.end() && state.group_visible(dynamic_object.group))
            dynamic_object.world =
                met(transformed(dynamic_object.own, glm::mat4(state.world(group.anchor))), rays.meeting(*o));
    } else if (state.object_visible(dynamic_object.object)) {
        const ray::ObjectGeometry& geometry = rays.geometry(dynamic_object.object);
        const Box3 own = bounds_of(geometry);
        dynamic_object.world =
            met(geometry.to_world ? transformed(own, *geometry.to_world) : own, rays.meeting(dynamic_object.object));
    }
    const auto index = static_cast<std::uint32_t>(&dynamic_object - dynamic_.data());
    if (index < tree_.size()) tree_.move(index, dynamic_object.world);
}

void DynamicBounds::update(const scene::SceneState& state, const ray::RayScene& rays)
{
    const scene::FrameChanges& changes = state.changes();
    ++updates_;
    placed_.clear();
    const auto follow = [&](std::uint32_t m) {
        if (dynamic_[m].placed_at == updates_) return;
        dynamic_[m].placed_at = updates_;
        placed_.push_back({m, dynamic_[m].world});
        place(dynamic_[m], state, rays);
    };
    by_group_.resize(state.scene().groups.size(), scene::none);
    by_object_.resize(state.scene().objects.size(), scene::none);
    for (const scene::ObjectId o : changes.added)
        if (const scene::GroupId g = state.group_of(o); g != scene::none) measure_group(g, state, rays);
    for (const scene::GroupId g : changes.groups_moved) follow(by_group_[g]);
    for (const scene::ObjectId o : changes.changed) follow(dynamic_of(o, state));
    for (const scene::ObjectId o : changes.added) follow(dynamic_of(o, state));
    grow_tree();
}

// Monotone: if it is true for a box, it is true for every box around it. Rounding is monotone, so this holds to the
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

bool may_shadow(const Box3& blocker, const Box3& points, const Box3& light)
{
    const float room = k_widen * std::max({largest_of(points.low), largest_of(points.high), largest_of(light.low),
                                           largest_of(light.high)});
    const glm::vec3 slope_low = light.low - points.low, slope_high = light.high - points.high;
    float first = 0, last = 1;
    for (int axis = 0; axis < 3; ++axis)
        if (!narrow(points.low[axis], slope_low[axis], points.high[axis], slope_high[axis], blocker.low[axis] - room,
                    blocker.high[axis] + room, first, last))
            return false;
    return true;
}

bool may_shadow(const Box3& blocker, const Box3& points, const glm::vec3& to_light, float radius)
{
    const float room = k_widen * std::max(largest_of(points.low), largest_of(points.high));
    // Unit vectors within the angle differ from the middle by less, in each coordinate.
    const glm::vec3 slope_low = to_light - radius - k_widen, slope_high = to_light + radius + k_widen;
    float first = 0, last = k_infinity;
    for (int axis = 0; axis < 3; ++axis)
        if (!narrow(points.low[axis], slope_low[axis], points.high[axis], slope_high[axis], blocker.low[axis] - room,
                    blocker.high[axis] + room, first, last))
            return false;
    return true;
}

std::size_t DynamicBounds::select(const Box3& points, const Box3& light, std::vector<std::uint32_t>& selected) const
{
    selected.clear();
    return tree_.find([&](const Box3& box) { return may_shadow(box, points, light); },
                      [&](std::uint32_t dynamic_object) { selected.push_back(dynamic_object); });
}

void DynamicBounds::objects_of(std::uint32_t index, const scene::SceneState& state,
                               std::vector<scene::ObjectId>& objects) const
{
    objects.clear();
    const DynamicObject& dynamic_object = dynamic_[index];
    if (dynamic_object.group == scene::none) {
        objects.push_back(dynamic_object.object);
        return;
    }
    for (const scene::ObjectId o : state.scene().groups[dynamic_object.group].objects)
        if (state.group_of(o) == dynamic_object.group) objects.push_back(o);
}

std::size_t DynamicBounds::select(const Box3& points, const glm::vec3& light, bool directional,
                                  std::vector<Box3>& selected) const
{
    selected.clear();
    return tree_.find([&](const Box3& box) { return may_shadow(box, points, light, directional); },
                      [&](std::uint32_t dynamic_object) { selected.push_back(dynamic_[dynamic_object].world); });
}

void DynamicBounds::select_of_all(const Box3& points, const glm::vec3& light, bool directional,
                                  std::vector<Box3>& selected) const
{
    selected.clear();
    for (const DynamicObject& dynamic_object : dynamic_)
        if (!dynamic_object.world.empty() && may_shadow(dynamic_object.world, points, light, directional))
            selected.push_back(dynamic_object.world);
}

void DynamicBounds::all(std::vector<Box3>& boxes) const
{
    boxes.clear();
    for (const DynamicObject& dynamic_object : dynamic_)
        if (!dynamic_object.world.empty()) boxes.push_back(dynamic_object.world);
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

}   // namespace gnomon::visibility
