// SPDX-License-Identifier: Apache-2.0
#include "reference/light_choice.h"

#include <algorithm>

namespace gnomon::reference {

LightChoice::LightChoice(const scene::SceneState& state, std::span<const scene::LightId> lights)
    : state_(state), lights_(lights.begin(), lights.end()), source_(lights.size(), k_none)
{
    const scene::Scene& scene = state.scene();
    std::vector<Source> sources;
    for (std::size_t k = 0; k < lights_.size(); ++k) {
        const scene::Light& light = scene.lights[lights_[k]];
        cones_.push_back(scene::cone_of(light));
        if (lights_.size() <= k_listed || light.type == scene::LightType::directional) {
            listed_.push_back(k);
            continue;
        }
        source_[k] = static_cast<std::uint32_t>(sources.size());
        in_tree_.push_back(k);
        Source& source = sources.emplace_back();
        source.bounds.add(state.light(lights_[k]).position);
        const bool spot = light.type == scene::LightType::spot;
        source.axis = spot ? state.light(lights_[k]).direction : glm::vec3(0, 0, 1);
        source.spread = spot ? 0 : static_cast<float>(k_pi);
        source.reach = spot ? light.outer_angle : static_cast<float>(k_pi / 2);
        source.steady = light.falloff == scene::Falloff::constant;
        source.power = luminance(light.color);
    }
    tree_ = SourceTree(sources);
}

// What arrives from a light without occlusion.
float LightChoice::arriving(std::size_t light, const glm::vec3& position, const glm::vec3& normal,
                            const glm::vec3& horizon, scene::LightSample& sample) const
{
    sample =
        scene::illuminate(state_.scene().lights[lights_[light]], state_.light(lights_[light]), cones_[light], position);
    const float cosine = glm::dot(sample.to_light, normal);
    return cosine > 0 && glm::dot(sample.to_light, horizon) > 0 ? cosine * luminance(sample.irradiance) : 0;
}

// @return  what arrives from all listed lights
float LightChoice::weigh_listed(const glm::vec3& position, const glm::vec3& normal, const glm::vec3& horizon,
                                Scratch& scratch) const
{
    scratch.arriving.resize(listed_.size()), scratch.samples.resize(listed_.size());
    float sum = 0;
    for (std::size_t i = 0; i < listed_.size(); ++i)
        sum += scratch.arriving[i] = arriving(listed_[i], position, normal, horizon, scratch.samples[i]);
    return sum;
}

LightChoice::Chosen LightChoice::choose(const glm::vec3& position, const glm::vec3& normal, const glm::vec3& horizon,
                                        double number, Scratch& scratch) const
{
    const float listed = weigh_listed(position, normal, horizon, scratch);
    const float all = listed + tree_.importance(position, normal);
    if (!(all > 0)) return {};
    double left = number * static_cast<double>(all);
    if (left < static_cast<double>(listed) || !(all > listed)) {
        std::size_t chosen = 0;
        for (std::size_t i = 0; i < listed_.size(); ++i) {
            if (scratch.arriving[i] > 0) chosen = i;
            if ((left -= static_cast<double>(scratch.arriving[i])) < 0) break;
        }
        return {listed_[chosen], scratch.arriving[chosen] / all, scratch.samples[chosen]};
    }
    const auto of_tree = static_cast<double>(all - listed);
    const SourceTree::Choice choice =
        tree_.choose(position, normal, std::clamp((left - static_cast<double>(listed)) / of_tree, 0.0, 1 - 0x1p-53));
    if (!(choice.chance > 0)) return {};
    Chosen result{in_tree_[choice.source], choice.chance * (all - listed) / all, {}};
    if (!(arriving(result.light, position, normal, horizon, result.sample) > 0)) return {};
    return result;
}

LightChoice::Chosen LightChoice::chosen(std::size_t light, const glm::vec3& position, const glm::vec3& normal,
                                        const glm::vec3& horizon, Scratch& scratch) const
{
    Chosen result;
    result.light = light;
    const float own = arriving(light, position, normal, horizon, result.sample);
    if (!(own > 0)) return result;
    if (lights_.size() == 1) {
        result.chance = 1;
        return result;
    }
    const float listed = weigh_listed(position, normal, horizon, scratch);
    const float all = listed + tree_.importance(position, normal);
    if (source_[light] == k_none)
        result.chance = own / all;
    else
        result.chance = tree_.chance(source_[light], position, normal) * ((all - listed) / all);
    return result;
}

}   // namespace gnomon::reference
