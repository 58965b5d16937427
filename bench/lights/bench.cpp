// SPDX-License-Identifier: Apache-2.0
#include "bench/lights/bench.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>

#include "area_light/cell_places.h"
#include "base/clocks.h"
#include "base/random.h"
#include "bench/core/bench_points.h"
#include "bench/lights/soft.h"
#include "bench/lights/squares.h"
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
    AreaLight light;
    light.shape.outline.corner = square_corners(centre, direction, side);
    light.shape.outline.corners = 4;
    light.shape.outline.normal = direction;
    light.dynamic = dynamic;
    return light;
}

std::vector<NamedLight> lights_of(const scene::SceneState& state, scene::SizedLights& sized, float side)
{
    std::vector<NamedLight> lights;
    const scene::Scene& scene = state.scene();
    for (scene::LightId l = 0; l < scene.lights.size(); ++l) {
        const scene::Light& light = scene.lights[l];
        if (!becomes_square(light)) continue;
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
        if (!light.is_flat()) continue;
        lights.push_back({fmt::format("emissive {} {}", light.faces.size() > 1 ? "figure" : "polygon", number),
                          area_light::area_light_of(light)});
    }
    return lights;
}

float area_of(const area_light::LightPolygon& polygon)
{
    const glm::vec3 &a = polygon.corner[0], &b = polygon.corner[1], &c = polygon.corner[2],
                    &d = polygon.corner[static_cast<std::size_t>(polygon.corners - 1)];
    return 0.5f * (glm::length(glm::cross(b - a, c - a)) + glm::length(glm::cross(c - a, d - a)));
}

// Adds stratified places of a polygon: uniform in area over its two triangles.
void add_places(const area_light::LightPolygon& polygon, int count, Random& random, std::vector<glm::vec3>& places)
{
    const auto side = std::max(1, static_cast<int>(std::lround(std::sqrt(count))));
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
}

// About so many places of a light.
std::vector<glm::vec3> places_of(const area_light::FlatLight& light, int count, std::uint64_t seed)
{
    Random random(seed);
    std::vector<glm::vec3> places;
    if (light.faces.empty()) {
        add_places(light.outline, count, random, places);
        return places;
    }
    double all = 0, sum = 0;
    for (const area_light::LightPolygon& face : light.faces) all += static_cast<double>(area_of(face));
    for (const area_light::LightPolygon& face : light.faces) {
        const auto before = static_cast<int>(std::lround(sum / all * count));
        sum += static_cast<double>(area_of(face));
        const int here = static_cast<int>(std::lround(sum / all * count)) - before;
        if (here > 0) add_places(face, here, random, places);
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

constexpr std::uint32_t k_targets = 1024;   // places that checks choose from
constexpr int k_most_compared = 8;          // frames that are compared with it, of many; fewer than twice as many are

constexpr std::size_t k_soft_lights = 8;              // that have soft textures, the first ones: views take memory
constexpr double k_dark_share = 1e-3, k_leak = 0.1;   // of a light

// What soft textures of one kind sum up.
struct SoftSums {
    SoftTextures textures;
    const char* name;
    std::vector<Sums> by_light;
    Sums error;
    std::uint64_t leaks = 0, darkest = 0;
    double first = 0, then = 0, updated = 0;
};

class LightsBench {
 public:
    LightsBench(const std::shared_ptr<const scene::Scene>& scene, const LightsBenchOptions& options)
        : scene_(*scene),
          options_(options),
          state_(scene, scene->timeline.time_of(options.frames.first)),
          rays_(state_),
          visibility_(state_, rays_, options.proofs),
          opponent_errors_(options.samples.size()),
          opponent_ms_(options.samples.size())
    {
        lights_ = lights_of(state_, sized_, options.side);
        if (lights_.empty())
            throw UsageError("bench lights needs a point or spot light, or an emissive surface of few polygons");
        sums_.resize(lights_.size());
        const std::vector<Sums> none(lights_.size());
        soft_.push_back({SoftTextures(shadow_textures::SoftScale::receiver), "a distance for each receiver", none, {}});
        soft_.push_back({SoftTextures(shadow_textures::SoftScale::occluder), "one for each occluder on it", none, {}});
    }

    LightsBenchResult run(const Progress& progress)
    {
        const int frames = options_.frames.count();
        for (int f = 0; f < frames; ++f) {
            compared_ += f % std::max(1, frames / k_most_compared) == 0;
            begin_frame(f);
            for (std::size_t l = 0; l < lights_.size(); ++l) {
                const double done = (f + static_cast<double>(l) / static_cast<double>(lights_.size())) / frames;
                if (progress && !progress({"measuring", done})) throw InterruptedError("interrupted");
                find_asked(l);
                time(l, f == 0);
                check(l, 977 * static_cast<std::uint64_t>(f) + l);
                if (f % std::max(1, frames / k_most_compared) == 0) compare(l);
            }
        }
        return result();
    }

 private:
    void begin_frame(int f)
    {
        if (f > 0) {
            state_.advance(scene_.timeline.time_of(options_.frames.first + f));
            rays_.update(state_);
            lights_ = lights_of(state_, sized_, options_.side);
            if (lights_.size() != sums_.size())
                throw UsageError("bench lights: the number of lights changes in the clip");
        }
        std::vector<AreaLight> plain;
        for (const NamedLight& light : lights_) plain.push_back(light.light);
        visibility_.follow(state_, rays_, plain);
        plain.resize(std::min(plain.size(), k_soft_lights));
        for (SoftSums& soft : soft_) {
            const double ms = milliseconds_of([&] { soft.textures.update(state_, plain); });
            (f == 0 ? soft.first : soft.then) += ms;
            if (f > 0) soft.updated += static_cast<double>(soft.textures.updated());
        }
        const scene::View view = scene::make_view(state_, options_.camera, options_.size);
        // Find the points, tile by tile, as a frame hands them over.
        tiles_.clear();
        for (int y = 0; y < options_.size.height; y += PointTracer::k_tile)
            for (int x = 0; x < options_.size.width; x += PointTracer::k_tile) {
                BenchPoints points;
                tracer_.trace(state_, rays_, view, x, y, 0, points);
                tiles_.push_back(std::move(points.points));
            }
    }

    // The points that face the light, and that it faces.
    void find_asked(std::size_t l)
    {
        const area_light::LightPolygon& polygon = lights_[l].light.shape.outline;
        asked_.assign(tiles_.size(), {});
        count_ = 0;
        for (std::size_t t = 0; t < tiles_.size(); ++t)
            for (std::uint32_t p = 0; p < tiles_[t].size(); ++p) {
                const ShadowPoint& point = tiles_[t][p];
                if (point.normal == glm::vec3(0)) continue;
                const float side = glm::dot(polygon.normal, point.origin - polygon.corner[0]);
                if (lights_[l].light.two_sided ? side == 0 : side <= 0) continue;
                bool above = false;
                for (int k = 0; k < polygon.corners; ++k)
                    above =
                        above || glm::dot(point.normal, polygon.corner[static_cast<std::size_t>(k)] - point.origin) > 0;
                if (above) asked_[t].push_back(p), ++count_;
            }
        answers_.resize(tiles_.size());
    }

    void find_shares(std::size_t l)
    {
        shares_.clear();
        for (std::size_t t = 0; t < tiles_.size(); ++t) {
            AreaVisibility::Answers& answers = answers_[t];
            visibility_.find(scratch_, tiles_[t], asked_[t], l, answers);
            for (std::size_t k = 0; k < asked_[t].size(); ++k) {
                const ShadowPoint& p = tiles_[t][asked_[t][k]];
                float share = answers.answer[k] == AreaVisibility::Answer::lit ? 1.0f : 0.0f;
                if (answers.answer[k] == AreaVisibility::Answer::partial)
                    share = visibility_.cells(l, answers.back[k] != 0)
                                .share(p.origin, p.normal, p.normal, answers.cells[answers.at[k]]);
                shares_.push_back(share);
            }
        }
    }

    // The first time, and when everything is known.
    void time(std::size_t l, bool first_frame)
    {
        LightSums& sum = sums_[l];
        scratch_ = {};
        double least = milliseconds_of([&] { find_shares(l); });
        sum.triangles += scratch_.counters.triangles;
        if (first_frame) {
            sum.cold = least;
            for (int r = 0; r < options_.repeats; ++r) {
                const double again = milliseconds_of([&] { find_shares(l); });
                least = r == 0 ? again : std::min(least, again);
            }
        }
        sum.steady += least, ++sum.steady_frames;
    }

    // Counts the states, and checks what is proven with rays past static objects.
    void check(std::size_t l, std::uint64_t seed)
    {
        LightSums& sum = sums_[l];
        Random random(seed);
        const std::vector<glm::vec3> targets = places_of(lights_[l].light.shape, k_targets, 2);
        for (std::size_t t = 0; t < tiles_.size(); ++t)
            for (std::size_t k = 0; k < asked_[t].size(); ++k) {
                const ShadowPoint& p = tiles_[t][asked_[t][k]];
                const PartState part = answers_[t].state[k];
                sum.lit += part == PartState::lit, sum.dark += part == PartState::dark || part == PartState::unlit;
                sum.penumbra += part == PartState::listed, sum.unproven += part == PartState::open;
                if (part != PartState::lit && part != PartState::dark) continue;
                for (int s = 0; s < options_.check; ++s) {
                    const glm::vec3 way = targets[random.below(static_cast<std::uint32_t>(targets.size()))] - p.origin;
                    if (!(glm::dot(way, p.normal) > 0)) continue;
                    ++sum.segments;
                    sum.wrong += rays_.occluded_single(p.origin, 0, way, ray::k_shadow_ray_end,
                                                       ray::Against::static_only) != (part == PartState::dark);
                }
            }
    }

    // Compares some of the points with the truth, and the opponents with both.
    void compare(std::size_t l)
    {
        const area_light::LightPolygon& polygon = lights_[l].light.shape.outline;
        glm::vec3 centre(0);
        for (int k = 0; k < polygon.corners; ++k)
            centre += polygon.corner[static_cast<std::size_t>(k)] / static_cast<float>(polygon.corners);
        const std::size_t stride = std::max<std::size_t>(1, count_ / static_cast<std::size_t>(options_.truth_points));
        std::vector<const ShadowPoint*> compared;
        std::vector<double> truth;
        RayShares one(rays_, polygon, places_of(lights_[l].light.shape, options_.truth / 2, 3)),
            two(rays_, polygon, places_of(lights_[l].light.shape, options_.truth / 2, 4));
        std::size_t number = 0;
        for (std::size_t t = 0; t < tiles_.size(); ++t)
            for (const std::uint32_t asked : asked_[t]) {
                const ShadowPoint& p = tiles_[t][asked];
                const std::size_t at = number++;
                // Where most of the light is below the horizon, or is seen edge-on, shares are of next to nothing.
                const glm::vec3 to_centre = centre - p.origin;
                constexpr float k_edge_on = 0.01f;   // sine
                if (at % stride != 0 || !(glm::dot(p.normal, to_centre) > 0) ||
                    !(std::abs(glm::dot(polygon.normal, to_centre)) > k_edge_on * glm::length(to_centre)))
                    continue;
                const double x = one.share(p), y = two.share(p);
                compared.push_back(&p);
                truth.push_back(0.5 * (x + y));
                truth_noise_.add(0.5 * (x - y));
                sums_[l].error.add(static_cast<double>(shares_[at]) - truth.back());
                // Their views are those of the light's front.
                const bool soft_too = l < k_soft_lights && glm::dot(polygon.normal, p.origin - polygon.corner[0]) > 0;
                for (SoftSums& soft : soft_) {
                    if (!soft_too) break;
                    const auto seen = static_cast<double>(soft.textures.share(l, p));
                    soft.error.add(seen - truth.back());
                    soft.by_light[l].add(seen - truth.back());
                    if (truth.back() > k_dark_share) continue;
                    ++soft.darkest, soft.leaks += seen > k_leak;
                }
            }
        for (std::size_t s = 0; s < options_.samples.size(); ++s) {
            RayShares opponent(rays_, polygon, places_of(lights_[l].light.shape, options_.samples[s], 5));
            for (std::size_t k = 0; k < compared.size(); ++k)
                opponent_errors_[s].add(opponent.share(*compared[k]) - truth[k]);
            opponent_ms_[s] += milliseconds_of([&] {
                for (std::size_t t = 0; t < tiles_.size(); ++t)
                    for (const std::uint32_t p : asked_[t]) opponent.share(tiles_[t][p]);
            });
        }
    }

    LightsBenchResult result() const
    {
        LightsBenchResult result;
        for (std::size_t l = 0; l < lights_.size(); ++l) {
            const LightSums& s = sums_[l];
            LightsBenchResult::Row row;
            row.light = lights_[l].name;
            row.points = s.lit + s.dark + s.penumbra + s.unproven;
            const auto share = [&](std::uint64_t count) {
                return row.points ? static_cast<double>(count) / static_cast<double>(row.points) : 0;
            };
            row.lit = share(s.lit), row.dark = share(s.dark);
            row.penumbra = share(s.penumbra), row.unproven = share(s.unproven);
            row.wrong = s.wrong, row.segments = s.segments;
            row.ms_cold = s.cold, row.ms_steady = s.steady / s.steady_frames;
            row.error = s.error.error();
            for (const SoftSums& soft : soft_)
                if (soft.by_light[l].count > 0) row.soft_rmse.push_back(soft.by_light[l].error().rmse);
            row.triangles = s.penumbra ? static_cast<double>(s.triangles) / static_cast<double>(s.penumbra) : 0;
            result.rows.push_back(row);
        }
        for (std::size_t s = 0; s < options_.samples.size(); ++s)
            result.opponents.push_back({options_.samples[s],
                                        opponent_ms_[s] / (static_cast<double>(lights_.size()) * compared_),
                                        opponent_errors_[s].error()});
        const double later = std::max(options_.frames.count() - 1, 1);
        for (const SoftSums& s : soft_)
            result.soft.push_back({s.name, s.error.error(), s.leaks, s.darkest, s.textures.textures(),
                                   s.updated / later, s.first, s.then / later});
        result.truth_rmse = truth_noise_.error().rmse;
        result.bytes = visibility_.bytes();
        return result;
    }

    const scene::Scene& scene_;
    const LightsBenchOptions& options_;
    scene::SceneState state_;
    ray::RayScene rays_;
    AreaVisibility visibility_;
    scene::SizedLights sized_;
    std::vector<NamedLight> lights_;
    std::vector<LightSums> sums_;
    std::vector<SoftSums> soft_;
    std::vector<Sums> opponent_errors_;
    std::vector<double> opponent_ms_;
    int compared_ = 0;   // frames
    Sums truth_noise_;
    PointTracer tracer_;
    std::vector<std::vector<ShadowPoint>> tiles_;     // of the present frame
    std::vector<std::vector<std::uint32_t>> asked_;   // by tile, of the present light
    std::size_t count_ = 0;                           // of these
    std::vector<AreaVisibility::Answers> answers_;    // by tile
    std::vector<float> shares_;                       // of all asked points
    AreaVisibility::Scratch scratch_;
};

}   // namespace

LightsBenchResult bench_lights(const std::shared_ptr<const scene::Scene>& scene, const LightsBenchOptions& options,
                               const Progress& progress)
{
    return LightsBench(scene, options).run(progress);
}

}   // namespace gnomon::bench
