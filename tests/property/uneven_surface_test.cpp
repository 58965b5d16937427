// SPDX-License-Identifier: Apache-2.0
// Surfaces that rise and fall between cache points, or whose light changes between them, against the path-traced
// reference.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "api/scene_access.h"
#include "gnomon/gnomon.h"
#include "scene_helpers.h"

namespace gnomon {
namespace {

constexpr int k_size = 96;

// A dark surface around the origin, under an even sky.
Scene under_sky(scene::Mesh mesh, const glm::dvec3& eye)
{
    scene::Scene scene;
    scene.materials.resize(1);
    scene.materials[0].base_color = glm::vec3(0.3f);
    scene.materials[0].roughness = 1, scene.materials[0].ior = 1;
    mesh.parts = {{0, 0, static_cast<std::uint32_t>(mesh.triangles.size())}};
    scene.meshes.push_back(std::move(mesh));
    test::add_object(scene, 0);
    scene.background.kind = scene::Background::Kind::sky;
    scene.background.zenith = scene.background.horizon = scene.background.ground = glm::vec3(1);
    scene::Camera camera;
    camera.node =
        scene.add_node("camera", scene::none, glm::inverse(glm::lookAt(eye, glm::dvec3(0), glm::dvec3(0, 1, 0))));
    camera.vertical_fov = 0.35;
    scene.cameras.push_back(camera);
    scene.finish();
    return api::public_scene(std::make_shared<const scene::Scene>(std::move(scene)));
}

// A roof of round tiles, as high as wide, seen from low above: tiles are some ten pixels wide.
Scene tiles()
{
    constexpr int k_tiles = 25, k_around = 8, k_along = 50;
    constexpr float k_width = 0.16f, k_length = 4;
    scene::Mesh mesh;
    const int columns = k_tiles * k_around;
    for (int j = 0; j <= k_along; ++j)
        for (int i = 0; i <= columns; ++i) {
            const float angle = static_cast<float>(k_pi) * static_cast<float>(i % k_around) / k_around;
            mesh.positions.emplace_back(k_width * (static_cast<float>(i) / k_around - 0.5f * k_tiles),
                                        k_width * std::sin(angle), k_length * (0.5f - static_cast<float>(j) / k_along));
        }
    for (int j = 0; j < k_along; ++j)
        for (int i = 0; i < columns; ++i) {
            const auto a = static_cast<std::uint32_t>(j * (columns + 1) + i), b = a + 1,
                       c = a + static_cast<std::uint32_t>(columns) + 1, d = c + 1;
            mesh.triangles.emplace_back(a, b, d), mesh.triangles.emplace_back(a, d, c);
        }
    return under_sky(std::move(mesh), {-1.5, 1, 4});
}

// A wall: a profile that is extruded sideways. Each of its faces is two triangles.
// @param profile  from below: height, and how far it is out
Scene wall_of(const std::vector<glm::vec2>& profile)
{
    constexpr float k_half = 3;
    scene::Mesh mesh;
    for (std::size_t i = 0; i + 1 < profile.size(); ++i) {
        const auto first = static_cast<std::uint32_t>(mesh.positions.size());
        for (const glm::vec2& p : {profile[i], profile[i + 1]})
            for (const float x : {-k_half, k_half}) mesh.positions.emplace_back(x, p.x, p.y);
        mesh.triangles.emplace_back(first, first + 1, first + 3),
            mesh.triangles.emplace_back(first, first + 3, first + 2);
    }
    return under_sky(std::move(mesh), {-1.5, -1, 4});
}

// Long mouldings: bands and grooves between them.
Scene mouldings()
{
    constexpr int k_bands = 30;
    constexpr float k_band = 0.1f, k_groove = 0.05f, k_depth = 0.05f;
    // Go up along a band, into the groove, up along it, and out again.
    std::vector<glm::vec2> profile;
    for (int i = 0; i < k_bands; ++i) {
        const float at = (k_band + k_groove) * (static_cast<float>(i) - 0.5f * k_bands);
        profile.insert(profile.end(),
                       {{at, 0}, {at + k_band, 0}, {at + k_band, -k_depth}, {at + k_band + k_groove, -k_depth}});
    }
    return wall_of(profile);
}

// Eaves above each other. Below each, a face in its dark lies a little behind the one that is seen below it: by a 55th
// of the spacing of cache points.
Scene eaves()
{
    constexpr int k_eaves = 8;
    constexpr float k_face = 0.22f, k_dark = 0.1f, k_step = 0.0045f, k_eave = 0.05f, k_out = 0.12f;
    std::vector<glm::vec2> profile;
    for (int i = 0; i < k_eaves; ++i) {
        const float at = (k_face + k_dark + k_eave) * (static_cast<float>(i) - 0.5f * k_eaves);
        const float top = at + k_face + k_dark;
        profile.insert(
            profile.end(),
            {{at, 0}, {at + k_face, 0}, {at + k_face, -k_step}, {top, -k_step}, {top, k_out}, {top + k_eave, k_out}});
    }
    return wall_of(profile);
}

// Leaves close above a floor, as wide as cache points are apart, which therefore lie on the leaves.
Scene below_leaves()
{
    constexpr int k_leaves = 3;
    constexpr float k_half = 1, k_wide = 0.3f, k_height = 0.05f;
    scene::Mesh mesh;
    const auto add = [&](const glm::vec3& at, float half) {
        const auto first = static_cast<std::uint32_t>(mesh.positions.size());
        for (const glm::vec2 to : {glm::vec2(-1, 1), glm::vec2(1, 1), glm::vec2(1, -1), glm::vec2(-1, -1)})
            mesh.positions.push_back(at + half * glm::vec3(to.x, 0, to.y));
        mesh.triangles.emplace_back(first, first + 1, first + 2),
            mesh.triangles.emplace_back(first, first + 2, first + 3);
    };
    add({0, 0, 0}, k_half);
    for (int i = 0; i < k_leaves; ++i)
        for (int k = 0; k < k_leaves; ++k)
            add({0.5f * (static_cast<float>(i) - 1), k_height, 0.5f * (static_cast<float>(k) - 1)}, k_wide / 2);
    return under_sky(std::move(mesh), {2.5, 2.5, 0.7});
}

// A floor, half of it below a low roof: the sky's light ends within the spacing of cache points.
Scene below_a_roof()
{
    constexpr float k_half = 2, k_height = 0.12f, k_thick = 0.002f;
    scene::Mesh mesh;
    const auto add = [&](const glm::vec3& a, const glm::vec3& b, const glm::vec3& c, const glm::vec3& d) {
        const auto first = static_cast<std::uint32_t>(mesh.positions.size());
        mesh.positions.insert(mesh.positions.end(), {a, b, c, d});
        mesh.triangles.emplace_back(first, first + 1, first + 2),
            mesh.triangles.emplace_back(first, first + 2, first + 3);
    };
    const float y = k_height, t = k_height + k_thick;
    add({-k_half, 0, k_half}, {k_half, 0, k_half}, {k_half, 0, -k_half}, {-k_half, 0, -k_half});
    add({-k_half, t, k_half}, {0, t, k_half}, {0, t, -k_half}, {-k_half, t, -k_half});
    add({-k_half, y, -k_half}, {0, y, -k_half}, {0, y, k_half}, {-k_half, y, k_half});
    add({0, y, k_half}, {0, y, -k_half}, {0, t, -k_half}, {0, t, k_half});
    return under_sky(std::move(mesh), {4.2, 0.9, 0.5});
}

std::vector<float> light_of(const Scene& scene, const RenderOptions& options)
{
    const Frame frame = Renderer(options).render(scene, 1);
    const auto layer = std::ranges::find(frame.layers, "indirect", &Layer::name);
    return layer->copy();
}

struct Compared {
    double energy = 0, nrmse = 0;
    std::size_t count = 0;
};

// Bounced light beside that of the path-traced reference.
// @param shade  where the reference has less than this fraction of its brightest pixel
Compared compare(const Scene& scene, float shade = 2)
{
    RenderOptions options;
    options.size = {k_size, k_size};
    options.layers = true;
    options.samples = 1;
    options.bounces = 1;
    const std::vector<float> got = light_of(scene, options);
    options.reference = ReferenceLightOptions{64, 1, 0};
    const std::vector<float> truth = light_of(scene, options);
    double square = 0, sum = 0, sum_truth = 0;
    Compared result;
    const float most = shade * *std::ranges::max_element(truth);
    for (std::size_t i = 0; i < truth.size(); i += 3) {
        if (!(truth[i] > 0) || !(truth[i] < most)) continue;
        const double error = static_cast<double>(got[i] - truth[i]);
        square += error * error, sum += static_cast<double>(got[i]), sum_truth += static_cast<double>(truth[i]);
        ++result.count;
    }
    const auto count = static_cast<double>(result.count);
    result.energy = sum / sum_truth;
    result.nrmse = std::sqrt(square / count) / (sum_truth / count);
    testing::Test::RecordProperty("energy", std::to_string(result.energy));
    testing::Test::RecordProperty("nrmse", std::to_string(result.nrmse));
    return result;
}

TEST(UnevenSurface, RoofTilesAreLitAsTheyAreSeen)
{
    const Compared roof = compare(tiles());
    EXPECT_GT(roof.count, 0.7 * k_size * k_size);
    // .79 and .26 if cache points a spacing apart stand for what lies between them.
    EXPECT_NEAR(roof.energy, 1, 0.06);
    EXPECT_LT(roof.nrmse, 0.13);
}

// Faces of mouldings are as long as the wall, but lower than cache points are apart.
TEST(UnevenSurface, MouldingsAreLitAsTheyAreSeen)
{
    const Compared wall = compare(mouldings());
    EXPECT_GT(wall.count, 0.9 * k_size * k_size);
    EXPECT_NEAR(wall.energy, 1, 0.03);
    EXPECT_LT(wall.nrmse, 0.05);   // .096 by lattice points in the grooves beside
}

TEST(UnevenSurface, FacesBelowEavesAreNotLitLikeThoseInTheirDark)
{
    const Compared wall = compare(eaves());
    EXPECT_GT(wall.count, 0.9 * k_size * k_size);
    EXPECT_NEAR(wall.energy, 1, 0.03);
    EXPECT_LT(wall.nrmse, 0.1);   // .141 by those faces, if they count as even
}

TEST(UnevenSurface, TheSkysLightEndsWhereARoofBegins)
{
    const Compared floor = compare(below_a_roof(), 0.6f);
    EXPECT_GT(floor.count, 0.02 * k_size * k_size);
    // The light changes sixfold within a spacing. .80 if a level stands for it that has a finer one below it.
    EXPECT_LT(floor.nrmse, 0.75);
}

TEST(UnevenSurface, LeavesShadeTheFloorBelowThem)
{
    const Compared floor = compare(below_leaves(), 0.75f);
    EXPECT_GT(floor.count, 0.02 * k_size * k_size);
    // .67 and 1.59 if the floor below takes its light from cache points around the leaves. The shadow is wider than
    // they show.
    EXPECT_LT(floor.nrmse, 0.55);
    EXPECT_LT(floor.energy, 1.5);
}

}   // namespace
}   // namespace gnomon
