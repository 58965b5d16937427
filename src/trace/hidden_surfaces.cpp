// SPDX-License-Identifier: Apache-2.0
#include "trace/hidden_surfaces.h"

#include <algorithm>
#include <cmath>

namespace gnomon::trace {

namespace {

// The distance at which a ray goes on behind a surface, and no nearer than 16 representable numbers behind it.
float behind(float distance)
{
    constexpr float k_step = 2e-6f;
    return distance + std::max(distance * k_step, 1e-30f);
}

}   // namespace

bool hides_surfaces(const scene::Scene& scene)
{
    return std::ranges::any_of(scene.materials, [](const scene::Material& m) { return m.hidden_from_camera; });
}

void pass_hidden_surfaces(const scene::Scene& scene, const ray::RayScene& rays, const ray::RayQueue& queue,
                          const std::function<bool(std::size_t)>& is_straight, ray::Hits& hits)
{
    const auto is_hidden = [&](std::size_t i) {
        if (hits.object[i] == scene::none) return false;
        const scene::Mesh& mesh = scene.meshes[scene.objects[hits.object[i]].mesh];
        return scene.materials[mesh.part_of(hits.triangle[i]).material].hidden_from_camera;
    };
    std::vector<std::size_t> passing;
    for (std::size_t i = 0; i < queue.size(); ++i)
        if (is_straight(i) && is_hidden(i)) passing.push_back(i);
    ray::RayQueue again;
    ray::Hits found;
    while (!passing.empty()) {
        again.clear();
        again.purpose = queue.purpose;
        for (const std::size_t i : passing)
            again.push(queue.origin(i), behind(hits.t[i]), queue.direction(i), queue.tfar[i]);
        found.resize(again.size());
        rays.closest(again, 0, again.size(), found, ray::Sides::front);
        for (std::size_t k = 0; k < passing.size(); ++k) {
            const std::size_t i = passing[k];
            hits.t[i] = found.t[k], hits.u[i] = found.u[k], hits.v[i] = found.v[k];
            hits.object[i] = found.object[k], hits.triangle[i] = found.triangle[k];
        }
        std::erase_if(passing, [&](std::size_t i) { return !is_hidden(i); });
    }
}

}   // namespace gnomon::trace
