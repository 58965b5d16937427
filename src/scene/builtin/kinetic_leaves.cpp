// SPDX-License-Identifier: Apache-2.0
#include "scene/builtin/kinetic_leaves.h"

namespace gnomon::scene::kinetic {

glm::vec3 on_sphere(Random& random)
{
    const float z = random.uniform(-1, 1), a = random.uniform(0, static_cast<float>(2 * k_pi));
    const float r = std::sqrt(std::max(0.0f, 1 - z * z));
    return {r * std::cos(a), z, r * std::sin(a)};
}

void add_leaf(MeshBuilder& b, const glm::vec3& stalk, const glm::vec3& grow, const glm::vec3& face, float length,
              float width)
{
    const glm::vec3 along = glm::normalize(grow);
    glm::vec3 side = glm::cross(face, along);
    constexpr float parallel = 1e-8f;   // squared sine
    if (!(glm::dot(side, side) > parallel)) return;
    side = glm::normalize(side);
    const glm::vec3 up = glm::cross(along, side);
    const float droop = 0.12f * length, fold = 0.18f * width;   // the tip hangs, the edges rise
    const glm::vec3 tip = stalk + along * length - up * droop;
    const glm::vec3 rib = stalk + along * (0.5f * length);
    for (const float hand : {-1.0f, 1.0f}) {
        const glm::vec3 edge = rib + side * (hand * 0.5f * width) + up * fold;
        const glm::vec3 n = glm::normalize(up - side * (hand * 0.45f));
        const std::uint32_t s = b.vertex(stalk, n, {0, 0}), e = b.vertex(edge, n, {0, 0});
        const std::uint32_t t = b.vertex(tip, n, {0, 0});
        b.triangle(s, e, t);
    }
}

glm::vec3 vary(Random& random, float amount)
{
    const float light = random.uniform(1 - amount, 1 + amount), warm = random.uniform(0, amount);
    return light * glm::vec3(1 + 0.9f * warm, 1, 1 - 0.4f * warm);
}

}   // namespace gnomon::scene::kinetic
