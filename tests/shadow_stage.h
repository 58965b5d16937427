// SPDX-License-Identifier: Apache-2.0
#pragma once
// Small scenes of loose triangles under lights. Tests teach the shadow memory with some points, and then compare its
// answers for all points with those of rays.

#include <functional>

#include "base/random.h"
#include "ray/origin.h"
#include "ray/ray_scene.h"
#include "scene_helpers.h"
#include "shadow_culling/certified/certified_culling.h"

namespace gnomon::test {

/// A scene under construction. Object n is the n-th mesh added.
struct Stage {
    scene::Scene scene;

    Stage() { add_materials(scene); }

    /// Adds loose triangles, three corners each; texture coordinates are (x, y).
    scene::NodeId add(const std::vector<glm::vec3>& corners, scene::MaterialId material = two_sided,
                      std::shared_ptr<const scene::TransformTrack> track = nullptr)
    {
        scene::Mesh mesh;
        mesh.positions = corners;
        for (const glm::vec3& p : corners) mesh.texcoords[0].emplace_back(p.x, p.y);
        for (std::uint32_t i = 0; i + 2 < corners.size(); i += 3) mesh.triangles.emplace_back(i, i + 1, i + 2);
        mesh.parts = {{material, 0, static_cast<std::uint32_t>(mesh.triangles.size())}};
        return add(std::move(mesh), std::move(track));
    }
    scene::NodeId add(scene::Mesh mesh, std::shared_ptr<const scene::TransformTrack> track = nullptr)
    {
        scene.meshes.push_back(std::move(mesh));
        const scene::NodeId node = add_object(scene, static_cast<scene::MeshId>(scene.meshes.size() - 1));
        scene.nodes[node].transform = std::move(track);
        return node;
    }

    /// Adds a point or spot light at `place`, or a directional light from `place` towards the origin.
    void add_light(const glm::vec3& place, scene::LightType type = scene::LightType::point,
                   std::shared_ptr<const scene::TransformTrack> track = nullptr)
    {
        scene::Light light;
        light.type = type;
        light.outer_angle = 1.2f;
        light.node = scene.add_node("", scene::none, shining_from(place));
        scene.nodes[light.node].transform = std::move(track);
        scene.lights.push_back(light);
    }
    /// A matrix at `place` that points towards the origin, or down along Y if `place` is the origin.
    static glm::dmat4 shining_from(const glm::vec3& place)
    {
        const glm::vec3 z = glm::length(place) > 0 ? glm::normalize(place) : glm::vec3(0, 1, 0);
        glm::vec3 s, t;
        make_basis(z, s, t);
        glm::dmat4 m(1);
        m[0] = glm::dvec4(s, 0), m[1] = glm::dvec4(t, 0), m[2] = glm::dvec4(z, 0), m[3] = glm::dvec4(place, 1);
        return m;
    }
};

/// A shading point on a triangle as the renderer makes it; the object is `none` if the triangle has no area.
inline shadow_culling::ShadowPoint shadow_point(const ray::RayScene& rays, scene::ObjectId object,
                                                std::uint32_t triangle, float u, float v, bool front)
{
    shadow_culling::ShadowPoint p;
    glm::vec3 c[3];
    rays.geometry(object).corners(triangle, c);
    const glm::vec3 cross = glm::cross(c[1] - c[0], c[2] - c[0]);
    if (!(glm::length(cross) > 0)) return p;
    p.object = object, p.triangle = triangle, p.u = u, p.v = v, p.front = front;
    p.normal = glm::normalize(front ? cross : -cross);
    p.origin = std::max(0.0f, 1 - u - v) * c[0] + u * c[1] + v * c[2] + ray::origin_lift(c) * p.normal;
    return p;
}

/// Ground truth by ray: the light is behind the surface, or something occludes it.
inline bool truly_occluded(const scene::SceneState& state, const ray::RayScene& rays,
                           const shadow_culling::ShadowPoint& p, std::size_t light)
{
    const scene::LightState& at = state.light(static_cast<scene::LightId>(light));
    const bool directional = state.scene().lights[light].type == scene::LightType::directional;
    const glm::vec3 d = directional ? -at.direction : at.position - p.origin;
    if (!(glm::dot(d, p.normal) > 0)) return true;
    return rays.occluded_single(p.origin, 0, d, directional ? k_infinity : 0.9999f);
}

/// Whether a point's result matters: a spot light illuminates its cone only.
inline bool in_light(const scene::SceneState& state, const shadow_culling::ShadowPoint& p, std::size_t light)
{
    const scene::Light& described = state.scene().lights[light];
    const scene::LightState& at = state.light(static_cast<scene::LightId>(light));
    return scene::illuminate(described, at, p.origin).irradiance != glm::vec3(0);
}

struct Outcome {
    std::uint64_t asked = 0, wrong = 0;
    std::uint64_t none = 0, full = 0;   // remembered results
    Outcome& operator+=(const Outcome& o)
    {
        asked += o.asked, wrong += o.wrong, none += o.none, full += o.full;
        return *this;
    }
};

/// Which points the memory learns from; one-sided evidence is most likely to mislead it.
enum class Teach { all, free_ones, occluded_ones };

/// A stage at a time, and the shadow memory for it.
class Rehearsal {
 public:
    using Points = std::vector<shadow_culling::ShadowPoint>;

    Rehearsal(Stage stage, const shadow_culling::CertifiedOptions& options = {})
        : scene_(finished(stage.scene)), state_(scene_, 0), rays_(state_), culling_(state_, rays_, options)
    {
    }
    const scene::Scene& scene() const { return *scene_; }
    scene::SceneState& state() { return state_; }
    const ray::RayScene& rays() const { return rays_; }
    const shadow_culling::CertifiedCulling& culling() const { return culling_; }
    /// Sets the pixel width: with wide pixels a triangle is one part, with narrow ones it is divided into many.
    void set_view(const shadow_culling::CullingView& view) { view_ = view; }

    void advance(double time)
    {
        state_.advance(time);
        rays_.update(state_);
    }
    /// Random points on some objects, `each` per triangle.
    Points points(const std::vector<scene::ObjectId>& objects, int each, std::uint64_t seed = 1,
                  bool both_sides = false)
    {
        Random random(seed);
        Points result;
        for (const scene::ObjectId o : objects)
            for (std::uint32_t t = 0; t < rays_.geometry(o).mesh->triangles.size(); ++t)
                for (int i = 0; i < each; ++i) {
                    float u = random.uniform(), v = random.uniform();
                    if (u + v > 1) u = 1 - u, v = 1 - v;
                    const auto p = shadow_point(rays_, o, t, u, v, !both_sides || random.below(2) == 0);
                    if (p.object != scene::none) result.push_back(p);
                }
        return result;
    }
    /// Renders one frame: queries the memory, compares it with rays, and lets it compute certificates.
    Outcome query(const Points& points)
    {
        using namespace shadow_culling;
        culling_.begin_frame(state_, rays_, view_);
        std::vector<std::unique_ptr<CertifiedCulling::Batch>> batches;
        batches.push_back(culling_.make_batch());
        culling_.classify(*batches[0], points);
        std::vector<std::uint8_t> occluded(points.size() + ray::k_packet_pad);
        Outcome outcome;
        for (std::size_t l = 0; l < scene_->lights.size(); ++l) {
            culling_.shadow(*batches[0], static_cast<int>(l), occluded.data());
            for (std::uint32_t i = 0; i < points.size(); ++i) {
                const ShadowState known = culling_.state_of(*batches[0], i, static_cast<int>(l));
                outcome.none += known == ShadowState::none;
                outcome.full += known == ShadowState::full;
                if (!in_light(state_, points[i], l)) continue;
                ++outcome.asked;
                outcome.wrong += truly_occluded(state_, rays_, points[i], l) != static_cast<bool>(occluded[i]);
            }
        }
        culling_.end_frame(batches, one_);
        return outcome;
    }
    /// Teaches the memory with the points of one kind (for light 0), for some frames.
    Outcome teach(const Points& points, Teach what, int frames = 1)
    {
        Points chosen;
        for (const auto& p : points)
            if (what == Teach::all || truly_occluded(state_, rays_, p, 0) == (what == Teach::occluded_ones))
                chosen.push_back(p);
        Outcome outcome;
        for (int f = 0; f < frames; ++f) {
            advance(state_.time());
            outcome += query(chosen);
        }
        return outcome;
    }

 private:
    std::shared_ptr<const scene::Scene> scene_;
    scene::SceneState state_;
    ray::RayScene rays_;
    shadow_culling::CertifiedCulling culling_;
    shadow_culling::CullingView view_{glm::vec3(0, 0, 4), 0, 1e9f};
    Tasks one_{1};
};

}   // namespace gnomon::test
