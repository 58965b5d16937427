// SPDX-License-Identifier: Apache-2.0
// Foliage: many small leaves, each two to four triangles, around invisible crowns or along invisible stems.

#include <glm/gtc/matrix_transform.hpp>

#include "scene/kinetic.h"

namespace gnomon::scene::kinetic {

namespace {

glm::vec3 on_sphere(Random& random)
{
    const float z = random.uniform(-1, 1), a = random.uniform(0, static_cast<float>(2 * k_pi));
    const float r = std::sqrt(std::max(0.0f, 1 - z * z));
    return {r * std::cos(a), z, r * std::sin(a)};
}

// A leaf from its stalk along `grow`, its face towards `face`, folded at the rib; four triangles, or two if `simple`.
void add_leaf(MeshBuilder& b, const glm::vec3& stalk, const glm::vec3& grow, const glm::vec3& face, float length,
              float width, bool simple)
{
    const glm::vec3 along = glm::normalize(grow);
    glm::vec3 side = glm::cross(face, along);
    if (!(glm::dot(side, side) > 1e-8f)) return;
    side = glm::normalize(side);
    const glm::vec3 up = glm::cross(along, side);
    const float droop = 0.12f * length, fold = 0.18f * width;
    const glm::vec3 tip = stalk + along * length - up * droop;
    const glm::vec3 rib = stalk + along * (0.5f * length);
    for (const float hand : {-1.0f, 1.0f}) {
        const glm::vec3 edge = rib + side * (hand * 0.5f * width) + up * fold;
        const glm::vec3 n = glm::normalize(up - side * (hand * 0.45f));
        const std::uint32_t s = b.vertex(stalk, n, {0, 0}), e = b.vertex(edge, n, {0, 0});
        const std::uint32_t t = b.vertex(tip, n, {0, 0});
        if (simple) {
            b.triangle(s, e, t);
        } else {
            const std::uint32_t r = b.vertex(rib, n, {0, 0});
            b.triangle(s, e, r);
            b.triangle(r, e, t);
        }
    }
}

glm::vec3 vary(Random& random, float amount)
{
    const float light = random.uniform(1 - amount, 1 + amount), warm = random.uniform(0, amount);
    return light * glm::vec3(1 + 0.9f * warm, 1, 1 - 0.4f * warm);
}

// Leaves on and in an ellipsoid, denser outside, facing outwards and up; the inside sees less sky.
struct Crown {
    glm::vec3 centre, radii;
    int leaves;
    float length, width;
    bool simple;
};
void add_crown(MeshBuilder& b, Random& random, const Crown& crown)
{
    for (int i = 0; i < crown.leaves; ++i) {
        const glm::vec3 out = on_sphere(random);
        const float depth = std::cbrt(random.uniform(0.35f, 1.0f));
        const glm::vec3 p = crown.centre + crown.radii * out * depth;
        const float seen = (0.30f + 0.70f * depth * depth * depth) * (0.62f + 0.38f * out.y);
        b.open_sky([seen](const glm::vec3&, const glm::vec3&) { return seen; });
        b.tint(vary(random, 0.3f));
        const glm::vec3 grow = glm::normalize(out + 0.9f * on_sphere(random) - glm::vec3(0, 0.25f, 0));
        const glm::vec3 face = glm::normalize(out + glm::vec3(0, 0.7f, 0) + 0.5f * on_sphere(random));
        const float size = random.uniform(0.7f, 1.2f);
        add_leaf(b, p, grow, face, crown.length * size, crown.width * size, crown.simple);
    }
}

void add_pot(MeshBuilder& b, const Materials& m, float scale)
{
    b.open_sky([scale](const glm::vec3& p, const glm::vec3& n) {
        return (n.y < 0 ? 0.6f : 0.9f) * (0.6f + 0.4f * glm::smoothstep(0.0f, 0.4f * scale, p.y));
    });
    b.tint(glm::vec3(1));
    b.use(m.terracotta);
    std::vector<glm::vec2> p{{0.20f, 0.0f}, {0.22f, 0.0f}, {0.225f, 0.04f}};
    for (int i = 0; i <= 12; ++i) {
        const float t = static_cast<float>(i) / 12;
        p.emplace_back(0.22f + 0.11f * std::sin(1.45f * t), 0.05f + 0.36f * t);
    }
    for (const glm::vec2& q : arc({0.345f, 0.45f}, 0.035f, -1.5f, 1.57f, 8)) p.push_back(q);
    p.insert(p.end(), {{0.31f, 0.485f}, {0.305f, 0.43f}});
    for (glm::vec2& q : p) q *= scale;
    b.lathe(make_outline(p, false), 48);
    b.use(m.soil);
    const glm::vec2 soil[] = {{0.31f * scale, 0.44f * scale}, {0.0f, 0.46f * scale}};
    b.lathe(make_outline(soil, false), 24);
}

MeshId make_orange_tree(Scene& scene, const Materials& m)
{
    MeshBuilder b;
    Random random(101);
    add_pot(b, m, 1.15f);
    b.use(m.bark);
    b.open_sky([](const glm::vec3& p, const glm::vec3&) { return 0.75f - 0.4f * glm::smoothstep(0.9f, 1.6f, p.y); });
    const glm::vec3 trunk[] = {{0, 0.45f, 0}, {0.03f, 0.8f, 0.02f}, {-0.02f, 1.2f, 0.01f}, {0.0f, 1.65f, 0}};
    const auto path = smooth_path(trunk, 6);
    std::vector<float> radii;
    for (std::size_t i = 0; i < path.size(); ++i) radii.push_back(0.05f - 0.0012f * static_cast<float>(i));
    b.tube(path, radii, 12);
    for (int i = 0; i < 9; ++i) {
        glm::vec3 out = on_sphere(random);
        out.y = 0.35f + 0.5f * std::abs(out.y);
        const glm::vec3 branch[] = {{0, 1.25f + 0.04f * static_cast<float>(i), 0},
                                    glm::vec3(0, 1.4f, 0) + 0.25f * out,
                                    glm::vec3(0, 1.55f, 0) + 0.55f * out};
        const float thick[] = {0.025f, 0.018f, 0.008f};
        b.tube(branch, thick, 7);
    }
    // Five clumps make the crown uneven.
    b.use(m.orange_leaf);
    add_crown(b, random, {{0, 1.85f, 0}, {0.60f, 0.55f, 0.60f}, 1500, 0.105f, 0.050f, false});
    add_crown(b, random, {{0.30f, 1.70f, 0.15f}, {0.36f, 0.32f, 0.36f}, 550, 0.105f, 0.050f, false});
    add_crown(b, random, {{-0.32f, 1.75f, 0.12f}, {0.34f, 0.30f, 0.36f}, 500, 0.105f, 0.050f, false});
    add_crown(b, random, {{0.05f, 1.70f, -0.34f}, {0.36f, 0.32f, 0.34f}, 450, 0.105f, 0.050f, false});
    add_crown(b, random, {{0.02f, 2.22f, 0.02f}, {0.34f, 0.30f, 0.34f}, 450, 0.100f, 0.047f, false});
    b.use(m.orange);
    for (int i = 0; i < 26; ++i) {
        glm::vec3 out = on_sphere(random);
        out.y = 0.6f * out.y - 0.15f;
        b.tint(glm::vec3(1, 0.85f + 0.3f * random.uniform(), 1));
        b.open_sky([](const glm::vec3&, const glm::vec3& n) { return 0.6f + 0.3f * n.y; });
        b.sphere(glm::vec3(0, 1.82f, 0) + glm::vec3(0.60f, 0.52f, 0.60f) * out, random.uniform(0.038f, 0.048f), 14, 7);
    }
    return add_mesh(scene, b, "orange tree");
}

MeshId make_box_ball(Scene& scene, const Materials& m)
{
    MeshBuilder b;
    Random random(103);
    add_pot(b, m, 0.95f);
    b.use(m.bark);
    const glm::vec3 stem[] = {{0, 0.4f, 0}, {0, 0.75f, 0}};
    b.tube(stem, 0.03f, 8);
    b.sphere({0, 0.84f, 0}, 0.30f, 16, 9);   // keeps the inside dark
    b.use(m.box_leaf);
    add_crown(b, random, {{0, 0.84f, 0}, {0.42f, 0.40f, 0.42f}, 3000, 0.055f, 0.032f, true});
    return add_mesh(scene, b, "box tree");
}

MeshId make_cypress(Scene& scene, const Materials& m)
{
    MeshBuilder b;
    Random random(107);
    b.use(m.bark);
    const glm::vec3 trunk[] = {{0, -0.5f, 0}, {0, 1.0f, 0}};
    b.tube(trunk, 0.10f, 10);
    b.use(m.cypress);
    constexpr int leaves = 4600;
    for (int i = 0; i < leaves; ++i) {
        // A flame of sprays: wide below the middle, pointed above.
        const float t = std::pow(random.uniform(), 0.85f);
        const float angle = random.uniform(0, static_cast<float>(2 * k_pi));
        const float widest = 0.62f * std::pow(1 - t, 0.75f) * (0.35f + 0.65f * glm::smoothstep(0.0f, 0.25f, t)) + 0.03f;
        const float lump = 1 + 0.16f * std::sin(3 * angle + 9 * t) * std::sin(23 * t + angle);
        const float depth = std::sqrt(random.uniform(0.45f, 1.0f));
        const glm::vec3 out(std::cos(angle), 0, std::sin(angle));
        const glm::vec3 p = out * (widest * depth * lump) + glm::vec3(0, 0.25f + 5.6f * t, 0);
        const float seen = 0.25f + 0.65f * depth * depth * depth;
        b.open_sky([seen](const glm::vec3&, const glm::vec3&) { return seen; });
        b.tint(vary(random, 0.35f));
        add_leaf(b, p, glm::vec3(0, 1, 0) + 0.45f * out + 0.35f * on_sphere(random), out + 0.6f * on_sphere(random),
                 random.uniform(0.18f, 0.33f), random.uniform(0.06f, 0.10f), true);
    }
    return add_mesh(scene, b, "cypress");
}

// Stands outside the picture: its shade falls into it.
MeshId make_olive(Scene& scene, const Materials& m)
{
    MeshBuilder b;
    Random random(113);
    b.use(m.bark);
    const glm::vec3 trunk[] = {{0, -0.5f, 0}, {0.1f, 1.2f, 0}, {-0.15f, 2.6f, 0.1f}, {0.1f, 4.2f, 0}};
    const float thick[] = {0.30f, 0.22f, 0.16f, 0.08f};
    b.tube(trunk, thick, 12);
    std::vector<glm::vec3> clumps;
    for (int i = 0; i < 9; ++i) {
        const float angle = 2.4f * static_cast<float>(i), reach = 0.5f + 0.2f * static_cast<float>(i);
        clumps.emplace_back(reach * std::cos(angle), 4.1f + 0.9f * random.uniform(), reach * std::sin(angle));
        const glm::vec3 branch[] = {{-0.1f, 2.4f, 0.1f}, 0.5f * clumps.back() + glm::vec3(0, 1.4f, 0), clumps.back()};
        const float thin[] = {0.08f, 0.05f, 0.02f};
        b.tube(branch, thin, 6);
    }
    b.use(m.olive);
    for (const glm::vec3& clump : clumps) add_crown(b, random, {clump, {0.95f, 0.65f, 0.95f}, 420, 0.17f, 0.05f, true});
    return add_mesh(scene, b, "olive tree");
}

// Climbs on a wall: along a few wandering stems, leaves lie flat with their tips down.
struct Climber {
    glm::vec3 foot;         // where it comes out of the ground
    glm::vec3 along, out;   // the wall's direction and its normal
    float reach, height;    // how far it spreads
    float drift;            // and how far its tops lean over along the wall
    int stems, leaves;      // leaves a stem
    MaterialId leaf, blossom;
    float blossoms;   // share of leaves that flower
};
void add_climber(MeshBuilder& b, const Materials& m, Random& random, const Climber& c)
{
    for (int s = 0; s < c.stems; ++s) {
        // Walk upwards, drifting to one side.
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
            add_leaf(b, p, grow, face, size, 0.85f * size, false);
        }
    }
}

}   // namespace

void add_plants(Scene& scene, const Materials& m)
{
    const MeshId orange = make_orange_tree(scene, m);
    add_object(scene, orange, "orange tree", placed({-4.3, 0.01, 4.9}, 0.4));
    add_object(scene, orange, "orange tree", placed({5.3, 0.01, -4.25}, 2.3, 0.95));
    add_object(scene, orange, "orange tree", placed({-5.6, 0.01, -4.1}, 4.0, 1.05));

    const MeshId box = make_box_ball(scene, m);
    for (const double x : {-2.35, 2.35}) add_object(scene, box, "box tree", placed({x, 0.01, 2.45}, 1.7 * x));
    for (const double x : {-2.4, 2.4}) add_object(scene, box, "box tree", placed({x, 0.01, -4.6}, 0.9 * x, 1.1));

    const MeshId cypress = make_cypress(scene, m);
    struct Place {
        glm::dvec3 at;
        double turn, scale;
    };
    for (const Place& p : {Place{{-10.2, -0.2, -4.8}, 1.9, 1.0}, Place{{-10.8, -0.4, -1.4}, 3.8, 1.1},
                           Place{{-11.5, -0.6, 2.2}, 5.7, 0.95}, Place{{-14.5, -0.9, -9.5}, 0.6, 1.2}})
        add_object(scene, cypress, "cypress", placed(p.at, p.turn, p.scale));

    add_object(scene, make_olive(scene, m), "olive tree", placed({-11.2, -0.3, 7.4}, 0.7));

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
        add_leaf(b, at, grow, {0, 1, 0}, random.uniform(0.04f, 0.07f), 0.05f, true);
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
