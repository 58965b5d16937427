// SPDX-License-Identifier: Apache-2.0
#pragma once
// Surrounds a scene with the light of an environment map, and places lights that have a direction.

#include <functional>
#include <memory>
#include <string>

#include "api/stamps.h"
#include "scene/environment.h"
#include "scene/scene.h"

namespace gnomon::api {

/// @throws UsageError  not a power of two from 1 to 1024
void check_environment_lights(int lights);

/// Replaces the background, an earlier environment and the default lights by an environment map and the directional
/// lights that approximate it.
/// @param add_node  adds the node of a light by its name and its transform to the world
using AddNode = std::function<scene::NodeId(const std::string&, const glm::dmat4&)>;
void set_environment(scene::Scene& scene, SceneStamps& stamps, std::shared_ptr<const scene::Environment> environment,
                     int lights, const AddNode& add_node);

/// From the space of a light that shines in a direction to the world.
glm::dmat4 looking_matrix(const glm::dvec3& position, const glm::dvec3& direction);

/// Adds a node below the world. The scene may be finished already.
scene::NodeId add_root(scene::Scene& scene, const std::string& name, const glm::dmat4& local);

/// Removes the warning about default light, and what came with it: the background of a studio, and the ground unless
/// the user asked for one. The lights are the caller's.
void forget_default_light(scene::Scene& scene);

}   // namespace gnomon::api
