// SPDX-License-Identifier: Apache-2.0
#include "frame/shutter.h"

#include <algorithm>
#include <array>
#include <map>
#include <vector>

#include "scene/emission.h"

namespace gnomon::frame {

namespace {

constexpr int k_probes = 9;             // times at which motion is looked for, the shutter's ends among them
constexpr int k_grid = 15;              // places of an image a side
constexpr double k_camera_margin = 2;   // what moves past a camera may be nearer than the places that were looked at

bool same_view(const scene::View& a, const scene::View& b)
{
    return a.eye == b.eye && a.right == b.right && a.up == b.up && a.forward == b.forward && a.shift == b.shift;
}

bool emits(const scene::Scene& scene, const scene::Object& object)
{
    return std::ranges::any_of(scene.meshes[object.mesh].parts, [&](const scene::MeshPart& part) {
        return scene::may_emit(scene.materials[part.material]);
    });
}

// The box of an object's vertices in the space of its node, or in the world for skinned ones.
Box3 own_box(const scene::SceneState& state, scene::ObjectId id)
{
    const scene::Object& object = state.scene().objects[id];
    if (!object.deforming) return state.scene().meshes[object.mesh].bounds();
    Box3 box;
    for (const glm::vec3& p : state.deformed(id).positions) box.add(p);
    return box;
}

// The corners of an object's box in the world.
std::array<glm::dvec3, 8> corners_of(const scene::SceneState& state, scene::ObjectId id)
{
    const scene::Object& object = state.scene().objects[id];
    const Box3 box = own_box(state, id);
    std::array<glm::dvec3, 8> corners;
    for (std::size_t i = 0; i < corners.size(); ++i) {
        const glm::dvec3 corner(i & 1 ? box.high.x : box.low.x, i & 2 ? box.high.y : box.low.y,
                                i & 4 ? box.high.z : box.low.z);
        corners[i] = object.skin != scene::none ? corner : transform_point(state.world(object.node), corner);
    }
    return corners;
}

// How far points move in an image, in pixels: the longest way of one of them. Infinite where one is not in front.
template <class Points>
double way(const scene::View& before, const Points& from, const scene::View& now, const Points& to)
{
    double longest = 0;
    for (std::size_t i = 0; i < from.size(); ++i) {
        const std::optional<glm::dvec2> a = before.project(from[i]), b = now.project(to[i]);
        if (!a || !b) return k_infinity;
        longest = std::max(longest, glm::length(*b - *a));
    }
    return longest;
}

// Sets the number of poses for which blurred edges have no steps, and that of phases for which first samples meet what
// moves in every part of its way: within the pixels around each that tell of its error.
void set_times(double pixels, trace::BlurMotion& motion)
{
    constexpr int k_seen_around = 4;   // pixels
    motion.times = trace::k_first_blur_samples;
    while (motion.times < trace::k_most_blur_times && motion.times < pixels) motion.times *= 2;
    if (motion.times < trace::k_most_blur_times) return;
    while (trace::k_first_blur_samples * motion.phases < trace::k_most_blur_times &&
           trace::k_first_blur_samples * motion.phases * k_seen_around < pixels)
        motion.phases *= 2;
}

}   // namespace

SeenPlaces see_places(const ray::RayScene& rays, const scene::View& view)
{
    ray::RayQueue queue;
    queue.purpose = ray::RayClass::check;
    const auto place = [](int i, int side) {
        return (static_cast<float>(i) + 0.5f) * static_cast<float>(side) / static_cast<float>(k_grid);
    };
    for (int j = 0; j < k_grid; ++j)
        for (int i = 0; i < k_grid; ++i) {
            glm::vec3 origin, direction;
            float tnear, tfar;
            view.ray(place(i, view.size.width), place(j, view.size.height), origin, direction, tnear, tfar);
            queue.push(origin, tnear, direction, tfar);
        }
    ray::Hits hits;
    hits.resize(queue.size());
    rays.closest(queue, 0, queue.size(), hits, ray::Sides::front);
    SeenPlaces places;
    for (int k = 0; k < k_grid * k_grid; ++k) {
        const auto at = static_cast<std::size_t>(k);
        const bool hit = hits.object[at] != scene::none;
        const glm::vec3 point = queue.origin(at) + hits.t[at] * queue.direction(at);
        if (hit) places.points.emplace_back(point);
        const auto middle = [](int i) { return i >= k_grid / 3 && i < k_grid - k_grid / 3; };
        if (middle(k % k_grid) && middle(k / k_grid))
            places.middle_depths.push_back(hit ? glm::dot(point - view.eye, view.forward) : k_infinity);
    }
    std::sort(places.middle_depths.begin(), places.middle_depths.end());
    return places;
}

trace::BlurMotion find_motion(const scene::SceneState& state, const scene::View& view, const Shutter& shutter,
                              const SeenPlaces& places)
{
    trace::BlurMotion motion;
    if (!(shutter.close > shutter.open)) return motion;
    const auto fraction = [](int i) { return static_cast<double>(i) / (k_probes - 1); };
    scene::SceneState posed(state.base(), shutter.at(0));
    if (shutter.host) shutter.host->apply_all(posed), shutter.host->apply_pose(posed, 0);
    posed.advance(shutter.at(0));

    // Note the boxes of what moves from one time to the next, and how far it moves in the image.
    std::map<scene::ObjectId, Box3> boxes;
    std::map<scene::ObjectId, std::array<glm::dvec3, 8>> corners;
    for (const scene::ObjectId o : posed.dynamic_objects()) corners[o] = corners_of(posed, o);
    std::vector<scene::Light> lights = posed.scene().lights;
    scene::View view_before = shutter.view_at(posed, 0);
    double pixels = 0, of_camera = 0;
    for (int i = 1; i < k_probes; ++i) {
        if (shutter.host) shutter.host->apply_pose(posed, fraction(i));
        const scene::FrameChanges& changes = posed.advance(shutter.at(fraction(i)));
        const scene::View now = shutter.view_at(posed, fraction(i));
        const bool camera = !same_view(view_before, now);
        if (!changes.lights_moved.empty() || !changes.lights_relit.empty() || !changes.materials_changed.empty())
            motion.relit = true;
        // Edges of shadows and cones may move by any number of pixels.
        if (!changes.lights_moved.empty()) pixels = k_infinity;
        for (const scene::LightId l : changes.lights_relit) {
            const scene::Light& light_now = posed.scene().lights[l];
            if (!scene::same_reach(lights[l], light_now)) pixels = k_infinity;
            lights[l] = light_now;
        }
        if (camera) motion.everything = true;
        if (camera) of_camera += way(view_before, places.points, now, places.points);
        double longest = 0;
        for (const scene::ObjectId o : changes.changed) {
            const auto to = corners_of(posed, o);
            const auto known = corners.try_emplace(o, to).first;
            if (posed.object_there(o)) longest = std::max(longest, way(view_before, known->second, now, to));
            Box3& box = boxes[o];
            for (int c = 0; c < 8; ++c) {
                const auto corner = static_cast<std::size_t>(c);
                box.add(glm::vec3(known->second[corner])), box.add(glm::vec3(to[corner]));
            }
            known->second = to;
            if (emits(posed.scene(), posed.scene().objects[o])) motion.relit = true;
        }
        pixels += longest;
        view_before = now;
    }
    motion.everything = motion.everything || motion.relit;
    for (const auto& [object, box] : boxes) motion.boxes.push_back(box), motion.objects.push_back(object);
    if (!motion.everything && boxes.empty()) return motion;
    pixels = std::max(pixels, k_camera_margin * of_camera);
    // Longer ways than the image are seen in part.
    set_times(std::min(pixels, static_cast<double>(std::max(view.size.width, view.size.height))), motion);
    return motion;
}

scene::Lens find_lens(const scene::View& view, const RenderOptions& options, const SeenPlaces& places)
{
    scene::Lens lens;
    if (options.f_number == 0 && options.aperture == 0) return lens;
    constexpr double k_millimetre = 1e-3;
    lens.radius = options.f_number > 0 ? scene::lens_radius(view, options.f_number)
                                       : static_cast<float>(0.5 * options.aperture * k_millimetre);
    const std::vector<float>& depths = places.middle_depths;
    const float middle = depths.empty() ? k_infinity : depths[depths.size() / 2];
    constexpr float k_far = 1e9f;   // in place of infinity
    lens.focus = options.focus ? static_cast<float>(*options.focus) : std::min(middle, k_far);
    return lens;
}

}   // namespace gnomon::frame
