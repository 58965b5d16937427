// SPDX-License-Identifier: Apache-2.0
// The mobile: arms that hang from arms, each turning about its own wire at its own speed. Six rigid groups; all that moves
// in this scene but the camera.

#include <glm/gtc/matrix_transform.hpp>

#include "scene/kinetic.h"

namespace gnomon::scene::kinetic {

namespace {

// Hangs at a point of its parent, turns about +Y, and sways a little.
class TurnTrack final : public TransformTrack {
 public:
    TurnTrack(const glm::dvec3& at, double start, double speed, double sway)
        : at_(at), start_(start), speed_(speed), sway_(sway)
    {
    }
    glm::dmat4 evaluate(double time) const override
    {
        const double t = std::min(std::max(time, 0.0), k_end);
        const double angle = start_ + speed_ * t + sway_ * std::sin(1.3 * t + start_);
        const double tilt = 0.4 * sway_ * std::sin(1.7 * t + 2 * start_);
        glm::dmat4 m = placed(at_, angle);
        return glm::rotate(m, tilt, glm::dvec3(0, 0, 1));
    }
    std::vector<Interval> changing() const override { return {{0, k_end}}; }

 private:
    glm::dvec3 at_;
    double start_, speed_, sway_;   // radians, radians a second, radians
};

// A leaf-shaped plate that hangs from the origin by a short wire; its plane holds the arm's direction.
void add_petal(MeshBuilder& b, const Materials& m, MaterialId color, const glm::vec3& at, float wire, float length,
               float width, float lean)
{
    b.use(m.iron);
    const glm::vec3 line[] = {at, at - glm::vec3(0, wire + 0.02f, 0)};
    b.tube(line, 0.006f, 6);
    std::vector<glm::vec2> p;
    constexpr int steps = 40;
    for (int i = 0; i < steps; ++i) {
        const float a = static_cast<float>(2 * k_pi) * static_cast<float>(i) / steps;
        const float fall = 0.5f - 0.5f * std::cos(a);   // 0 at the tip, 1 at the far end
        p.emplace_back(0.5f * width * std::sin(a) * (0.55f + 0.75f * fall), -length * fall);
    }
    // Counter-clockwise seen from +Z.
    std::vector<glm::vec2> turned(p.rbegin(), p.rend());
    const glm::mat4 place = glm::translate(glm::mat4(1), at - glm::vec3(0, wire, 0)) *
                            glm::rotate(glm::mat4(1), lean, glm::vec3(0, 1, 0)) *
                            glm::rotate(glm::mat4(1), 0.35f, glm::vec3(1, 0, 0));
    b.place(place);
    b.use(color);
    b.plate(turned, {0, -0.6f * length}, 0.022f, 0.006f);
    b.place(glm::mat4(1));
}

void add_disc(MeshBuilder& b, const Materials& m, MaterialId color, const glm::vec3& at, float wire, float radius,
              float lean)
{
    b.use(m.iron);
    const glm::vec3 line[] = {at, at - glm::vec3(0, wire + 0.01f, 0)};
    b.tube(line, 0.006f, 6);
    b.place(glm::translate(glm::mat4(1), at - glm::vec3(0, wire + radius, 0)) *
            glm::rotate(glm::mat4(1), lean, glm::vec3(0, 1, 0)));
    b.use(color);
    std::vector<glm::vec2> p = arc({0, 0}, radius, 0, static_cast<float>(2 * k_pi), 64);
    p.pop_back();
    b.plate(p, {0, 0}, 0.022f, 0.006f);
    b.place(glm::mat4(1));
}

void add_drop(MeshBuilder& b, const Materials& m, MaterialId glass, const glm::vec3& at, float wire, float radius)
{
    b.use(m.iron);
    const glm::vec3 line[] = {at, at - glm::vec3(0, wire, 0)};
    b.tube(line, 0.006f, 6);
    b.use(m.gold);
    b.sphere(at - glm::vec3(0, wire + 0.01f, 0), 0.025f, 16, 9);
    b.use(glass);
    b.sphere(at - glm::vec3(0, wire + 0.03f + radius, 0), radius, 64, 31);
}

// An arm from -left to +right that bows up in between, with beads at its ends and its middle.
void add_arm(MeshBuilder& b, const Materials& m, float wire, float left, float right)
{
    b.use(m.iron);
    const glm::vec3 line[] = {{0, 0, 0}, {0, -wire, 0}};
    b.tube(line, 0.007f, 6);
    b.use(m.bronze);
    const float bow = 0.10f * (left + right);
    const glm::vec3 knots[] = {{-left, -wire - bow, 0}, {-0.55f * left, -wire - 0.28f * bow, 0}, {0, -wire, 0},
                               {0.55f * right, -wire - 0.28f * bow, 0}, {right, -wire - bow, 0}};
    b.tube(smooth_path(knots, 10), 0.020f, 12);
    b.use(m.gold);
    for (const int i : {0, 2, 4}) b.sphere(knots[i], 0.034f, 20, 11);
}
glm::vec3 arm_end(float wire, float left, float right, float x)
{
    return {x, -wire - 0.10f * (left + right), 0};
}

}   // namespace

void add_mobile(Scene& scene, const Materials& m)
{
    MeshBuilder b;
    const auto hang = [&](const char* name, NodeId parent, const glm::vec3& at, double start, double speed,
                          double sway) {
        const NodeId node = scene.add_node(name, parent);
        scene.nodes[node].transform = std::make_shared<TurnTrack>(glm::dvec3(at), start, speed, sway);
        scene.nodes[node].mesh = add_mesh(scene, b, name);
        return node;
    };

    // The great arm.
    add_arm(b, m, 0.35f, 1.75f, 1.35f);
    const NodeId great = hang("mobile: great arm", none, {0, 6.42f, 0}, 0.35, 0.21, 0.03);
    const glm::vec3 left = arm_end(0.35f, 1.75f, 1.35f, -1.75f), right = arm_end(0.35f, 1.75f, 1.35f, 1.35f);

    // On its left: a red sail, and an arm of leaves.
    add_arm(b, m, 0.25f, 0.95f, 0.75f);
    add_petal(b, m, m.red, arm_end(0.25f, 0.95f, 0.75f, -0.95f), 0.06f, 1.30f, 0.78f, 0.25f);
    const NodeId second = hang("mobile: second arm", great, left, 0.9, -0.34, 0.05);

    add_arm(b, m, 0.28f, 0.55f, 0.50f);
    add_petal(b, m, m.black, arm_end(0.28f, 0.55f, 0.50f, -0.55f), 0.05f, 0.80f, 0.46f, 0.5f);
    add_drop(b, m, m.amber_glass, arm_end(0.28f, 0.55f, 0.50f, 0.50f), 0.28f, 0.16f);
    hang("mobile: third arm", second, arm_end(0.25f, 0.95f, 0.75f, 0.75f), 2.1, 0.55, 0.06);

    // On its right: discs, and glass below them.
    add_arm(b, m, 0.45f, 0.80f, 0.90f);
    add_disc(b, m, m.yellow, arm_end(0.45f, 0.80f, 0.90f, 0.90f), 0.08f, 0.40f, 0.3f);
    const NodeId fourth = hang("mobile: fourth arm", great, right, 0.4, -0.42, 0.05);

    add_arm(b, m, 0.30f, 0.55f, 0.62f);
    add_disc(b, m, m.blue, arm_end(0.30f, 0.55f, 0.62f, -0.55f), 0.06f, 0.27f, -0.2f);
    const NodeId fifth =
        hang("mobile: fifth arm", fourth, arm_end(0.45f, 0.80f, 0.90f, -0.80f), 1.2, 0.62, 0.06);

    add_arm(b, m, 0.25f, 0.36f, 0.40f);
    add_petal(b, m, m.white, arm_end(0.25f, 0.36f, 0.40f, -0.36f), 0.04f, 0.55f, 0.30f, 0.1f);
    add_drop(b, m, m.blue_glass, arm_end(0.25f, 0.36f, 0.40f, 0.40f), 0.20f, 0.11f);
    hang("mobile: sixth arm", fifth, arm_end(0.30f, 0.55f, 0.62f, 0.62f), 0.2, -0.75, 0.07);
}

}   // namespace gnomon::scene::kinetic
