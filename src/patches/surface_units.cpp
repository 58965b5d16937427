// SPDX-License-Identifier: Apache-2.0
#include "patches/surface_units.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "base/micro_triangles.h"
#include "base/triangle_edges.h"

namespace gnomon::patches {

namespace {

constexpr std::uint32_t k_most_tile_level = 12;
constexpr float k_tile_near = 0.5f, k_tile_far = 0.5f;   // its longest edge: of the region's size, of its distance

// The corners of a part of a triangle.
void corners_of_part(const glm::vec3 (&p)[3], const MicroTriangle& part, std::uint32_t level, glm::vec3 (&out)[3])
{
    glm::dvec2 corner[3];
    corners_of(part, level, corner);
    for (int c = 0; c < 3; ++c) {
        const glm::vec2 at(corner[c]);
        out[c] = (1 - at.x - at.y) * p[0] + at.x * p[1] + at.y * p[2];
    }
}

// Which quarter is taken at each level on the way to a point of a triangle.
std::uint32_t path_to(float u, float v)
{
    const MicroPath path(u, v, static_cast<int>(k_most_tile_level));
    std::uint32_t code = 0;
    for (std::size_t level = 0; level < k_most_tile_level; ++level)
        code = 4 * code + static_cast<std::uint32_t>(path.quarter(level));
    return code;
}

}   // namespace

SurfaceUnits::SurfaceUnits(const scene::SceneState& state, const ray::RayScene& rays, const UnitOptions& options,
                           std::size_t patches)
{
    number(state, rays, options, patches);
    region_ = DetailRegion(state, whole_, [&](std::size_t i) {
        const auto unit = static_cast<std::uint32_t>(i);
        FlatPiece piece;
        corners(rays, unit, piece.corners);
        piece.area = area_[unit];
        piece.added = state.scene().objects[object(unit)].by_default;
        return piece;
    });
    divide_far(rays, options.tiles);
    weight_.resize(size());
    for (std::uint32_t unit = 0; unit < size(); ++unit) {
        glm::vec3 p[3];
        corners(rays, unit, p);
        weight_[unit] = region_.weight((p[0] + p[1] + p[2]) / 3.0f);
    }
}

// Numbers the triangles of static objects that block light, or their groups, and measures them.
void SurfaceUnits::number(const scene::SceneState& state, const ray::RayScene& rays, const UnitOptions& options,
                          std::size_t patches)
{
    const scene::Scene& scene = state.scene();
    place_of_object_.assign(scene.objects.size(), scene::none);
    std::size_t triangles = 0;
    for (scene::ObjectId o = 0; o < scene.objects.size(); ++o) {
        if (scene.objects[o].removed || state.is_dynamic(o) || !state.object_there(o)) continue;
        const scene::Mesh& mesh = scene.meshes[scene.objects[o].mesh];
        if (!rays.geometry(o).mesh || mesh.triangles.empty()) continue;
        place_of_object_[o] = static_cast<std::uint32_t>(objects_.size());
        objects_.push_back(o);
        triangles += mesh.triangles.size();
    }
    if (triangles > options.ungrouped) group_meshes(state, rays, options, triangles, patches);
    first_unit_.push_back(0);
    for (std::uint32_t index = 0; index < objects_.size(); ++index) {
        const ray::ObjectGeometry& geometry = rays.geometry(objects_[index]);
        const scene::Mesh& mesh = *geometry.mesh;
        const auto area_of = [&](std::uint32_t t) {
            glm::vec3 p[3];
            geometry.corners(t, p);
            return 0.5f * glm::length(glm::cross(p[1] - p[0], p[2] - p[0]));
        };
        const std::size_t first = area_.size();
        if (const TriangleGroups* groups = groups_of(index)) {
            for (const TriangleGroups::Group& group : groups->groups) {
                const float area = group.area * area_of(group.triangle);
                area_.push_back(std::isfinite(area) ? area : 0);
            }
        } else {
            area_.resize(first + mesh.triangles.size(), 0.0f);
            for (const scene::MeshPart& part : mesh.parts) {
                if (scene.materials[part.material].surface_class() == scene::SurfaceClass::transparent) continue;
                for (std::uint32_t t = part.first_triangle; t < part.first_triangle + part.triangle_count; ++t)
                    if (const float area = area_of(t); std::isfinite(area)) area_[first + t] = area;
            }
        }
        first_unit_.push_back(static_cast<std::uint32_t>(area_.size()));
    }
    whole_ = static_cast<std::uint32_t>(area_.size());
    index_of_block_.resize((whole_ + k_block - 1) / k_block);
    for (std::uint32_t index = 0, block = 0; block < index_of_block_.size(); ++block) {
        while (first_unit_[index + 1] <= block * k_block) ++index;
        index_of_block_[block] = index;
    }
}

// Groups the triangles of each mesh, by the size of its largest instance.
void SurfaceUnits::group_meshes(const scene::SceneState& state, const ray::RayScene& rays, const UnitOptions& options,
                                std::size_t triangles, std::size_t patches)
{
    struct Use {
        const glm::vec3* positions = nullptr;
        scene::ObjectId object = 0;
        double area = 0;    // in the space of the mesh
        double scale = 0;   // of areas, by the largest instance
        std::uint32_t groups = 0;
    };
    std::vector<Use> uses;   // by first object
    std::unordered_map<const glm::vec3*, std::size_t> use_of;
    double area = 0;
    for (const scene::ObjectId o : objects_) {
        const ray::ObjectGeometry& geometry = rays.geometry(o);
        const auto [at, is_new] = use_of.try_emplace(geometry.positions, uses.size());
        if (is_new) {
            Use& use = uses.emplace_back(Use{geometry.positions, o, 0, 0, 0});
            for (const glm::uvec3& t : geometry.mesh->triangles) {
                const glm::vec3 a = geometry.positions[t.x];
                const float own =
                    0.5f * glm::length(glm::cross(geometry.positions[t.y] - a, geometry.positions[t.z] - a));
                if (std::isfinite(own)) use.area += static_cast<double>(own);
            }
        }
        Use& use = uses[at->second];
        const double scale =
            geometry.to_world ? std::pow(std::abs(glm::determinant(glm::dmat3(*geometry.to_world))), 2.0 / 3) : 1;
        use.scale = std::max(use.scale, scale);
        // What the library adds is few large triangles, which do not tell how small groups have to be.
        if (!state.scene().objects[o].by_default) area += scale * use.area;
        groups_of_.push_back(static_cast<std::uint32_t>(at->second));
    }
    const double most = options.group_area * area / static_cast<double>(patches);
    GroupOptions group;
    group.triangles = static_cast<std::uint32_t>((triangles + options.grouped - 1) / options.grouped);
    for (const Use& use : uses) {
        group.area = use.scale > 0 ? static_cast<float>(most / use.scale) : 0;
        groups_.push_back(group_triangles(state.scene(), rays.geometry(use.object), group));
    }
}

// Lets tiles take the place of what reaches far beyond the region_.
void SurfaceUnits::divide_far(const ray::RayScene& rays, std::size_t most)
{
    struct Open {
        MicroTriangle part;
        std::uint32_t level = 0, code = 0;
    };
    std::vector<Open> open;
    for (float scale = 1;; scale *= 2) {
        tiles_.clear();
        for (std::uint32_t unit = 0; unit < whole_ && tiles_.size() <= most; ++unit) {
            if (!(area_[unit] > 0) || !divides(unit)) continue;
            glm::vec3 whole[3];
            corners(rays, unit, whole);
            if (region_.holds(whole)) continue;
            const std::size_t first = tiles_.size();
            open.assign(1, {});
            while (!open.empty() && tiles_.size() <= most) {
                const Open tile = open.back();
                open.pop_back();
                glm::vec3 p[3];
                corners_of_part(whole, tile.part, tile.level, p);
                const glm::vec3 centre = (p[0] + p[1] + p[2]) / 3.0f;
                float radius = 0;
                for (const glm::vec3& corner : p) radius = std::max(radius, glm::length(corner - centre));
                const float far = std::max(0.0f, region_.distance(centre) - radius);
                const bool small = longest_edge(p) <= scale * std::max(k_tile_near * region_.size(), k_tile_far * far);
                if (small || region_.holds(p) || tile.level == k_most_tile_level) {
                    tiles_.push_back({unit, tile.code, micro_index(tile.part, tile.level) << 4 | tile.level});
                    continue;
                }
                MicroTriangle child[4];
                children_of(tile.part, child);
                const std::uint32_t step = 1u << (2 * (k_most_tile_level - tile.level - 1));
                for (std::uint32_t k = 4; k-- > 0;) open.push_back({child[k], tile.level + 1, tile.code + k * step});
            }
            if (tiles_.size() == first + 1) tiles_.pop_back();
        }
        if (tiles_.size() <= most) break;
    }
    area_.resize(size());
    for (std::uint32_t t = 0; t < tiles_.size(); ++t)
        area_[whole_ + t] = area_[tiles_[t].whole] / static_cast<float>(1u << (2 * tiles_[t].level()));
    for (const Tile& tile : tiles_) area_[tile.whole] = 0;
}

std::uint32_t SurfaceUnits::index_of(std::uint32_t unit) const
{
    const std::uint32_t whole = whole_of(unit);
    std::uint32_t index = index_of_block_[whole / k_block];
    while (first_unit_[index + 1] <= whole) ++index;
    return index;
}

const TriangleGroups::Group* SurfaceUnits::group(std::uint32_t unit) const
{
    const std::uint32_t index = index_of(unit);
    const TriangleGroups* groups = groups_of(index);
    return groups ? &groups->groups[whole_of(unit) - first_unit_[index]] : nullptr;
}

std::uint32_t SurfaceUnits::triangle(std::uint32_t unit) const
{
    if (const TriangleGroups::Group* of = group(unit)) return of->triangle;
    return whole_of(unit) - first_unit_[index_of(unit)];
}

void SurfaceUnits::corners(const ray::RayScene& rays, std::uint32_t unit, glm::vec3 (&p)[3]) const
{
    const ray::ObjectGeometry& geometry = rays.geometry(object(unit));
    if (unit < whole_) return geometry.corners(triangle(unit), p);
    const Tile& tile = tiles_[unit - whole_];
    glm::vec3 whole[3];
    geometry.corners(triangle(unit), whole);
    corners_of_part(whole, micro_at(tile.index(), tile.level()), tile.level(), p);
}

bool SurfaceUnits::divides(std::uint32_t unit) const
{
    const TriangleGroups::Group* of = group(unit);
    return !of || of->area <= 1;
}

float SurfaceUnits::radius_of_group(const ray::RayScene& rays, std::uint32_t unit) const
{
    const TriangleGroups::Group* of = group(unit);
    if (!of || of->area <= 1) return 0;
    glm::vec3 p[3];
    corners(rays, unit, p);
    return of->radius * longest_edge(p);
}

glm::vec2 SurfaceUnits::in_triangle(std::uint32_t unit, const glm::dvec2& uv) const
{
    if (unit < whole_) return glm::vec2(uv);
    const Tile& tile = tiles_[unit - whole_];
    glm::dvec2 corner[3];
    corners_of(micro_at(tile.index(), tile.level()), tile.level(), corner);
    return glm::vec2((1 - uv.x - uv.y) * corner[0] + uv.x * corner[1] + uv.y * corner[2]);
}

SurfaceUnits::Place SurfaceUnits::at(scene::ObjectId object, std::uint32_t triangle, float u, float v) const
{
    if (object >= place_of_object_.size() || place_of_object_[object] == scene::none) return {};
    const std::uint32_t index = place_of_object_[object];
    const TriangleGroups* groups = groups_of(index);
    const std::uint32_t own = groups ? groups->group_of[triangle] : triangle;
    if (own == scene::none) return {};
    const std::uint32_t unit = first_unit_[index] + own;
    if (tiles_.empty()) return {unit, u, v};
    const auto by_unit = [](const Tile& tile, std::uint32_t whole) { return tile.whole < whole; };
    const auto first = std::lower_bound(tiles_.begin(), tiles_.end(), unit, by_unit);
    if (first == tiles_.end() || first->whole != unit) return {unit, u, v};
    // Take the last tile that begins before the point, or there.
    const auto last = std::lower_bound(first, tiles_.end(), unit + 1, by_unit);
    const auto after = std::upper_bound(first, last, path_to(u, v),
                                        [](std::uint32_t code, const Tile& tile) { return code < tile.code; });
    const auto tile = after == first ? first : after - 1;
    const MicroTriangle part = micro_at(tile->index(), tile->level());
    const auto parts = static_cast<float>(1u << tile->level());
    const float a = u * parts - static_cast<float>(part.i), b = v * parts - static_cast<float>(part.j);
    return {whole_ + static_cast<std::uint32_t>(tile - tiles_.begin()), std::max(0.0f, part.upper ? 1 - a : a),
            std::max(0.0f, part.upper ? 1 - b : b)};
}

std::size_t SurfaceUnits::bytes() const
{
    std::size_t bytes =
        (first_unit_.size() + index_of_block_.size() + place_of_object_.size()) * sizeof(std::uint32_t) +
        tiles_.size() * sizeof(Tile);
    for (const TriangleGroups& groups : groups_)
        bytes += groups.groups.size() * sizeof(TriangleGroups::Group) + groups.group_of.size() * sizeof(std::uint32_t);
    return bytes;
}

}   // namespace gnomon::patches
