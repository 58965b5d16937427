// SPDX-License-Identifier: Apache-2.0
#pragma once
// Chooses one of a scene's lights for a surface point, for the path-traced reference.
//
// Few lights, and those without a place, are chosen in proportion to what arrives from each without occlusion. Of more
// than k_listed lights, those with a place are chosen by a tree (source_tree.h).
//
// Cost: the listed lights, and two nodes for each level of the tree.

#include <span>
#include <vector>

#include "reference/source_tree.h"
#include "scene/light_cone.h"
#include "scene/state.h"

namespace gnomon::reference {

class LightChoice {
 public:
    static constexpr std::size_t k_listed = 16;

    LightChoice(const scene::SceneState& state, std::span<const scene::LightId> lights);

    /// A light by its place in the list, the chance with which choose() returns it, and what arrives from it.
    struct Chosen {
        std::size_t light = 0;
        float chance = 0;   // 0: nothing arrives
        scene::LightSample sample;
    };
    /// Of one thread.
    struct Scratch {
        std::vector<float> arriving;
        std::vector<scene::LightSample> samples;
    };
    /// @param normal   unit; of the cosine
    /// @param horizon  light from below it does not arrive
    /// @param number   in [0, 1)
    Chosen choose(const glm::vec3& position, const glm::vec3& normal, const glm::vec3& horizon, double number,
                  Scratch& scratch) const;
    /// The same for a given light.
    Chosen chosen(std::size_t light, const glm::vec3& position, const glm::vec3& normal, const glm::vec3& horizon,
                  Scratch& scratch) const;

 private:
    float arriving(std::size_t light, const glm::vec3& position, const glm::vec3& normal, const glm::vec3& horizon,
                   scene::LightSample& sample) const;
    float weigh_listed(const glm::vec3& position, const glm::vec3& normal, const glm::vec3& horizon,
                       Scratch& scratch) const;

    static constexpr std::uint32_t k_none = ~0u;
    const scene::SceneState& state_;
    std::vector<scene::LightId> lights_;
    std::vector<scene::LightCone> cones_;         // by light
    std::vector<std::size_t> listed_, in_tree_;   // places in lights_
    std::vector<std::uint32_t> source_;           // by light: its number in the tree; k_none: listed
    SourceTree tree_{std::span<const Source>{}};
};

}   // namespace gnomon::reference
