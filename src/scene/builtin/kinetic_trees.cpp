// SPDX-License-Identifier: Apache-2.0
// Trees and shrubs: crowns of many small leaves.

#include <glm/gtc/matrix_transform.hpp>

#include "scene/builtin/kinetic_leaves.h"

namespace gnomon::scene::kinetic {

namespace {

// Leaves on and in an ellipsoid, denser near its surface, facing outwards and up. Inner leaves see less sky.
struct Crown {
    glm::vec3 centre, radii;
    int leaves;
    float length, width;
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
        add_leaf(b, p, grow, face, crown.length * size, crown.width * size);
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
    add_crown(b, random, {{0, 1.85f, 0}, {0.60f, 0.55f, 0.60f}, 1500, 0.105f, 0.050f});
    add_crown(b, random, {{0.30f, 1.70f, 0.15f}, {0.36f, 0.32f, 0.36f}, 550, 0.105f, 0.050f});
    add_crown(b, random, {{-0.32f, 1.75f, 0.12f}, {0.34f, 0.30f, 0.36f}, 500, 0.105f, 0.050f});
    add_crown(b, random, {{0.05f, 1.70f, -0.34f}, {0.36f, 0.32f, 0.34f}, 450, 0.105f, 0.050f});
    add_crown(b, random, {{0.02f, 2.22f, 0.02f}, {0.34f, 0.30f, 0.34f}, 450, 0.100f, 0.047f});
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
    b.sphere({0, 0.84f, 0}, 0.30f, 16, 9);   // keeps the interior dark
    b.use(m.box_leaf);
    add_crown(b, random, {{0, 0.84f, 0}, {0.42f, 0.40f, 0.42f}, 3000, 0.055f, 0.032f});
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
        const glm::vec3 grow = glm::vec3(0, 1, 0) + 0.45f * out + 0.35f * on_sphere(random);
        const glm::vec3 face = out + 0.6f * on_sphere(random);
        const float length = random.uniform(0.18f, 0.33f), width = random.uniform(0.06f, 0.10f);
        add_leaf(b, p, grow, face, length, width);
    }
    return add_mesh(scene, b, "cypress");
}

// Stands outside the frame; its shadow falls into view.
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
    for (const glm::vec3& clump : clumps) add_crown(b, random, {clump, {0.95f, 0.65f, 0.95f}, 420, 0.17f, 0.05f});
    return add_mesh(scene, b, "olive tree");
}

}   // namespace

void add_trees(Scene& scene, const Materials& m)
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
}

}   // namespace gnomon::scene::kinetic
