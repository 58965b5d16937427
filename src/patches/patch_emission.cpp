// SPDX-License-Identifier: Apache-2.0
#include "patches/patch_emission.h"

#include <algorithm>
#include <bit>

#include "base/check.h"
#include "base/interruption.h"
#include "ray/origin.h"
#include "shading/polygon_light.h"

namespace gnomon::patches {

namespace {

constexpr std::size_t k_points_at_once = 512;   // in a task

bool same(const scene::SizedLight& a, const scene::SizedLight& b)
{
    const auto same_face = [](const scene::SizedFace& x, const scene::SizedFace& y) {
        return x.corner == y.corner && x.corners == y.corners && x.normal == y.normal && x.radiance == y.radiance &&
               x.two_sided == y.two_sided;
    };
    const auto same_place = [](const scene::SizedPlace& x, const scene::SizedPlace& y) {
        return x.position == y.position && x.radiance == y.radiance && x.face == y.face && x.area == y.area;
    };
    return std::equal(a.faces.begin(), a.faces.end(), b.faces.begin(), b.faces.end(), same_face) &&
           std::equal(a.places.begin(), a.places.end(), b.places.begin(), b.places.end(), same_place) &&
           a.cell_radiance == b.cell_radiance && a.cone == b.cone;
}

}   // namespace

// Shades points by one light.
class PatchEmission::Shading {
 public:
    Shading(const scene::SizedLight& light) : light_(light), seen_(light.places.size()) {}

    static shading::SurfacePoint surface(const Point& point)
    {
        shading::SurfacePoint s;
        s.position = point.position;
        s.geometric_normal = s.smooth_normal = s.normal = s.to_viewer = point.normal;
        return s;
    }
    glm::vec3 unshadowed(const Point& point) const
    {
        if (glm::dot(point.normal, light_.centre - point.position) <= -light_.radius) return glm::vec3(0);
        return shading::unshadowed(surface(point), light_, false).irradiance;
    }
    /// What is left of some irradiance if only some places are visible.
    glm::vec3 shadowed(const Point& point, const glm::vec3& unshadowed, std::uint32_t visible)
    {
        if (visible == 0) return glm::vec3(0);
        if (visible == all()) return unshadowed;
        for (std::size_t i = 0; i < seen_.size(); ++i) seen_[i] = (visible >> i) & 1;
        return unshadowed * shading::visible_share(surface(point), light_, light_.places, seen_, 1, false).irradiance;
    }
    std::uint32_t all() const { return static_cast<std::uint32_t>((std::uint64_t{1} << light_.places.size()) - 1); }

 private:
    const scene::SizedLight& light_;
    std::vector<std::uint8_t> seen_;
};

PatchEmission::PatchEmission(const SurfacePatches& patches, const EmissionOptions& options)
    : patches_(patches), options_(options)
{
    GNOMON_CHECK(options.lights.places <= 32);
}

PatchEmission::~PatchEmission() = default;

// Chooses points of the patches at equal steps of area.
void PatchEmission::choose_points(std::size_t lights)
{
    const int wanted =
        std::clamp(options_.points_and_lights / static_cast<int>(std::max<std::size_t>(lights, 1)), 1, options_.points);
    if (lights == 0 || points_of_patch_ == static_cast<std::uint32_t>(wanted)) return;
    points_of_patch_ = static_cast<std::uint32_t>(wanted);
    lights_.clear();
    points_.clear();
    points_.reserve(patches_.patches().size() * points_of_patch_);
    for (const Patch& patch : patches_.patches()) {
        const std::span<const PatchPlace> places = patches_.places(patch);
        double all = 0;
        for (const PatchPlace& place : places) all += static_cast<double>(place.area);
        double sum = static_cast<double>(places[0].area);
        std::size_t at = 0;
        for (int k = 0; k < wanted; ++k) {
            const double middle = all * (static_cast<double>(k) + 0.5) / static_cast<double>(wanted);
            while (sum < middle && at + 1 < places.size()) sum += static_cast<double>(places[++at].area);
            points_.push_back({places[at].position, places[at].normal});
        }
    }
}

// Finds what one light brings to the points, past static geometry.
void PatchEmission::light_points(Light& light, const ray::RayScene& rays, Tasks& tasks) const
{
    const std::vector<scene::SizedPlace>& places = light.shape.places;
    const std::size_t step = std::max<std::size_t>(places.size() / options_.first_places, 1);
    const std::size_t runs = (points_.size() + k_points_at_once - 1) / k_points_at_once;
    std::vector<std::vector<Reached>> found(runs);
    tasks.for_each(runs, [&](std::size_t run, int) {
        interruption_point();
        std::vector<Reached>& reached = found[run];
        const Shading shading(light.shape);
        const std::size_t last = std::min((run + 1) * k_points_at_once, points_.size());
        for (std::size_t p = run * k_points_at_once; p < last; ++p)
            if (const glm::vec3 arrives = shading.unshadowed(points_[p]); arrives != glm::vec3(0))
                reached.push_back({static_cast<std::uint32_t>(p), 0, arrives});
        // Ask some places first. Where they agree, so do the others.
        ray::RayQueue queue;
        std::vector<std::pair<std::uint32_t, std::uint32_t>> target;   // by ray: reached point, place
        std::vector<std::uint8_t> occluded;
        const auto push = [&](std::uint32_t r, std::uint32_t place) {
            const Point& point = points_[reached[r].point];
            queue.push(point.position, 0, places[place].position - point.position, ray::k_shadow_ray_end);
            target.emplace_back(r, place);
        };
        const auto trace = [&] {
            occluded.resize(queue.size() + ray::k_packet_pad);
            rays.occluded(queue, 0, queue.size(), occluded.data(), ray::Against::static_only);
            for (std::size_t i = 0; i < target.size(); ++i)
                if (!occluded[i]) reached[target[i].first].visible |= 1u << target[i].second;
            queue.clear(), target.clear();
        };
        std::uint32_t asked = 0;
        for (std::uint32_t place = 0; place < places.size(); place += static_cast<std::uint32_t>(step))
            asked |= 1u << place;
        for (std::uint32_t r = 0; r < reached.size(); ++r)
            for (std::uint32_t place = 0; place < places.size(); ++place)
                if ((asked >> place) & 1) push(r, place);
        trace();
        for (std::uint32_t r = 0; r < reached.size(); ++r) {
            if (reached[r].visible == asked) reached[r].visible = shading.all();
            if (reached[r].visible == 0 || reached[r].visible == shading.all()) continue;
            for (std::uint32_t place = 0; place < places.size(); ++place)
                if (!((asked >> place) & 1)) push(r, place);
        }
        trace();
        std::erase_if(reached, [](const Reached& r) { return r.visible == 0; });
        if (rays.thins_light()) thin(light, rays, step, reached);
    });
    light.reached.clear();
    for (const std::vector<Reached>& some : found) light.reached.insert(light.reached.end(), some.begin(), some.end());
}

// Multiplies what a light brings by the mean of what passes surfaces that thin light, toward every so many of the
// places that are visible.
void PatchEmission::thin(const Light& light, const ray::RayScene& rays, std::size_t step,
                         std::span<Reached> reached) const
{
    const std::vector<scene::SizedPlace>& places = light.shape.places;
    ray::RayQueue queue;
    std::vector<std::pair<std::size_t, float>> target;   // by ray: reached point, weight
    for (std::size_t r = 0; r < reached.size(); ++r) {
        const Point& point = points_[reached[r].point];
        // Of a light that is seen in part, ask every visible place.
        const bool whole = std::popcount(reached[r].visible) == static_cast<int>(places.size());
        for (std::size_t place = 0; place < places.size(); place += whole ? step : 1) {
            if (!((reached[r].visible >> place) & 1)) continue;
            const float weight = weight_of(places[place], point);
            if (!(weight > 0)) continue;
            queue.push(point.position, 0, places[place].position - point.position, ray::k_shadow_ray_end);
            target.emplace_back(r, weight);
        }
    }
    std::vector<glm::vec3> passes(queue.size());
    rays.let_through(queue, 0, queue.size(), passes.data(), ray::Against::static_only);
    for (std::size_t i = 0; i < target.size();) {
        const std::size_t r = target[i].first;
        glm::dvec3 sum(0);
        double all = 0;
        for (; i < target.size() && target[i].first == r; ++i) {
            const auto weight = static_cast<double>(target[i].second);
            sum += weight * glm::dvec3(passes[i]), all += weight;
        }
        if (all > 0) reached[r].light *= glm::vec3(sum / all);
    }
}

bool PatchEmission::update(const scene::SceneState& state, const ray::RayScene& rays, const scene::SizedLights& lights,
                           Tasks& tasks)
{
    const bool first = first_;
    if (first)
        dynamic_ = std::make_unique<visibility::DynamicBounds>(state, rays);
    else
        dynamic_->update(state, rays);
    const bool relit = first || version_ != lights.version();
    if (relit) {
        first_ = true;   // until all is made
        choose_points(lights.lights().size());
        lights_.resize(lights.lights().size());
        for (std::size_t l = 0; l < lights_.size(); ++l) {
            const scene::SizedLight& shape = lights.lights()[l];
            if (lights_[l] && same(lights_[l]->shape, shape)) continue;
            lights_[l] = std::make_unique<Light>();
            lights_[l]->shape = shape;
            for (const scene::SizedPlace& place : shape.places) lights_[l]->box.add(place.position);
            light_points(*lights_[l], rays, tasks);
        }
        // Sum what the lights bring.
        static_.assign(patches_.patches().size(), glm::vec3(0));
        const float weight = 1 / static_cast<float>(points_of_patch_);
        for (const auto& light : lights_) {
            Shading shading(light->shape);
            for (const Reached& r : light->reached)
                static_[r.point / points_of_patch_] += weight * shading.shadowed(points_[r.point], r.light, r.visible);
        }
        version_ = lights.version();
        first_ = false;
    }
    if (relit || !state.changes().changed.empty()) {
        now_ = static_;
        follow_blockers(rays, tasks);
    }
    return relit;
}

// The weight of a place of a light in what passes on the way to it.
float PatchEmission::weight_of(const scene::SizedPlace& place, const Point& point)
{
    const glm::vec3 way = place.position - point.position;
    const float square = glm::dot(way, way);
    return place.area * luminance(place.radiance) * glm::dot(way, point.normal) / (square * square);
}

// Takes away what dynamic objects hide, and what they do not let through.
void PatchEmission::follow_blockers(const ray::RayScene& rays, Tasks& tasks)
{
    constexpr std::size_t k_reached_at_once = 2048;
    const float weight = 1 / static_cast<float>(points_of_patch_);
    for (const auto& light : lights_) {
        const std::vector<scene::SizedPlace>& places = light->shape.places;
        const std::size_t runs = (light->reached.size() + k_reached_at_once - 1) / k_reached_at_once;
        std::vector<std::vector<std::pair<std::uint32_t, glm::vec3>>> less(runs);   // by patch, ascending
        tasks.for_each(runs, [&](std::size_t run, int) {
            interruption_point();
            const std::size_t last = std::min((run + 1) * k_reached_at_once, light->reached.size());
            ray::RayQueue queue;
            std::vector<std::pair<std::uint32_t, std::uint32_t>> target;   // by ray: reached point, place
            std::vector<std::uint32_t> blockers;
            for (std::size_t r = run * k_reached_at_once; r < last; ++r) {
                const Reached& reached = light->reached[r];
                const glm::vec3& from = points_[reached.point].position;
                Box3 box;
                box.add(from);
                blockers.clear();
                dynamic_->select(box, light->box, blockers);
                if (blockers.empty()) continue;
                for (std::uint32_t place = 0; place < places.size(); ++place) {
                    if (!((reached.visible >> place) & 1)) continue;
                    queue.push(from, 0, places[place].position - from, ray::k_shadow_ray_end);
                    target.emplace_back(static_cast<std::uint32_t>(r), place);
                }
            }
            std::vector<std::uint8_t> occluded(queue.size() + ray::k_packet_pad);
            rays.occluded(queue, 0, queue.size(), occluded.data(), ray::Against::dynamic_only);
            std::vector<glm::vec3> passes(rays.thins_light() ? queue.size() : 0);
            if (!passes.empty()) rays.let_through(queue, 0, queue.size(), passes.data(), ray::Against::dynamic_only);
            Shading shading(light->shape);
            for (std::size_t i = 0; i < target.size();) {
                const Reached& reached = light->reached[target[i].first];
                const Point& point = points_[reached.point];
                std::uint32_t visible = reached.visible;
                const std::uint32_t r = target[i].first;
                // Of the places that are visible, find the mean of what passes.
                glm::dvec3 passing(0);
                double all = 0;
                for (; i < target.size() && target[i].first == r; ++i) {
                    const std::uint32_t place = target[i].second;
                    if (occluded[i]) visible &= ~(1u << place);
                    if (occluded[i] || passes.empty()) continue;
                    const auto by = static_cast<double>(std::max(weight_of(places[place], point), 0.0f));
                    passing += by * glm::dvec3(passes[i]), all += by;
                }
                const glm::vec3 passed = all > 0 ? glm::vec3(passing / all) : glm::vec3(1);
                if (visible == reached.visible && passed == glm::vec3(1)) continue;
                less[run].emplace_back(reached.point / points_of_patch_,
                                       shading.shadowed(point, reached.light, visible) * passed -
                                           shading.shadowed(point, reached.light, reached.visible));
            }
        });
        for (const auto& some : less)
            for (const auto& [patch, difference] : some) now_[patch] += weight * difference;
    }
    for (glm::vec3& irradiance : now_) irradiance = glm::max(irradiance, glm::vec3(0));
}

std::size_t PatchEmission::bytes() const
{
    std::size_t bytes = points_.size() * sizeof(Point) + 2 * static_.size() * sizeof(glm::vec3);
    for (const auto& light : lights_) bytes += light->reached.size() * sizeof(Reached);
    return bytes;
}

}   // namespace gnomon::patches
