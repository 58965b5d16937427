// SPDX-License-Identifier: Apache-2.0
#include "patches/dynamic_reflection.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>

#include "base/interruption.h"
#include "base/micro_triangles.h"
#include "lighting/diffuse.h"
#include "ray/light_through.h"
#include "ray/origin.h"
#include "shading/polygon_light.h"

namespace gnomon::patches {

namespace {

constexpr std::size_t k_least_places = 8, k_places_in_all = 1024;   // of a group, and of all groups
constexpr std::size_t k_rays = 8;                                   // of a place
constexpr std::size_t k_places_at_once = 64;                        // by a thread
constexpr double k_most_level = 6;                                  // how often a triangle is divided
constexpr float k_least_bounce = 1e-3f;                             // of the first, the last that counts
constexpr int k_most_bounces = 64;
constexpr float k_most_albedo = 0.98f;
constexpr double k_golden_angle = 2.399963229728653;   // radians
// Steps of a sequence that fills the unit square evenly [Roberts 2018].
constexpr double k_step_u = 0.7548776662466927, k_step_v = 0.5698402909980532;
// A mesh whose areas, as vectors, sum up to less than this fraction of its area is taken to be closed.
constexpr double k_closed = 1e-3;

double area_of(const glm::vec3 (&p)[3])
{
    return 0.5 * static_cast<double>(glm::length(glm::cross(p[1] - p[0], p[2] - p[0])));
}

// Whether the fronts of a closed mesh face its inside. Skins may mirror what they move, and files with double-sided
// materials need not care which side is the front.
bool is_inside_out(const ray::ObjectGeometry& geometry)
{
    double volume = 0;
    glm::vec3 p[3];
    geometry.corners(0, p);
    const glm::dvec3 origin(p[0]);
    for (std::uint32_t t = 0; t < geometry.mesh->triangles.size(); ++t) {
        geometry.corners(t, p);
        const glm::dvec3 a = glm::dvec3(p[0]) - origin, b = glm::dvec3(p[1]) - origin, c = glm::dvec3(p[2]) - origin;
        volume += glm::dot(a, glm::cross(b, c));
    }
    return geometry.mirrored ? volume > 0 : volume < 0;
}

// Ray r of place k, about +z: a Fibonacci lattice on the unit disk, projected up. That of each place is turned and has
// other radii, so that places that face the same way look in many directions together.
glm::vec3 direction_of(std::size_t k, std::size_t r)
{
    const double place = static_cast<double>(k + 1), ray = static_cast<double>(r);
    const double square = (ray + std::fmod(place * k_step_v, 1.0)) / static_cast<double>(k_rays);
    const double phi = (ray + place) * k_golden_angle, radius = std::sqrt(square);
    return glm::vec3(glm::dvec3(radius * std::cos(phi), radius * std::sin(phi), std::sqrt(1 - square)));
}

// What lights may bring to reflectors, by ray: the reflector and what arrives there.
using Arriving = std::vector<std::pair<std::uint32_t, glm::vec3>>;

// Adds what arrives along rays that nothing occludes.
void add_arriving(const ray::RayScene& rays, const ray::RayQueue& queue, const Arriving& arriving,
                  std::vector<glm::vec3>& light)
{
    if (queue.empty()) return;
    std::vector<std::uint8_t> occluded(queue.size() + ray::k_packet_pad);
    rays.occluded(queue, 0, queue.size(), occluded.data());
    std::vector<glm::vec3> passes(rays.thins_light() ? queue.size() : 0);
    if (!passes.empty()) rays.let_through(queue, 0, queue.size(), passes.data(), ray::Against::everything);
    for (std::size_t r = 0; r < arriving.size(); ++r)
        if (!occluded[r])
            light[arriving[r].first] += passes.empty() ? arriving[r].second : arriving[r].second * passes[r];
}

// What each of a place's rays brings besides its own light, if it leaves the scene: the part of an image's irradiance
// that they do not find where nothing hides it.
glm::vec3 missed_by(const Surroundings& surroundings, const PatchRays& rays, std::size_t first, const glm::vec3& normal)
{
    if (!surroundings.any()) return glm::vec3(0);
    glm::vec3 found(0);
    for (std::size_t r = first; r < first + k_rays; ++r) found += surroundings.radiance_beside_spots(rays.direction(r));
    return surroundings.irradiance_beside_spots(normal) - static_cast<float>(k_pi) / static_cast<float>(k_rays) * found;
}

}   // namespace

DynamicReflection::Surface& DynamicReflection::surface_of(const scene::SceneState& state, const ray::RayScene& rays,
                                                          scene::ObjectId object)
{
    const scene::Mesh* mesh = rays.geometry(object).mesh;
    Surface& surface = surfaces_[object];
    if (surface.mesh == mesh) return surface;
    surface = {};
    surface.mesh = mesh;
    // Sum the areas of what blocks light, or thins it. Thin surfaces show their insides, too.
    surface.sums.resize(mesh->triangles.size());
    glm::dvec3 vectors(0);
    bool thin = false, double_sided = false;
    for (std::uint32_t t = 0; t < mesh->triangles.size(); ++t) {
        const scene::Material& material = state.scene().materials[mesh->part_of(t).material];
        const bool thins = scene::thins_light(material);
        if (material.surface_class() != scene::SurfaceClass::transparent || thins) {
            thin = thin || thins, double_sided = double_sided || material.double_sided;
            const glm::uvec3 index = mesh->triangles[t];
            const glm::dvec3 a(mesh->positions[index.x]), b(mesh->positions[index.y]), c(mesh->positions[index.z]);
            const glm::dvec3 vector = 0.5 * glm::cross(b - a, c - a);
            surface.area += glm::length(vector), vectors += vector;
        }
        surface.sums[t] = surface.area;
    }
    surface.closed = !thin && glm::length(vectors) < k_closed * surface.area;
    surface.inside_out = surface.closed && double_sided && is_inside_out(rays.geometry(object));
    return surface;
}

// Chooses places of an object, on both sides unless it is closed: parts of triangles that are larger than two steps of
// area at rest, and places on the others at equal steps.
void DynamicReflection::choose_places(Surface& surface, std::size_t wanted)
{
    if (surface.wanted == wanted) return;
    surface.wanted = wanted;
    surface.places.clear();
    const std::vector<double>& sums = surface.sums;
    const std::size_t sides = surface.closed ? 1 : 2, count = std::max<std::size_t>(wanted / sides, 1);
    const double step = surface.area / static_cast<double>(count);
    const auto add = [&](Place place) {
        for (std::size_t side = 0; side < sides; ++side) {
            place.front = (side == 0) != surface.inside_out;
            surface.places.push_back(place);
        }
    };
    double small = 0, next = 0.5 * step;   // area of small triangles so far, and where the next place is
    for (std::uint32_t t = 0; t < sums.size(); ++t) {
        const double area = sums[t] - (t > 0 ? sums[t - 1] : 0);
        if (area > 2 * step) {
            const auto level =
                static_cast<std::uint32_t>(std::clamp(0.5 * std::log2(area / step) + 0.5, 1.0, k_most_level));
            for (std::uint32_t i = 0; i < 1u << (2 * level); ++i) {
                glm::dvec2 corner[3];
                corners_of(micro_at(i, level), level, corner);
                const glm::vec2 middle((corner[0] + corner[1] + corner[2]) / 3.0);
                add({t,
                     middle.x,
                     middle.y,
                     std::exp2(-2.0f * static_cast<float>(level)),
                     true,
                     {glm::vec2(corner[1] - corner[0]), glm::vec2(corner[2] - corner[0])}});
            }
            continue;
        }
        for (small += area; next < small; next += step) {
            const auto k = static_cast<double>(surface.places.size() / sides + 1);
            double u = std::fmod(k * k_step_u, 1.0), v = std::fmod(k * k_step_v, 1.0);
            if (u + v > 1) u = 1 - u, v = 1 - v;
            add({t, static_cast<float>(u), static_cast<float>(v), static_cast<float>(step / area), true, {}});
        }
    }
    find_neighbours(surface);
}

// Finds the nearest places at rest that face as a place does.
void DynamicReflection::find_neighbours(Surface& surface)
{
    constexpr float k_facing = 0.85f;   // cosine
    const std::size_t count = surface.places.size();
    std::vector<glm::vec3> position(count), normal(count);
    for (std::size_t k = 0; k < count; ++k) {
        const Place& place = surface.places[k];
        const glm::uvec3 index = surface.mesh->triangles[place.triangle];
        const glm::vec3 a = surface.mesh->positions[index.x], b = surface.mesh->positions[index.y] - a,
                        c = surface.mesh->positions[index.z] - a, n = glm::cross(b, c);
        position[k] = a + place.u * b + place.v * c;
        if (glm::length(n) > 0) normal[k] = glm::normalize(place.front ? n : -n);
    }
    surface.neighbours.resize(count);
    std::vector<std::pair<float, std::uint32_t>> near;
    for (std::uint32_t k = 0; k < count; ++k) {
        near.clear();
        for (std::uint32_t other = 0; other < count; ++other)
            if (other != k && glm::dot(normal[k], normal[other]) > k_facing) {
                const glm::vec3 way = position[other] - position[k];
                near.emplace_back(glm::dot(way, way), other);
            }
        const std::size_t found = std::min(near.size(), k_neighbours);
        std::partial_sort(near.begin(), near.begin() + static_cast<std::ptrdiff_t>(found), near.end());
        surface.neighbours[k].fill(k);
        for (std::size_t i = 0; i < found; ++i) surface.neighbours[k][i] = near[i].second;
    }
}

// Of more objects than places, chooses those on which equal steps of area end, in an order that does not depend on
// their numbers.
std::vector<DynamicReflection::Chosen> DynamicReflection::choose_objects(std::vector<Measured> objects, double all)
{
    std::ranges::sort(objects, [](const Measured& a, const Measured& b) {
        for (const int column : {3, 0, 1, 2})
            for (int row = 0; row < 3; ++row)
                if (a.matrix[column][row] != b.matrix[column][row])
                    return a.matrix[column][row] < b.matrix[column][row];
        return a.area < b.area;
    });
    const double step = all / static_cast<double>(k_places_in_all);
    std::vector<Chosen> chosen;
    double sum = 0;
    std::size_t next = 0;
    for (const Measured& of : objects) {
        sum += of.area;
        std::size_t count = 0;
        while (next < k_places_in_all && (static_cast<double>(next) + 0.5) * step < sum) ++next, ++count;
        if (count > 0) chosen.push_back({of.object, count, static_cast<double>(count) * step / of.area});
    }
    return chosen;
}

void DynamicReflection::add_places(const scene::SceneState& state, const ray::RayScene& rays, scene::ObjectId object,
                                   const Surface& surface, float weight)
{
    const ray::ObjectGeometry& geometry = rays.geometry(object);
    const auto first = static_cast<std::uint32_t>(reflectors_.size());
    std::vector<std::uint32_t> reflector(surface.places.size(), scene::none);   // by place
    for (std::uint32_t k = 0; k < surface.places.size(); ++k) {
        const Place& place = surface.places[k];
        glm::vec3 p[3];
        geometry.corners(place.triangle, p);
        glm::vec3 normal = glm::cross(p[1] - p[0], p[2] - p[0]);
        const float length = glm::length(normal);
        if (!(length > 0)) continue;
        normal /= length;
        if (place.front == geometry.mirrored) normal = -normal;
        const glm::vec3 position = (1 - place.u - place.v) * p[0] + place.u * p[1] + place.v * p[2];
        const auto along = [&](const glm::vec2& side) { return side.x * (p[1] - p[0]) + side.y * (p[2] - p[0]); };
        reflector[k] = static_cast<std::uint32_t>(reflectors_.size());
        reflectors_.push_back({object,
                               position,
                               normal,
                               position + ray::origin_lift(p) * normal,
                               glm::vec3(0),
                               weight * place.share * static_cast<float>(area_of(p)),
                               k,
                               {along(place.sides[0]), along(place.sides[1])}});
        const scene::Scene& scene = state.scene();
        const scene::Material& material = scene.materials[geometry.mesh->part_of(place.triangle).material];
        const float covered =
            scene::thins_light(material)
                ? ray::thin_surface(scene, *geometry.mesh, material, place.triangle, place.u, place.v).covered
                : 1;
        albedo_.push_back(covered * lighting::albedo(scene, geometry, place.triangle, place.u, place.v));
        reflected_.push_back(covered *
                             lighting::exitance_per_irradiance(scene, geometry, place.triangle, place.u, place.v));
    }
    // A neighbour without area is none.
    for (std::uint32_t r = first; r < reflectors_.size(); ++r) {
        std::array<std::uint32_t, k_neighbours>& around = neighbours_.emplace_back();
        for (std::size_t i = 0; i < k_neighbours; ++i) {
            const std::uint32_t other = reflector[surface.neighbours[reflectors_[r].number][i]];
            around[i] = other == scene::none ? r : other;
        }
    }
}

// Replaces the irradiance of each place by the mean over those around it.
void DynamicReflection::smoothen()
{
    std::vector<glm::vec3> mean(reflectors_.size());
    for (std::uint32_t k = 0; k < reflectors_.size(); ++k) {
        float area = reflectors_[k].area;
        glm::vec3 sum = area * irradiance_[k];
        for (const std::uint32_t other : neighbours_[k]) {
            if (other == k) continue;
            sum += reflectors_[other].area * irradiance_[other], area += reflectors_[other].area;
        }
        mean[k] = area > 0 ? sum / area : irradiance_[k];
    }
    irradiance_.swap(mean);
}

std::vector<DynamicReflection::Reflector> DynamicReflection::gather(
    const scene::SceneState& state, const ray::RayScene& rays, std::span<const std::vector<scene::ObjectId>> groups,
    const Light& light, Tasks& tasks)
{
    reflectors_.clear(), albedo_.clear(), reflected_.clear(), neighbours_.clear(), order_.clear(), patch_links_.clear();
    if (groups.empty() ||
        (light.exitance.empty() && !light.surroundings.any() && light.emission.empty() && light.further == 0))
        return {};
    surfaces_.resize(state.scene().objects.size());
    group_of_.assign(state.scene().objects.size(), scene::none);
    first_of_group_.clear();
    const std::size_t of_group = std::max(k_places_in_all / groups.size(), k_least_places);
    for (const std::vector<scene::ObjectId>& group : groups) {
        for (const scene::ObjectId o : group) group_of_[o] = static_cast<std::uint32_t>(first_of_group_.size());
        first_of_group_.push_back(static_cast<std::uint32_t>(reflectors_.size()));
        // Divide the group's places by the objects' areas.
        std::vector<Measured> areas;
        double all = 0, of_scale = -1, scale = 1;
        for (const scene::ObjectId o : group) {
            if (!state.object_visible(o)) continue;
            const glm::mat4 matrix = state.object_matrix(o);
            // Most objects have the same size as the one before.
            if (const double volume = std::abs(glm::determinant(glm::dmat3(matrix))); volume != of_scale)
                of_scale = volume, scale = std::cbrt(volume);
            const double area = surface_of(state, rays, o).area * scale * scale;
            if (!std::isfinite(area)) continue;
            areas.push_back({matrix, o, area});
            all += area;
        }
        if (!std::isfinite(all)) continue;
        if (areas.size() > k_places_in_all) {
            for (const Chosen& one : choose_objects(std::move(areas), all)) {
                choose_places(surfaces_[one.object], one.places);
                add_places(state, rays, one.object, surfaces_[one.object], static_cast<float>(one.weight));
            }
            continue;
        }
        for (const auto& [matrix, o, area] : areas) {
            if (!(area > 0)) continue;
            Surface& surface = surfaces_[o];
            const double wanted = std::round(area / all * static_cast<double>(of_group));
            choose_places(surface, std::max<std::size_t>(static_cast<std::size_t>(wanted), 1));
            add_places(state, rays, o, surface, 1);
        }
    }
    first_of_group_.push_back(static_cast<std::uint32_t>(reflectors_.size()));
    irradiance_.assign(reflectors_.size(), glm::vec3(0));
    sides_.clear();
    for (const Reflector& r : reflectors_) sides_.push(r.position, r.normal);
    links_.clear();
    light_by_patches(state, rays, light, tasks);
    light_by_spots(rays, light.surroundings);
    light_by_emission(rays, light);
    smoothen();
    if (!links_.empty()) {
        light_by_points(state, rays);
        bounce_between(irradiance_, of_points_, light.further);
    }
    for (std::size_t k = 0; k < reflectors_.size(); ++k)
        reflectors_[k].flux = reflectors_[k].area * albedo_[k] * irradiance_[k];
    // Sums over them must not depend on the objects' numbers, which a host that adds and removes objects changes.
    const auto key = [](const Reflector& r) {
        return std::tuple(r.position.x, r.position.y, r.position.z, r.normal.x, r.normal.y, r.normal.z, r.flux.x,
                          r.flux.y, r.flux.z);
    };
    order_.resize(reflectors_.size());
    std::iota(order_.begin(), order_.end(), 0u);
    std::ranges::sort(order_, {}, [&](std::uint32_t k) { return key(reflectors_[k]); });
    std::vector<Reflector> result;
    result.reserve(order_.size());
    for (const std::uint32_t k : order_) result.push_back(reflectors_[k]);
    return result;
}

std::vector<glm::vec3> DynamicReflection::again(std::span<const glm::vec3> exitance, int further) const
{
    std::vector<glm::vec3> irradiance(reflectors_.size(), glm::vec3(0)), flux;
    for (const Link& link : patch_links_) irradiance[link.from] += link.weight * exitance[link.to];
    if (!links_.empty()) bounce_between(irradiance, {}, further);
    flux.reserve(order_.size());
    for (const std::uint32_t k : order_) flux.push_back(reflectors_[k].area * albedo_[k] * irradiance[k]);
    return flux;
}

// Adds what patches and the surroundings bring.
void DynamicReflection::light_by_patches(const scene::SceneState& state, const ray::RayScene& rays, const Light& light,
                                         Tasks& tasks)
{
    if (light.exitance.empty() && !light.surroundings.any() && light.further == 0) return;
    const std::size_t count = (reflectors_.size() + k_places_at_once - 1) / k_places_at_once;
    if (runs_.size() < count) runs_.resize(count);
    tasks.for_each(count, [&](std::size_t k, int) {
        interruption_point();
        light_run(state, rays, light, k * k_places_at_once, std::min((k + 1) * k_places_at_once, reflectors_.size()),
                  runs_[k]);
    });
    for (std::size_t k = 0; k < count; ++k) {
        links_.insert(links_.end(), runs_[k].links.begin(), runs_[k].links.end());
        patch_links_.insert(patch_links_.end(), runs_[k].patch_links.begin(), runs_[k].patch_links.end());
    }
    for (glm::vec3& irradiance : irradiance_) irradiance = glm::max(irradiance, glm::vec3(0));   // `missed` may be less
}

// The same for the reflectors first ... end - 1.
void DynamicReflection::light_run(const scene::SceneState& state, const ray::RayScene& rays, const Light& light,
                                  std::size_t first, std::size_t end, Run& run)
{
    PatchRays& cast = run.rays;
    cast.clear();
    run.links.clear(), run.patch_links.clear();
    for (std::size_t k = first; k < end; ++k) {
        const Reflector& from = reflectors_[k];
        glm::vec3 x, y;
        make_basis(from.normal, x, y);
        for (std::size_t r = 0; r < k_rays; ++r) {
            const glm::vec3 d = direction_of(from.number, r);
            cast.push(from.sample, d.x * x + d.y * y + d.z * from.normal);
        }
    }
    cast.trace(state.scene(), rays, ray::Against::everything);
    std::vector<glm::vec3> passes(rays.thins_light() ? cast.size() : 0);
    if (!passes.empty()) cast.find_passing(rays, passes.data(), ray::Against::everything);
    constexpr float k_weight = 1 / static_cast<float>(k_rays);
    glm::vec3 missed(0);
    for (std::size_t r = 0; r < cast.size(); ++r) {
        const std::size_t from = first + r / k_rays;
        if (r % k_rays == 0) missed = missed_by(light.surroundings, cast, r, reflectors_[from].normal);
        const glm::vec3 weight = passes.empty() ? glm::vec3(k_weight) : k_weight * passes[r];
        glm::vec3 arrives(0);
        if (cast.leaves(r)) {
            if (light.surroundings.any())
                arrives =
                    static_cast<float>(k_pi) * light.surroundings.radiance_beside_spots(cast.direction(r)) + missed;
        } else if (state.is_dynamic(cast.object(r))) {
            if (light.further == 0) continue;
            const std::uint32_t to = nearest_place(cast.object(r), cast.end(rays, r));
            if (to != scene::none) run.links.push_back({static_cast<std::uint32_t>(from), to, weight});
            continue;
        } else if (!light.exitance.empty()) {
            const PatchId met = cast.patch(light.patches, rays, r);
            if (met == k_no_patch) continue;
            arrives = light.exitance[met];
            run.patch_links.push_back({static_cast<std::uint32_t>(from), met, weight});
        }
        irradiance_[from] += weight * arrives;
    }
}

// The place that stands for a point of a dynamic object: the nearest of its group that faces the same way.
std::uint32_t DynamicReflection::nearest_place(scene::ObjectId object, const PatchRays::End& at) const
{
    const std::uint32_t group = group_of_[object];
    if (group == scene::none) return scene::none;
    // Of equally near places, take one that does not depend on the objects' numbers.
    const auto key = [&](std::uint32_t k) {
        const Reflector& r = reflectors_[k];
        return std::tuple(r.position.x, r.position.y, r.position.z, r.normal.x, r.normal.y, r.normal.z);
    };
    const std::uint32_t first = first_of_group_[group], last = first_of_group_[group + 1];
    const float least = sides_.least(first, last, at.position, at.normal);
    std::uint32_t nearest = scene::none;
    for (std::uint32_t k = sides_.next(first, last, at.position, at.normal, least); k < last;
         k = sides_.next(k + 1, last, at.position, at.normal, least))
        if (nearest == scene::none || key(k) < key(nearest)) nearest = k;
    return nearest;
}

// Finds what lights without size bring to the places that others see. What these reflect of it themselves is in the
// light maps.
void DynamicReflection::light_by_points(const scene::SceneState& state, const ray::RayScene& rays)
{
    interruption_point();
    of_points_.assign(reflectors_.size(), glm::vec3(0));
    std::vector<char> seen(reflectors_.size(), 0);
    for (const Link& link : links_) seen[link.to] = 1;
    ray::RayQueue queue;
    queue.purpose = ray::RayClass::indirect;
    Arriving arriving;   // exitance
    const scene::Scene& scene = state.scene();
    for (scene::LightId l = 0; l < scene.lights.size(); ++l) {
        if (scene.lights[l].of_surface || scene.lights[l].of_environment || !state.light(l).visible) continue;
        for (std::uint32_t k = 0; k < reflectors_.size(); ++k) {
            if (!seen[k]) continue;
            const Reflector& to = reflectors_[k];
            const scene::LightSample sample = scene::illuminate(scene.lights[l], state.light(l), to.sample);
            const float cosine = glm::dot(sample.to_light, to.normal);
            if (!(cosine > 0) || sample.irradiance == glm::vec3(0)) continue;
            const bool far = !std::isfinite(sample.distance);
            queue.push(to.sample, 0, far ? sample.to_light : sample.distance * sample.to_light,
                       far ? k_infinity : ray::k_shadow_ray_end);
            arriving.emplace_back(k, reflected_[k] * cosine * sample.irradiance);
        }
    }
    add_arriving(rays, queue, arriving, of_points_);
}

// Adds what the places bring to each other, bounce by bounce.
// @param of_points  exitance by lights without size; empty: none
void DynamicReflection::bounce_between(std::vector<glm::vec3>& irradiance, std::span<const glm::vec3> of_points,
                                       int most) const
{
    const std::size_t count = reflectors_.size();
    // The brightest place: a maximum does not depend on the order of the places.
    const auto brightest = [](const std::vector<glm::vec3>& light) {
        float most_light = 0;
        for (const glm::vec3& of : light) most_light = std::max(most_light, luminance(of));
        return most_light;
    };
    std::vector<glm::vec3> last(count), next(count);
    for (std::size_t k = 0; k < count; ++k)
        last[k] = glm::min(albedo_[k], glm::vec3(k_most_albedo)) * irradiance[k] +
                  (of_points.empty() ? glm::vec3(0) : of_points[k]);
    const float enough = k_least_bounce * brightest(last);
    for (int bounce = 0; bounce < std::min(most, k_most_bounces); ++bounce) {
        std::fill(next.begin(), next.end(), glm::vec3(0));
        for (const Link& link : links_) next[link.from] += link.weight * last[link.to];
        for (std::size_t k = 0; k < count; ++k) {
            irradiance[k] += next[k];
            next[k] *= glm::min(albedo_[k], glm::vec3(k_most_albedo));
        }
        last.swap(next);
        if (!(brightest(last) > enough)) break;
    }
}

// Adds what the brightest parts of an environment image bring: rays would meet them by chance.
void DynamicReflection::light_by_spots(const ray::RayScene& rays, const Surroundings& surroundings)
{
    constexpr std::size_t k_most = 4;   // of a place
    const std::span<const Surroundings::Spot> spots = surroundings.spots();
    const std::size_t of_place = std::min(k_most, spots.size());
    ray::RayQueue queue;
    queue.purpose = ray::RayClass::indirect;
    Arriving arriving;   // irradiance
    for (std::uint32_t k = 0; k < reflectors_.size(); ++k)
        for (std::size_t i = 0; i < of_place; ++i) {
            const Reflector& to = reflectors_[k];
            const Surroundings::Spot& spot = spots[(of_place * to.number + i) % spots.size()];
            const float cosine = glm::dot(spot.direction, to.normal);
            if (!(cosine > 0)) continue;
            queue.push(to.sample, 0, spot.direction, k_infinity);
            arriving.emplace_back(
                k, cosine * static_cast<float>(spots.size()) / static_cast<float>(of_place) * spot.irradiance);
        }
    add_arriving(rays, queue, arriving, irradiance_);
}

// Adds what emissive surfaces bring.
void DynamicReflection::light_by_emission(const ray::RayScene& rays, const Light& light)
{
    ray::RayQueue queue;
    queue.purpose = ray::RayClass::indirect;
    Arriving arriving;   // irradiance
    for (const scene::SizedLight& of : light.emission.lights()) {
        interruption_point();
        for (std::size_t k = 0; k < reflectors_.size(); ++k) {
            const Reflector& to = reflectors_[k];
            if (of.places.empty() || glm::dot(to.normal, of.centre - to.position) <= -of.radius) continue;
            // Choose a place of the light that is above the reflector's horizon.
            std::size_t place = to.number % of.places.size(), tried = 0;
            while (tried < of.places.size() && !(glm::dot(of.places[place].position - to.sample, to.normal) > 0))
                place = (place + 1) % of.places.size(), ++tried;
            if (tried == of.places.size()) continue;
            shading::SurfacePoint s;
            s.position = to.position;
            s.geometric_normal = s.smooth_normal = s.normal = s.to_viewer = to.normal;
            const glm::vec3 irradiance = shading::unshadowed(s, of, false).irradiance;
            if (irradiance == glm::vec3(0)) continue;
            queue.push(to.sample, 0, of.places[place].position - to.sample, ray::k_shadow_ray_end);
            arriving.emplace_back(static_cast<std::uint32_t>(k), irradiance);
        }
    }
    add_arriving(rays, queue, arriving, irradiance_);
}

}   // namespace gnomon::patches
