// SPDX-License-Identifier: Apache-2.0
#include "patches/surface_patches.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/check.h"
#include "base/interruption.h"
#include "base/micro_triangles.h"
#include "base/triangle_edges.h"
#include "lighting/diffuse.h"
#include "patches/nearest_place.h"
#include "ray/directions_above.h"
#include "ray/origin.h"

namespace gnomon::patches {

namespace {

constexpr std::uint16_t k_no_code = 0xffff, k_crossed = 0x8000;
constexpr std::uint32_t k_most_level = 9;
constexpr std::uint64_t k_most_parts = 1 << 20;   // unless there are more triangles
constexpr int k_more_levels = 2;                  // for parts longer than patches are wide,
constexpr float k_sliver = 0.06f;                 // if they have this area in squares of that width
constexpr double k_fewer = 0.7;                   // patches aimed at, until there are few enough
constexpr float k_most_albedo = 0.98f;
constexpr std::size_t k_tries = 12;   // places that a point of a crossed part is tested against
constexpr float k_shrink = 0.98f;     // corners of a part, towards its middle
// Directions that are added to the free ones of each place, so that what is closed on all sides still has a weight.
constexpr float k_least_open = 0.2f;
constexpr std::size_t k_cells_at_once = 64, k_units_at_once = 4096, k_patches_at_once = 256;

// The weight of a place among those of its patch, by the number of its free directions: the cube of the free part.
// Light that leaves a patch comes from the places that are open; those between leaves or in joints, which see little of
// the scene and are seen by little of it, do not dilute it.
float weight_of_openness(std::uint8_t openness)
{
    constexpr std::size_t k_directions = std::tuple_size_v<decltype(ray::directions_above({}))>;
    const float open =
        (static_cast<float>(openness) + k_least_open) / (static_cast<float>(k_directions) + k_least_open);
    return open * open * open;
}

}   // namespace

struct SurfacePatches::Part {
    glm::vec3 middle{0}, normal{0};
    float area = 0, radius = 0, lift = 0;
    float width = 0;   // of the cube that it lies in
    std::uint32_t unit = 0;
};

// One side of a part, in its cell.
struct SurfacePatches::Side {
    std::uint64_t cell = 0;
    std::uint32_t code = 0;   // 2 * part + (back ? 1 : 0)
    bool back() const { return (code & 1) != 0; }
    std::uint32_t part() const { return code / 2; }
    glm::vec3 normal(const Part& part) const { return back() ? -part.normal : part.normal; }
};

// The patches of some cells, before they are numbered.
struct SurfacePatches::Made {
    std::vector<Patch> patches;
    std::vector<PatchPlace> places;
    std::vector<std::uint32_t> patch_of;   // by side of these cells

    // Scratch.
    ray::RayQueue rays;
    std::vector<std::uint8_t> occluded;
    std::vector<std::uint32_t> chosen, group, open, target;
    std::vector<float> represents;
    std::vector<std::uint8_t> openness;   // by chosen place
    NearestPlace middles;                 // of the chosen places

    Made() { rays.purpose = ray::RayClass::indirect; }
    void trace(const ray::RayScene& scene)
    {
        occluded.resize(rays.size() + ray::k_packet_pad);
        scene.occluded(rays, 0, rays.size(), occluded.data(), ray::Against::static_only);
    }
};

SurfacePatches::SurfacePatches(const scene::SceneState& state, const ray::RayScene& rays, const PatchOptions& options,
                               Tasks& tasks)
    : options_(options), units_(state, rays, options.units, options.patches)
{
    GNOMON_CHECK(options.most < k_crossed);
    double area = 0;   // where it matters less, less of it counts
    for (std::uint32_t unit = 0; unit < units_.size(); ++unit)
        area += static_cast<double>(units_.weight(unit)) * static_cast<double>(units_.area(unit));
    if (!(area > 0) || !std::isfinite(area)) return;
    std::vector<Part> parts;
    std::vector<Side> sides;
    std::vector<std::size_t> cells;   // of which the first side lies here
    std::vector<Made> made;
    for (double wanted = static_cast<double>(options.patches);; wanted *= k_fewer) {
        // Divide evenly first, to find where there is detail; then by that.
        const auto even = static_cast<float>(std::sqrt(area / wanted));
        divide(
            rays, [&](std::uint32_t unit) { return even / std::sqrt(units_.weight(unit)); }, tasks, parts);
        std::vector<DetailSample> samples;
        for (const Part& part : parts)
            samples.push_back(
                {part.middle, part.area, units_.weight(part.unit), static_cast<std::int8_t>(facing_of(part.normal))});
        const DetailCells cubes(samples, static_cast<std::size_t>(wanted));
        std::vector<float> width(units_.size(), k_infinity);   // by unit: the least of its cubes
        for (const Part& part : parts) width[part.unit] = std::min(width[part.unit], cubes.cube_at(part.middle).width);
        divide(
            rays, [&](std::uint32_t unit) { return width[unit]; }, tasks, parts);
        sort_sides(cubes, tasks, parts, sides);
        cells.clear();
        for (std::size_t s = 0; s < sides.size(); ++s)
            if (s == 0 || sides[s].cell != sides[s - 1].cell) cells.push_back(s);
        if (cells.size() > options.most_cells) continue;
        cells.push_back(sides.size());
        made = make_cells(rays, parts, sides, cells, tasks);
        std::size_t count = 0;
        for (const Made& run : made) count += run.patches.size();
        if (count <= options.most) break;
    }
    units_.forget_areas();
    patch_.assign(2 * parts.size(), k_no_code);
    number_patches(sides, cells, made);
    const std::size_t count = cells.size() - 1;
    tasks.for_each(made.size(), [&](std::size_t run, int) {
        interruption_point();
        const std::size_t first = cells[run * k_cells_at_once],
                          last = cells[std::min((run + 1) * k_cells_at_once, count)];
        mark_crossed(rays, parts, std::span<const Side>(sides).subspan(first, last - first));
    });
}

// Makes the patches of all cells, k_cells_at_once together.
// @param cells  where the sides of each begin, and where those of the last end
std::vector<SurfacePatches::Made> SurfacePatches::make_cells(const ray::RayScene& rays, std::span<const Part> parts,
                                                             std::span<const Side> sides,
                                                             std::span<const std::size_t> cells, Tasks& tasks) const
{
    const std::size_t count = cells.size() - 1;
    std::vector<Made> made((count + k_cells_at_once - 1) / k_cells_at_once);
    tasks.for_each(made.size(), [&](std::size_t run, int) {
        const std::size_t first = run * k_cells_at_once, last = std::min(first + k_cells_at_once, count);
        for (std::size_t c = first; c < last; ++c) {
            interruption_point();
            make_cell(rays, parts, sides.subspan(cells[c], cells[c + 1] - cells[c]), made[run]);
        }
        made[run].rays = {}, made[run].occluded = {};
    });
    return made;
}

void SurfacePatches::number_patches(std::span<const Side> sides, std::span<const std::size_t> cells,
                                    std::vector<Made>& made)
{
    for (std::size_t run = 0; run < made.size(); ++run) {
        const auto patch = static_cast<std::uint32_t>(patches_.size());
        const auto place = static_cast<std::uint32_t>(places_.size());
        const std::size_t first = cells[run * k_cells_at_once];
        for (std::size_t s = 0; s < made[run].patch_of.size(); ++s)
            patch_[sides[first + s].code] = static_cast<std::uint16_t>(patch + made[run].patch_of[s]);
        for (Patch& p : made[run].patches) {
            p.first += place, p.cell += patch;
            patches_.push_back(p);
        }
        places_.insert(places_.end(), made[run].places.begin(), made[run].places.end());
        made[run] = {};
    }
    GNOMON_CHECK(patches_.size() < k_crossed);
}

// The barycentric coordinates of a part's middle, in its unit.
glm::dvec2 SurfacePatches::middle_of(std::uint32_t part, std::uint32_t unit) const
{
    glm::dvec2 corner[3];
    corners_of(micro_at(part - first_part_[unit], level_[unit]), level_[unit], corner);
    return (corner[0] + corner[1] + corner[2]) / 3.0;
}

// How often a triangle is divided into quarters.
std::uint8_t SurfacePatches::level_of(float area, float edge, float width) const
{
    std::uint8_t level = 0;
    const float side = width / options_.parts;
    while (area > side * side && level < k_most_level) area *= 0.25f, ++level;
    // Divide long parts further, unless they are slivers.
    edge /= static_cast<float>(1u << level);
    for (int more = 0; more < k_more_levels && edge > width && level < k_most_level; ++more) {
        if (area < k_sliver * width * width) break;
        area *= 0.25f, edge *= 0.5f, ++level;
    }
    return level;
}

// Divides the units into parts, by how wide patches are there.
void SurfacePatches::divide(const ray::RayScene& rays, const std::function<float(std::uint32_t)>& width, Tasks& tasks,
                            std::vector<Part>& parts)
{
    first_part_.assign(1, 0);
    level_.assign(units_.size(), 0);
    // Choose levels; coarser ones, if there were too many parts. Groups are not divided, unless they are one triangle.
    for (float scale = 1;; scale *= 1.5f) {
        std::uint64_t count = 0;
        bool whole = true;   // no unit is divided
        for (std::uint32_t unit = 0; unit < units_.size(); ++unit) {
            if (!(units_.area(unit) > 0)) continue;
            if (units_.divides(unit)) {
                glm::vec3 p[3];
                units_.corners(rays, unit, p);
                level_[unit] = level_of(units_.area(unit), longest_edge(p), scale * width(unit));
            }
            whole = whole && level_[unit] == 0;
            count += std::uint64_t{1} << (2 * level_[unit]);
        }
        if (count <= k_most_parts || whole) break;
    }
    for (std::uint32_t unit = 0; unit < units_.size(); ++unit)
        first_part_.push_back(first_part_.back() + (units_.area(unit) > 0 ? 1u << (2 * level_[unit]) : 0));
    parts.assign(first_part_.back(), {});
    const std::size_t runs = (units_.size() + k_units_at_once - 1) / k_units_at_once;
    tasks.for_each(runs, [&](std::size_t run, int) {
        interruption_point();
        const std::size_t last = std::min((run + 1) * k_units_at_once, std::size_t{units_.size()});
        for (std::size_t u = run * k_units_at_once; u < last; ++u) {
            if (first_part_[u] == first_part_[u + 1]) continue;
            const auto unit = static_cast<std::uint32_t>(u);
            glm::vec3 p[3];
            units_.corners(rays, unit, p);
            Part part;
            part.normal = glm::normalize(glm::cross(p[1] - p[0], p[2] - p[0]));
            part.lift = ray::origin_lift(p);
            part.area = units_.area(unit) / static_cast<float>(1u << (2 * level_[u]));
            part.unit = unit;
            const float scale = 1 / static_cast<float>(1u << level_[u]);
            const glm::vec3 centre = (p[0] + p[1] + p[2]) / 3.0f;
            for (const glm::vec3& corner : p) part.radius = std::max(part.radius, scale * glm::length(corner - centre));
            part.radius = std::max(part.radius, units_.radius_of_group(rays, unit));
            for (std::uint32_t i = first_part_[u]; i < first_part_[u + 1]; ++i) {
                const glm::vec2 at(middle_of(i, unit));
                part.middle = (1 - at.x - at.y) * p[0] + at.x * p[1] + at.y * p[2];
                parts[i] = part;
            }
        }
    });
}

// Sorts the sides of the parts by cell: by cube, side and the direction that they face.
void SurfacePatches::sort_sides(const DetailCells& cubes, Tasks& tasks, std::vector<Part>& parts,
                                std::vector<Side>& sides)
{
    std::vector<Side> unsorted(2 * parts.size());   // in the order of their codes
    const std::size_t runs = (parts.size() + k_units_at_once - 1) / k_units_at_once;
    tasks.for_each(runs, [&](std::size_t run, int) {
        const std::size_t last = std::min((run + 1) * k_units_at_once, parts.size());
        for (std::size_t i = run * k_units_at_once; i < last; ++i) {
            const DetailCells::Cube cube = cubes.cube_at(parts[i].middle);
            parts[i].width = cube.width;
            const auto facing = static_cast<std::uint64_t>(facing_of(parts[i].normal));
            for (const std::uint64_t back : {0, 1})
                unsorted[2 * i + back] = {static_cast<std::uint64_t>(cube.number) << 4 | (facing << 1) | back,
                                          static_cast<std::uint32_t>(2 * i + back)};
        }
    });
    // Cells are numbers below 16 times the number of cubes: count those of each, and place them one after the other.
    std::uint64_t most = 0;
    for (const Side& side : unsorted) most = std::max(most, side.cell);
    std::vector<std::size_t> next(static_cast<std::size_t>(most) + 2, 0);
    for (const Side& side : unsorted) ++next[side.cell + 1];
    for (std::size_t cell = 1; cell < next.size(); ++cell) next[cell] += next[cell - 1];
    sides.resize(unsorted.size());
    for (const Side& side : unsorted) sides[next[side.cell]++] = side;
}

// Chooses places of a cell at equal steps of area.
void SurfacePatches::choose_places(std::span<const Part> parts, std::span<const Side> sides, Made& made) const
{
    const auto part = [&](std::size_t s) -> const Part& { return parts[sides[s].part()]; };
    made.chosen.clear();
    if (sides.size() <= options_.places) {
        for (std::uint32_t s = 0; s < sides.size(); ++s) made.chosen.push_back(s);
    } else {
        double all = 0, sum = 0;
        for (std::size_t s = 0; s < sides.size(); ++s) all += static_cast<double>(part(s).area);
        const double step = all / static_cast<double>(options_.places);
        double next = 0.5 * step;
        for (std::uint32_t s = 0; s < sides.size(); ++s) {
            sum += static_cast<double>(part(s).area);
            if (sum <= next) continue;
            made.chosen.push_back(s);
            while (next < sum) next += step;
        }
    }
}

// A place of a cell, at some height above its surface.
glm::vec3 SurfacePatches::above(std::span<const Part> parts, const Side& side, float lift)
{
    const Part& of = parts[side.part()];
    return of.middle + std::max(lift, of.lift) * side.normal(of);
}

// Groups the places that see each other above the surface. Covered ones, with something closer than that, are a group
// of their own.
// @return  how many groups there are
std::uint32_t SurfacePatches::group_places(const ray::RayScene& rays, std::span<const Part> parts,
                                           std::span<const Side> sides, Made& made) const
{
    const std::size_t count = made.chosen.size();
    const auto side = [&](std::size_t k) -> const Side& { return sides[made.chosen[k]]; };
    const float lift = options_.lift * parts[sides[0].part()].width;
    constexpr std::uint32_t k_open = scene::none;
    made.group.assign(count, k_open);
    made.rays.clear();
    for (std::size_t k = 0; k < count; ++k)
        made.rays.push(above(parts, side(k), 0), 0, lift * side(k).normal(parts[side(k).part()]), 1);
    made.trace(rays);
    std::uint32_t groups = 0;
    bool covered = false;
    for (std::size_t k = 0; k < count; ++k)
        if (made.occluded[k]) made.group[k] = 0, covered = true;
    if (covered) groups = 1;
    for (int round = 0; round < options_.separated; ++round) {
        made.open.clear();
        for (std::uint32_t k = 0; k < count; ++k)
            if (made.group[k] == k_open) made.open.push_back(k);
        if (made.open.empty()) break;
        const std::uint32_t group = groups++;
        const bool last = round + 1 == options_.separated;
        const glm::vec3 from = above(parts, side(made.open.front()), lift);
        made.rays.clear();
        for (const std::uint32_t k : made.open) made.rays.push(from, 0, above(parts, side(k), lift) - from, 1);
        made.trace(rays);
        for (std::size_t i = 0; i < made.open.size(); ++i)
            if (last || i == 0 || !made.occluded[i]) made.group[made.open[i]] = group;
    }
    return groups;
}

// Counts the directions in which nothing is close to a place: those that see much of the scene are seen by it.
void SurfacePatches::find_openness(const ray::RayScene& rays, std::span<const Part> parts, std::span<const Side> sides,
                                   Made& made) const
{
    constexpr std::size_t k_directions = std::tuple_size_v<decltype(ray::directions_above({}))>;
    const float reach = options_.open_reach * parts[sides[0].part()].width;
    made.rays.clear();
    for (const std::uint32_t s : made.chosen) {
        const glm::vec3 n = sides[s].normal(parts[sides[s].part()]), from = above(parts, sides[s], 0);
        for (const glm::vec3& d : ray::directions_above(n)) made.rays.push(from, 0, reach * d, 1);
    }
    made.trace(rays);
    made.openness.assign(made.chosen.size(), 0);
    for (std::size_t r = 0; r < made.rays.size(); ++r) made.openness[r / k_directions] += made.occluded[r] ? 0 : 1;
}

// Splits groups by how open their places are.
// @return  how many groups there are
std::uint32_t SurfacePatches::split_by_openness(std::uint32_t groups, Made& made)
{
    constexpr std::uint32_t k_classes = 3;   // of 0 or 1, 2 or 3, 4 or 5 open directions
    std::vector<std::uint32_t> number(k_classes * groups, scene::none);
    std::uint32_t count = 0;
    for (std::size_t k = 0; k < made.chosen.size(); ++k) {
        std::uint32_t& of = number[k_classes * made.group[k] + made.openness[k] / 2];
        if (of == scene::none) of = count++;
        made.group[k] = of;
    }
    return count;
}

// Keeps some places of a group, at equal steps of what they represent, and divides the patch's area among them.
void SurfacePatches::keep_places(std::span<const Part> parts, std::span<const Side> sides, std::uint32_t group,
                                 float patch_area, Made& made) const
{
    std::size_t count = 0;
    double all = 0, sum = 0;
    for (std::size_t k = 0; k < made.chosen.size(); ++k)
        if (made.group[k] == group) ++count, all += static_cast<double>(made.represents[k]);
    const double step = all / static_cast<double>(options_.kept), scale = static_cast<double>(patch_area) / all;
    double next = 0.5 * step;
    for (std::size_t k = 0; k < made.chosen.size(); ++k) {
        if (made.group[k] != group) continue;
        const Side& side = sides[made.chosen[k]];
        const Part& of = parts[side.part()];
        auto represents = static_cast<double>(made.represents[k]);
        if (count > options_.kept) {
            sum += represents;
            if (sum <= next) continue;
            for (represents = 0; next < sum; next += step) represents += step;
        }
        const auto area = static_cast<float>(scale * represents);
        made.places.push_back({above(parts, side, 0), side.normal(of), area, side.part()});
    }
}

// Makes the patches of one cell.
void SurfacePatches::make_cell(const ray::RayScene& rays, std::span<const Part> parts, std::span<const Side> sides,
                               Made& made) const
{
    const auto part = [&](std::size_t s) -> const Part& { return parts[sides[s].part()]; };
    choose_places(parts, sides, made);
    const std::uint32_t seeing = group_places(rays, parts, sides, made);
    find_openness(rays, parts, sides, made);
    const std::uint32_t groups = split_by_openness(seeing, made);
    const std::size_t count = made.chosen.size();

    // Give each side to the nearest place.
    const std::size_t first_side = made.patch_of.size();
    made.target.assign(sides.size(), 0);
    made.represents.assign(count, 0);
    made.middles.clear();
    for (const std::uint32_t s : made.chosen) made.middles.push(part(s).middle);
    for (std::size_t s = 0, own = 0; s < sides.size(); ++s) {
        while (own < count && made.chosen[own] < s) ++own;
        const std::uint32_t best =
            own < count && made.chosen[own] == s ? static_cast<std::uint32_t>(own) : made.middles.of(part(s).middle);
        made.target[s] = best;
        made.represents[best] += part(s).area;
    }
    for (std::size_t k = 0; k < count; ++k) made.represents[k] *= weight_of_openness(made.openness[k]);

    // Measure the patches.
    const auto cell = static_cast<PatchId>(made.patches.size());
    for (std::uint32_t g = 0; g < groups; ++g) {
        Patch patch;
        patch.cell = cell;
        patch.first = static_cast<std::uint32_t>(made.places.size());
        glm::dvec3 position(0), normal(0);
        double area = 0, weighted = 0;
        for (std::size_t s = 0; s < sides.size(); ++s) {
            if (made.group[made.target[s]] != g) continue;
            const auto a = static_cast<double>(part(s).area);
            weighted += static_cast<double>(units_.weight(part(s).unit)) * a;
            position += a * glm::dvec3(part(s).middle), normal += a * glm::dvec3(sides[s].normal(part(s))), area += a;
        }
        patch.position = glm::vec3(position / area), patch.normal = glm::vec3(normal / area);
        patch.area = static_cast<float>(area), patch.weight = static_cast<float>(weighted / area);
        for (std::size_t s = 0; s < sides.size(); ++s)
            if (made.group[made.target[s]] == g)
                patch.radius = std::max(patch.radius, glm::length(part(s).middle - patch.position) + part(s).radius);
        float nearest = k_infinity;
        std::uint8_t most_open = 0;
        for (std::uint32_t k = 0; k < count; ++k) {
            if (made.group[k] != g) continue;
            const float distance = glm::length(part(made.chosen[k]).middle - patch.position);
            if (made.openness[k] < most_open || (made.openness[k] == most_open && !(distance < nearest))) continue;
            most_open = made.openness[k], nearest = distance;
            patch.sample = above(parts, sides[made.chosen[k]], 0);
        }
        keep_places(parts, sides, g, patch.area, made);
        patch.places = static_cast<std::uint32_t>(made.places.size()) - patch.first;
        made.patches.push_back(patch);
    }
    made.patch_of.resize(first_side + sides.size());
    for (std::size_t s = 0; s < sides.size(); ++s) made.patch_of[first_side + s] = cell + made.group[made.target[s]];
}

// Marks the sides of parts that other geometry crosses: one of the corners is not visible from the middle.
void SurfacePatches::mark_crossed(const ray::RayScene& rays, std::span<const Part> parts, std::span<const Side> sides)
{
    ray::RayQueue queue;
    queue.purpose = ray::RayClass::indirect;
    std::vector<std::uint32_t> code;
    for (const Side& side : sides) {
        const Part& part = parts[side.part()];
        if (part.area < options_.crossed_area * part.width * part.width) continue;
        glm::vec3 p[3];
        units_.corners(rays, part.unit, p);
        glm::dvec2 corner[3];
        const std::uint32_t level = level_[part.unit];
        corners_of(micro_at(side.part() - first_part_[part.unit], level), level, corner);
        const glm::vec3 from =
            part.middle + std::max(part.lift, options_.crossed_lift * part.width) * side.normal(part);
        for (const glm::dvec2& c : corner) {
            const glm::vec2 at(c);
            queue.push(from, 0, k_shrink * ((1 - at.x - at.y) * p[0] + at.x * p[1] + at.y * p[2] - part.middle), 1);
            code.push_back(side.code);
        }
    }
    std::vector<std::uint8_t> occluded(queue.size() + ray::k_packet_pad);
    rays.occluded(queue, 0, queue.size(), occluded.data(), ray::Against::static_only);
    for (std::size_t r = 0; r < code.size(); ++r)
        if (occluded[r]) patch_[code[r]] |= k_crossed;
}

PatchId SurfacePatches::patch_at(const ray::RayScene& rays, scene::ObjectId object, std::uint32_t triangle, float u,
                                 float v, bool front, const glm::vec3& above) const
{
    if (patches_.empty()) return k_no_patch;
    const SurfaceUnits::Place at = units_.at(object, triangle, u, v);
    if (at.unit == scene::none || first_part_[at.unit] == first_part_[at.unit + 1]) return k_no_patch;
    const std::uint32_t part = first_part_[at.unit] + micro_index_at(at.u, at.v, level_[at.unit]);
    const std::uint16_t code = patch_[2 * part + (front ? 0 : 1)];
    if (code == k_no_code) return k_no_patch;
    if (!(code & k_crossed)) return code;

    // Take the nearest place of the cell that is visible from the point.
    struct Candidate {
        float square;
        PatchId patch;
        glm::vec3 way;
    };
    std::array<Candidate, k_tries> nearest;   // in order, of equally near ones the first in front
    std::size_t count = 0;
    const PatchId cell = patches_[code & ~k_crossed].cell;
    for (PatchId p = cell; p < patches_.size() && patches_[p].cell == cell; ++p)
        for (const PatchPlace& place : places(patches_[p])) {
            const glm::vec3 way = place.position - above;
            const float square = glm::dot(way, way);
            if (count == k_tries && !(square < nearest[count - 1].square)) continue;
            std::size_t i = count < k_tries ? count++ : count - 1;
            for (; i > 0 && square < nearest[i - 1].square; --i) nearest[i] = nearest[i - 1];
            nearest[i] = {square, p, way};
        }
    for (const Candidate& candidate : std::span(nearest).first(count))
        if (!rays.occluded_single(above, 0, candidate.way, ray::k_shadow_ray_end, ray::Against::static_only))
            return candidate.patch;
    return k_no_patch;
}

std::vector<glm::vec3> SurfacePatches::albedo(const scene::Scene& scene, const ray::RayScene& rays, Tasks& tasks) const
{
    std::vector<glm::vec3> result(patches_.size());
    tasks.for_each((patches_.size() + k_patches_at_once - 1) / k_patches_at_once, [&](std::size_t run, int) {
        const std::size_t last = std::min((run + 1) * k_patches_at_once, patches_.size());
        for (std::size_t p = run * k_patches_at_once; p < last; ++p) {
            glm::vec3 sum(0);
            float area = 0;
            for (const PatchPlace& place : places(patches_[p])) {
                const auto after = std::upper_bound(first_part_.begin(), first_part_.end(), place.part);
                const auto unit = static_cast<std::uint32_t>(after - first_part_.begin() - 1);
                const glm::vec2 at = units_.in_triangle(unit, middle_of(place.part, unit));
                sum += place.area *
                       lighting::albedo(scene, rays.geometry(units_.object(unit)), units_.triangle(unit), at.x, at.y);
                area += place.area;
            }
            result[p] = glm::clamp(sum / area, glm::vec3(0), glm::vec3(k_most_albedo));
        }
    });
    return result;
}

std::size_t SurfacePatches::bytes() const
{
    return units_.bytes() + first_part_.size() * (sizeof(std::uint32_t) + 1) + patch_.size() * sizeof(std::uint16_t) +
           patches_.size() * sizeof(Patch) + places_.size() * sizeof(PatchPlace);
}

}   // namespace gnomon::patches
