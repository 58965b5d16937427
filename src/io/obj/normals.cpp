// SPDX-License-Identifier: Apache-2.0
#include "io/obj/normals.h"

#include "io/obj/polygon.h"

namespace gnomon::io {

namespace {

// With more corners than this at one vertex, the exact rule, which compares all pairs, would be slow. The corners are
// then sorted into at most this many bundles of similar normals.
constexpr std::size_t k_most_pairs = 128;
constexpr std::size_t k_most_bundles = 16;

struct Incident {
    std::uint32_t corner;      // index within the object
    std::uint32_t smoothing;   // group
    glm::dvec3 normal;         // of the face, unit
    double angle;              // at the corner
};

glm::vec3 unit_or_zero(const glm::dvec3& v)
{
    const double length = glm::length(v);
    return length > 0 && std::isfinite(length) ? glm::vec3(v / length) : glm::vec3(0);
}

double angle_between(const glm::dvec3& a, const glm::dvec3& b)
{
    const double sine = glm::length(glm::cross(a, b)), cosine = glm::dot(a, b);
    return sine > 0 || cosine != 0 ? std::atan2(sine, cosine) : 0.0;
}

bool smooth_together(const Incident& a, const Incident& b, double least_cosine)
{
    if (a.smoothing != b.smoothing) return false;
    return a.smoothing != ObjFace::k_unset || glm::dot(a.normal, b.normal) >= least_cosine;
}

// Sets the normals of the corners that have none, each of which is one of the incidents of one vertex.
void smooth_vertex(std::span<const Incident> at, double least_cosine, std::vector<glm::vec3>& normals)
{
    if (at.size() <= k_most_pairs) {
        for (const Incident& a : at) {
            if (a.smoothing == 0 || normals[a.corner] != glm::vec3(0)) continue;
            glm::dvec3 sum(0);
            for (const Incident& b : at)
                if (smooth_together(a, b, least_cosine)) sum += b.angle * b.normal;
            normals[a.corner] = unit_or_zero(sum);
        }
        return;
    }
    std::vector<std::pair<Incident, glm::dvec3>> bundles;
    std::vector<std::uint32_t> bundle_of(at.size(), k_no_index);
    for (std::size_t i = 0; i < at.size(); ++i) {
        if (at[i].smoothing == 0) continue;
        for (std::size_t b = 0; b < bundles.size() && bundle_of[i] == k_no_index; ++b)
            if (smooth_together(bundles[b].first, at[i], least_cosine)) bundle_of[i] = static_cast<std::uint32_t>(b);
        if (bundle_of[i] == k_no_index) {
            if (bundles.size() == k_most_bundles) continue;   // stays flat
            bundle_of[i] = static_cast<std::uint32_t>(bundles.size());
            bundles.emplace_back(at[i], glm::dvec3(0));
        }
        bundles[bundle_of[i]].second += at[i].angle * at[i].normal;
    }
    for (std::size_t i = 0; i < at.size(); ++i)
        if (bundle_of[i] != k_no_index && normals[at[i].corner] == glm::vec3(0))
            normals[at[i].corner] = unit_or_zero(bundles[bundle_of[i]].second);
}

}   // namespace

std::vector<glm::vec3> corner_normals(const ObjData& data, std::span<const std::uint32_t> faces,
                                      const ObjNormalOptions& options, std::vector<std::uint32_t>& positions_used)
{
    struct Contributing {
        glm::dvec3 normal;                        // of the face, unit
        std::uint32_t first, corner, smoothing;   // its first contribution, and its corner
    };
    std::vector<glm::vec3> normals;
    std::vector<Contributing> contributing;
    // By contribution. They are few bytes each, because a file of a gigabyte has tens of millions of them.
    std::vector<double> angles;
    std::vector<std::uint32_t> face_of, slot_of;
    std::vector<std::uint32_t> used;   // positions in order of first use
    std::vector<glm::vec3> points;

    for (const std::uint32_t f : faces) {
        const ObjFace& face = data.faces[f];
        const ObjCorner* const corners = &data.corners[face.first_corner];
        bool lacking = false;
        for (std::uint32_t i = 0; i < face.corner_count; ++i) {
            const glm::vec3 given =
                corners[i].normal == k_no_index ? glm::vec3(0) : unit_or_zero(data.normals[corners[i].normal]);
            normals.push_back(given);
            lacking |= given == glm::vec3(0);
        }
        if (!lacking || face.smoothing == 0) continue;

        // Record the face's contribution to each of its vertices.
        points.clear();
        for (std::uint32_t i = 0; i < face.corner_count; ++i) points.push_back(data.positions[corners[i].position]);
        const std::size_t n = face.corner_count;
        contributing.push_back({glm::dvec3(unit_or_zero(newell_normal(points))),
                                static_cast<std::uint32_t>(slot_of.size()),
                                static_cast<std::uint32_t>(normals.size() - n), face.smoothing});
        for (std::size_t i = 0; i < n; ++i) {
            const glm::dvec3 p(points[i]);
            angles.push_back(
                angle_between(glm::dvec3(points[(i + 1) % n]) - p, glm::dvec3(points[(i + n - 1) % n]) - p));
            face_of.push_back(static_cast<std::uint32_t>(contributing.size() - 1));
            std::uint32_t& slot = positions_used[corners[i].position];
            if (slot == k_no_index) {
                slot = static_cast<std::uint32_t>(used.size());
                used.push_back(corners[i].position);
            }
            slot_of.push_back(slot);
        }
    }

    // Group the contributions by vertex (stable counting sort) and smooth each vertex.
    std::vector<std::uint32_t> begin(used.size() + 1, 0);
    for (const std::uint32_t slot : slot_of) ++begin[slot + 1];
    for (std::size_t i = 0; i < used.size(); ++i) begin[i + 1] += begin[i];
    std::vector<std::uint32_t> sorted(slot_of.size()), fill = begin;
    for (std::size_t i = 0; i < slot_of.size(); ++i) sorted[fill[slot_of[i]]++] = static_cast<std::uint32_t>(i);
    const double least_cosine = std::cos(static_cast<double>(options.crease_angle));
    std::vector<Incident> at;
    for (std::size_t v = 0; v < used.size(); ++v) {
        at.clear();
        for (std::uint32_t k = begin[v]; k < begin[v + 1]; ++k) {
            const std::uint32_t i = sorted[k];
            const Contributing& face = contributing[face_of[i]];
            at.push_back({face.corner + (i - face.first), face.smoothing, face.normal, angles[i]});
        }
        smooth_vertex(at, least_cosine, normals);
    }

    for (const std::uint32_t p : used) positions_used[p] = k_no_index;
    return normals;
}

}   // namespace gnomon::io
