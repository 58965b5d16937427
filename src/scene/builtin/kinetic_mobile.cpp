// SPDX-License-Identifier: Apache-2.0
// The mobile: arms that hang from arms, each turning about its own wire at its own speed. Its six rigid groups are all
// that moves in this scene, apart from the camera.

#include <glm/gtc/matrix_transform.hpp>

#include "scene/builtin/kinetic.h"

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
    b.sphere(at - glm::vec3(0, wire + 0.03f + radius, 0), radius, 48, 23);
}

// An arm that hangs from the origin and bows up between its ends, with beads at the ends and the middle.
struct Arm {
    float wire, left, right;   // lengths

    float bow() const { return 0.10f * (left + right); }
    glm::vec3 left_end() const { return {-left, -wire - bow(), 0}; }
    glm::vec3 right_end() const { return {right, -wire - bow(), 0}; }
};
void add_arm(MeshBuilder& b, const Materials& m, const Arm& arm)
{
    const glm::vec3 middle(0, -arm.wire, 0), sag(0, -0.28f * arm.bow(), 0);
    b.use(m.iron);
    const glm::vec3 line[] = {{0, 0, 0}, middle};
    b.tube(line, 0.007f, 6);
    b.use(m.bronze);
    const glm::vec3 knots[] = {arm.left_end(), middle + sag - glm::vec3(0.55f * arm.left, 0, 0), middle,
                               middle + sag + glm::vec3(0.55f * arm.right, 0, 0), arm.right_end()};
    b.tube(smooth_path(knots, 10), 0.024f, 12);
    b.use(m.gold);
    for (const int i : {0, 2, 4}) b.sphere(knots[i], 0.040f, 20, 11);
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
    const Arm great_arm{0.30f, 2.2f, 1.7f};
    add_arm(b, m, great_arm);
    const NodeId great = hang("mobile: great arm", none, {0, 6.0f, 0}, 0.35, 0.21, 0.03);

    // On its left: a red sail, and an arm of leaves.
    const Arm second_arm{0.25f, 1.15f, 0.95f};
    add_arm(b, m, second_arm);
    add_petal(b, m, m.red, second_arm.left_end(), 0.06f, 1.55f, 0.95f, 0.25f);
    const NodeId second = hang("mobile: second arm", great, great_arm.left_end(), -1.2, -0.12, 0.05);

    const Arm third_arm{0.28f, 0.70f, 0.62f};
    add_arm(b, m, third_arm);
    add_petal(b, m, m.black, third_arm.left_end(), 0.05f, 0.95f, 0.55f, 0.5f);
    add_drop(b, m, m.amber_glass, third_arm.right_end(), 0.28f, 0.20f);
    hang("mobile: third arm", second, second_arm.right_end(), 2.1, 0.55, 0.06);

    // On its right: discs, and glass below them.
    const Arm fourth_arm{0.40f, 1.0f, 1.1f};
    add_arm(b, m, fourth_arm);
    add_disc(b, m, m.yellow, fourth_arm.right_end(), 0.08f, 0.50f, -0.65f);
    const NodeId fourth = hang("mobile: fourth arm", great, great_arm.right_end(), -0.2, -0.10, 0.05);

    const Arm fifth_arm{0.28f, 0.65f, 0.72f};
    add_arm(b, m, fifth_arm);
    add_disc(b, m, m.blue, fifth_arm.left_end(), 0.06f, 0.34f, 1.1f);
    const NodeId fifth = hang("mobile: fifth arm", fourth, fourth_arm.left_end(), 1.2, 0.62, 0.06);

    const Arm sixth_arm{0.25f, 0.42f, 0.46f};
    add_arm(b, m, sixth_arm);
    add_petal(b, m, m.white, sixth_arm.left_end(), 0.04f, 0.66f, 0.38f, 0.1f);
    add_drop(b, m, m.blue_glass, sixth_arm.right_end(), 0.20f, 0.14f);
    hang("mobile: sixth arm", fifth, fifth_arm.right_end(), 0.2, -0.75, 0.07);
}

}   // namespace gnomon::scene::kinetic
