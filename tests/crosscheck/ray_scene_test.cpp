// SPDX-License-Identifier: Apache-2.0
// RayScene against a brute-force reference: every triangle of the scene in double precision (Moller and Trumbore 1997),
// with an independent implementation of sides, masks and transparency. Single and double precision may differ at
// borders: of triangles, of a mask's squares, of edge-on views, of the ray's own ends. So the reference answers twice,
// with all borders moved by a margin in the ray's favour and against it. The result must lie between the two, and for
// nearly all rays the two must agree.
#include <gtest/gtest.h>

#include <algorithm>

#include "ray_helpers.h"
#include "scene_helpers.h"

namespace gnomon::test {
namespace {

constexpr double k_margin = 2e-4;   // in barycentric coordinates, cosines, and relative to the distance

class BruteForce {
 public:
    explicit BruteForce(const scene::SceneState& state) : scene_(state.scene())
    {
        for (scene::ObjectId o = 0; o < scene_.objects.size(); ++o) {
            if (!state.object_visible(o)) continue;
            const scene::Object& object = scene_.objects[o];
            const scene::Mesh& mesh = scene_.meshes[object.mesh];
            const glm::dmat4& world = state.world(object.node);
            const auto& positions = object.deforming ? state.deformed(o).positions : mesh.positions;
            // A mirroring matrix reverses the winding, not the outside.
            const double outside = glm::determinant(glm::dmat3(world)) < 0 ? -1 : 1;
            for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
                Triangle triangle{o, t, &mesh, &scene_.materials[mesh.part_of(t).material], {}, {}};
                for (int i = 0; i < 3; ++i)
                    triangle.p[i] = transform_point(world, glm::dvec3(positions[mesh.triangles[t][i]]));
                triangle.outward = outside * glm::cross(triangle.p[1] - triangle.p[0], triangle.p[2] - triangle.p[0]);
                if (glm::length(triangle.outward) > 0) triangles_.push_back(triangle);
            }
        }
    }

    /// @param slack  added to the accepted range at every border; negative: subtracted
    /// @return distance of the nearest hit; infinite if there is none
    double nearest(const ray::RayQueue& rays, std::size_t i, bool front_only, bool shadow, double slack) const
    {
        double result = k_infinity;
        for (const Triangle& triangle : triangles_) {
            const double t = meet(triangle, rays, i, front_only, shadow, slack);
            result = std::min(result, t);
        }
        return result;
    }

    /// The distance at which the ray hits this very triangle, with borders moved outwards.
    double distance_to(const ray::Hit& hit, const ray::RayQueue& rays, std::size_t i, bool front_only) const
    {
        for (const Triangle& triangle : triangles_)
            if (triangle.object == hit.object && triangle.index == hit.triangle)
                return meet(triangle, rays, i, front_only, false, k_margin);
        return k_infinity;
    }

 private:
    struct Triangle {
        scene::ObjectId object;
        std::uint32_t index;
        const scene::Mesh* mesh;
        const scene::Material* material;
        glm::dvec3 p[3];
        glm::dvec3 outward;
    };

    double meet(const Triangle& triangle, const ray::RayQueue& rays, std::size_t i, bool front_only, bool shadow,
                double slack) const
    {
        const glm::dvec3 origin(rays.origin(i)), along(rays.direction(i));
        const glm::dvec3 e1 = triangle.p[1] - triangle.p[0], e2 = triangle.p[2] - triangle.p[0];
        const glm::dvec3 s = glm::cross(along, e2), q = origin - triangle.p[0], r = glm::cross(q, e1);
        const double determinant = glm::dot(e1, s);
        const double cosine = glm::dot(glm::normalize(triangle.outward), glm::normalize(along));
        if (std::abs(cosine) < 1e-7) return k_infinity;
        // The uncertainty of grazing rays grows with the inverse of the cosine.
        const double border = slack / std::abs(cosine);
        const double u = glm::dot(q, s) / determinant, v = glm::dot(along, r) / determinant;
        if (u < -border || v < -border || u + v > 1 + border) return k_infinity;
        const double t = glm::dot(e2, r) / determinant;
        if (t < static_cast<double>(rays.tnear[i]) - border || t > static_cast<double>(rays.tfar[i]) + border)
            return k_infinity;
        const bool transparent = triangle.material->transmission > 0;
        if (shadow && transparent) return k_infinity;
        if (front_only && !triangle.material->double_sided && !transparent && cosine > slack) return k_infinity;
        if (triangle.material->alpha_mode == scene::AlphaMode::mask && !there(triangle, u, v, border))
            return k_infinity;
        return t;
    }

    // The chessboard of scene_helpers.h: at the border of a square, opaque if any (all) of the neighbourhood is.
    bool there(const Triangle& triangle, double u, double v, double slack) const
    {
        const glm::uvec3 index = triangle.mesh->triangles[triangle.index];
        const auto& uv = triangle.mesh->texcoords[0];
        bool any = false, all = true;
        for (const double du : {-std::abs(slack), 0.0, std::abs(slack)})
            for (const double dv : {-std::abs(slack), 0.0, std::abs(slack)}) {
                const glm::dvec2 at = (1 - u - v - du - dv) * glm::dvec2(uv[index[0]]) +
                                      (u + du) * glm::dvec2(uv[index[1]]) + (v + dv) * glm::dvec2(uv[index[2]]);
                const auto square = [](double x) { return static_cast<long>(std::floor(x * 8)); };
                const bool solid = (square(3 * at.x) + square(2 * at.y)) % 2 != 0;
                any = any || solid, all = all && solid;
            }
        return slack > 0 ? any : all;
    }

    const scene::Scene& scene_;
    std::vector<Triangle> triangles_;
};

TEST(RaySceneReference, EqualsBruteForceInDoublePrecision)
{
    std::size_t clear = 0, traced = 0, met = 0, dark = 0;
    for (std::uint64_t seed = 11; seed <= 14; ++seed) {
        const scene::SceneState state(make_random_scene(seed), 0.7 * static_cast<double>(seed));
        const ray::RayScene scene(state);
        const BruteForce reference(state);
        const ray::RayQueue rays = random_rays(seed, 1500);
        const Answers answers = trace(scene, rays);
        for (std::size_t i = 0; i < rays.size(); ++i) {
            for (const bool front_only : {false, true}) {
                const ray::Hit& hit = (front_only ? answers.front : answers.both)[i];
                const double low = reference.nearest(rays, i, front_only, false, k_margin);
                const double high = reference.nearest(rays, i, front_only, false, -k_margin);
                const bool found = hit.object != scene::none;
                const double t = found ? static_cast<double>(hit.t) : static_cast<double>(k_infinity);
                const double room = k_margin * (1 + std::abs(t));
                ASSERT_TRUE(found || high == static_cast<double>(k_infinity)) << "missed, seed " << seed << ' ' << i;
                if (found) {
                    ASSERT_GE(t, low - room) << "too near, seed " << seed << ", ray " << i;
                    ASSERT_LE(t, high + room) << "too far, seed " << seed << ", ray " << i;
                    ASSERT_NEAR(t, reference.distance_to(hit, rays, i, front_only), room) << "another triangle";
                }
                ++traced;
                met += found;
                clear += low == high || std::abs(high - low) <= room;
            }
            const bool surely = reference.nearest(rays, i, false, true, -k_margin) < static_cast<double>(k_infinity);
            const bool perhaps = reference.nearest(rays, i, false, true, k_margin) < static_cast<double>(k_infinity);
            ASSERT_TRUE(answers.occluded[i] ? perhaps : !surely) << "seed " << seed << ", ray " << i;
            ASSERT_EQ(answers.occluded[i], answers.occluded_static[i] | answers.occluded_dynamic[i]);
            ++traced;
            dark += answers.occluded[i];
            clear += surely == perhaps;
        }
    }
    EXPECT_GE(static_cast<double>(clear), 0.97 * static_cast<double>(traced));
    EXPECT_GT(met, traced / 12);
    EXPECT_GT(dark, traced / 30);
    RecordProperty("unclear", static_cast<int>(traced - clear));
}

// Shading gets the geometry that rays hit.
TEST(RaySceneReference, CornersOfTheHitTriangleSpanTheHitPoint)
{
    const scene::SceneState state(make_random_scene(21), 2.2);
    const ray::RayScene scene(state);
    const ray::RayQueue rays = random_rays(3, 4000);
    const Answers answers = trace(scene, rays);
    std::size_t met = 0;
    for (std::size_t i = 0; i < rays.size(); ++i) {
        const ray::Hit& hit = answers.both[i];
        if (hit.object == scene::none) continue;
        ++met;
        const ray::ObjectGeometry& geometry = scene.geometry(hit.object);
        glm::vec3 p[3];
        geometry.corners(hit.triangle, p);
        const glm::vec3 by_corners = (1 - hit.u - hit.v) * p[0] + hit.u * p[1] + hit.v * p[2];
        const glm::vec3 by_distance = rays.origin(i) + hit.t * rays.direction(i);
        ASSERT_LT(glm::distance(by_corners, by_distance), 1e-3f) << i;
        // Normals transform by the inverse transpose: the outside stays outside, even if the object is mirrored.
        const scene::Object& object = state.scene().objects[hit.object];
        const glm::dmat3 matrix(state.world(object.node));
        ASSERT_EQ(geometry.mirrored, glm::determinant(matrix) < 0) << i;
        const std::uint32_t vertex = geometry.mesh->triangles[hit.triangle].x;
        const glm::dvec3 rest(object.deforming ? state.deformed(hit.object).normals[vertex]
                                               : geometry.mesh->normals[vertex]);
        const glm::vec3 n = geometry.normals[vertex];
        const glm::vec3 normal = geometry.normal_to_world ? *geometry.normal_to_world * n : n;
        const glm::dvec3 expected = glm::normalize(glm::transpose(glm::inverse(matrix)) * rest);
        ASSERT_GT(glm::dot(expected, glm::normalize(glm::dvec3(normal))), 0.99999) << i;
    }
    EXPECT_GT(met, 500u);
}

// A ray that ends behind its origin hits nothing, in packets and as a single ray.
TEST(RaySceneReference, RaysWithNegativeLengthHitNothing)
{
    const scene::SceneState state(make_random_scene(22), 1.1);
    const ray::RayScene scene(state);
    const ray::RayQueue rays = random_rays(4, 300);
    for (const float end : {-1.0f, -2e9f, -k_infinity}) {
        ray::RayQueue behind;
        for (std::size_t i = 0; i < rays.size(); ++i) behind.push(rays.origin(i), 0, rays.direction(i), end);
        const Answers answers = trace(scene, behind), singly = trace_singly(scene, behind);
        EXPECT_EQ(differences(answers, singly), 0u) << end;
        EXPECT_EQ(count_hits(answers), 0u) << end;
        EXPECT_EQ(std::count(answers.occluded.begin(), answers.occluded.end(), 0), 300) << end;
    }
}

// Rays that see fronts only pass the backs of one-sided surfaces, so the far wall of a ball is not seen from inside.
TEST(RaySceneReference, HonoursSidesMasksAndGlass)
{
    scene::Scene description;
    add_materials(description);
    for (scene::MaterialId m = 0; m < material_count; ++m) description.meshes.push_back(ball(m, 12, 16));
    for (scene::MaterialId m = 0; m < material_count; ++m)
        for (const double mirror : {1.0, -1.0}) {
            const double x = 10.0 * m + (mirror < 0 ? 100 : 0);
            const scene::NodeId node =
                add_object(description, m, scene::none, glm::scale(translation(x, 0, 0), glm::dvec3(mirror, 1, 1)));
            description.nodes[node].animated = m % 2 == 0;   // half of them as dynamic objects
        }
    const scene::SceneState state(finished(description), 0);
    const ray::RayScene rays(state);
    const auto seen_from_inside = [&](float x, ray::Sides sides) {
        return rays.closest_single({x, 0.01f, 0.02f}, 0, {0.1f, 0.2f, 1}, 2, sides).object != scene::none;
    };
    for (const float start : {0.0f, 100.0f}) {
        for (const auto m : {two_sided, one_sided, glass}) {
            EXPECT_TRUE(seen_from_inside(start + 10.0f * static_cast<float>(m), ray::Sides::both)) << m;
            EXPECT_EQ(seen_from_inside(start + 10.0f * static_cast<float>(m), ray::Sides::front), m != one_sided) << m;
        }
        for (const auto m : {two_sided, one_sided, glass}) {
            const float x = start + 10.0f * static_cast<float>(m);
            // From outside all are hit; from inside one-sided surfaces block light as well, glass never does.
            EXPECT_EQ(look_at(rays, x, ray::Sides::front).object, 2 * m + (start > 0)) << m;
            EXPECT_EQ(rays.occluded_single({x, 0.01f, 0.02f}, 0, {0.1f, 0.2f, 1}, 2), m != glass) << m;
        }
    }
}

}   // namespace
}   // namespace gnomon::test
