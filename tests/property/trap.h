// SPDX-License-Identifier: Apache-2.0
#pragma once
// Small worlds that are made to break proofs of shadows: between a receiver and a light, sheets that are folded, holed,
// slit, crossing, flush with the light or with the receiver, and lights whose plane cuts the receiver.

#include <vector>

#include "area_light/light_places.h"
#include "base/random.h"
#include "scene/scene.h"
#include "visibility/static_triangles.h"

namespace gnomon::area_light {

inline glm::vec3 anywhere(Random& random, float reach)
{
    return {random.uniform(-reach, reach), random.uniform(-reach, reach), random.uniform(-reach, reach)};
}

// Whether a segment from a point, up to `end` of the way, crosses any triangle, in double precision. The kernel of rays
// rounds, and triangles that are seen edge-on may then be hit a little before they are met.
inline bool crosses_any(const visibility::StaticTriangles& triangles, const glm::dvec3& from, const glm::dvec3& way,
                        double end)
{
    for (visibility::TriangleId id = 0; id < triangles.size(); ++id) {
        const auto& p = triangles[id].p;
        const glm::dvec3 a(p[0]), b(p[1]), c(p[2]), n = glm::cross(b - a, c - a);
        const double along = glm::dot(n, way);
        if (along == 0) continue;
        const double t = glm::dot(n, a - from) / along;
        if (!(t > 0 && t < end)) continue;
        const glm::dvec3 at = from + t * way;
        if (glm::dot(glm::cross(b - a, at - a), n) >= 0 && glm::dot(glm::cross(c - b, at - b), n) >= 0 &&
            glm::dot(glm::cross(a - c, at - c), n) >= 0)
            return true;
    }
    return false;
}

// A receiver, a light and, between them, sheets.
class Trap {
 public:
    explicit Trap(std::uint64_t seed, bool solid = false) : random_(seed)
    {
        scene_.materials.emplace_back();
        scene_.materials.back().double_sided = true;
        make_light();
        make_receiver();
        const int sheets = 1 + static_cast<int>(random_.below(3));
        for (int s = 0; s < sheets; ++s) make_sheet();
        if (random_.below(3) == 0) make_box();
        if (solid) make_solid();
        scene_.finish();
    }
    const LightPolygon& light() const { return light_; }
    /// Of a solid that stands where the light is: some of its faces, or all.
    const std::vector<LightPolygon>& faces() const { return faces_; }
    std::shared_ptr<const scene::Scene> take() { return std::make_shared<scene::Scene>(std::move(scene_)); }

 private:
    void make_light()
    {
        const float size = random_.below(2) ? 0.3f : random_.below(2) ? 1.5f : 0.03f;
        const glm::vec3 u = size * anywhere(random_, 1), v = size * anywhere(random_, 1);
        at_ = anywhere(random_, 1) + glm::vec3(0, 1.5f, 0);
        light_.corner = {at_, at_ + u, at_ + u + v, at_ + v};
        light_.corners = random_.below(3) == 0 ? 3 : 4;
        light_.normal = glm::normalize(glm::cross(u, v));
        u_ = u, v_ = v;
    }
    void add(const std::vector<glm::vec3>& positions, const std::vector<glm::uvec3>& triangles)
    {
        scene::Mesh mesh;
        mesh.positions = positions;
        mesh.triangles = triangles;
        mesh.parts = {{0, 0, static_cast<std::uint32_t>(triangles.size())}};
        const scene::NodeId node = scene_.add_node("", scene::none);
        scene_.nodes[node].mesh = static_cast<scene::MeshId>(scene_.meshes.size());
        scene_.meshes.push_back(std::move(mesh));
    }
    // Around the light's place on the floor; in a third of the worlds the light's plane cuts it.
    void make_receiver()
    {
        glm::vec3 centre = anywhere(random_, 0.5f), u = anywhere(random_, 2), v = anywhere(random_, 2);
        if (random_.below(3) == 0) centre = at_ + random_.uniform(0.2f, 2.0f) * u_ + random_.uniform(-2.0f, 2.0f) * v_;
        receiver_ = centre;
        add({centre - u - v, centre + u - v, centre + u + v, centre - u + v}, {{0, 1, 2}, {0, 2, 3}});
    }
    // A grid across the way from the receiver to the light, larger or smaller than the light.
    void make_sheet()
    {
        constexpr std::uint32_t n = 6;
        // At which part of the way it lies: often very near one of its ends.
        const float near = random_.below(2) ? 1e-5f : 1e-3f;
        const std::uint32_t kind = random_.below(5);
        const float way = kind == 0 ? near : kind == 1 ? 1 - near : random_.uniform(0.05f, 0.95f);
        const glm::vec3 centre =
            glm::mix(receiver_, light_.corner[0] + 0.5f * (u_ + v_), way) + anywhere(random_, 0.05f);
        const float size = random_.below(2) ? 4.0f : random_.uniform(0.3f, 1.5f);
        glm::vec3 u = size * u_, v = size * v_;
        if (random_.below(2)) u = anywhere(random_, 1), v = anywhere(random_, 1);
        const float bumps = random_.below(3) == 0 ? 0 : random_.uniform(0, 0.2f);
        const bool folded = random_.below(3) == 0;
        std::vector<glm::vec3> positions;
        for (std::uint32_t j = 0; j <= n; ++j)
            for (std::uint32_t i = 0; i <= n; ++i) {
                float x = static_cast<float>(i) / n - 0.5f;
                // A fold runs back over itself.
                if (folded && i > n / 2) x = 0.5f - 0.6f * static_cast<float>(i) / n;
                positions.push_back(centre + x * u + (static_cast<float>(j) / n - 0.5f) * v +
                                    anywhere(random_, bumps * 0.3f));
            }
        const std::uint32_t hole = random_.below(3) == 0 ? random_.below(2 * n * n) : 2 * n * n;
        const std::uint32_t slit = random_.below(3) == 0 ? 1 + random_.below(n - 1) : n + 1;
        std::vector<glm::uvec3> triangles;
        for (std::uint32_t j = 0; j < n; ++j)
            for (std::uint32_t i = 0; i < n; ++i) {
                const std::uint32_t a = j * (n + 1) + i;
                for (const glm::uvec3& t : {glm::uvec3(a, a + 1, a + n + 2), glm::uvec3(a, a + n + 2, a + n + 1)})
                    if (triangles.size() != hole) triangles.push_back(t);
            }
        // Along a slit, the two sides have vertices of their own, some of them moved apart by little.
        if (slit <= n) {
            const auto first = static_cast<std::uint32_t>(positions.size());
            for (std::uint32_t j = 0; j <= n; ++j)
                positions.push_back(positions[j * (n + 1) + slit] + anywhere(random_, j % 2 ? 2e-4f : 0));
            for (glm::uvec3& t : triangles) {
                const bool beyond = (t.x % (n + 1) + t.y % (n + 1) + t.z % (n + 1)) > 3 * slit;
                for (int k = 0; k < 3; ++k)
                    if (beyond && t[k] < first && t[k] % (n + 1) == slit) t[k] = first + t[k] / (n + 1);
            }
        }
        if (random_.below(3) == 0)
            for (std::size_t t = 0; t < triangles.size(); t += 3) std::swap(triangles[t].y, triangles[t].z);
        add(positions, triangles);
    }
    // A closed box around the light or the receiver, cut by the light's plane.
    void make_box()
    {
        const glm::vec3 centre = random_.below(2) ? at_ : receiver_ + anywhere(random_, 0.5f);
        const glm::vec3 half = glm::abs(anywhere(random_, 0.6f)) + glm::vec3(0.01f);
        std::vector<glm::vec3> positions;
        for (int k = 0; k < 8; ++k)
            positions.push_back(centre + half * glm::vec3(k & 1 ? 1 : -1, k & 2 ? 1 : -1, k & 4 ? 1 : -1));
        add(positions, {{0, 2, 1},
                        {1, 2, 3},
                        {4, 5, 6},
                        {5, 7, 6},
                        {0, 1, 4},
                        {1, 5, 4},
                        {2, 6, 3},
                        {3, 6, 7},
                        {0, 4, 2},
                        {2, 4, 6},
                        {1, 3, 5},
                        {3, 7, 5}});
    }

    // An octahedron around the light, some of its corners dented, in the scene. The cluster has all of its faces or
    // some.
    void make_solid()
    {
        const glm::vec3 centre = at_ + 0.5f * (u_ + v_), w = 0.5f * glm::length(u_) * light_.normal;
        std::vector<glm::vec3> corner{centre + 0.5f * u_, centre - 0.5f * u_, centre + 0.5f * v_,
                                      centre - 0.5f * v_, centre + w,         centre - w};
        if (random_.below(3) == 0) corner[4] = centre - 0.5f * w;
        std::vector<glm::uvec3> triangles;
        const std::uint32_t all = random_.below(2);
        for (std::uint32_t k = 0; k < 8; ++k) {
            glm::uvec3 t(k & 1, 2 + (k >> 1 & 1), 4 + (k >> 2 & 1));
            const glm::vec3 n = glm::cross(corner[t.y] - corner[t.x], corner[t.z] - corner[t.x]);
            if ((glm::dot(n, corner[t.x] - (centre - 0.6f * w)) < 0)) std::swap(t.y, t.z);
            triangles.push_back(t);
            if (!all && random_.below(2)) continue;
            LightPolygon face;
            face.corner = {corner[t.x], corner[t.y], corner[t.z], corner[t.z]};
            face.corners = 3;
            const glm::vec3 normal = glm::cross(face.corner[1] - face.corner[0], face.corner[2] - face.corner[0]);
            if (!(glm::length(normal) > 0)) continue;
            face.normal = glm::normalize(normal);
            faces_.push_back(face);
        }
        add(corner, triangles);
    }

    Random random_;
    scene::Scene scene_;
    std::vector<LightPolygon> faces_;
    LightPolygon light_;
    glm::vec3 at_{0}, u_{0}, v_{0}, receiver_{0};
};

// Corners, edges and middle of a polygon, and some points inside.
inline std::vector<glm::vec3> places_on(const glm::vec3* corner, int corners, Random& random)
{
    std::vector<glm::vec3> places;
    glm::vec3 middle(0);
    for (int k = 0; k < corners; ++k) {
        places.push_back(corner[k]);
        places.push_back(glm::mix(corner[k], corner[(k + 1) % corners], random.uniform()));
        places.push_back(glm::mix(corner[k], corner[(k + 1) % corners], 0.5f));
        middle += corner[k] / static_cast<float>(corners);
    }
    places.push_back(middle);
    for (int k = 0; k < corners; ++k) places.push_back(glm::mix(middle, corner[k], random.uniform()));
    return places;
}

}   // namespace gnomon::area_light
