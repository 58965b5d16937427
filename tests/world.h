// SPDX-License-Identifier: Apache-2.0
#pragma once
// A scene at a frame with its rays, for tests of the layers above.

#include <memory>
#include <string>

#include "base/tasks.h"
#include "ray/ray_scene.h"
#include "scene/builtin/builtin.h"

namespace gnomon::test {

struct World {
    explicit World(scene::Scene made, int frame = 1, int threads = 1, Arithmetic arithmetic = Arithmetic::portable)
        : scene(std::make_shared<const scene::Scene>(std::move(made))),
          state(scene, scene->timeline.time_of(frame)),
          rays(state, MemoryLimit{}, arithmetic),
          tasks(threads)
    {
    }
    explicit World(const std::string& builtin, int frame = 1, int threads = 1,
                   Arithmetic arithmetic = Arithmetic::portable)
        : World(scene::make_builtin(builtin), frame, threads, arithmetic)
    {
    }
    void go(int frame)
    {
        state.advance(scene->timeline.time_of(frame));
        rays.update(state);
    }
    std::shared_ptr<const scene::Scene> scene;
    scene::SceneState state;
    ray::RayScene rays;
    Tasks tasks;
};

}   // namespace gnomon::test
