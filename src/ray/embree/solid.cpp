// SPDX-License-Identifier: Apache-2.0
#include "ray/embree/solid.h"

#include "base/check.h"
#include "ray/light_through.h"
#include "scene/alpha_mask.h"

namespace gnomon::ray {

namespace {

constexpr std::size_t k_padding = 2;   // vertices: Embree loads 16 bytes for 12

glm::vec3 unit_or_same(const glm::dvec3& v, const glm::vec3& same)
{
    const double length = glm::length(v);
    return length > 0 && std::isfinite(length) ? glm::vec3(v / length) : same;
}

const GeometryRecord& record_of(void* user)
{
    return *static_cast<const GeometryRecord*>(user);
}

bool faces_away(const RTCFilterFunctionNArguments* args, unsigned lane, bool mirrored)
{
    const unsigned n = args->N;
    const float side = RTCHitN_Ng_x(args->hit, n, lane) * RTCRayN_dir_x(args->ray, n, lane) +
                       RTCHitN_Ng_y(args->hit, n, lane) * RTCRayN_dir_y(args->ray, n, lane) +
                       RTCHitN_Ng_z(args->hit, n, lane) * RTCRayN_dir_z(args->ray, n, lane);
    return mirrored ? side < 0 : side > 0;
}

// Rejects hits on the back of one-sided surfaces (for rays that hit fronts only) and in the holes of masked ones.
void filter(const RTCFilterFunctionNArguments* args, bool may_be_front_only)
{
    const GeometryRecord& record = record_of(args->geometryUserPtr);
    const bool front_only =
        may_be_front_only && record.one_sided && reinterpret_cast<const TraceContext*>(args->context)->front_only;
    for (unsigned lane = 0; lane < args->N; ++lane) {
        if (args->valid[lane] != -1) continue;
        const std::uint32_t triangle = record.first_triangle + RTCHitN_primID(args->hit, args->N, lane);
        const scene::Material& material = record.scene->materials[record.mesh->part_of(triangle).material];
        if (front_only && material.one_sided() && faces_away(args, lane, record.mirrored))
            args->valid[lane] = 0;
        else if (material.alpha_mode == scene::AlphaMode::mask &&
                 scene::cut_away(*record.scene, *record.mesh, material, triangle, RTCHitN_u(args->hit, args->N, lane),
                                 RTCHitN_v(args->hit, args->N, lane)))
            args->valid[lane] = 0;
    }
}

void filter_closest(const RTCFilterFunctionNArguments* args)
{
    filter(args, true);
}

void filter_any(const RTCFilterFunctionNArguments* args)
{
    filter(args, false);
}

// Notes how much light the surface lets through, and lets the ray pass.
void filter_thin(const RTCFilterFunctionNArguments* args)
{
    const GeometryRecord& record = record_of(args->geometryUserPtr);
    std::vector<ThinHit>* const hits = reinterpret_cast<const TraceContext*>(args->context)->thin;
    const unsigned n = args->N;
    for (unsigned lane = 0; lane < n; ++lane) {
        if (args->valid[lane] != -1) continue;
        args->valid[lane] = 0;
        if (!hits) continue;
        const unsigned primitive = RTCHitN_primID(args->hit, n, lane);
        const std::uint32_t triangle = record.first_triangle + primitive;
        const scene::Material& material = record.scene->materials[record.mesh->part_of(triangle).material];
        if (!scene::thins_light(material)) continue;
        const glm::vec3 passes = let_through(*record.scene, *record.mesh, material, triangle,
                                             RTCHitN_u(args->hit, n, lane), RTCHitN_v(args->hit, n, lane));
        if (passes == glm::vec3(1)) continue;
        hits->push_back({RTCRayN_id(args->ray, n, lane), RTCHitN_instID(args->hit, n, lane, 0),
                         RTCHitN_geomID(args->hit, n, lane), primitive, passes});
    }
}

}   // namespace

void BakedVertices::bake(const std::vector<glm::vec3>& from_positions, const std::vector<glm::vec3>& from_normals,
                         const std::vector<glm::vec4>& from_tangents, const glm::dmat4& matrix)
{
    const std::size_t n = from_positions.size();
    positions.resize(n + k_padding);
    for (std::size_t i = 0; i < n; ++i)
        positions[i] = glm::vec3(transform_point(matrix, glm::dvec3(from_positions[i])));
    // The cofactor matrix rotates normals as the inverse transpose does, and exists for singular transforms, too.
    const glm::dmat3 linear(matrix);
    const glm::dmat3 cofactor(glm::cross(linear[1], linear[2]), glm::cross(linear[2], linear[0]),
                              glm::cross(linear[0], linear[1]));
    const double sign = glm::determinant(linear) < 0 ? -1 : 1;
    axis = glm::vec3(-linear[2]);
    normals.resize(from_normals.size());
    for (std::size_t i = 0; i < from_normals.size(); ++i)
        normals[i] = unit_or_same(sign * (cofactor * glm::dvec3(from_normals[i])), from_normals[i]);
    tangents.resize(from_tangents.size());
    for (std::size_t i = 0; i < from_tangents.size(); ++i) {
        const glm::vec3 t(from_tangents[i]);
        tangents[i] = glm::vec4(unit_or_same(linear * glm::dvec3(t), t), from_tangents[i].w);
    }
}

std::size_t BakedVertices::bytes() const
{
    return positions.size() * sizeof(glm::vec3) + normals.size() * sizeof(glm::vec3) +
           tangents.size() * sizeof(glm::vec4);
}

void attach_object(RTCDevice device, RTCScene scene, const scene::Scene& description, scene::ObjectId object,
                   const BakedVertices& vertices, bool mirrored, std::deque<GeometryRecord>& records,
                   RTCBuildQuality quality)
{
    const scene::Mesh& mesh = description.meshes[description.objects[object].mesh];
    const auto material_of = [&](const scene::MeshPart& part) -> const scene::Material& {
        return description.materials[part.material];
    };
    // Parts are sorted by surface class, so each class is one run.
    for (std::size_t begin = 0; begin < mesh.parts.size();) {
        const scene::SurfaceClass surface = material_of(mesh.parts[begin]).surface_class();
        std::size_t end = begin;
        std::uint32_t triangles = 0;
        bool one_sided = false, thins = false;
        for (; end < mesh.parts.size() && material_of(mesh.parts[end]).surface_class() == surface; ++end) {
            triangles += mesh.parts[end].triangle_count;
            one_sided = one_sided || material_of(mesh.parts[end]).one_sided();
            thins = thins || scene::thins_light(material_of(mesh.parts[end]));
        }
        const std::uint32_t first = mesh.parts[begin].first_triangle;
        begin = end;
        if (triangles == 0) continue;

        const bool blocks = surface != scene::SurfaceClass::transparent;
        const bool masked = surface == scene::SurfaceClass::masked;
        const unsigned mask = k_mask_seen | (blocks ? k_mask_blocks : 0) | (thins ? k_mask_thins : 0);
        const auto id = static_cast<unsigned>(records.size());
        records.push_back(
            {&description, &mesh, object, first, one_sided, mirrored, &vertices, triangles, mask, masked, thins, true});
        if (!scene) continue;

        const GeometryHandle geometry(rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE));
        rtcSetSharedGeometryBuffer(geometry.get(), RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                   vertices.positions.data(), 0, sizeof(glm::vec3), mesh.positions.size());
        rtcSetSharedGeometryBuffer(geometry.get(), RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, mesh.triangles.data(),
                                   first * sizeof(glm::uvec3), sizeof(glm::uvec3), triangles);
        rtcSetGeometryMask(geometry.get(), mask);
        if (thins) rtcSetGeometryOccludedFilterFunction(geometry.get(), &filter_thin);

        rtcSetGeometryUserData(geometry.get(), &records.back());
        if (one_sided || masked) rtcSetGeometryIntersectFilterFunction(geometry.get(), &filter_closest);
        if (masked) rtcSetGeometryOccludedFilterFunction(geometry.get(), &filter_any);
        rtcSetGeometryBuildQuality(geometry.get(), quality);
        rtcCommitGeometry(geometry.get());
        rtcAttachGeometryByID(scene, geometry.get(), id);
    }
}

}   // namespace gnomon::ray
