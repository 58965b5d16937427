// SPDX-License-Identifier: Apache-2.0
// The yard itself: paving, pool, balustrade, and the land beyond it.

#include <glm/gtc/matrix_transform.hpp>

#include "scene/builtin/kinetic.h"
#include "scene/builtin/patterns.h"

namespace gnomon::scene::kinetic {

namespace {

// The pool's inner edge.
constexpr float k_pool_x = 1.55f, k_pool_near = 7.6f, k_pool_far = 3.0f;
constexpr float k_rim = 0.38f, k_rim_height = 0.20f, k_water = 0.12f;
constexpr float k_yard_near = 10.4f;   // where the paving ends towards the camera

void add_paving(Scene& scene, const Materials& m)
{
    MeshBuilder b;
    Random random(29);
    b.open_sky(open_sky);
    b.use(m.soil);
    b.flat_quad({-7.6f, -0.05f, -6}, {7, -0.05f, -6}, {7, -0.05f, k_yard_near}, {-7.6f, -0.05f, k_yard_near},
                {0, 1, 0});
    b.use(m.paving);
    constexpr float size = 0.8f, joint = 0.007f;
    const float x_end = k_right_x - 0.85f, z_start = k_back_z + 0.85f;
    const int columns = static_cast<int>(std::round((x_end - k_left_x) / size));
    const int rows = static_cast<int>(std::round((k_yard_near - z_start) / size));
    const float sx = (x_end - k_left_x) / static_cast<float>(columns);
    const float sz = (k_yard_near - z_start) / static_cast<float>(rows);
    for (int row = 0; row < rows; ++row)
        for (int column = 0; column < columns; ++column) {
            // Every other row is shifted by half a slab; its ends are halves.
            const float shift = row % 2 ? 0.5f : 0.0f;
            const float x0 = k_left_x + sx * std::max(static_cast<float>(column) - shift, 0.0f);
            const float x1 = column + 1 == columns ? x_end : k_left_x + sx * (static_cast<float>(column + 1) - shift);
            const float z0 = z_start + sz * static_cast<float>(row), z1 = z0 + sz;
            const float tone = random.uniform(), warm = random.uniform();
            const float height = 0.006f * random.uniform();
            const glm::vec2 offset{random.uniform(), random.uniform()};
            // Skip slabs under the pool and slabs that the sundial's steps hide.
            const float farthest = std::max(std::abs(x0), std::abs(x1)), z_far = std::max(std::abs(z0), std::abs(z1));
            if (farthest * farthest + z_far * z_far < 2.0f * 2.0f) continue;
            if (x0 > -k_pool_x && x1 < k_pool_x && z0 > k_pool_far && z1 < k_pool_near) continue;
            b.tint((0.78f + 0.38f * tone) * glm::vec3(1, 0.97f + 0.05f * warm, 0.92f + 0.12f * warm));
            b.shift_texture(offset);
            b.box({x0 + joint, -0.08f, z0 + joint}, {x1 - joint, height, z1 - joint}, 0.012f);
        }
    add_object(scene, add_mesh(scene, b, "paving"), "paving", glm::dmat4(1));
}

void add_pool(Scene& scene, const Materials& m)
{
    MeshBuilder b;
    Random random(31);
    b.use(m.limestone);
    b.open_sky(open_sky);
    const auto coping = [&](glm::vec3 low, glm::vec3 high) {
        b.tint(glm::vec3(0.94f + 0.14f * random.uniform()));
        b.shift_texture({random.uniform(), random.uniform()});
        b.box(low, high, 0.025f);
    };
    constexpr int stones = 5;
    const float length = (k_pool_near - k_pool_far) / stones, width = (2 * k_pool_x + 2 * k_rim) / 3;
    for (int i = 0; i < stones; ++i) {
        const float z = k_pool_far + length * static_cast<float>(i);
        for (const float side : {-1.0f, 1.0f}) {
            const float inner = side * k_pool_x, outer = side * (k_pool_x + k_rim);
            coping({std::min(inner, outer), -0.05f, z + 0.003f},
                   {std::max(inner, outer), k_rim_height, z + length - 0.003f});
        }
    }
    for (int i = 0; i < 3; ++i) {
        const float x = -k_pool_x - k_rim + width * static_cast<float>(i);
        coping({x + 0.003f, -0.05f, k_pool_near}, {x + width - 0.003f, k_rim_height, k_pool_near + k_rim});
        coping({x + 0.003f, -0.05f, k_pool_far - k_rim}, {x + width - 0.003f, k_rim_height, k_pool_far});
    }
    b.tint(glm::vec3(1));
    add_object(scene, add_mesh(scene, b, "pool rim"), "pool rim", glm::dmat4(1));
    b.use(m.water);
    b.open_sky({});
    b.flat_quad({-k_pool_x - 0.03f, k_water, k_pool_far - 0.03f}, {k_pool_x + 0.03f, k_water, k_pool_far - 0.03f},
                {k_pool_x + 0.03f, k_water, k_pool_near + 0.03f}, {-k_pool_x - 0.03f, k_water, k_pool_near + 0.03f},
                {0, 1, 0});
    add_object(scene, add_mesh(scene, b, "water"), "water", glm::dmat4(1));

    // Water lilies in two groups: notched pads, here and there a flower.
    for (int i = 0; i < 15; ++i) {
        const bool near_group = i < 9;
        const float spread = near_group ? 0.75f : 0.5f;
        const float x = near_group ? random.uniform(-1.3f, -0.2f) : random.uniform(0.6f, 1.35f);
        const float z = (near_group ? 4.2f : 6.3f) + random.uniform(-spread, spread);
        const glm::vec3 at(x, k_water, z);
        const float radius = random.uniform(0.10f, 0.19f), turn = random.uniform(0, 6.28f);
        b.place(glm::translate(glm::mat4(1), at + glm::vec3(0, 0.003f + 0.001f * static_cast<float>(i), 0)) *
                glm::rotate(glm::mat4(1), turn, glm::vec3(0, 1, 0)));
        b.use(m.lily);
        b.tint(glm::vec3(0.8f + 0.5f * random.uniform()));
        const std::uint32_t hub = b.vertex({0, 0, 0}, {0, 1, 0}, {0, 0});
        std::uint32_t last = 0;
        constexpr int around = 28;
        for (int k = 0; k <= around; ++k) {
            const float angle = 0.25f + (6.2832f - 0.5f) * static_cast<float>(k) / around;
            const glm::vec3 p(radius * std::cos(angle), 0.004f, -radius * std::sin(angle));
            const std::uint32_t v = b.vertex(p, {0, 1, 0}, {0, 0});
            if (k > 0) b.triangle(hub, last, v);
            last = v;
        }
        if (i % 4 != 1) continue;
        b.use(m.blossom);
        for (int k = 0; k < 18; ++k) {
            const float angle = 2.4f * static_cast<float>(k), lift = 0.35f + 0.05f * static_cast<float>(k);
            const glm::vec3 out(std::cos(angle) * std::cos(lift), std::sin(lift), std::sin(angle) * std::cos(lift));
            const glm::vec3 side(-std::sin(angle), 0, std::cos(angle)), face = glm::cross(side, out);
            const glm::vec3 foot(0, 0.01f, 0);
            b.tint(glm::mix(glm::vec3(1.5f, 7.0f, 2.2f), glm::vec3(1.5f, 3.0f, 1.8f), static_cast<float>(k % 3) / 2));
            const std::uint32_t s = b.vertex(foot, face, {0, 0}), t = b.vertex(foot + 0.095f * out, face, {0, 0});
            b.triangle(s, b.vertex(foot + 0.05f * out + 0.022f * side, face, {0, 0}), t);
            b.triangle(s, b.vertex(foot + 0.05f * out - 0.022f * side, face, {0, 0}), t);
        }
    }
    b.place(glm::mat4(1));
    b.tint(glm::vec3(1));
    add_object(scene, add_mesh(scene, b, "water lilies"), "water lilies", glm::dmat4(1));
}

void add_balustrade(Scene& scene, const Materials& m)
{
    MeshBuilder b;
    b.use(m.limestone);
    b.open_sky([](const glm::vec3& p, const glm::vec3& n) {
        return (n.y < 0 ? 0.6f : 0.95f) * (0.65f + 0.35f * glm::smoothstep(0.0f, 0.35f, p.y));
    });
    std::vector<glm::vec2> p{{0.075f, 0}, {0.075f, 0.05f}, {0.055f, 0.06f}, {0.055f, 0.08f}};
    for (int i = 0; i <= 14; ++i) {   // the belly and the neck
        const float t = static_cast<float>(i) / 14;
        const float belly = std::exp(-18 * (t - 0.3f) * (t - 0.3f)), neck = std::exp(-40 * (t - 0.95f) * (t - 0.95f));
        p.emplace_back(0.036f + 0.048f * belly + 0.012f * neck, 0.085f + 0.44f * t);
    }
    p.insert(p.end(), {{0.06f, 0.54f}, {0.06f, 0.565f}, {0.075f, 0.575f}, {0.075f, 0.62f}});
    b.lathe(make_outline(p, false), 20);
    const MeshId baluster = add_mesh(scene, b, "baluster");

    // Six piers, five stretches between them.
    b.open_sky(open_sky);
    b.use(m.limestone);
    constexpr int piers = 6, between = 8;
    const float spacing = 2.9f, first = k_back_z + 0.45f;
    for (int i = 0; i < piers; ++i) {
        const float z = first + spacing * static_cast<float>(i);
        const float x = k_left_x;
        b.shift_texture({0, 0.37f * static_cast<float>(i)});
        b.box({x - 0.25f, -0.05f, z - 0.25f}, {x + 0.25f, 0.24f, z + 0.25f}, 0.025f);
        b.box({x - 0.21f, 0.24f, z - 0.21f}, {x + 0.21f, 0.98f, z + 0.21f}, 0.02f);
        b.box({x - 0.26f, 0.98f, z - 0.26f}, {x + 0.26f, 1.09f, z + 0.26f}, 0.03f);
        if (i + 1 == piers) break;
        b.box({x - 0.19f, -0.05f, z + 0.25f}, {x + 0.19f, 0.22f, z + spacing - 0.25f}, 0.02f);
        b.box({x - 0.17f, 0.84f, z + 0.21f}, {x + 0.17f, 0.96f, z + spacing - 0.21f}, 0.035f);
        for (int k = 0; k < between; ++k) {
            const double at = z + 0.25 + (spacing - 0.5) * (k + 0.5) / between;
            add_object(scene, baluster, "baluster", placed({x, 0.22, at}));
        }
    }
    add_object(scene, add_mesh(scene, b, "balustrade"), "balustrade", glm::dmat4(1));
}

}   // namespace

void add_courtyard(Scene& scene, const Materials& m)
{
    add_paving(scene, m);
    add_pool(scene, m);
    add_balustrade(scene, m);
}

void add_landscape(Scene& scene, const Materials& m)
{
    MeshBuilder b;
    b.use(m.grass);
    // A meadow that falls away from the yard and rolls; rings widen with distance.
    constexpr int around = 96, rings = 18;
    const TiledNoise rolling(6, 3, 71), dryness(24, 3, 72);
    const auto ground = [&rolling](float radius, float angle) {
        const glm::vec2 p(radius * std::cos(angle), -radius * std::sin(angle));
        const float roll = rolling(p / 80.0f) - 0.5f;
        const float away = glm::smoothstep(13.0f, 45.0f, radius);
        return glm::vec3(p.x, -0.09f - 2.5f * away + 4.0f * away * roll, p.y);
    };
    const auto at = [&](int ring, int i) {
        const float t = static_cast<float>(ring) / rings;
        const float angle = static_cast<float>(2 * k_pi) * static_cast<float>(i % around) / around;
        const float radius = 80 * t * t;
        const glm::vec3 p = ground(radius, angle);
        const glm::vec3 along = ground(radius, angle + 0.01f) - ground(radius, angle - 0.01f);
        const glm::vec3 out = ground(radius + 0.1f, angle) - ground(std::max(radius - 0.1f, 0.0f), angle);
        glm::vec3 n = ring == 0 ? glm::vec3(0, 1, 0) : glm::normalize(glm::cross(along, out));
        if (n.y < 0) n = -n;
        const float dry = dryness(glm::vec2(p.x, p.z) / 80.0f);
        b.tint(glm::mix(glm::vec3(0.75f, 1.0f, 0.7f), glm::vec3(1.25f, 1.05f, 0.8f), dry));
        return b.vertex(p, n, glm::vec2(p.x, p.z));
    };
    for (int ring = 0; ring < rings; ++ring)
        for (int i = 0; i < around; ++i) {
            const std::uint32_t corner[] = {at(ring, i), at(ring, i + 1), at(ring + 1, i + 1), at(ring + 1, i)};
            b.quad(corner[0], corner[1], corner[2], corner[3]);
        }
    b.tint(glm::vec3(1));

    // Two ranges of hills, flat and pale as distance makes them.
    struct Range {
        MaterialId material;
        float distance, height;
        std::uint32_t seed;
    };
    for (const Range& range : {Range{m.hill_near, 84, 7, 5}, Range{m.hill_far, 100, 15, 8}}) {
        b.use(range.material);
        constexpr int steps = 240;
        const TiledNoise ridge(9, 5, range.seed);
        const auto crest = [&](int i) {
            const float u = static_cast<float>(i % steps) / steps;
            return range.height * (0.25f + ridge({u, 0.3f}));
        };
        for (int i = 0; i < steps; ++i) {
            const float a0 = static_cast<float>(2 * k_pi) * static_cast<float>(i) / steps;
            const float a1 = static_cast<float>(2 * k_pi) * static_cast<float>((i + 1) % steps) / steps;
            const glm::vec3 p(range.distance * std::cos(a0), 0, -range.distance * std::sin(a0));
            const glm::vec3 q(range.distance * std::cos(a1), 0, -range.distance * std::sin(a1));
            const glm::vec3 base(0, -8, 0);
            b.flat_quad(p + base, q + base, q + glm::vec3(0, crest(i + 1) - 4, 0), p + glm::vec3(0, crest(i) - 4, 0),
                        -glm::normalize(p + q));
        }
    }
    add_object(scene, add_mesh(scene, b, "landscape"), "landscape", glm::dmat4(1));
}

}   // namespace gnomon::scene::kinetic
