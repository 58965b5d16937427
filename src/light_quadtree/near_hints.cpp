// SPDX-License-Identifier: Apache-2.0
#include "light_quadtree/near_hints.h"

#include <algorithm>
#include <cmath>

#include "light_quadtree/near_light.h"
#include "ray/origin.h"

namespace gnomon::light_quadtree {

NearHints::NearHints(const scene::Scene& scene, const ray::RayScene& rays, const NearHintOptions& options)
    : options_(options), directions_(cosine_directions(options.rays))
{
    const float cell = options.cell * options.radius;
    for (scene::ObjectId o = 0; o < scene.objects.size(); ++o) {
        const auto triangles = static_cast<std::uint32_t>(scene.meshes[scene.objects[o].mesh].triangles.size());
        for (std::uint32_t t = 0; t < triangles; ++t) {
            int side = 0;
            if (!scene.objects[o].dynamic) {
                glm::vec3 p[3];
                rays.geometry(o).corners(t, p);
                const float longest =
                    std::max({glm::length(p[1] - p[0]), glm::length(p[2] - p[1]), glm::length(p[0] - p[2])});
                side = 1;
                if (longest > cell)
                    side =
                        static_cast<int>(std::min(std::ceil(longest / cell), static_cast<float>(options.most_cells)));
            }
            first_.push_back(static_cast<std::uint32_t>(cells_));
            sides_.push_back(static_cast<std::uint8_t>(side));
            cells_ += static_cast<std::size_t>(side) * static_cast<std::size_t>(side);
        }
    }
    states_ = std::make_unique<std::atomic<std::uint8_t>[]>(2 * cells_);
}

void NearHints::answer(const ray::RayScene& rays, const std::vector<Asked>& asked, Scratch& scratch)
{
    // Spread over the cell by a lattice of irrational steps, each place with a direction of its own.
    constexpr float k_step_u = 0.7548777f, k_step_v = 0.5698403f;
    const auto count = static_cast<std::size_t>(options_.rays);
    scratch.rays.clear();
    scratch.rays.purpose = ray::RayClass::indirect;
    for (const Asked& a : asked) {
        glm::vec3 p[3];
        rays.geometry(a.object).corners(a.triangle, p);
        glm::vec3 normal = glm::cross(p[1] - p[0], p[2] - p[0]);
        const float length = glm::length(normal);
        normal = length > 0 ? normal / (a.front ? length : -length) : glm::vec3(0, 0, 1);
        glm::vec3 t, b;
        make_basis(normal, t, b);
        const float lift = ray::origin_lift(p);
        const std::uint32_t side = sides_[a.at], in = a.cell / 2 - first_[a.at];
        const std::uint32_t row = in / side, column = in % side;
        const auto per_side = 1 / static_cast<float>(side);
        for (std::size_t i = 0; i < count; ++i) {
            const float x = static_cast<float>(i) * k_step_u, y = static_cast<float>(i) * k_step_v;
            float u = (static_cast<float>(row) + (x - std::floor(x))) * per_side;
            float v = (static_cast<float>(column) + (y - std::floor(y))) * per_side;
            if (u + v > 1) {
                // Of a cell that the hypotenuse cuts, the mirror image; of one beyond it, nothing is ever asked.
                const float over = u + v - 1;
                u = std::max(u - over, 0.0f), v = std::max(v - over, 0.0f);
                if (u + v > 1) u = 1 - v;
            }
            const glm::vec3 from = (1 - u - v) * p[0] + u * p[1] + v * p[2] + lift * normal;
            const glm::vec3& d = directions_[i];
            scratch.rays.push(from, 0, d.x * t + d.y * b + d.z * normal, options_.reach * options_.radius);
        }
    }
    scratch.hits.resize(scratch.rays.size());
    rays.closest(scratch.rays, 0, scratch.rays.size(), scratch.hits, ray::Sides::both, ray::Against::static_only);
    scratch.cast += scratch.rays.size();
    for (std::size_t k = 0; k < asked.size(); ++k) {
        const auto first = scratch.hits.object.begin() + static_cast<std::ptrdiff_t>(k * count);
        const bool any = std::any_of(first, first + static_cast<std::ptrdiff_t>(count),
                                     [](scene::ObjectId object) { return object != scene::none; });
        states_[asked[k].cell].store(static_cast<std::uint8_t>(any ? State::near : State::none),
                                     std::memory_order_release);
    }
}

std::size_t NearHints::bytes() const
{
    return 2 * cells_ + first_.size() * sizeof(std::uint32_t) + sides_.size();
}

}   // namespace gnomon::light_quadtree
