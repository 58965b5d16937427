// SPDX-License-Identifier: Apache-2.0
#include "scene/defaults/surface_points.h"

#include <algorithm>

#include "base/interruption.h"
#include "scene/defaults/framing.h"
#include "scene/defaults/test_image.h"

namespace gnomon::scene {

namespace {

constexpr int k_points = 2048;
constexpr int k_image = 128;        // pixels along a side
constexpr double k_distance = 3;    // of the eye from the centre, in diagonals
constexpr float k_behind = 0.02f;   // a point is seen up to so far behind the surface, in diagonals
constexpr glm::dvec3 k_views[] = {{1, 0.6, 1},  {-1, 0.6, 1},    {1, 0.6, -1},  {-1, 0.6, -1}, {1, 0.05, 0},
                                  {0, 0.05, 1}, {0.01, 3, 0.01}, {-1, 0.05, 0}, {0, 0.05, -1}};

// Calls body(a, b, c, material) for every visible triangle.
template <class Body>
void for_each_triangle(const SceneState& state, const Body& body)
{
    const Scene& scene = state.scene();
    for (ObjectId id = 0; id < scene.objects.size(); ++id) {
        interruption_point();
        if (!state.object_visible(id)) continue;
        const Object& object = scene.objects[id];
        const Mesh& mesh = scene.meshes[object.mesh];
        const std::vector<glm::vec3>& positions = object.deforming ? state.deformed(id).positions : mesh.positions;
        const glm::mat4 world = state.object_matrix(id);
        const bool mirrored = glm::determinant(glm::mat3(world)) < 0;
        for (const MeshPart& part : mesh.parts) {
            const Material& material = scene.materials[part.material];
            for (std::uint32_t t = part.first_triangle; t < part.first_triangle + part.triangle_count; ++t) {
                glm::vec3 p[3];
                for (int c = 0; c < 3; ++c) p[c] = transform_point(world, positions[mesh.triangles[t][c]]);
                if (mirrored) std::swap(p[1], p[2]);
                body(p[0], p[1], p[2], material);
            }
        }
    }
}

}   // namespace

std::vector<SurfacePlace> surface_points(const SceneState& state, int count)
{
    const auto cross_of = [](const glm::vec3& a, const glm::vec3& b, const glm::vec3& c) {
        return glm::cross(glm::dvec3(b) - glm::dvec3(a), glm::dvec3(c) - glm::dvec3(a));
    };
    double all = 0;
    for_each_triangle(state, [&](const glm::vec3& a, const glm::vec3& b, const glm::vec3& c, const Material&) {
        if (const double area = glm::length(cross_of(a, b, c)); std::isfinite(area)) all += area;
    });
    std::vector<SurfacePlace> places;
    if (!(all > 0)) return places;
    const double step = all / count;
    double sum = 0, next = 0.5 * step;
    for_each_triangle(state, [&](const glm::vec3& a, const glm::vec3& b, const glm::vec3& c, const Material& material) {
        const glm::dvec3 cross = cross_of(a, b, c);
        const double area = glm::length(cross);
        if (!(area > 0) || !std::isfinite(area)) return;
        sum += area;
        for (int i = 0; next < sum && i < count; next += step, ++i) {
            // Spread the points of one triangle by a rank-1 sequence.
            double u = std::fmod(0.5 + 0.7548776662466927 * i, 1.0), v = std::fmod(0.5 + 0.5698402909980532 * i, 1.0);
            if (u + v > 1) u = 1 - u, v = 1 - v;
            if (i == 0) u = v = 1.0 / 3;
            places.push_back({a + static_cast<float>(u) * (b - a) + static_cast<float>(v) * (c - a),
                              glm::vec3(cross / area), material.one_sided(), material.model != ShadingModel::unlit});
        }
    });
    return places;
}

float share_seen_from_outside(const SceneState& state)
{
    const std::vector<SurfacePlace> places = surface_points(state, k_points);
    if (places.empty()) return 1;
    Box3 box;
    for (const SurfacePlace& place : places) box.add(place.position);
    const auto diagonal = static_cast<double>(box.diagonal());
    if (!(diagonal > 0)) return 1;
    const double fov = 2 * std::asin(0.52 / k_distance);
    std::vector<char> seen(places.size());
    for (const glm::dvec3& direction : k_views) {
        const glm::dmat3 axes = camera_axes(glm::normalize(direction)), to_camera = glm::transpose(axes);
        const glm::dvec3 eye = glm::dvec3(box.centre()) + k_distance * diagonal * axes[2];
        const TestImage image =
            draw_test_image(state, eye, axes, {.vertical_fov = fov, .near = diagonal, .side = k_image, .glass = false});
        const double scale = 0.5 * k_image / std::tan(fov / 2);
        for (std::size_t i = 0; i < places.size(); ++i) {
            const SurfacePlace& place = places[i];
            const glm::dvec3 p = to_camera * (glm::dvec3(place.position) - eye);
            if (place.one_sided && glm::dot(glm::dvec3(place.normal), glm::dvec3(place.position) - eye) >= 0) continue;
            const int x = static_cast<int>(0.5 * k_image + scale * p.x / -p.z);
            const int y = static_cast<int>(0.5 * k_image - scale * p.y / -p.z);
            if (x < 0 || y < 0 || x >= k_image || y >= k_image) continue;
            // Light does not pass the backs of one-sided surfaces, as views do.
            const TestPixel& pixel = image.pixels[static_cast<std::size_t>(y) * k_image + static_cast<std::size_t>(x)];
            const float depth = place.needs_light ? pixel.first : pixel.depth;
            if (static_cast<float>(-p.z) <= depth + k_behind * static_cast<float>(diagonal)) seen[i] = 1;
        }
    }
    return static_cast<float>(std::count(seen.begin(), seen.end(), 1)) / static_cast<float>(seen.size());
}

}   // namespace gnomon::scene
