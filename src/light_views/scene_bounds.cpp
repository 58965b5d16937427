// SPDX-License-Identifier: Apache-2.0
// The scene's bounds over its whole clip, and the part that contains most triangles; both depend on the scene only.
#include <algorithm>

#include "light_views/projection.h"

namespace gnomon::light_views {

namespace {

struct ObjectBox {
    Box3 box;
    double triangles;
};

// The value at which the sum of weights reaches a fraction of the total.
float quantile(std::vector<std::pair<float, double>> values, double fraction)
{
    std::sort(values.begin(), values.end());
    double sum = 0, all = 0;
    for (const auto& [value, weight] : values) all += weight;
    for (const auto& [value, weight] : values)
        if ((sum += weight) >= fraction * all) return value;
    return values.back().first;
}

// The box around the middle of the triangles, extended by objects that enlarge it little.
Box3 dense_part(const std::vector<ObjectBox>& boxes)
{
    constexpr double k_outliers = 0.1;   // fraction of triangles that may initially lie beyond each side
    constexpr float k_little = 0.25f;    // of its diagonal
    Box3 dense;
    std::vector<std::pair<float, double>> lows, highs;
    for (int axis = 0; axis < 3; ++axis) {
        lows.clear(), highs.clear();
        for (const ObjectBox& object : boxes) {
            lows.emplace_back(object.box.low[axis], object.triangles);
            highs.emplace_back(object.box.high[axis], object.triangles);
        }
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

}   // namespace

SceneBounds clip_bounds(const scene::Scene& scene, int most_times)
{
    std::vector<Box3> meshes;
    for (const scene::Mesh& mesh : scene.meshes) {
        Box3 box = mesh.bounds();
        if (mesh.vertex_keys)
            for (const auto& key : mesh.vertex_keys->positions)
                for (const glm::vec3& p : key) box.add(p);
        meshes.push_back(box);
    }
    SceneBounds bounds;
    std::vector<ObjectBox> boxes;
    const int frames = std::max(scene.timeline.frames, 1), times = std::min(frames, most_times);
    for (const scene::Object& object : scene.objects)
        boxes.push_back({{}, static_cast<double>(scene.meshes[object.mesh].triangles.size())});
    const bool moves =
        std::any_of(scene.objects.begin(), scene.objects.end(), [](const scene::Object& o) { return o.dynamic; });
    for (int i = 0; i < (moves ? times : 1); ++i) {
        const int frame = times > 1 ? 1 + static_cast<int>(static_cast<std::int64_t>(frames - 1) * i / (times - 1)) : 1;
        // Compute the matrices of all nodes at once, because walking up from each is slow in deep hierarchies.
        const std::vector<glm::dmat4> world = scene.world_matrices(scene.timeline.time_of(frame));
        for (std::size_t o = 0; o < boxes.size(); ++o) {
            const scene::Object& object = scene.objects[o];
            const Box3& box = meshes[object.mesh];
            if (box.empty() || (i > 0 && !object.dynamic)) continue;
            for (int corner = 0; corner < 8; ++corner) {
                const glm::dvec3 p(corner & 1 ? box.high.x : box.low.x, corner & 2 ? box.high.y : box.low.y,
                                   corner & 4 ? box.high.z : box.low.z);
                const glm::vec3 q(transform_point(world[object.node], p));
                if (is_finite(q)) boxes[o].box.add(q);
            }
        }
    }
    std::erase_if(boxes, [](const ObjectBox& placed) { return placed.box.empty(); });
    for (const ObjectBox& placed : boxes) bounds.whole.add(placed.box);
    if (!boxes.empty()) bounds.dense = dense_part(boxes);
    return bounds;
}

}   // namespace gnomon::light_views
