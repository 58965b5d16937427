// SPDX-License-Identifier: Apache-2.0
// builtin:spheres: equal spheres in a cube, some of which move; the scene in which shadow textures are measured.
//
// All objects instance one mesh. Dynamic objects follow closed curves: each coordinate is a short Fourier series with
// random phases, so none rests between two frames and the clip ends where it begins. Cost: constant per sphere.

#include <array>
#include <glm/gtc/matrix_transform.hpp>

#include "base/random.h"
#include "scene/builtin/builtin.h"
#include "scene/builtin/shapes.h"

namespace gnomon::scene {

namespace {

constexpr int k_frames = 240;
constexpr double k_fps = 24;
constexpr double k_period = k_frames / k_fps;

constexpr double k_half = 5;   // the cube is from -half to half
// With this radius, 300 spheres (10 percent moving, seed 1, time 0) cover a third (0.332) of a square view around the
// spot's cone. It was found by measuring radii in steps of 0.01; a test repeats the measurement.
constexpr double k_radius = 0.47;
constexpr double k_light_height = 60;    // above the cube's centre
constexpr double k_cone_margin = 1.02;   // of the tangent: the cube's nearest corners are just inside

// A crowd: dynamic objects stay in a column with this half width, seen from the light. Static objects are small and
// stand in the column or beyond its shadow on the cube's floor.
constexpr double k_stage = 3, k_beside = 3.7;
constexpr double k_small_radius = 0.05;
constexpr int k_small_vertices = 38;

constexpr int k_harmonics = 3;
constexpr double k_amplitude = 0.8;   // of the first harmonic; the k-th has 1 / k of it

// position(t) = centre + sum over k of amplitude / k * cos(2 pi k t / period + phase)
class ClosedPath final : public TransformTrack {
 public:
    ClosedPath(const glm::dvec3& centre, Random& random) : centre_(centre)
    {
        for (glm::vec3& phase : phase_)
            for (int axis = 0; axis < 3; ++axis) phase[axis] = random.uniform(0, static_cast<float>(2 * k_pi));
    }
    glm::dmat4 evaluate(double time) const override
    {
        // Make the path's end equal to its beginning bit for bit.
        const double turn = time > 0 && time < k_period ? time / k_period : 0;
        glm::dvec3 p = centre_;
        for (int k = 1; k <= k_harmonics; ++k)
            for (int axis = 0; axis < 3; ++axis)
                p[axis] += k_amplitude / k * std::cos(2 * k_pi * k * turn + static_cast<double>(phase_[k - 1][axis]));
        return glm::translate(glm::dmat4(1), p);
    }
    std::vector<Interval> changing() const override { return {{0, k_period}}; }

    static double reach()
    {
        double sum = 0;
        for (int k = 1; k <= k_harmonics; ++k) sum += k_amplitude / k;
        return sum;
    }

 private:
    glm::dvec3 centre_;
    std::array<glm::vec3, k_harmonics> phase_;
};

struct SphereGrid {
    int rings, segments;
};

// The grid whose 2 + rings * segments is nearest to `vertices`; among equals, the one most similar to 37 rings of
// 55.
SphereGrid grid_of(int vertices)
{
    constexpr double ideal = 55.0 / 37.0, slimmest = 1, widest = 4;   // segments to rings
    SphereGrid best{1, 3};
    double best_shape = widest;
    const auto miss = [&](const SphereGrid& g) { return std::abs(2 + g.rings * g.segments - vertices); };
    for (int rings = 1; rings * rings <= vertices; ++rings) {
        const int segments = std::max(3, (vertices - 2 + rings / 2) / rings);
        const double shape = static_cast<double>(segments) / rings;
        if (shape < slimmest || shape > widest) continue;
        const SphereGrid grid{rings, segments};
        const double from_ideal = std::abs(std::log(shape / ideal));
        if (miss(grid) < miss(best) || (miss(grid) == miss(best) && from_ideal < best_shape))
            best = grid, best_shape = from_ideal;
    }
    return best;
}

}   // namespace

Scene make_spheres(const SpheresOptions& options)
{
    Scene scene;
    scene.name = "builtin:spheres";
    Material material;
    material.name = "chalk";
    material.base_color = {0.75f, 0.50f, 0.28f};
    material.roughness = 0.9f;
    scene.materials.push_back(material);

    const auto add_sphere = [&](const char* name, double radius, int vertices) {
        const SphereGrid grid = grid_of(vertices);
        MeshBuilder builder;
        builder.sphere(glm::vec3(0), static_cast<float>(radius), grid.segments, grid.rings);
        scene.meshes.push_back(builder.finish(name));
    };
    add_sphere("sphere", k_radius, options.vertices);
    if (options.crowd) add_sphere("small sphere", k_small_radius, k_small_vertices);

    const int dynamic_objects = options.dynamic_objects >= 0
                                    ? options.dynamic_objects
                                    : static_cast<int>(std::lround(options.objects * options.dynamic / 100));

    // Place the spheres, leaving room for motion. Positions are random, so the first spheres can be the dynamic
    // ones.
    Random random(options.seed);
    scene.nodes.reserve(static_cast<std::size_t>(options.objects) + 2);
    for (int i = 0; i < options.objects; ++i) {
        const bool moves = i < dynamic_objects;
        const bool small = options.crowd && !moves;
        const double room = k_half - (small ? k_small_radius : k_radius) - (moves ? ClosedPath::reach() : 0.0);
        glm::dvec3 centre;
        const auto draw = [&](double across) {
            for (int axis = 0; axis < 3; ++axis)
                centre[axis] = (axis == 1 ? room : across) * (2.0 * random.uniform() - 1.0);
        };
        const bool near = options.crowd && i < dynamic_objects + k_spheres_near;
        draw(near ? std::min(room, k_stage - k_half + room) : room);
        while (small && !near && std::max(std::abs(centre.x), std::abs(centre.z)) < k_beside) draw(room);
        const NodeId node = scene.add_node({}, none, glm::translate(glm::dmat4(1), centre));
        scene.nodes[node].mesh = small ? 1 : 0;
        if (moves) scene.nodes[node].transform = std::make_shared<ClosedPath>(centre, random);
    }

    // One light above illuminates the whole cube.
    Light spot;
    spot.name = "spot";
    spot.type = LightType::spot;
    spot.color = glm::vec3(9000);   // candela
    spot.profile = SpotProfile::cosine;
    const double corner = k_half * std::sqrt(2.0) / (k_light_height - k_half);
    spot.outer_angle = static_cast<float>(std::atan(k_cone_margin * corner));
    const glm::dvec3 light_position(0, k_light_height, 0);
    spot.node =
        scene.add_node("spot", none, glm::inverse(glm::lookAt(light_position, glm::dvec3(0), glm::dvec3(0, 0, -1))));
    scene.lights.push_back(spot);

    Camera camera;
    camera.name = "corner";
    camera.vertical_fov = 0.72;
    const glm::dvec3 eye(11, 9, 16);
    camera.node =
        scene.add_node("camera", none, glm::inverse(glm::lookAt(eye, glm::dvec3(0, -0.4, 0), glm::dvec3(0, 1, 0))));
    scene.cameras.push_back(camera);
    scene.background.kind = Background::Kind::sky;
    scene.background.zenith = {0.10f, 0.13f, 0.19f};
    scene.background.horizon = {0.16f, 0.17f, 0.19f};
    scene.background.ground = {0.045f, 0.05f, 0.06f};

    scene.timeline = {0, (k_frames - 1) / k_fps, k_frames, k_fps, false};
    scene.finish();
    return scene;
}

}   // namespace gnomon::scene
