// SPDX-License-Identifier: Apache-2.0
#include "scene/defaults/interior.h"

#include <algorithm>

#include "base/interruption.h"

namespace gnomon::scene {

namespace {

constexpr double k_stage_fov = 0.7;   // radians: a box with an open side, seen through it
constexpr double k_room_fov = 1.0;    // from inside, wider
constexpr float k_stage_margin = 1.06f;
constexpr int k_stage_rays = 12;         // along each side of the opening
constexpr float k_stage_open = 0.85f;    // fraction of them that must enter
constexpr float k_stage_depth = 0.12f;   // to at least this fraction of the depth
constexpr float k_stage_walled =
    0.7f;   // fraction of the directions across, just within the opening, that meet its walls
constexpr int k_headings = 16;
constexpr float k_least_room = 0.06f;   // no surface nearer than this in the view, as a fraction of the longest side
constexpr float k_height_weight[3] = {1.0f, 0.8f,
                                      0.7f};   // weights of eye heights; the lowest, a standing person's, is preferred

float longest_side(const Box3& box)
{
    const glm::vec3 size = box.size();
    return std::max({size.x, size.y, size.z});
}

// How much of what lies across, as seen from places just within a side of the box, are fronts of surfaces: walls, a
// floor and a ceiling. Beside a lip or a handle that stands out from a pot there are none.
float walled(const SpaceGrid& grid, int axis, float sign)
{
    constexpr int k_places = 5;
    const Box3& box = grid.box();
    const glm::vec3 size = box.size();
    const int across = 2 - axis;
    glm::vec3 along(0), up(0, 1, 0);
    along[across] = 1;
    int met = 0;
    for (int i = 0; i < k_places * k_places; ++i) {
        glm::vec3 from;
        from[axis] = (sign > 0 ? box.low[axis] : box.high[axis]) + sign * 0.5f * k_stage_depth * size[axis];
        from[across] = box.low[across] + size[across] * (static_cast<float>(i % k_places) + 0.5f) / k_places;
        from.y = box.low.y + size.y * (static_cast<float>(i / k_places) + 0.5f) / k_places;
        for (const glm::vec3& direction : {along, -along, up, -up})
            met += grid.cast(from, direction).met == SpaceGrid::Met::front;
    }
    return static_cast<float>(met) / (4 * k_places * k_places);
}

// Finds a box that is open on one upright side, like a stage. The camera stands before it, so that the opening fills
// the frame.
bool find_stage(const SpaceGrid& grid, Interior& result)
{
    const Box3& box = grid.box();
    const glm::vec3 size = box.size();
    float best = k_stage_open;
    bool found = false;
    for (int side = 0; side < 4; ++side) {
        const int axis = side < 2 ? 0 : 2, across = 2 - axis;
        const float sign = side % 2 ? 1.0f : -1.0f;   // which way the rays go
        glm::vec3 direction(0);
        direction[axis] = sign;
        int open = 0;
        for (int i = 0; i < k_stage_rays * k_stage_rays; ++i) {
            const int column = i % k_stage_rays, row = i / k_stage_rays;
            glm::vec3 from;
            from[axis] = (sign > 0 ? box.low[axis] : box.high[axis]) - sign * grid.cell();
            from[across] = box.low[across] + size[across] * (static_cast<float>(column) + 0.5f) / k_stage_rays;
            from.y = box.low.y + size.y * (static_cast<float>(row) + 0.5f) / k_stage_rays;
            const SpaceGrid::Hit hit = grid.cast(from, direction);
            open += hit.met == SpaceGrid::Met::front && hit.distance - grid.cell() > k_stage_depth * size[axis];
        }
        const float entered = static_cast<float>(open) / (k_stage_rays * k_stage_rays);
        if (entered <= best || walled(grid, axis, sign) < k_stage_walled) continue;
        best = entered, found = true;
        result.direction = direction;
        result.eye = box.centre();
        const float half = 0.5f * k_stage_margin * std::max(size.y, size[across] * 0.75f);   // fits 4:3 and wider
        result.eye[axis] =
            (sign > 0 ? box.low[axis] : box.high[axis]) - sign * half / std::tan(static_cast<float>(k_stage_fov) / 2);
        result.vertical_fov = k_stage_fov;
        result.stage = true;
        for (int corner = 0; corner < 4; ++corner) {
            result.opening[corner][axis] = sign > 0 ? box.low[axis] : box.high[axis];
            result.opening[corner][across] = corner & 1 ? box.high[across] : box.low[across];
            result.opening[corner].y = corner & 2 ? box.high.y : box.low.y;
        }
    }
    return found;
}

// Rates a view: higher for long and wide views, most of all down the middle, and for many triangles (modellers spend
// them on what matters, not on the walls of back rooms); lower for back sides and for surfaces close by.
float rate_view(const SpaceGrid& grid, const glm::vec3& eye, const glm::vec3& direction, float longest)
{
    const glm::vec3 side = glm::cross(direction, glm::vec3(0, 1, 0));
    float sum = 0, detail = 0, middle = longest;
    int fronts = 0, count = 0;
    for (int i = -3; i <= 3; ++i) {
        for (int j = -1; j <= 2; ++j) {
            const glm::vec3 ray = glm::normalize(direction + 0.18f * static_cast<float>(i) * side +
                                                 glm::vec3(0, 0.16f * static_cast<float>(j), 0));
            const SpaceGrid::Hit hit = grid.cast(eye, ray);
            if (hit.distance < k_least_room * longest && j >= 0) return 0;
            // Sky above is normal in a courtyard; sky at eye level is a gap.
            fronts += hit.met == SpaceGrid::Met::front || (hit.met == SpaceGrid::Met::nothing && j > 0);
            if (std::abs(i) <= 1 && j >= 0) middle = std::min(middle, hit.distance);
            sum += std::sqrt(std::min(hit.distance, longest));
            detail += std::log2(1 + static_cast<float>(hit.triangles));
            ++count;
        }
    }
    const float seen = static_cast<float>(fronts) / static_cast<float>(count);
    const auto mean = 1.0f / static_cast<float>(count);
    return sum * mean * seen * (1 + detail * mean) * std::sqrt(middle / longest);
}

}   // namespace

std::optional<Interior> find_interior(const Scene& scene, const InteriorOptions& options)
{
    const SpaceGrid grid(scene, scene.timeline.start);
    if (grid.empty()) return std::nullopt;
    const Box3& box = grid.box();
    const float longest = longest_side(box), step = longest / static_cast<float>(options.lattice);

    // Test at points all over the scene whether surfaces enclose them.
    glm::ivec3 count;
    for (int axis = 0; axis < 3; ++axis) count[axis] = 1 + static_cast<int>(box.size()[axis] / step - 0.5f);
    const auto point = [&](int x, int y, int z) {
        const glm::vec3 fraction((static_cast<float>(x) + 0.5f) / static_cast<float>(count.x),
                                 (static_cast<float>(y) + 0.5f) / static_cast<float>(count.y),
                                 (static_cast<float>(z) + 0.5f) / static_cast<float>(count.z));
        return box.low + fraction * box.size();
    };
    struct Census {
        int points = 0, inside = 0, covered = 0;
    };
    const auto ask = [&](int stride) {
        Census census;
        for (int z = stride / 2; z < count.z; z += stride) {
            for (int y = stride / 2; y < count.y; y += stride) {
                interruption_point();
                for (int x = stride / 2; x < count.x; x += stride) {
                    ++census.points;
                    const glm::vec3 p = point(x, y, z);
                    if (grid.occupied(p) || grid.enclosure(p) < options.enclosed) continue;
                    ++census.inside;
                    census.covered += grid.cast(p, {0, 1, 0}).met != SpaceGrid::Met::nothing;
                }
            }
        }
        return census;
    };
    // A few points suffice to recognise most scenes as objects.
    constexpr int few = 3;
    if (const Census census = ask(few); census.points > 0 && census.inside == 0) return std::nullopt;
    const Census census = ask(1);
    if (static_cast<float>(census.inside) < options.interior * static_cast<float>(census.points)) return std::nullopt;

    Interior result;
    result.covered = static_cast<float>(census.covered) >= options.covered * static_cast<float>(census.inside);
    if (find_stage(grid, result)) return result;

    // Find the longest view from inside, at the eye heights of a standing person.
    float best = 0;
    for (int z = 0; z < count.z; ++z) {
        for (int x = 0; x < count.x; ++x) {
            interruption_point();
            for (int height = 0; height < 3; ++height) {
                glm::vec3 eye = point(x, 0, z);
                eye.y = box.low.y + options.eye_heights[height] * box.size().y;
                if (grid.occupied(eye) || grid.enclosure(eye) < options.enclosed) continue;
                for (int heading = 0; heading < k_headings; ++heading) {
                    const float angle = 2 * static_cast<float>(k_pi) * static_cast<float>(heading) / k_headings;
                    const glm::vec3 direction(std::cos(angle), 0, std::sin(angle));
                    const float rating = k_height_weight[height] * rate_view(grid, eye, direction, longest);
                    if (rating <= best * 1.001f) continue;   // among equals, keep the first
                    best = rating, result.eye = eye, result.direction = direction;
                }
            }
        }
    }
    if (best == 0) return std::nullopt;
    result.vertical_fov = k_room_fov;
    return result;
}

}   // namespace gnomon::scene
