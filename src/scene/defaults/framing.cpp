// SPDX-License-Identifier: Apache-2.0
#include "scene/defaults/framing.h"

#include <algorithm>
#include <limits>
#include <optional>

#include "base/bits.h"
#include "scene/convex_hull.h"
#include "scene/file_surfaces.h"
#include "scene/node_poses.h"

namespace gnomon::scene {

namespace {

constexpr double k_least_distance = 0.05;   // in front of the nearest point, as a fraction of the scene's size
constexpr double k_least_size = 1e-6;
// A floor: flat, and so many times as wide as what stands on it, which is not flat itself.
constexpr float k_floor_height = 0.02f, k_floor_width = 3, k_standing = 0.1f;
constexpr float k_sunk = 0.25f;   // of the height of what stands on a floor may be below it

// Of many points, a camera need not fit those within polygons that it fits already. The nearest ones count, too.
class OuterPoints {
 public:
    bool is_inner(const glm::dvec3& p)
    {
        if (polygons_[0].contains({p.z, p.x}) && polygons_[1].contains({p.z, p.y}) && p.z <= nearest_) return true;
        nearest_ = std::max(nearest_, p.z);
        points_[0].emplace_back(p.z, p.x);
        points_[1].emplace_back(p.z, p.y);
        if (points_[0].size() < k_pending) return false;
        for (int axis = 0; axis < 2; ++axis) {
            hulls_[axis].insert(hulls_[axis].end(), points_[axis].begin(), points_[axis].end());
            points_[axis].clear();
            reduce_to_hull(hulls_[axis]);
            polygons_[axis] = InnerPolygon(hulls_[axis]);
        }
        return false;
    }

 private:
    static constexpr std::size_t k_pending = 1024;   // points that are collected before the polygons grow
    std::vector<glm::dvec2> points_[2], hulls_[2];
    InnerPolygon polygons_[2];
    double nearest_ = -std::numeric_limits<double>::max();
};

// What the image must show: its box, and unless that suffices, what a camera must fit.
struct Content {
    std::optional<CameraFit> fit;
    glm::dmat3 to_camera{1};
    Box3 box;
    OuterPoints outer;

    void add(const glm::vec3& p)
    {
        box.add(p);
        if (!fit) return;
        const glm::dvec3 from_camera = to_camera * glm::dvec3(p);
        if (!outer.is_inner(from_camera)) fit->add(from_camera);
    }
};

// The objects of a scene in which nothing deforms, at one time after another.
class RigidObjects {
 public:
    static constexpr bool k_rigid = true;
    RigidObjects(const Scene& scene, double time) : scene_(scene), poses_(scene, time) {}
    void go_to(double time) { poses_.go_to(time); }
    bool is_visible(ObjectId id) const
    {
        return !scene_.objects[id].removed && poses_.visible(scene_.objects[id].node);
    }
    glm::mat4 matrix(ObjectId id) const { return glm::mat4(poses_.world(scene_.objects[id].node)); }
    const std::vector<glm::vec3>& positions(ObjectId id) const
    {
        return scene_.meshes[scene_.objects[id].mesh].positions;
    }

 private:
    const Scene& scene_;
    NodePoses poses_;
};

// Those of any scene.
class AnyObjects {
 public:
    static constexpr bool k_rigid = false;
    AnyObjects(const Scene& scene, double time) : state_({std::shared_ptr<const Scene>(), &scene}, time) {}
    void go_to(double time) { state_.advance(time); }
    bool is_visible(ObjectId id) const { return state_.object_visible(id); }
    glm::mat4 matrix(ObjectId id) const { return state_.object_matrix(id); }
    const std::vector<glm::vec3>& positions(ObjectId id) const
    {
        const Object& object = state_.scene().objects[id];
        return object.deforming ? state_.deformed(id).positions : state_.scene().meshes[object.mesh].positions;
    }

 private:
    SceneState state_;   // its pointer does not own the scene
};

// Collects the vertices of objects.
class Collector {
 public:
    /// @param rigid  no object deforms
    Collector(const Scene& scene, bool rigid) : scene_(scene), rigid_(rigid), used_(scene.meshes.size()) {}

    template <class Objects>
    void add(const Objects& objects, ObjectId id, Content& content)
    {
        if (!objects.is_visible(id)) return;
        const glm::mat4 world = objects.matrix(id);
        const std::vector<glm::vec3>& positions = objects.positions(id);
        for (const std::uint32_t v : used_in(scene_.objects[id].mesh))
            if (const glm::vec3 p = transform_point(world, positions[v]); is_finite(p)) content.add(p);
    }

 private:
    // The vertices of a mesh's triangles. A vertex may belong to many triangles, and to none. Of few vertices, those in
    // the place of others are left out, because many objects may show them.
    const std::vector<std::uint32_t>& used_in(MeshId id)
    {
        std::optional<std::vector<std::uint32_t>>& list = used_[id];
        if (list) return *list;
        const Mesh& mesh = scene_.meshes[id];
        std::vector<char> used(mesh.positions.size());
        for (const glm::uvec3& triangle : mesh.triangles)
            for (int i = 0; i < 3; ++i) used[triangle[i]] = 1;
        list.emplace();
        constexpr std::size_t k_few = 64;
        for (std::uint32_t v = 0; v < used.size(); ++v) {
            const bool repeated =
                rigid_ && used.size() <= k_few && std::any_of(list->begin(), list->end(), [&](std::uint32_t other) {
                    return same_bits(mesh.positions[v], mesh.positions[other]);
                });
            if (used[v] && !repeated) list->push_back(v);
        }
        return *list;
    }

    const Scene& scene_;
    bool rigid_;
    std::vector<std::optional<std::vector<std::uint32_t>>> used_;   // by mesh
};

// The number of times at which a clip is looked at.
int looks_at(const Scene& scene, const FramingOptions& options)
{
    constexpr double k_most = 480;
    std::size_t vertices = 1;
    for (const Object& object : scene.objects)
        if (object.dynamic) vertices += scene.meshes[object.mesh].positions.size();
    const double frames = std::min(static_cast<double>(scene.timeline.frames), k_most);
    const std::size_t affordable = options.vertices / vertices;
    return std::max(options.looks, static_cast<int>(std::min(frames, static_cast<double>(affordable))));
}

template <class Objects>
Content content_of(const Scene& scene, const FramingOptions& options, Content content)
{
    const double start = scene.timeline.start, length = scene.timeline.end - start;
    const auto objects = static_cast<ObjectId>(scene.objects.size());
    Objects at(scene, start);
    Collector collector(scene, Objects::k_rigid);
    Content& first = content;
    // Begin with some objects all over the scene, so that most of the others lie within what these need.
    constexpr ObjectId k_stride = 64;
    std::vector<ObjectId> order;
    for (ObjectId id = 0; id < objects; id += k_stride) order.push_back(id);
    for (ObjectId id = 0; id < objects; ++id)
        if (id % k_stride != 0) order.push_back(id);
    std::erase_if(order, [&](ObjectId id) { return id < options.left_out.size() && options.left_out[id]; });
    for (const ObjectId id : order) collector.add(at, id, first);
    std::erase_if(order, [&](ObjectId id) { return !scene.objects[id].dynamic; });
    Content all = first;
    const int looks = length > 0 ? looks_at(scene, options) : 1;
    for (int look = 1; look < looks; ++look) {
        at.go_to(start + length * look / (looks - 1));
        for (const ObjectId id : order) collector.add(at, id, all);
    }
    // What has no size in the first frame, such as something that grows out of a point, says nothing.
    constexpr float k_point = 1e-6f;
    const bool goes_far = !first.box.empty() && first.box.diagonal() > k_point * all.box.diagonal() &&
                          all.box.diagonal() > options.widest_clip * first.box.diagonal();
    Content result = std::move(goes_far ? first : all);
    if (result.box.empty())
        for (int corner = 0; corner < 8; ++corner)
            result.add({corner & 1 ? 0.6f : -0.6f, corner & 2 ? 0.6f : -0.6f, corner & 4 ? 0.6f : -0.6f});
    return result;
}

// Collects what a clip shows, from nothing but what `content` says.
Content content_of_clip(const Scene& scene, const FramingOptions& options, Content content)
{
    const bool deforms =
        std::any_of(scene.objects.begin(), scene.objects.end(), [](const Object& object) { return object.deforming; });
    return deforms ? content_of<AnyObjects>(scene, options, std::move(content))
                   : content_of<RigidObjects>(scene, options, std::move(content));
}

double size_of(const Content& content)
{
    return std::max(static_cast<double>(content.box.diagonal()), k_least_size);
}

// The box of an object at a time; empty if it is not visible.
Box3 box_of(const SceneState& state, ObjectId id)
{
    Box3 box;
    if (!state.object_visible(id)) return box;
    const Object& object = state.scene().objects[id];
    const Mesh& mesh = state.scene().meshes[object.mesh];
    const glm::mat4 world = state.object_matrix(id);
    for (const glm::vec3& position : object.deforming ? state.deformed(id).positions : mesh.positions)
        if (const glm::vec3 p = transform_point(world, position); is_finite(p)) box.add(p);
    return box;
}

// Whether a box is that of a wide floor below others.
bool is_wide_floor(const Box3& box, const Box3& rest)
{
    if (box.empty() || rest.empty()) return false;
    const glm::vec3 size = box.size(), of_rest = rest.size(), middle = rest.centre();
    const float side = std::min(size.x, size.z), widest = std::max(of_rest.x, of_rest.z);
    if (!(side > k_floor_width * widest) || size.y > k_floor_height * side) return false;
    if (of_rest.y < k_standing * widest || rest.low.y < box.low.y - k_sunk * of_rest.y) return false;
    return middle.x > box.low.x && middle.x < box.high.x && middle.z > box.low.z && middle.z < box.high.z;
}

// Leaves out one floor, if there is one, of the objects that are not left out.
bool leave_out_floor(const Scene& scene, const std::vector<Box3>& boxes, std::vector<char>& left_out)
{
    const auto width = [&](ObjectId id) { return std::min(boxes[id].size().x, boxes[id].size().z); };
    ObjectId widest = none;
    for (ObjectId id = 0; id < scene.objects.size(); ++id)
        if (!left_out[id] && !boxes[id].empty() && (widest == none || width(id) > width(widest))) widest = id;
    if (widest == none || scene.objects[widest].dynamic) return false;
    Box3 rest;
    for (ObjectId id = 0; id < scene.objects.size(); ++id)
        if (!left_out[id] && id != widest && !boxes[id].empty()) rest.add(boxes[id].low), rest.add(boxes[id].high);
    if (!is_wide_floor(boxes[widest], rest)) return false;
    left_out[widest] = 1;
    return true;
}

}   // namespace

std::vector<char> surrounding_objects(const SceneState& state)
{
    const Scene& scene = state.scene();
    std::vector<char> left_out(scene.objects.size());
    for (ObjectId id = 0; id < scene.objects.size(); ++id) {
        const Mesh& mesh = scene.meshes[scene.objects[id].mesh];
        left_out[id] = !mesh.parts.empty() &&
                       std::all_of(mesh.parts.begin(), mesh.parts.end(),
                                   [&](const MeshPart& part) { return scene.materials[part.material].outline; });
    }
    // A floor below a dome may be as wide as it; what stands there is the rest.
    Box3 dome;
    std::vector<Box3> boxes(scene.objects.size());
    for (ObjectId id = 0; id < scene.objects.size(); ++id) {
        boxes[id] = box_of(state, id);
        if (left_out[id] && !boxes[id].empty()) dome.add(boxes[id].low), dome.add(boxes[id].high);
    }
    std::vector<char> floors(scene.objects.size());
    Box3 rest;
    for (ObjectId id = 0; id < scene.objects.size(); ++id) {
        if (left_out[id] || boxes[id].empty()) continue;
        floors[id] = !dome.empty() && is_floor_of_dome(boxes[id], dome);
        if (!floors[id]) rest.add(boxes[id].low), rest.add(boxes[id].high);
    }
    bool any = false;
    for (ObjectId id = 0; id < scene.objects.size(); ++id) {
        if (left_out[id] || floors[id]) left_out[id] = !rest.empty() && boxes[id].diagonal() > k_dome * rest.diagonal();
        any = any || left_out[id];
    }
    // So may a floor without a dome, and another one below it.
    constexpr int k_floors = 4;
    for (int floor = 0; floor < k_floors && leave_out_floor(scene, boxes, left_out); ++floor) any = true;
    return any ? left_out : std::vector<char>();
}

std::vector<char> all_but_largest_group(const SceneState& state)
{
    const auto count = static_cast<ObjectId>(state.scene().objects.size());
    std::vector<Box3> boxes(count);
    std::vector<char> left_out(count, 1);
    Box3 group;
    ObjectId largest = none;
    for (ObjectId id = 0; id < count; ++id) {
        boxes[id] = box_of(state, id);
        if (boxes[id].empty()) continue;
        if (largest == none || boxes[id].diagonal() > boxes[largest].diagonal()) largest = id;
    }
    if (largest == none) return {};
    left_out[largest] = 0, group = boxes[largest];
    // Add what is no farther away than the group is large, until nothing is.
    for (bool grows = true; grows;) {
        grows = false;
        const float reach = group.diagonal();
        for (ObjectId id = 0; id < count; ++id) {
            if (!left_out[id] || boxes[id].empty()) continue;
            const glm::vec3 apart =
                glm::max(glm::max(boxes[id].low - group.high, group.low - boxes[id].high), glm::vec3(0));
            if (!(glm::length(apart) <= reach)) continue;
            left_out[id] = 0, grows = true;
            group.add(boxes[id].low), group.add(boxes[id].high);
        }
    }
    return std::find(left_out.begin(), left_out.end(), 1) == left_out.end() ? std::vector<char>() : left_out;
}

glm::dmat3 camera_axes(const glm::dvec3& back)
{
    const glm::dvec3 right = glm::normalize(glm::cross(glm::dvec3(0, 1, 0), back));
    return {right, glm::cross(back, right), back};
}

Framed frame_clip(const Scene& scene, const FramingOptions& options)
{
    Framed framed;
    framed.axes = camera_axes(options.back);
    Content content = content_of_clip(
        scene, options,
        {CameraFit(CameraFit::Lens{options.vertical_fov, options.margin, 0}), glm::transpose(framed.axes), {}, {}});
    framed.box = content.box;
    framed.size = size_of(content);
    content.fit->set_least_distance(k_least_distance * framed.size);
    framed.fit = std::make_shared<const CameraFit>(*std::move(content.fit));
    return framed;
}

Framed box_of_clip(const Scene& scene)
{
    const Content content = content_of_clip(scene, {}, {});
    Framed framed;
    framed.box = content.box;
    framed.size = size_of(content);
    return framed;
}

}   // namespace gnomon::scene
