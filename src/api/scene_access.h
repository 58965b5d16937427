// SPDX-License-Identifier: Apache-2.0
#pragma once
// Connects the public Scene with the scene::Scene that it wraps: for the library, its benchmarks and its tests.

#include <memory>

#include "api/stamps.h"
#include "gnomon/scene.h"
#include "scene/scene.h"

namespace gnomon {

struct Scene::Impl {
    std::shared_ptr<const scene::Scene> scene;
    api::SceneStamps stamps;
};

namespace api {

class SceneAccess {
 public:
    static Scene make(std::shared_ptr<const scene::Scene> scene, SceneStamps stamps);
    static const Scene::Impl& impl(const Scene& scene) { return *scene.impl_; }
};

/// The scene that a public one wraps.
inline const std::shared_ptr<const scene::Scene>& scene_of(const Scene& scene)
{
    return SceneAccess::impl(scene).scene;
}

/// Wraps a finished scene; its parts get new ids.
Scene public_scene(std::shared_ptr<const scene::Scene> scene);

}   // namespace api

}   // namespace gnomon
