// SPDX-License-Identifier: Apache-2.0
#include "api/environment.h"

#include <fmt/format.h>

#include <glm/gtc/matrix_transform.hpp>

#include "gnomon/error.h"
#include "scene/builtin/studio.h"
#include "scene/defaults/surroundings.h"

namespace gnomon::api {

void check_environment_lights(int lights)
{
    if (lights < 1 || lights > 1024 || (lights & (lights - 1)) != 0)
        throw UsageError(fmt::format("{} lights for an environment: expected a power of two from 1 to 1024", lights));
}

void set_environment(scene::Scene& scene, SceneStamps& stamps, std::shared_ptr<const scene::Environment> environment,
                     int lights, const AddNode& add_node)
{
    for (std::size_t l = scene.lights.size(); l-- > 0;) {
        if (!scene.lights[l].by_default && !scene.lights[l].of_environment) continue;
        scene.lights.erase(scene.lights.begin() + static_cast<std::ptrdiff_t>(l));
        stamps.lights.erase(l);
    }
    forget_default_light(scene);
    int number = 0;
    for (const scene::EnvironmentLight& part : environment->lights(lights)) {
        scene::Light light;
        light.name = fmt::format("environment {}", number++);
        light.type = scene::LightType::directional;
        light.color = part.irradiance;
        light.of_environment = true;
        light.node = add_node(light.name, looking_matrix(glm::dvec3(0), -glm::dvec3(part.to_light)));
        scene.lights.push_back(std::move(light));
        stamps.lights.renew(stamps.lights.size());
    }
    while (stamps.nodes.size() < scene.nodes.size()) stamps.nodes.renew(stamps.nodes.size());
    scene.background = {};
    scene.background.kind = scene::Background::Kind::image;
    scene.background.environment = std::move(environment);
}

glm::dmat4 looking_matrix(const glm::dvec3& position, const glm::dvec3& direction)
{
    const glm::dvec3 up = std::abs(direction.y) > 0.99 ? glm::dvec3(0, 0, -1) : glm::dvec3(0, 1, 0);
    return glm::inverse(glm::lookAt(position, position + direction, up));
}

scene::NodeId add_root(scene::Scene& scene, const std::string& name, const glm::dmat4& local)
{
    const scene::NodeId node = scene.add_node(name, scene::none, local);
    if (!scene.child_begin.empty()) scene.child_begin.push_back(scene.child_begin.back());   // no children
    return node;
}

void forget_default_light(scene::Scene& scene)
{
    std::erase_if(scene.warnings,
                  [](const std::string& warning) { return warning.starts_with("no light in the scene"); });
    if (scene.background.environment == scene::studio_environment()) scene.background = {};
    bool removed = false;
    for (scene::Node& node : scene.nodes)
        if (node.by_default && node.mesh != scene::none && node.name == scene::k_default_ground)
            node.mesh = scene::none, removed = true;
    if (removed) scene.finish();
}

}   // namespace gnomon::api
