// SPDX-License-Identifier: Apache-2.0
// The sundial in the middle and the objects around it: lanterns, a mirror ball, vases.

#include <glm/gtc/matrix_transform.hpp>

#include "scene/builtin/kinetic.h"

namespace gnomon::scene::kinetic {

namespace {

float shade_of_steps(const glm::vec3& p, const glm::vec3& n)
{
    return (n.y > 0.5f ? 0.97f : 0.78f) * (n.y < -0.2f ? 0.55f : 1.0f) *
           (0.75f + 0.25f * glm::smoothstep(0.0f, 0.3f, p.y));
}

// A round step with a rounded nose.
void add_step(MeshBuilder& b, float radius, float y0, float y1)
{
    std::vector<glm::vec2> p{{radius - 0.03f, y0}, {radius - 0.03f, y1 - 0.08f}, {radius - 0.005f, y1 - 0.065f}};
    for (const glm::vec2& q : arc({radius - 0.03f, y1 - 0.03f}, 0.03f, 0, static_cast<float>(k_pi) / 2, 6))
        p.push_back(q);
    p.emplace_back(radius * 0.6f, y1);
    p.emplace_back(0.0f, y1);
    b.lathe(make_outline(p, false), 96);
}

// The fin: its long edge points to the celestial pole, its back is cut to a curve.
void add_gnomon(MeshBuilder& b, const Materials& m)
{
    std::vector<glm::vec2> p{{0.02f, 0}, {0.75f, 0}};
    const glm::vec2 top(0.62f, 0.64f);
    p.emplace_back(0.75f, 0.05f);
    for (int i = 0; i <= 16; ++i) {   // the back, hollow
        const float t = static_cast<float>(i) / 16;
        const glm::vec2 a(0.70f, 0.09f), c(0.53f, 0.34f);
        p.push_back((1 - t) * (1 - t) * a + 2 * t * (1 - t) * c + t * t * (top + glm::vec2(0.02f, -0.01f)));
    }
    p.push_back(top);
    p.emplace_back(0.60f, 0.635f);
    b.use(m.bronze);
    b.plate(p, {0.52f, 0.22f}, 0.034f, 0.008f);
    b.use(m.gold);
    b.sphere({top.x, top.y + 0.045f, 0}, 0.055f, 32, 17);
}

}   // namespace

void add_sundial(Scene& scene, const Materials& m)
{
    MeshBuilder b;
    b.open_sky(shade_of_steps);
    b.use(m.limestone);
    add_step(b, 2.15f, -0.05f, 0.15f);
    b.shift_texture({0.3f, 0.6f});
    add_step(b, 1.70f, 0.15f, 0.30f);
    b.shift_texture({0.7f, 0.1f});
    add_step(b, 1.25f, 0.30f, 0.45f);

    b.shift_texture({0, 0});

    // The pedestal.
    b.use(m.marble);
    std::vector<glm::vec2> p{{0.52f, 0.45f}, {0.52f, 0.53f}, {0.50f, 0.55f}};
    for (const glm::vec2& q : arc({0.44f, 0.60f}, 0.05f, -1.5f, 1.5f, 8)) p.push_back(q);
    p.insert(p.end(), {{0.40f, 0.655f}, {0.38f, 0.67f}});
    for (int i = 0; i <= 16; ++i) {
        const float t = static_cast<float>(i) / 16;
        p.emplace_back(0.25f + 0.13f * (1 - t) * (1 - t) * (1 - t) + 0.10f * t * t * t, 0.69f + 0.44f * t);
    }
    for (const glm::vec2& q : arc({0.37f, 1.17f}, 0.035f, -1.5f, 1.5f, 8)) p.push_back(q);
    p.insert(p.end(), {{0.40f, 1.21f}, {0.40f, 1.27f}, {0.0f, 1.275f}});
    b.lathe(make_outline(p, false), 64);

    // The dial leans towards the camera; its own space has the face in y = 0 and noon along +z.
    const glm::mat4 dial =
        glm::translate(glm::mat4(1), glm::vec3(0, 1.74f, 0.0f)) * glm::rotate(glm::mat4(1), 0.62f, glm::vec3(1, 0, 0));
    b.place(dial);
    b.open_sky([](const glm::vec3&, const glm::vec3& n) { return n.y > 0 ? 0.95f : 0.45f; });
    std::vector<glm::vec2> rim{{0, -0.12f}, {0.50f, -0.12f}, {0.80f, -0.085f}, {0.98f, -0.08f}};
    for (const glm::vec2& q : arc({0.98f, -0.04f}, 0.04f, -1.5f, 1.57f, 10)) rim.push_back(q);
    rim.emplace_back(0.955f, 0.0f);
    b.lathe(make_outline(rim, false), 96);
    b.use(m.bronze);
    const glm::vec2 band[] = {{0.965f, -0.005f}, {0.965f, 0.012f}, {0.95f, 0.014f}, {0.94f, 0.012f}, {0.94f, -0.005f}};
    b.lathe(make_outline(band, false), 96);
    b.use(m.dial);
    constexpr int around = 96;
    const glm::vec3 up(0, 1, 0);
    constexpr float radius = 0.95f;
    const auto on_face = [&](float x, float z) {
        return b.vertex({x, 0, z}, up, {0.5f + 0.5f * x / radius, 0.5f + 0.5f * z / radius});
    };
    const std::uint32_t hub = on_face(0, 0);
    std::uint32_t last = 0;
    for (int i = 0; i <= around; ++i) {
        const float angle = static_cast<float>(2 * k_pi) * static_cast<float>(i % around) / around;
        const std::uint32_t v = on_face(radius * std::cos(angle), -radius * std::sin(angle));
        if (i > 0) b.triangle(hub, last, v);
        last = v;
    }
    // The fin stands on the noon line: its own x runs along +z of the dial.
    b.place(dial * glm::translate(glm::mat4(1), glm::vec3(0, -0.004f, -0.52f)) *
            glm::rotate(glm::mat4(1), static_cast<float>(-k_pi / 2), glm::vec3(0, 1, 0)));
    add_gnomon(b, m);
    // A strut from pedestal to dial, hidden but for its sides.
    b.place(glm::mat4(1));
    b.use(m.marble);
    b.open_sky(shade_of_steps);
    const glm::vec2 neck[] = {{0.26f, 1.25f}, {0.20f, 1.30f}, {0.15f, 1.38f}, {0.13f, 1.48f}, {0.13f, 1.62f}};
    b.lathe(make_outline(neck, false), 48);
    add_object(scene, add_mesh(scene, b, "sundial"), "sundial", glm::dmat4(1));
}

namespace {

// A lantern that hangs from its origin: a cap, four bars, a floor, a flame.
MeshId make_lantern(Scene& scene, const Materials& m)
{
    MeshBuilder b;
    b.use(m.iron);
    const glm::vec3 chain[] = {{0, 0, 0}, {0, -0.42f, 0}};
    b.tube(chain, 0.008f, 8);
    const glm::vec2 cap[] = {{0.15f, -0.56f}, {0.16f, -0.55f}, {0.10f, -0.48f}, {0.05f, -0.44f}, {0.0f, -0.41f}};
    b.lathe(make_outline(cap, false), 24);
    const glm::vec2 under[] = {{0.0f, -0.56f}, {0.15f, -0.56f}};
    b.lathe(make_outline(under, false), 24);
    const glm::vec2 floor[] = {{0.0f, -0.93f}, {0.05f, -0.925f}, {0.11f, -0.90f}, {0.115f, -0.885f}, {0.0f, -0.885f}};
    b.lathe(make_outline(floor, false), 24);
    for (int i = 0; i < 6; ++i) {
        const float a = static_cast<float>(k_pi / 3) * static_cast<float>(i);
        const glm::vec3 out(std::cos(a), 0, std::sin(a));
        const glm::vec3 bar[] = {0.135f * out + glm::vec3(0, -0.555f, 0), 0.10f * out + glm::vec3(0, -0.89f, 0)};
        b.tube(bar, 0.006f, 6);
    }
    b.use(m.flame);
    const glm::vec2 flame[] = {{0.0f, -0.70f},    {0.02f, -0.69f},   {0.032f, -0.665f},
                               {0.028f, -0.635f}, {0.012f, -0.595f}, {0.0f, -0.575f}};
    b.lathe(make_outline(flame, false, 1.5f), 16);
    return add_mesh(scene, b, "lantern");
}
constexpr double k_flame = -0.74;   // the light, just below the flame that would hide it

void add_lantern(Scene& scene, MeshId mesh, const glm::dvec3& hook)
{
    const NodeId node = add_object(scene, mesh, "lantern", placed(hook));
    Light light;
    light.name = "lantern";
    light.type = LightType::point;
    light.color = {9.0f, 4.6f, 1.7f};   // candela
    light.node = scene.add_node("lantern light", node, placed({0, k_flame, 0}));
    scene.lights.push_back(light);
}

MeshId make_vase(Scene& scene, MaterialId glass)
{
    // A thick-walled vase: outside up, inside down, so that light is refracted as by real glass.
    MeshBuilder b;
    b.use(glass);
    std::vector<glm::vec2> out, in;
    for (int i = 0; i <= 24; ++i) {
        const float t = static_cast<float>(i) / 24;
        const float belly = 0.10f + 0.09f * std::sin(static_cast<float>(k_pi) * (0.18f + 1.12f * t));
        const float lip = 0.05f * glm::smoothstep(0.86f, 1.0f, t);
        out.emplace_back(belly + lip, 0.46f * t);
        in.emplace_back(belly + lip - 0.014f, glm::mix(0.03f, 0.46f, t));
    }
    std::vector<glm::vec2> p{{0.0f, 0.0f}};
    p.insert(p.end(), out.begin(), out.end());
    p.insert(p.end(), in.rbegin(), in.rend());
    p.emplace_back(0.0f, 0.03f);
    b.lathe(make_outline(p, false, 1.2f), 48);
    return add_mesh(scene, b, "vase");
}

}   // namespace

void add_ornaments(Scene& scene, const Materials& m)
{
    // Lanterns hang in the middle of arches.
    const MeshId lantern = make_lantern(scene, m);
    const double hook = k_springing + 0.96;
    for (const int bay : {0, 2, 5})
        add_lantern(scene, lantern, {k_left_x + (bay + 0.5) * double{k_bay}, hook, k_back_z - 0.9});
    for (const int bay : {1, 3})
        add_lantern(scene, lantern, {k_right_x + 0.9, hook, k_back_z + (bay + 0.5) * double{k_bay}});

    // A mirror ball on a pedestal, which reflects the whole yard.
    MeshBuilder b;
    b.open_sky(shade_of_steps);
    b.use(m.limestone);
    b.box({-0.27f, -0.02f, -0.27f}, {0.27f, 0.10f, 0.27f}, 0.02f);
    std::vector<glm::vec2> p{{0.24f, 0.10f}, {0.24f, 0.13f}, {0.20f, 0.16f}};
    for (int i = 0; i <= 12; ++i) {
        const float t = static_cast<float>(i) / 12;
        p.emplace_back(0.13f + 0.05f * (1 - t) * (1 - t) + 0.03f * t * t * t, 0.18f + 0.42f * t);
    }
    for (const glm::vec2& q : arc({0.19f, 0.63f}, 0.03f, -1.5f, 1.5f, 6)) p.push_back(q);
    p.insert(p.end(), {{0.21f, 0.67f}, {0.21f, 0.70f}, {0.0f, 0.705f}});
    b.lathe(make_outline(p, false), 48);
    b.use(m.gold);
    const glm::vec2 ring[] = {{0.13f, 0.70f}, {0.145f, 0.72f}, {0.13f, 0.745f}, {0.11f, 0.75f}};
    b.lathe(make_outline(ring, false, 1.5f), 48);
    b.open_sky({});
    b.use(m.mirror);
    b.sphere({0, 1.03f, 0}, 0.33f, 72, 35);
    add_object(scene, add_mesh(scene, b, "mirror ball"), "mirror ball", placed({3.05, 0, 5.6}));

    // Place the glass slightly above the pool's rim: at equal heights, rays could leak into the stone.
    constexpr double k_on_rim = 0.203;
    add_object(scene, make_vase(scene, m.glass), "vase", placed({1.74, k_on_rim, 3.3}));
    b.use(m.blue_glass);
    b.sphere({0, 0.13f, 0}, 0.13f, 48, 23);
    add_object(scene, add_mesh(scene, b, "blue ball"), "blue ball", placed({1.72, k_on_rim, 4.1}));
    b.use(m.amber_glass);
    b.sphere({0, 0.09f, 0}, 0.09f, 48, 23);
    add_object(scene, add_mesh(scene, b, "amber ball"), "amber ball", placed({1.80, k_on_rim, 3.78}));

    // Masts in the corners carry the wires from which the mobile hangs.
    const glm::vec3 corners[] = {{k_left_x - 0.05f, 5.3f, k_back_z},
                                 {k_right_x + 1.4f, 7.0f, k_back_z - 1.4f},
                                 {k_right_x, 5.3f, k_back_z + k_right_bays * k_bay + 0.1f},
                                 {k_left_x, 1.0f, k_back_z + 0.45f + 5 * 2.9f}};
    const glm::vec3 knot(0, 6.03f, 0);
    for (const glm::vec3& foot : corners) {
        const glm::vec3 top(foot.x, 8.1f, foot.z);
        b.use(m.bronze);
        const glm::vec3 mast[] = {foot, top};
        const float radii[] = {0.05f, 0.03f};
        b.tube(mast, radii, 12);
        b.use(m.gold);
        b.sphere(top + glm::vec3(0, 0.06f, 0), 0.08f, 24, 13);
        // The wire sags a little.
        b.use(m.iron);
        std::vector<glm::vec3> wire;
        for (int i = 0; i <= 24; ++i) {
            const float t = static_cast<float>(i) / 24;
            wire.push_back(glm::mix(top, knot, t) - glm::vec3(0, 0.8f * t * (1 - t), 0));
        }
        b.tube(wire, 0.009f, 6);
    }
    b.use(m.gold);
    b.sphere(knot, 0.07f, 24, 13);
    add_object(scene, add_mesh(scene, b, "rigging"), "rigging", glm::dmat4(1));
}

}   // namespace gnomon::scene::kinetic
