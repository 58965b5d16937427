// SPDX-License-Identifier: Apache-2.0
#include "scene/defaults/framing.h"

#include <algorithm>

#include "scene/state.h"

namespace gnomon::scene {

namespace {

constexpr double k_least_distance = 0.05;   // in front of the nearest point, as a fraction of the scene's size
constexpr double k_least_size = 1e-6;

// What the image must show.
struct Content {
    CameraFit fit;
    glm::dmat3 to_camera;
    Box3 box;

    Content(const FramingOptions& options, const glm::dmat3& axes)
        : fit(CameraFit::Lens{options.vertical_fov, options.margin, 0}), to_camera(glm::transpose(axes))
    {
    }
    void add(const glm::vec3& p)
    {
        fit.add(to_camera * glm::dvec3(p));
        box.add(p);
    }
};

void add_object(const SceneState& state, ObjectId id, Content& content)
{
    if (!state.object_visible(id)) return;
    const Scene& scene = state.scene();
    const Object& object = scene.objects[id];
    const glm::mat4 world = state.object_matrix(id);
    const std::vector<glm::vec3>& positions =
        object.deforming ? state.deformed(id).positions : scene.meshes[object.mesh].positions;
    // A vertex may belong to many triangles, and to none.
    std::vector<char> used(positions.size());
    for (const glm::uvec3& triangle : scene.meshes[object.mesh].triangles)
        for (int i = 0; i < 3; ++i) used[triangle[i]] = 1;
    for (std::size_t v = 0; v < positions.size(); ++v)
        if (used[v])
            if (const glm::vec3 p = transform_point(world, positions[v]); is_finite(p)) content.add(p);
}

// The number of times at which a clip is looked at.
int looks_at(const Scene& scene, const FramingOptions& options)
{
    constexpr double k_most = 480;
    std::size_t vertices = 1;
    for (const Object& object : scene.objects)
        if (object.dynamic) vertices += scene.meshes[object.mesh].positions.size();
    const double frames = std::min(static_cast<double>(scene.timeline.frames), k_most);
    const auto affordable = static_cast<double>(options.vertices / vertices);
    return std::max(options.looks, static_cast<int>(std::min(frames, affordable)));
}

}   // namespace

glm::dmat3 camera_axes(const glm::dvec3& back)
{
    const glm::dvec3 right = glm::normalize(glm::cross(glm::dvec3(0, 1, 0), back));
    return {right, glm::cross(back, right), back};
}

Framed frame_clip(const Scene& scene, const FramingOptions& options)
{
    Framed framed;
    framed.axes = camera_axes(options.back);
    const double start = scene.timeline.start, length = scene.timeline.end - start;
    const auto objects = static_cast<ObjectId>(scene.objects.size());
    SceneState state({std::shared_ptr<const Scene>(), &scene}, start);   // the pointer does not own the scene
    Content first(options, framed.axes);
    for (ObjectId id = 0; id < objects; ++id) add_object(state, id, first);
    Content all = first;
    const int looks = length > 0 ? looks_at(scene, options) : 1;
    for (int look = 1; look < looks; ++look) {
        state.advance(start + length * look / (looks - 1));
        for (ObjectId id = 0; id < objects; ++id)
            if (scene.objects[id].dynamic) add_object(state, id, all);
    }
    const bool goes_far = !first.box.empty() && all.box.diagonal() > options.widest_clip * first.box.diagonal();
    Content& content = goes_far ? first : all;
    if (content.box.empty())
        for (int corner = 0; corner < 8; ++corner)
            content.add({corner & 1 ? 0.6f : -0.6f, corner & 2 ? 0.6f : -0.6f, corner & 4 ? 0.6f : -0.6f});
    framed.box = content.box;
    framed.size = std::max(static_cast<double>(content.box.diagonal()), k_least_size);
    content.fit.set_least_distance(k_least_distance * framed.size);
    framed.fit = std::make_shared<const CameraFit>(std::move(content.fit));
    return framed;
}

}   // namespace gnomon::scene
