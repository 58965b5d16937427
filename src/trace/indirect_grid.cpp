// SPDX-License-Identifier: Apache-2.0
#include "trace/indirect_grid.h"

#include "base/check.h"
#include "shading/surface.h"

namespace gnomon::trace {

IndirectGrid cast_indirect_grid(const scene::Scene& scene, const ray::RayScene& rays, const scene::View& view, int step,
                                Tasks& tasks)
{
    GNOMON_CHECK(step > 0);
    IndirectGrid grid;
    grid.columns = (view.size.width - 1) / step + 2;
    const int rows = (view.size.height - 1) / step + 2;
    grid.receivers.resize(static_cast<std::size_t>(grid.columns) * static_cast<std::size_t>(rows));
    tasks.for_each(static_cast<std::size_t>(rows), [&](std::size_t row, int) {
        ray::RayQueue queue;
        queue.purpose = ray::RayClass::primary;
        for (int column = 0; column < grid.columns; ++column) {
            glm::vec3 origin, direction;
            float tnear, tfar;
            view.ray(static_cast<float>(column * step) + 0.5f,
                     static_cast<float>(row) * static_cast<float>(step) + 0.5f, origin, direction, tnear, tfar);
            queue.push(origin, tnear, direction, tfar);
        }
        ray::Hits hits;
        hits.resize(queue.size());
        rays.closest(queue, 0, queue.size(), hits, ray::Sides::front);
        for (std::size_t i = 0; i < queue.size(); ++i) {
            if (hits.object[i] == scene::none) continue;
            shading::SurfacePoint s;
            shading::surface_at(scene, rays.geometry(hits.object[i]), hits.triangle[i], hits.u[i], hits.v[i], hits.t[i],
                                queue.direction(i), {view.pixel_width, view.pixel_spread}, s);
            grid.receivers[row * static_cast<std::size_t>(grid.columns) + i] = {s.position, s.normal, s.cone.width};
        }
    });
    return grid;
}

}   // namespace gnomon::trace
