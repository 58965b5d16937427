// SPDX-License-Identifier: Apache-2.0
#include "scene/scene_bounds.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "base/volume.h"
#include "scene/node_poses.h"
#include "scene/state.h"

namespace gnomon::scene {

namespace {

struct ObjectBox {
    Box3 box;
    double triangles;
};

// The value at which the sum of weights reaches a fraction of the total. Weights are whole numbers, so that the order
// in which they are added does not matter. Reorders the values; cost: O(n) on average.
float quantile(std::span<std::pair<float, double>> values, double fraction)
{
    double all = 0;
    for (const auto& [value, weight] : values) all += weight;
    double below = 0;   // the sum of the weights in front of the values that are left
    while (values.size() > 1) {
        const std::size_t half = values.size() / 2;
        std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(half), values.end());
        double sum = below;
        for (const auto& [value, weight] : values.first(half)) sum += weight;
        if (sum >= fraction * all)
            values = values.first(half);
        else
            values = values.subspan(half), below = sum;
    }
    return values.front().first;
}

// The box around the middle of the triangles that count, extended by objects that enlarge it little.
Box3 dense_part(const std::vector<ObjectBox>& boxes)
{
    constexpr double k_outliers = 0.1;   // fraction of triangles that may initially lie beyond each side
    constexpr float k_little = 0.25f;    // of its diagonal
    Box3 dense;
    std::vector<std::pair<float, double>> lows, highs;
    for (int axis = 0; axis < 3; ++axis) {
        lows.clear(), highs.clear();
        for (const ObjectBox& object : boxes) {
            if (!(object.triangles > 0)) continue;
            lows.emplace_back(object.box.low[axis], object.triangles);
            highs.emplace_back(object.box.high[axis], object.triangles);
        }
        if (lows.empty()) return {};
        dense.low[axis] = quantile(lows, k_outliers);
        dense.high[axis] = quantile(highs, 1 - k_outliers);
    }
    if (dense.empty()) return {};
    for (int round = 0; round < 2; ++round) {
        const float most = k_little * dense.diagonal();
        Box3 grown = dense;
        for (const ObjectBox& object : boxes) {
            const glm::vec3 below = dense.low - object.box.low, above = object.box.high - dense.high;
            const glm::vec3 beyond = glm::max(below, above);
            if (std::max({beyond.x, beyond.y, beyond.z}) <= most) grown.add(object.box);
        }
        dense = grown;
    }
    return dense;
}

// Whether products of a matrix with coordinates of float stay within the range of double, and are numbers.
bool is_moderate(const glm::dmat4& m)
{
    constexpr double k_most = 1e200;
    bool moderate = true;
    for (int column = 0; column < 4; ++column)
        for (int row = 0; row < 3; ++row) moderate = moderate & (std::abs(m[column][row]) < k_most);
    return moderate;
}

// Adds the corners of a box that a matrix transforms, as transform_point() does, but for those that are not finite.
void add_transformed(const glm::dmat4& m, const Box3& box, Box3& result)
{
    // Sums that are rounded rise with each summand, so that the least one has the least summands.
    const glm::dvec3 a(box.low), b(box.high);
    const glm::dvec3 xa(m[0] * a.x), xb(m[0] * b.x), ya(m[1] * a.y), yb(m[1] * b.y), za(m[2] * a.z), zb(m[2] * b.z);
    const glm::dvec3 origin(m[3]);
    const glm::vec3 low((glm::min(xa, xb) + glm::min(ya, yb)) + (glm::min(za, zb) + origin));
    const glm::vec3 high((glm::max(xa, xb) + glm::max(ya, yb)) + (glm::max(za, zb) + origin));
    if (is_moderate(m) && is_finite(box.low) && is_finite(box.high) && is_finite(low) && is_finite(high)) {
        result.add(low), result.add(high);
        return;
    }
    for (int corner = 0; corner < 8; ++corner) {
        const glm::dvec3 p(corner & 1 ? b.x : a.x, corner & 2 ? b.y : a.y, corner & 4 ? b.z : a.z);
        const glm::vec3 q(transform_point(m, p));
        if (is_finite(q)) result.add(q);
    }
}

}   // namespace

SceneBounds clip_bounds(const Scene& scene, int most_times)
{
    std::vector<Box3> meshes;
    for (const Mesh& mesh : scene.meshes) {
        Box3 box = mesh.bounds();
        if (mesh.vertex_keys)
            for (const auto& key : mesh.vertex_keys->positions)
                for (const glm::vec3& p : key) box.add(p);
        meshes.push_back(box);
    }
    SceneBounds bounds;
    std::vector<ObjectBox> boxes;
    const int frames = std::max(scene.timeline.frames, 1), times = std::min(frames, most_times);
    for (const Object& object : scene.objects) {
        const std::size_t triangles = object.by_default ? 0 : scene.meshes[object.mesh].triangles.size();
        boxes.push_back({{}, static_cast<double>(triangles)});
    }
    const bool moves =
        std::any_of(scene.objects.begin(), scene.objects.end(), [](const Object& o) { return o.dynamic; });
    // Compute the matrices of all nodes at once, because walking up from each is slow in deep hierarchies.
    NodePoses poses(scene, scene.timeline.time_of(1));
    for (int i = 0; i < (moves ? times : 1); ++i) {
        const int frame = times > 1 ? 1 + static_cast<int>(static_cast<std::int64_t>(frames - 1) * i / (times - 1)) : 1;
        if (frame > 1) poses.go_to(scene.timeline.time_of(frame));
        for (std::size_t o = 0; o < boxes.size(); ++o) {
            const Object& object = scene.objects[o];
            const Box3& box = meshes[object.mesh];
            if (box.empty() || object.removed || (i > 0 && !object.dynamic)) continue;
            add_transformed(poses.world(object.node), box, boxes[o].box);
        }
    }
    for (std::size_t o = 0; o < boxes.size(); ++o) {
        const Box3& reach = scene.nodes[scene.objects[o].node].reach;
        if (!scene.objects[o].removed && !reach.empty()) boxes[o].box.add(reach);
    }
    std::erase_if(boxes, [](const ObjectBox& placed) { return placed.box.empty(); });
    for (const ObjectBox& placed : boxes) bounds.whole.add(placed.box);
    if (!boxes.empty()) bounds.dense = dense_part(boxes);
    return bounds;
}

namespace {

// How far a side moves outwards to enclose `excess` beyond it.
double step_of(double extent, double excess)
{
    constexpr int k_least = -4;   // a sixteenth of the extent
    int power = k_least;
    while (std::ldexp(extent, power) < excess) ++power;
    return std::ldexp(extent, power);
}

// Rounding aside: what only just touches the clip's bounds is inside.
bool exceeds(const Box3& clip, const Box3& box)
{
    constexpr float k_rounding = 1e-5f;   // of the clip's diagonal
    const glm::vec3 margin(clip.empty() ? 0.0f : k_rounding * clip.diagonal());
    return clip.empty() || glm::any(glm::lessThan(box.low, clip.low - margin)) ||
           glm::any(glm::greaterThan(box.high, clip.high + margin));
}

}   // namespace

Box3 enlarged_bounds(const Box3& clip, const Box3& outside)
{
    if (outside.empty()) return clip;
    Box3 result = clip;
    if (clip.empty()) result = {glm::vec3(0), glm::vec3(0)};
    const glm::dvec3 size(result.size());
    for (int axis = 0; axis < 3; ++axis) {
        // A flat scene has steps of its diagonal, a point steps of one unit.
        double extent = size[axis];
        if (!(extent > 0)) extent = glm::length(size);
        if (!(extent > 0)) extent = 1;
        const double low = static_cast<double>(result.low[axis]), high = static_cast<double>(result.high[axis]);
        const double below = low - static_cast<double>(outside.low[axis]);
        const double above = static_cast<double>(outside.high[axis]) - high;
        if (below > 0) result.low[axis] = std::min(static_cast<float>(low - step_of(extent, below)), outside.low[axis]);
        if (above > 0)
            result.high[axis] = std::max(static_cast<float>(high + step_of(extent, above)), outside.high[axis]);
    }
    return result;
}

PresentBounds::PresentBounds(const SceneState& state) : clip_(clip_bounds(state.scene())), present_(clip_)
{
    follow(state);
}

void PresentBounds::follow(const SceneState& state)
{
    if (!state.any_displaced()) {
        watching_ = false;
        outside_.clear();
        present_ = clip_;
        return;
    }
    // Measure what changed; everything dynamic when the first override comes into force.
    if (watching_)
        for (const ObjectId object : state.changes().changed) measure(state, object);
    else
        for (const ObjectId object : state.dynamic_objects()) measure(state, object);
    watching_ = true;
    enlarge(state);
}

const PresentBounds::MeshFacts& PresentBounds::facts_of(const Scene& scene, MeshId id)
{
    const auto [at, fresh] = meshes_.try_emplace(id);
    if (!fresh) return at->second;
    const Mesh& mesh = scene.meshes[id];
    at->second.box = mesh.bounds();
    for (const MeshPart& part : mesh.parts)
        at->second.casts |=
            part.triangle_count > 0 && scene.materials[part.material].surface_class() != SurfaceClass::transparent;
    return at->second;
}

// Lists an object if it reaches outside, or removes it from the list.
void PresentBounds::measure(const SceneState& state, ObjectId id)
{
    outside_.erase(id);
    if (!state.object_there(id)) return;
    const Object& object = state.scene().objects[id];
    const MeshFacts& mesh = facts_of(state.scene(), object.mesh);
    if (!mesh.casts) return;
    Box3 own = mesh.box;
    if (object.deforming) {
        own = {};
        for (const glm::vec3& p : state.deformed(id).positions) own.add(p);
    }
    if (own.empty()) return;
    const glm::mat4 matrix = state.object_matrix(id);
    Box3 box;
    for (int corner = 0; corner < 8; ++corner) {
        const glm::vec3 p =
            transform_point(matrix, glm::vec3(corner & 1 ? own.high.x : own.low.x, corner & 2 ? own.high.y : own.low.y,
                                              corner & 4 ? own.high.z : own.low.z));
        // No ray meets what is farther away.
        const glm::vec3 size = glm::abs(p);
        if (!(std::max({size.x, size.y, size.z}) <= k_largest_coordinate) || !is_finite(p)) return;
        box.add(p);
    }
    if (exceeds(clip_.whole, box)) outside_.emplace(id, box);
}

// Encloses those outside that an override took there. An override may begin to differ from a track that moves on, so
// all of them are asked each time.
void PresentBounds::enlarge(const SceneState& state)
{
    Box3 all;
    for (const auto& [object, box] : outside_)
        if (state.displaced(object)) all.add(box);
    present_ = {enlarged_bounds(clip_.whole, all), clip_.dense};
}

}   // namespace gnomon::scene
