// SPDX-License-Identifier: Apache-2.0
// The arcades: columns, arches, cornice, a tiled roof, and the walk behind them. A run is built along its own +x with
// the yard on its +z side, and then transformed as a whole.

#include <glm/gtc/matrix_transform.hpp>

#include "scene/builtin/kinetic.h"

namespace gnomon::scene::kinetic {

namespace {

constexpr float k_half_wall = 0.26f;
constexpr float k_arch = 0.97f;   // radius
constexpr float k_ceiling = 4.30f;
constexpr int k_arch_steps = 32;

struct Run {
    MeshBuilder& builder;
    const Materials& materials;
    int bays;
    float length() const { return static_cast<float>(bays) * k_bay; }
};

// One bay of the wall over the columns.
void add_arch(Run& run, float x0)
{
    MeshBuilder& b = run.builder;
    const float x1 = x0 + k_bay, middle = 0.5f * (x0 + x1);
    b.use(run.materials.plaster);
    for (const float side : {-1.0f, 1.0f}) {
        const float z = side * k_half_wall;
        const glm::vec3 normal(0, 0, side);
        for (const float x : {x0, middle + k_arch}) {
            const float end = x == x0 ? middle - k_arch : x1;
            b.flat_quad({x, k_springing, z}, {end, k_springing, z}, {end, k_eaves, z}, {x, k_eaves, z}, normal);
        }
        const auto curve = arc({middle, k_springing}, k_arch, 0, static_cast<float>(k_pi), k_arch_steps);
        for (int i = 0; i < k_arch_steps; ++i) {
            const glm::vec2 p = curve[i], q = curve[i + 1];
            b.flat_quad({p, z}, {q, z}, {q.x, k_eaves, z}, {p.x, k_eaves, z}, normal);
        }
    }
    // The arch's underside and its moulding, front and back, in stone.
    b.use(run.materials.limestone);
    constexpr float h = k_half_wall;
    const glm::vec2 profile[] = {{0.24f, h},          {0.225f, h + 0.03f}, {0.19f, h + 0.035f}, {0.17f, h + 0.065f},
                                 {0.03f, h + 0.065f}, {0.0f, h + 0.045f},  {0.0f, -h},          {0.03f, -h - 0.02f},
                                 {0.2f, -h - 0.02f},  {0.2f, -h}};
    std::vector<Frame> frames;
    for (int i = 0; i <= k_arch_steps; ++i) {
        const float a = static_cast<float>(k_pi) * static_cast<float>(i) / k_arch_steps;
        const glm::vec3 out(std::cos(a), std::sin(a), 0);
        frames.push_back({glm::vec3(middle, k_springing, 0) + k_arch * out, out, {0, 0, 1}, k_arch * a});
    }
    b.sweep(make_outline(profile, false), frames);
    b.box({middle - 0.11f, k_springing + k_arch - 0.05f, -h - 0.03f},
          {middle + 0.11f, k_springing + k_arch + 0.34f, h + 0.11f}, 0.02f);
}

void add_cornice(Run& run)
{
    MeshBuilder& b = run.builder;
    b.use(run.materials.limestone);
    constexpr float w = k_half_wall;
    const glm::vec2 profile[] = {{w, 4.42f},         {w + 0.05f, 4.42f}, {w + 0.05f, 4.50f}, {w + 0.02f, 4.52f},
                                 {w + 0.02f, 4.60f}, {w + 0.06f, 4.66f}, {w + 0.13f, 4.70f}, {w + 0.21f, 4.71f},
                                 {w + 0.21f, 4.80f}, {w + 0.19f, 4.83f}, {w, 4.83f}};
    const Frame ends[] = {{{-0.3f, 0, 0}, {0, 0, 1}, {0, 1, 0}, 0},
                          {{run.length() + 0.3f, 0, 0}, {0, 0, 1}, {0, 1, 0}, run.length()}};
    b.sweep(make_outline(profile, false), ends, false);
    // Dentils.
    for (float x = 0.1f; x < run.length(); x += 0.2f)
        b.box({x - 0.05f, 4.52f, w - 0.02f}, {x + 0.05f, 4.62f, w + 0.075f}, 0.01f);
}

// Barrel tiles, each a little wider at its lower end, so that courses overlap.
void add_roof(Run& run, Random& random)
{
    MeshBuilder& b = run.builder;
    constexpr float spacing = 0.24f, tile = 0.46f;
    const glm::vec3 low(0, 4.84f, k_half_wall + 0.38f), high(0, 6.15f, -k_arcade_depth - 0.35f);
    const glm::vec3 slope = glm::normalize(high - low);
    const glm::vec3 up = glm::normalize(glm::cross(slope, glm::vec3(-1, 0, 0)));
    const float rise = glm::length(high - low);
    const glm::vec3 along(1, 0, 0), start(-0.3f, 0, 0), finish(run.length() + 0.3f, 0, 0);
    b.use(run.materials.roof);
    b.tint(glm::vec3(0.55f));
    b.flat_quad(start + low, finish + low, finish + high, start + high, up);
    b.flat_quad(start + low, finish + low, finish + low - 0.05f * up, start + low - 0.05f * up, -slope);
    const Outline half = make_outline(arc({0, 0}, 1, 0, static_cast<float>(k_pi), 8), false);
    for (float x = start.x + 0.1f; x < finish.x - 0.05f; x += spacing) {
        const float light = 0.8f + 0.35f * random.uniform(), warm = 0.95f + 0.1f * random.uniform();
        b.tint(light * glm::vec3(1, warm, 1));
        b.shift_texture({random.uniform(), random.uniform()});
        std::vector<Frame> frames;
        // A clay disc closes the barrel at the eaves.
        frames.push_back({along * x + low - slope * 0.055f, along * 0.02f, up * 0.02f, 0});
        for (float s = -0.06f; s < rise; s += tile) {
            const glm::vec3 a = low + slope * s, c = low + slope * std::min(s + tile, rise);
            frames.push_back({along * x + a + up * 0.035f, along * 0.115f, up * 0.105f, s});
            frames.push_back({along * x + c, along * 0.098f, up * 0.088f, s + tile});
        }
        b.sweep(half, frames);
    }
    b.tint(glm::vec3(1));
    b.shift_texture({0, 0});
}

// Wall, ceiling and floor of the walk behind the columns.
void add_walk(Run& run, float floor_from, float steps_from)
{
    MeshBuilder& b = run.builder;
    const float back = -k_arcade_depth, length = run.length();
    constexpr int rows = 8;
    b.use(run.materials.plaster);
    for (int bay = 0; bay < run.bays; ++bay)
        for (int half = 0; half < 2; ++half)
            for (int row = 0; row < rows; ++row) {
                const float x0 = (static_cast<float>(bay) + 0.5f * static_cast<float>(half)) * k_bay;
                const float x1 = x0 + 0.5f * k_bay;
                const float t0 = static_cast<float>(row) / rows, t1 = static_cast<float>(row + 1) / rows;
                const float y0 = glm::mix(k_arcade_floor, k_ceiling, t0), y1 = glm::mix(k_arcade_floor, k_ceiling, t1);
                b.flat_quad({x0, y0, back}, {x1, y0, back}, {x1, y1, back}, {x0, y1, back}, {0, 0, 1});
                const float z0 = glm::mix(back, k_half_wall, t0), z1 = glm::mix(back, k_half_wall, t1);
                b.flat_quad({x0, k_ceiling, z0}, {x1, k_ceiling, z0}, {x1, k_ceiling, z1}, {x0, k_ceiling, z1},
                            {0, -1, 0});
            }
    b.use(run.materials.limestone);
    for (int bay = 0; bay < run.bays; ++bay) {
        const float x = static_cast<float>(bay) * k_bay;
        // A stone dado, a beam over every column, and a pilaster behind it.
        b.box({x + 0.16f, k_arcade_floor, back - 0.1f}, {x + k_bay - 0.16f, 1.15f, back + 0.05f}, 0.02f);
        if (bay > 0) b.box({x - 0.13f, k_ceiling - 0.2f, back}, {x + 0.13f, k_ceiling + 0.1f, -k_half_wall}, 0.02f);
        b.box({x - 0.16f, k_arcade_floor, back - 0.1f}, {x + 0.16f, k_ceiling - 0.2f, back + 0.09f}, 0.02f);
    }
    // Floor and steps, in blocks.
    Random random(91);
    b.use(run.materials.paving);
    const auto blocks = [&](float from, float y0, float y1, float z0, float z1) {
        const int count = static_cast<int>(std::ceil((length + 0.25f - from) / 1.2f));
        const float size = (length + 0.25f - from) / static_cast<float>(count);
        for (int i = 0; i < count; ++i) {
            const float x = from + size * static_cast<float>(i);
            b.tint(glm::vec3(0.92f + 0.2f * random.uniform()));
            b.shift_texture({random.uniform(), random.uniform()});
            b.box({x + 0.003f, y0, z0}, {x + size - 0.003f, y1 - 0.004f * random.uniform(), z1}, 0.018f);
        }
    };
    blocks(floor_from, -0.1f, k_arcade_floor, -0.25f, 0.45f);
    blocks(floor_from, -0.1f, k_arcade_floor, -1.45f, -0.253f);
    blocks(floor_from, -0.1f, k_arcade_floor, back, -1.453f);
    blocks(steps_from, -0.1f, 0.5f * k_arcade_floor, 0.453f, 0.85f);
    b.tint(glm::vec3(1));
    b.shift_texture({0, 0});
}

// A closing wall across the run's end: a gable that follows the roof, with a coping.
void add_end(Run& run, float x0, float x1)
{
    MeshBuilder& b = run.builder;
    const float back = -k_arcade_depth - 0.45f, front = k_half_wall + 0.12f;
    const float thickness = x1 - x0, low = 4.98f, high = 6.5f;
    // A plate's own x runs along the wall, towards the yard.
    const glm::mat4 before = b.placement();
    b.place(before * glm::translate(glm::mat4(1), glm::vec3(0.5f * (x0 + x1), 0, 0)) *
            glm::rotate(glm::mat4(1), static_cast<float>(-k_pi / 2), glm::vec3(0, 1, 0)));
    b.use(run.materials.plaster);
    const glm::vec2 wall[] = {{back, -0.1f}, {front, -0.1f}, {front, low}, {back, high}};
    b.plate(wall, {0.5f * (back + front), 2.5f}, thickness, 0.03f);
    b.use(run.materials.limestone);
    const glm::vec2 coping[] = {
        {back - 0.05f, high}, {front + 0.14f, low - 0.06f}, {front + 0.14f, low + 0.10f}, {back - 0.05f, high + 0.16f}};
    b.plate(coping, 0.25f * (coping[0] + coping[1] + coping[2] + coping[3]), thickness + 0.18f, 0.03f);
    b.place(before);
    b.box({x0 - 0.05f, -0.1f, back - 0.05f}, {x1 + 0.05f, 0.75f, front + 0.05f}, 0.03f);
    b.box({x0 - 0.05f, k_springing - 0.12f, front - 0.4f}, {x1 + 0.05f, k_springing + 0.02f, front + 0.05f}, 0.03f);
}

void add_doors(Run& run, std::span<const int> bays)
{
    MeshBuilder& b = run.builder;
    const float back = -k_arcade_depth;
    for (const int bay : bays) {
        const float x = (static_cast<float>(bay) + 0.5f) * k_bay;
        b.use(run.materials.limestone);
        for (const float side : {-1.0f, 1.0f})
            b.box({x + side * 0.63f - 0.09f, k_arcade_floor, back}, {x + side * 0.63f + 0.09f, 2.6f, back + 0.12f},
                  0.02f);
        b.box({x - 0.8f, 2.6f, back}, {x + 0.8f, 2.82f, back + 0.15f}, 0.03f);
        b.use(run.materials.blue);
        for (const float leaf : {-0.27f, 0.27f}) {
            b.box({x + leaf - 0.265f, k_arcade_floor + 0.02f, back}, {x + leaf + 0.265f, 2.6f, back + 0.08f}, 0.015f);
            for (const float y : {0.5f, 1.2f, 1.9f})
                b.box({x + leaf - 0.18f, y, back + 0.05f}, {x + leaf + 0.18f, y + 0.55f, back + 0.105f}, 0.03f);
        }
        b.use(run.materials.gold);
        b.sphere({x + 0.06f, 1.35f, back + 0.12f}, 0.035f, 16, 9);
    }
}

}   // namespace

void add_arcades(Scene& scene, const Materials& m)
{
    const MeshId column = make_column(scene, m);
    Random random(17);
    const glm::dmat4 back_place = placed({k_left_x, 0, k_back_z});
    const glm::dmat4 right_place = placed({k_right_x, 0, k_back_z}, -k_pi / 2);

    const auto build = [&](const char* name, const glm::dmat4& place, int bays, float floor_from, float steps_from,
                           std::span<const int> doors, bool end_first, bool end_last) {
        MeshBuilder b;
        b.open_sky(open_sky);
        b.place(glm::mat4(place));
        Run run{b, m, bays};
        for (int bay = 0; bay < bays; ++bay) add_arch(run, static_cast<float>(bay) * k_bay);
        add_cornice(run);
        add_roof(run, random);
        add_walk(run, floor_from, steps_from);
        add_doors(run, doors);
        if (end_first) add_end(run, -0.32f, 0.25f);
        if (end_last) add_end(run, run.length() - 0.25f, run.length() + 0.32f);
        add_object(scene, add_mesh(scene, b, name), name, glm::dmat4(1));
        for (int i = 1; i < bays; ++i)
            add_object(scene, column, "column", place * placed({i * double{k_bay}, k_arcade_floor, 0}));
    };
    const int back_doors[] = {1, 4}, right_doors[] = {1, 3};
    build("back arcade", back_place, k_back_bays, -0.3f, -0.3f, back_doors, true, false);
    build("right arcade", right_place, k_right_bays, 0.45f, 0.45f, right_doors, false, true);
}

}   // namespace gnomon::scene::kinetic
