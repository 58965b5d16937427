// SPDX-License-Identifier: Apache-2.0
// Bounced light that samples take from places that earlier ones met (bounced_places.h).
#include "trace/tile_tracer.h"

namespace gnomon::trace {

namespace {

// Places that are seen directly are that much nearer to each other, as points of the irradiance cache are.
constexpr float k_primary_width = 0.25f;

}   // namespace

// A place that a sample meets, without its light. A path of low throughput may be coarser, as for the irradiance cache.
// @return  none: its light is that of its time alone
std::optional<BouncedPlace> TileTracer::bounced_place(const TilePoint& point, const shadow_culling::ShadowPoint& at,
                                                      bool primary) const
{
    const float throughput = largest(point.throughput) * std::max(point.lobe.rays, 1.0f) * point.parts;
    BouncedPlace place;
    place.object = at.object;
    place.position = point.surface.position, place.plane = point.surface.geometric_normal;
    place.normal = point.surface.normal;
    place.width = point.surface.cone.width / std::sqrt(std::min(throughput, 1.0f));
    if (primary) place.width *= k_primary_width;
    if (!places_->moves(at.object)) return place;
    if (scene_.objects[at.object].deforming) return {};

    // Find the place on the mesh, so that places follow the object.
    const scene::Mesh& mesh = scene_.meshes[scene_.objects[at.object].mesh];
    const glm::uvec3& corners = mesh.triangles[at.triangle];
    const glm::vec3 a = mesh.positions[corners.x], b = mesh.positions[corners.y] - a, c = mesh.positions[corners.z] - a;
    glm::vec3 p[3];
    rays_.geometry(at.object).corners(at.triangle, p);
    const glm::vec3 in_mesh = glm::cross(b, c), in_world = glm::cross(p[1] - p[0], p[2] - p[0]);
    const float area = glm::length(in_mesh);
    place.position = a + at.u * b + at.v * c;
    place.plane = in_mesh / area;
    place.width *= std::sqrt(area / glm::length(in_world));
    return place;
}

// Gives a point of a further or blurred sample the bounced light of the places known on it, if the nearest agree in it.
bool TileTracer::take_place(TilePoint& point, const shadow_culling::ShadowPoint& at, bool primary) const
{
    const shading::SurfacePoint& s = point.surface;
    if (point.behind || s.model == scene::ShadingModel::unlit || s.diffuse == glm::vec3(0)) return false;
    const std::optional<BouncedPlace> place = bounced_place(point, at, primary);
    if (!place) return false;
    const std::optional<BouncedPlaces::Found> found = places_->find(*place);
    if (!found) return false;
    const float exposure = blur_ ? blur_->exposure() : refinement_->options.exposure;
    const glm::vec3 reflected = point.throughput * s.diffuse * (s.coverage / static_cast<float>(k_pi));
    const glm::vec3 dark = shading::shown(reflected * found->low, exposure);
    const glm::vec3 bright = shading::shown(reflected * found->high, exposure);
    if (shading::difference(bright, dark) > options_.refine.agree_bounced) return false;
    point.irradiance = found->mean;
    return true;
}

// Takes note of a place whose light was computed.
void TileTracer::note_place(const TilePoint& point, const shadow_culling::ShadowPoint& at, bool primary,
                            const glm::vec3& irradiance)
{
    if (std::optional<BouncedPlace> place = bounced_place(point, at, primary)) {
        place->irradiance = irradiance;
        new_places_.push_back(*place);
    }
}

}   // namespace gnomon::trace
