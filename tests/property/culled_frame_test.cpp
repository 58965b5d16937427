// SPDX-License-Identifier: Apache-2.0
// Certified shadow culling changes no bit: whole films with and without it, warm and cold, on any number of threads.
#include <gtest/gtest.h>

#include "base/hash.h"
#include "base/random.h"
#include "gnomon/gnomon.h"
#include "ray/ray_scene.h"
#include "render/traced_frame.h"
#include "scene/builtin.h"
#include "shadow_culling/certified_culling.h"
#include "support.h"

namespace gnomon {
namespace {

std::vector<std::uint64_t> frame_hashes(const Scene& scene, FrameRange frames, ShadowCulling culling, int threads = 1)
{
    RenderOptions options;
    options.size = {160, 120};
    options.threads = threads;
    options.shadow_culling = culling;
    Renderer renderer(options);
    std::vector<std::uint64_t> hashes;
    for (int frame = frames.first; frame <= frames.last; ++frame)
        hashes.push_back(hash_span(std::span<const float>(renderer.render(scene, frame).layers[0].data)));
    return hashes;
}

void expect_same(const Scene& scene, FrameRange frames)
{
    const auto plain = frame_hashes(scene, frames, ShadowCulling::off);
    EXPECT_EQ(plain, frame_hashes(scene, frames, ShadowCulling::certified));
    EXPECT_EQ(plain, frame_hashes(scene, frames, ShadowCulling::certified, 3));
    // Cold: a renderer that starts in the middle.
    const FrameRange late{frames.first + frames.count() / 2, frames.last};
    const auto cold = frame_hashes(scene, late, ShadowCulling::certified);
    EXPECT_TRUE(std::equal(cold.begin(), cold.end(), plain.end() - static_cast<std::ptrdiff_t>(cold.size())));
}

TEST(CulledFrame, SameAsTracedOnBuiltinScenes)
{
    expect_same(load("builtin:cornell"), {1, 12});
    expect_same(load("builtin:kinetic"), {40, 46});
    expect_same(load("builtin:spheres?objects=60&dynamic=20&vertices=200"), {1, 8});
}

TEST(CulledFrame, SameAsTracedOnKitchenWithTheCarMoving)
{
    GNOMON_NEED_SCENE(file, "bart/kitchen/aff/kitchen.aff");
    expect_same(load(file.string()), {196, 204});
}

TEST(CulledFrame, SameAsTracedOnRobots)
{
    GNOMON_NEED_SCENE(file, "bart/robots/aff/Robot.aff");
    expect_same(load(file.string()), {200, 206});
}

TEST(CulledFrame, LeavesRaysOutFromTheSecondFrameOn)
{
    const Scene scene = load("builtin:cornell");
    Renderer renderer({.size = {160, 120}, .threads = 1});
    EXPECT_EQ(renderer.render(scene, 1).counters.shadow.rays_skipped, 0u);
    renderer.render(scene, 2);
    const FrameCounters::Shadow shadow = renderer.render(scene, 3).counters.shadow;
    EXPECT_GT(shadow.rays_skipped, shadow.rays / 2);
    EXPECT_GT(shadow.rays_dynamic_only, 0u);
}

// --- Random triangle soups: lights anywhere, on and inside geometry too; points everywhere; what is remembered is
// asked again and again, and must be what rays say.

class Soup {
 public:
    explicit Soup(std::uint64_t seed) : random_(seed)
    {
        scene_.materials.emplace_back();
        scene_.materials.back().double_sided = true;
        const int meshes = 2 + static_cast<int>(random_.below(4));
        for (int m = 0; m < meshes; ++m) add_mesh();
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

// Asks `rounds` batches of random surface points and returns how many answers differ from single rays.
std::uint64_t wrong_answers(std::uint64_t seed, int rounds, std::uint64_t& skipped)
{
    using namespace shadow_culling;
    const auto scene = Soup(seed).take();
    scene::SceneState state(scene, 0);
    const ray::RayScene rays(state);
    CertifiedCulling culling(state, rays, {});
    Tasks one(1);
    Random random(seed, 77);
    std::uint64_t wrong = 0;
    for (int round = 0; round < rounds; ++round) {
        state.advance(0);
        culling.begin_frame(state, rays, {glm::vec3(0, 0, 4), 0.004f, 0});
        std::vector<ShadowPoint> points;
        for (int i = 0; i < 400; ++i) {
            ShadowPoint p;
            p.object = random.below(static_cast<std::uint32_t>(scene->objects.size()));
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
        std::vector<std::unique_ptr<CertifiedCulling::Batch>> batches;
        batches.push_back(culling.make_batch());
        culling.classify(*batches[0], points);
        std::vector<std::uint8_t> blocked(points.size() + 8);
        for (std::size_t l = 0; l < scene->lights.size(); ++l) {
            culling.shadow(*batches[0], static_cast<int>(l), blocked.data());
            const scene::LightState& at = state.light(static_cast<scene::LightId>(l));
            const bool directional = scene->lights[l].type == scene::LightType::directional;
            for (std::size_t i = 0; i < points.size(); ++i) {
                const glm::vec3 d = directional ? -at.direction : at.position - points[i].origin;
                const bool faces = glm::dot(d, points[i].normal) > 0;
                const bool truth =
                    !faces || rays.blocked_single(points[i].origin, 0, d, directional ? k_infinity : 0.9999f);
                wrong += truth != static_cast<bool>(blocked[i]);
            }
        }
        culling.end_frame(batches, one);
        skipped += culling.counters().skipped;
    }
    return wrong;
}

// A static object taken by hand stops casting the shadow that was remembered, and casts its own where it is.
TEST(CertifiedCulling, FollowsStaticObjectsMovedByHand)
{
    const auto scene = std::make_shared<scene::Scene>(scene::make_cornell());
    scene::SceneState state(scene, 0);
    ray::RayScene rays(state);
    shadow_culling::CertifiedCulling culling(state, rays, {});
    Tasks one(1);
    render::TracedOptions options;
    const render::View view = render::make_view(state, 0, {120, 120});
    const auto compare = [&](int frame) {
        render::FrameBuffers remembered, plain;
        render::trace_frame(state, rays, view, options, one, remembered, &culling);
        render::trace_frame(state, rays, view, options, one, plain);
        EXPECT_EQ(remembered.color.data, plain.color.data) << "frame " << frame;
    };
    scene::NodeId block = scene::none;   // the second static object above the floor: any will do
    for (const scene::Object& object : scene->objects)
        if (!object.dynamic) block = object.node;
    ASSERT_NE(block, scene::none);
    for (int frame = 0; frame < 12; ++frame) {
        if (frame >= 4 && frame % 2 == 0) {
            glm::dmat4 moved = scene->nodes[block].local;
            moved[3] += glm::dvec4(-0.08 * frame, 0.1, 0.05 * frame, 0);
            state.override_transform(block, &moved);
        }
        state.advance(scene->timeline.time_of(1 + frame));
        rays.update(state);
        compare(frame);
    }
}

TEST(CertifiedCulling, NeverWrongOnRandomSoups)
{
    std::uint64_t wrong = 0, skipped = 0;
    for (std::uint64_t seed = 1; seed <= 60; ++seed) wrong += wrong_answers(seed, 12, skipped);
    EXPECT_EQ(wrong, 0u);
    EXPECT_GT(skipped, 100'000u);   // else nothing was put to the test
}

TEST(CertifiedCullingFull, NeverWrongOnAThousandRandomSoups)
{
    std::uint64_t wrong = 0, skipped = 0;
    for (std::uint64_t seed = 1; seed <= 1000; ++seed) wrong += wrong_answers(seed, 12, skipped);
    EXPECT_EQ(wrong, 0u);
}

}   // namespace
}   // namespace gnomon
