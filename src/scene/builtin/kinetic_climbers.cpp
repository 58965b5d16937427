// SPDX-License-Identifier: Apache-2.0
// Climbing plants on the walls, and their fallen petals.

#include "scene/builtin/kinetic_leaves.h"

namespace gnomon::scene::kinetic {

namespace {

// A climbing plant: leaves lie flat, tips down, along a few wandering stems.
struct Climber {
    glm::vec3 foot;         // where it comes out of the ground
    glm::vec3 along, out;   // the wall's direction and its normal
    float reach, height;    // how far it spreads
    float drift;            // and how far its tops lean over along the wall
    int stems, leaves;      // leaves a stem
    MaterialId leaf, blossom;
    float blossoms;   // fraction of leaves that flower
};
void add_climber(MeshBuilder& b, const Materials& m, Random& random, const Climber& c)
{
    for (int s = 0; s < c.stems; ++s) {
        // Grow upwards while drifting to one side.
        const float spread = random.uniform(-1, 1), top = c.height * random.uniform(c.drift > 0 ? 0.9f : 0.55f, 1.0f);
        const float drift = c.drift * random.uniform();
        const float phase = random.uniform(0, 6.28f), wave = random.uniform(0.08f, 0.22f);
        std::vector<glm::vec3> knots;
        constexpr int pieces = 9;
        for (int i = 0; i <= pieces; ++i) {
            const float t = static_cast<float>(i) / pieces;
            // Up first, then along.
            const float up = std::min(t / 0.6f, 1.0f), lean = std::max(t - 0.45f, 0.0f) / 0.55f;
            const float x = c.reach * spread * std::pow(t, 0.8f) + drift * lean;
            const float y = top * up * (2 - up) + wave * lean * std::sin(phase + 9 * t);
            knots.push_back(c.foot + c.along * (x + 0.5f * wave * std::sin(phase + 7 * t)) + c.out * 0.025f +
                            glm::vec3(0, y, 0));
        }
        const auto path = smooth_path(knots, 2);
        std::vector<float> radii;
        for (std::size_t i = 0; i < path.size(); ++i)
            radii.push_back(0.016f * (1 - 0.8f * static_cast<float>(i) / static_cast<float>(path.size())));
        b.open_sky([](const glm::vec3&, const glm::vec3&) { return 0.6f; });
        b.tint(glm::vec3(1));
        b.use(m.bark);
        b.tube(path, radii, 5);
        for (int i = 0; i < c.leaves; ++i) {
            const float t = std::pow(random.uniform(), 0.7f);
            const float at = t * static_cast<float>(path.size() - 2);
            const auto k = static_cast<std::size_t>(at);
            const glm::vec3 stem = glm::mix(path[k], path[k + 1], at - static_cast<float>(k));
            const float away = random.uniform(0.005f, 0.13f);
            const float sideways = 0.16f * (random.uniform() + random.uniform() - 1);
            const glm::vec3 p =
                stem + c.along * sideways + c.out * away + glm::vec3(0, random.uniform(-0.12f, 0.12f), 0);
            const float seen = 0.40f + 3.4f * away;
            b.open_sky([seen](const glm::vec3&, const glm::vec3&) { return seen; });
            const bool flower = random.uniform() < c.blossoms * glm::smoothstep(0.1f, 0.8f, t);
            b.use(flower ? c.blossom : c.leaf);
            b.tint(vary(random, 0.35f));
            const glm::vec3 grow = glm::vec3(0, -0.8f, 0) + 0.9f * on_sphere(random) + 0.3f * c.out;
            const glm::vec3 face = c.out + glm::vec3(0, 0.5f, 0) + 0.55f * on_sphere(random);
            const float size = random.uniform(0.06f, 0.11f);
            add_leaf(b, p, grow, face, size, 0.85f * size);
        }
    }
}

}   // namespace

void add_climbers(Scene& scene, const Materials& m)
{
    MeshBuilder b;
    Random random(109);
    const float front = k_back_z + 0.40f;
    // Fallen petals below the bougainvillea.
    b.use(m.blossom);
    b.open_sky({});
    for (int i = 0; i < 260; ++i) {
        const float x = random.uniform() + random.uniform() - 0.7f, z = random.uniform() * random.uniform();
        const float step = z < 0.26f ? k_arcade_floor : z < 0.66f ? 0.5f * k_arcade_floor : 0.008f;
        const glm::vec3 at(k_left_x + 0.4f + 1.3f * x, step + 0.006f, k_back_z + 0.2f + 2.2f * z * 0.7f);
        b.tint(vary(random, 0.35f));
        glm::vec3 grow = on_sphere(random);
        grow.y *= 0.1f;
        add_leaf(b, at, grow, {0, 1, 0}, random.uniform(0.04f, 0.07f), 0.05f);
    }
    // Bougainvillea on the left end of the back arcade, ivy on the tower and on the right arcade's end.
    add_climber(b, m, random,
                {{k_left_x, 0.1f, front}, {1, 0, 0}, {0, 0, 1}, 0.22f, 4.9f, 0, 8, 150, m.ivy, m.blossom, 0.75f});
    add_climber(b, m, random,
                {{k_left_x, 0.1f, front}, {1, 0, 0}, {0, 0, 1}, 0.15f, 4.55f, 4.4f, 12, 230, m.ivy, m.blossom, 0.8f});
    const glm::vec3 to_yard(-1, 0, 0), tower(k_right_x - 0.32f, 0.3f, k_back_z + 0.02f);
    add_climber(b, m, random, {tower, {0, 0, 1}, to_yard, 0.22f, 4.3f, 0.2f, 7, 150, m.ivy, m.ivy, 0});
    const float end = k_back_z + k_right_bays * k_bay + 0.34f;
    const glm::vec3 gable(k_right_x + 0.6f, 0, end), corner(k_right_x - 0.42f, 0, end - 0.3f);
    add_climber(b, m, random, {gable, {1, 0, 0}, {0, 0, 1}, 0.9f, 4.7f, 0.6f, 18, 170, m.ivy, m.ivy, 0});
    add_climber(b, m, random, {corner, {0, 0, -1}, to_yard, 0.2f, 4.4f, 1.6f, 9, 170, m.ivy, m.ivy, 0});
    add_object(scene, add_mesh(scene, b, "climbers"), "climbers", glm::dmat4(1));
}

}   // namespace gnomon::scene::kinetic
