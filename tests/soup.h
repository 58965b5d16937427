// SPDX-License-Identifier: Apache-2.0
#pragma once
// Random triangle soups with lights anywhere, also on and inside geometry, and points on their surfaces.
#include <memory>
#include <vector>

#include "base/random.h"
#include "ray/ray_scene.h"
#include "shadow_culling/certified/shadow_point.h"

namespace gnomon {

class Soup {
 public:
    /// @param dynamic_objects  the number of closed and open meshes that a test will move by user override
    explicit Soup(std::uint64_t seed, int dynamic_objects = 0) : random_(seed)
    {
        scene_.materials.emplace_back();
        scene_.materials.back().double_sided = true;
        const int meshes = 2 + static_cast<int>(random_.below(4));
        for (int m = 0; m < meshes; ++m) add_mesh();
        for (int m = 0; m < dynamic_objects; ++m) m % 2 ? add_mesh() : add_ball();
        const int lights = 1 + static_cast<int>(random_.below(6));
        for (int l = 0; l < lights; ++l) add_light();
        scene_.finish();
    }
    std::shared_ptr<const scene::Scene> take() { return std::make_shared<scene::Scene>(std::move(scene_)); }

 private:
    glm::vec3 anywhere(float reach)
    {
        return {random_.uniform(-reach, reach), random_.uniform(-reach, reach), random_.uniform(-reach, reach)};
    }
    void add_mesh()
    {
        scene::Mesh mesh;
        if (random_.below(2)) {   // a bumpy sheet: shared edges, silhouettes, contact
            constexpr std::uint32_t n = 7;
            const glm::vec3 at = anywhere(1), u = anywhere(1), v = anywhere(1);
            for (std::uint32_t j = 0; j <= n; ++j)
                for (std::uint32_t i = 0; i <= n; ++i)
                    mesh.positions.push_back(at + u * (static_cast<float>(i) / n) + v * (static_cast<float>(j) / n) +
                                             anywhere(0.05f));
            for (std::uint32_t j = 0; j < n; ++j)
                for (std::uint32_t i = 0; i < n; ++i) {
                    const std::uint32_t a = j * (n + 1) + i;
                    mesh.triangles.emplace_back(a, a + 1, a + n + 2);
                    mesh.triangles.emplace_back(a, a + n + 2, a + n + 1);
                }
        } else {
            for (std::uint32_t t = 0; t < 20; ++t) {
                const glm::vec3 at = anywhere(1.5f);
                for (int c = 0; c < 3; ++c) mesh.positions.push_back(at + anywhere(0.7f));
                mesh.triangles.emplace_back(3 * t, 3 * t + 1, 3 * t + 2);
            }
            mesh.triangles.emplace_back(0, 0, 1);   // degenerate
        }
        finish_mesh(std::move(mesh));
    }
    // Adds a closed mesh with shared vertices: a bumpy or convex ball, sometimes with a part cut out.
    void add_ball()
    {
        constexpr std::uint32_t rings = 5, around = 8;
        scene::Mesh mesh;
        const glm::vec3 at = anywhere(1);
        const float radius = random_.uniform(0.1f, 0.6f), smooth = random_.below(2) ? 1.0f : 0.8f;
        const auto out = [&](float polar, float turn) {
            return at +
                   radius * random_.uniform(smooth, 1.0f) *
                       glm::vec3(std::sin(polar) * std::cos(turn), std::cos(polar), std::sin(polar) * std::sin(turn));
        };
        constexpr float k_half_turn = 3.14159265f;
        mesh.positions.push_back(out(0, 0));
        for (std::uint32_t r = 1; r < rings; ++r)
            for (std::uint32_t a = 0; a < around; ++a)
                mesh.positions.push_back(
                    out(k_half_turn * static_cast<float>(r) / rings, 2 * k_half_turn * static_cast<float>(a) / around));
        mesh.positions.push_back(out(k_half_turn, 0));
        const std::uint32_t last = static_cast<std::uint32_t>(mesh.positions.size()) - 1;
        for (std::uint32_t a = 0; a < around; ++a) {
            const std::uint32_t b = (a + 1) % around;
            mesh.triangles.emplace_back(0, 1 + b, 1 + a);
            for (std::uint32_t r = 0; r + 2 < rings; ++r) {
                const std::uint32_t here = 1 + r * around, below = here + around;
                mesh.triangles.emplace_back(here + a, here + b, below + b);
                mesh.triangles.emplace_back(here + a, below + b, below + a);
            }
            mesh.triangles.emplace_back(last, last - around + a, last - around + b);
        }
        if (random_.below(3) == 0) mesh.triangles.resize(mesh.triangles.size() - 5);
        finish_mesh(std::move(mesh));
    }
    void finish_mesh(scene::Mesh mesh)
    {
        mesh.parts = {{0, 0, static_cast<std::uint32_t>(mesh.triangles.size())}};
        const scene::NodeId node = scene_.add_node("", scene::none);
        scene_.nodes[node].mesh = static_cast<scene::MeshId>(scene_.meshes.size());
        scene_.meshes.push_back(std::move(mesh));
    }
    void add_light()
    {
        scene::Light light;
        light.type = random_.below(4) == 0 ? scene::LightType::directional : scene::LightType::point;
        glm::vec3 at = anywhere(3);
        if (random_.below(4) == 0)
            at = scene_.meshes[0]
                     .positions[random_.below(static_cast<std::uint32_t>(scene_.meshes[0].positions.size()))];
        glm::dmat4 place(1);
        const glm::dvec3 z = glm::normalize(glm::dvec3(anywhere(1)) + glm::dvec3(1e-3));
        glm::vec3 s, t;
        make_basis(glm::vec3(z), s, t);
        place[0] = glm::dvec4(s, 0), place[1] = glm::dvec4(t, 0), place[2] = glm::dvec4(z, 0),
        place[3] = glm::dvec4(at, 1);
        light.node = scene_.add_node("", scene::none, place);
        scene_.lights.push_back(light);
    }
    Random random_;
    scene::Scene scene_;
};

/// Random points on the surfaces, in runs on the same triangle.
inline std::vector<shadow_culling::ShadowPoint> random_points(const scene::Scene& scene, const ray::RayScene& rays,
                                                              Random& random, int count)
{
    std::vector<shadow_culling::ShadowPoint> points;
    for (int i = 0; i < count; ++i) {
        shadow_culling::ShadowPoint p;
        p.object = random.below(static_cast<std::uint32_t>(scene.objects.size()));
        const ray::ObjectGeometry& g = rays.geometry(p.object);
        p.triangle = random.below(static_cast<std::uint32_t>(g.mesh->triangles.size()));
        p.u = random.uniform(), p.v = random.uniform();
        if (p.u + p.v > 1) p.u = 1 - p.u, p.v = 1 - p.v;
        p.front = random.below(2);
        glm::vec3 c[3];
        g.corners(p.triangle, c);
        const glm::vec3 cross = glm::cross(c[1] - c[0], c[2] - c[0]);
        if (!(glm::length(cross) > 0)) continue;
        p.normal = glm::normalize(p.front ? cross : -cross);
        float largest = 0;
        for (const glm::vec3& q : c) largest = std::max({largest, std::abs(q.x), std::abs(q.y), std::abs(q.z)});
        p.origin = std::max(0.0f, 1 - p.u - p.v) * c[0] + p.u * c[1] + p.v * c[2] + 2e-6f * largest * p.normal;
        points.push_back(p);
    }
    return points;
}

/// Moves the last objects of a soup by user override: rotated, scaled, mirrored. Some stay where they are.
inline void move_last(const scene::Scene& scene, scene::SceneState& state, Random& random, std::size_t dynamic_objects)
{
    for (std::size_t o = scene.objects.size() - dynamic_objects; o < scene.objects.size(); ++o) {
        if (random.below(4) == 0) continue;
        glm::dmat4 place(1);
        for (int column = 0; column < 3; ++column)
            for (int row = 0; row < 3; ++row)
                place[column][row] = static_cast<double>((column == row ? 1.0f : 0.0f) + random.uniform(-0.5f, 0.5f));
        if (random.below(3) == 0) place[0] = -place[0];
        for (int row = 0; row < 3; ++row) place[3][row] = static_cast<double>(random.uniform(-1, 1));
        state.override_transform(scene.objects[o].node, &place);
    }
}

}   // namespace gnomon
