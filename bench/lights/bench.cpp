// SPDX-License-Identifier: Apache-2.0
#include "bench/lights/bench.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>

#include "area_light/area_visibility.h"
#include "base/clocks.h"
#include "base/random.h"
#include "bench/core/bench_points.h"
#include "ray/origin.h"
#include "scene/sized_light.h"
#include "scene/view.h"

namespace gnomon::bench {

namespace {

using area_light::AreaLight;
using area_light::AreaVisibility;
using area_light::PartState;
using visibility::ShadowPoint;

struct NamedLight {
    std::string name;
    AreaLight light;
};

AreaLight square(const glm::vec3& centre, const glm::vec3& direction, float side, bool dynamic)
{
    glm::vec3 u, v;
    make_basis(direction, u, v);
    const glm::vec3 a = 0.5f * side * u, b = 0.5f * side * v;
    AreaLight light;
    light.polygon.corner = {centre - a - b, centre + a - b, centre + a + b, centre - a + b};
    light.polygon.corners = 4;
    light.polygon.normal = direction;
    if (glm::dot(glm::cross(a, b), direction) < 0) std::swap(light.polygon.corner[1], light.polygon.corner[3]);
    light.dynamic = dynamic;
    return light;
}

std::vector<NamedLight> lights_of(const scene::SceneState& state, scene::SizedLights& sized, float side)
{
    std::vector<NamedLight> lights;
    const scene::Scene& scene = state.scene();
    for (scene::LightId l = 0; l < scene.lights.size(); ++l) {
        const scene::Light& light = scene.lights[l];
        if (light.type == scene::LightType::directional || light.of_surface || light.of_environment) continue;
        const scene::LightState& at = state.light(l);
        bool moves = false;
        for (scene::NodeId n = light.node; n != scene::none; n = scene.nodes[n].parent)
            moves = moves || scene.nodes[n].may_move();
        lights.push_back({light.name.empty() ? fmt::format("light {}", l) : light.name,
                          square(at.position, at.direction, side, moves)});
    }
    sized.update(state);
    int number = 0;
    for (const scene::SizedLight& light : sized.lights()) {
        ++number;
        if (!light.is_polygon()) continue;
        const scene::SizedFace& face = light.faces.front();
        AreaLight area;
        area.polygon = {face.corner, face.corners, face.normal};
        area.two_sided = face.two_sided;
        area.dynamic = light.dynamic;
        lights.push_back({fmt::format("emissive polygon {}", number), area});
    }
    return lights;
}

// Stratified places of a polygon: uniform in area over its two triangles.
std::vector<glm::vec3> places_of(const area_light::LightPolygon& polygon, int count, std::uint64_t seed)
{
    Random random(seed);
    std::vector<glm::vec3> places;
    const auto side = static_cast<int>(std::lround(std::sqrt(count)));
    const glm::vec3 &a = polygon.corner[0], &b = polygon.corner[1], &c = polygon.corner[2],
                    &d = polygon.corner[static_cast<std::size_t>(polygon.corners - 1)];
    const float first = glm::length(glm::cross(b - a, c - a)), second = glm::length(glm::cross(c - a, d - a));
    const float split = first / (first + second);
    for (int j = 0; j < side; ++j)
        for (int i = 0; i < count / side; ++i) {
            float u = (static_cast<float>(i) + random.uniform()) / static_cast<float>(count / side);
            const float v = (static_cast<float>(j) + random.uniform()) / static_cast<float>(side);
            const bool one = u < split;
            u = one ? u / split : (u - split) / (1 - split);
            const float root = std::sqrt(u);
            const glm::vec3 &q = one ? b : c, &r = one ? c : d;
            places.push_back((1 - root) * a + root * (1 - v) * q + root * v * r);
        }
    return places;
}

// The visible share of the irradiance by rays to these places.
class RayShares {
 public:
    RayShares(const ray::RayScene& rays, const area_light::LightPolygon& polygon, std::vector<glm::vec3> places)
        : rays_(rays), normal_(polygon.normal), places_(std::move(places))
    {
    }
    double share(const ShadowPoint& p)
    {
        queue_.clear(), weights_.clear();
        double all = 0, seen = 0;
        for (const glm::vec3& place : places_) {
            const glm::vec3 way = place - p.origin;
            const float here = glm::dot(way, p.normal), there = std::abs(glm::dot(way, normal_)),
                        square = glm::dot(way, way);
            if (!(here > 0)) continue;
            weights_.push_back(here * there / (square * square));
            queue_.push(p.origin, 0, way, ray::k_shadow_ray_end);
        }
        occluded_.resize(queue_.size() + ray::k_packet_pad);
        rays_.occluded(queue_, 0, queue_.size(), occluded_.data());
        for (std::size_t r = 0; r < weights_.size(); ++r) {
            all += static_cast<double>(weights_[r]);
            if (!occluded_[r]) seen += static_cast<double>(weights_[r]);
        }
        return all > 0 ? seen / all : 0;
    }

 private:
    const ray::RayScene& rays_;
    glm::vec3 normal_;
    std::vector<glm::vec3> places_;
    ray::RayQueue queue_;
    std::vector<float> weights_;
    std::vector<std::uint8_t> occluded_;
};

struct Sums {
    double squares = 0, most = 0;
    std::uint64_t count = 0;
    void add(double difference)
    {
        squares += difference * difference, most = std::max(most, std::abs(difference)), ++count;
    }
    LightsBenchResult::Error error() const
    {
        return {count ? std::sqrt(squares / static_cast<double>(count)) : 0, most};
    }
};

double milliseconds_of(const std::function<void()>& work)
{
    const double start = cpu_ms();
    work();
    return cpu_ms() - start;
}

// What one light's row sums up.
struct LightSums {
    std::uint64_t lit = 0, dark = 0, penumbra = 0, unproven = 0, wrong = 0, segments = 0, triangles = 0;
    double cold = 0, steady = 0;
    int steady_frames = 0;
    Sums error;
};

}   // namespace

LightsBenchResult bench_lights(const std::shared_ptr<const scene::Scene>& scene, const LightsBenchOptions& options,
                               const Progress& progress)
{
    scene::SceneState state(scene, scene->timeline.time_of(options.frames.first));
    ray::RayScene rays(state);
    AreaVisibility visibility(state, rays);
    scene::SizedLights sized;
    LightsBenchResult result;
    std::vector<NamedLight> lights = lights_of(state, sized, options.side);
    if (lights.empty())
        throw UsageError("bench lights needs a point or spot light, or an emissive surface of few polygons");
    std::vector<LightSums> sums(lights.size());
    std::vector<Sums> opponent_errors(options.samples.size());
    std::vector<double> opponent_ms(options.samples.size());
    Sums truth_noise;
    PointTracer tracer;
    const int frames = options.frames.count();
    for (int f = 0; f < frames; ++f) {
        if (f > 0) {
            state.advance(scene->timeline.time_of(options.frames.first + f));
            rays.update(state);
            lights = lights_of(state, sized, options.side);
            if (lights.size() != sums.size())
                throw UsageError("bench lights: the number of lights changes in the clip");
        }
        std::vector<AreaLight> plain;
        for (const NamedLight& light : lights) plain.push_back(light.light);
        visibility.follow(state, rays, plain);
        const scene::View view = scene::make_view(state, options.camera, options.size);

        // Find the points, tile by tile, as a frame hands them over.
        std::vector<std::vector<ShadowPoint>> tiles;
        for (int y = 0; y < options.size.height; y += PointTracer::k_tile)
            for (int x = 0; x < options.size.width; x += PointTracer::k_tile) {
                BenchPoints points;
                tracer.trace(state, rays, view, x, y, 0, points);
                tiles.push_back(std::move(points.points));
            }
        for (std::size_t l = 0; l < lights.size(); ++l) {
            const double done = (f + static_cast<double>(l) / static_cast<double>(lights.size())) / frames;
            if (progress && !progress({"measuring", done})) throw InterruptedError("interrupted");
            const area_light::LightPolygon& polygon = lights[l].light.polygon;
            LightSums& sum = sums[l];
            // The points that face the light, and that it faces.
            std::vector<std::vector<std::uint32_t>> asked(tiles.size());
            std::size_t count = 0;
            for (std::size_t t = 0; t < tiles.size(); ++t)
                for (std::uint32_t p = 0; p < tiles[t].size(); ++p) {
                    const ShadowPoint& point = tiles[t][p];
                    if (point.normal == glm::vec3(0)) continue;
                    const float side = glm::dot(polygon.normal, point.origin - polygon.corner[0]);
                    if (lights[l].light.two_sided ? side == 0 : side <= 0) continue;
                    bool above = false;
                    for (int k = 0; k < polygon.corners; ++k)
                        above = above ||
                                glm::dot(point.normal, polygon.corner[static_cast<std::size_t>(k)] - point.origin) > 0;
                    if (above) asked[t].push_back(p), ++count;
                }

            // Time it: the first time, and when everything is known.
            std::vector<AreaVisibility::Answers> answers(tiles.size());
            std::vector<float> shares;
            AreaVisibility::Scratch scratch;
            const auto all = [&] {
                shares.clear();
                for (std::size_t t = 0; t < tiles.size(); ++t) {
                    visibility.find(scratch, tiles[t], asked[t], l, answers[t]);
                    for (std::size_t k = 0; k < asked[t].size(); ++k) {
                        const ShadowPoint& p = tiles[t][asked[t][k]];
                        float share = answers[t].answer[k] == AreaVisibility::Answer::lit ? 1.0f : 0.0f;
                        if (answers[t].answer[k] == AreaVisibility::Answer::partial)
                            share = visibility.cells(l, answers[t].back[k] != 0)
                                        .share(p.origin, p.normal, p.normal, answers[t].cells[answers[t].at[k]]);
                        shares.push_back(share);
                    }
                }
            };
            const double first = milliseconds_of(all);
            if (f == 0) sum.cold = first;
            double least = first;
            if (f == 0)
                for (int r = 0; r < options.repeats; ++r)
                    least = r == 0 ? milliseconds_of(all) : std::min(least, milliseconds_of(all));
            sum.steady += least, ++sum.steady_frames;

            // Count the states, and check what is proven with rays past static objects.
            glm::vec3 centre(0);
            for (int k = 0; k < polygon.corners; ++k)
                centre += polygon.corner[static_cast<std::size_t>(k)] / static_cast<float>(polygon.corners);
            constexpr std::uint32_t k_targets = 1024;
            const std::vector<glm::vec3> targets = places_of(polygon, k_targets, 2);
            Random random(977 * static_cast<std::uint64_t>(f) + l);
            std::size_t number = 0;
            std::vector<std::pair<const ShadowPoint*, float>> compared;
            const std::size_t stride = std::max<std::size_t>(1, count / static_cast<std::size_t>(options.truth_points));
            for (std::size_t t = 0; t < tiles.size(); ++t)
                for (std::size_t k = 0; k < asked[t].size(); ++k, ++number) {
                    const ShadowPoint& p = tiles[t][asked[t][k]];
                    const PartState part = answers[t].state[k];
                    sum.lit += part == PartState::lit, sum.dark += part == PartState::dark || part == PartState::unlit;
                    sum.penumbra += part == PartState::listed, sum.unproven += part == PartState::open;
                    // Where most of the light is below the horizon, or is seen edge-on, shares are of next to nothing.
                    const glm::vec3 to_centre = centre - p.origin;
                    constexpr float k_edge_on = 0.01f;   // sine
                    if (number % stride == 0 && glm::dot(p.normal, to_centre) > 0 &&
                        std::abs(glm::dot(polygon.normal, to_centre)) > k_edge_on * glm::length(to_centre))
                        compared.emplace_back(&p, shares[number]);
                    if (part != PartState::lit && part != PartState::dark) continue;
                    for (int s = 0; s < options.check; ++s) {
                        const glm::vec3 way = targets[random.below(k_targets)] - p.origin;
                        if (!(glm::dot(way, p.normal) > 0)) continue;
                        ++sum.segments;
                        sum.wrong += rays.occluded_single(p.origin, 0, way, ray::k_shadow_ray_end,
                                                          ray::Against::static_only) != (part == PartState::dark);
                    }
                }

            // Compare with the truth.
            constexpr int k_truth = 2048;
            RayShares one(rays, polygon, places_of(polygon, k_truth, 3)),
                two(rays, polygon, places_of(polygon, k_truth, 4));
            std::vector<double> truth;
            for (const auto& [p, share] : compared) {
                const double x = one.share(*p), y = two.share(*p);
                truth.push_back(0.5 * (x + y));
                truth_noise.add(0.5 * (x - y));
                sum.error.add(static_cast<double>(share) - truth.back());
            }
            for (std::size_t s = 0; s < options.samples.size(); ++s) {
                RayShares opponent(rays, polygon, places_of(polygon, options.samples[s], 5));
                for (std::size_t k = 0; k < compared.size(); ++k)
                    opponent_errors[s].add(opponent.share(*compared[k].first) - truth[k]);
                opponent_ms[s] += milliseconds_of([&] {
                    for (std::size_t t = 0; t < tiles.size(); ++t)
                        for (const std::uint32_t p : asked[t]) opponent.share(tiles[t][p]);
                });
            }
            sum.triangles += scratch.counters.triangles / static_cast<std::uint64_t>(f == 0 ? options.repeats + 1 : 1);
        }
    }
    for (std::size_t l = 0; l < lights.size(); ++l) {
        const LightSums& s = sums[l];
        LightsBenchResult::Row row;
        row.light = lights[l].name;
        row.points = s.lit + s.dark + s.penumbra + s.unproven;
        const double points = std::max<double>(1, static_cast<double>(row.points));
        row.lit = static_cast<double>(s.lit) / points, row.dark = static_cast<double>(s.dark) / points;
        row.penumbra = static_cast<double>(s.penumbra) / points,
        row.unproven = static_cast<double>(s.unproven) / points;
        row.wrong = s.wrong, row.segments = s.segments;
        row.ms_cold = s.cold, row.ms_steady = s.steady / s.steady_frames;
        row.error = s.error.error();
        row.triangles = s.penumbra ? static_cast<double>(s.triangles) / static_cast<double>(s.penumbra) : 0;
        result.rows.push_back(row);
    }
    for (std::size_t s = 0; s < options.samples.size(); ++s)
        result.opponents.push_back({options.samples[s], opponent_ms[s] / (static_cast<double>(lights.size()) * frames),
                                    opponent_errors[s].error()});
    result.truth_rmse = truth_noise.error().rmse;
    result.bytes = visibility.bytes();
    return result;
}

}   // namespace gnomon::bench
