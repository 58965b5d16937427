// SPDX-License-Identifier: Apache-2.0
// Single pieces of the arcades: the column, and the tower in their corner.

#include <glm/gtc/matrix_transform.hpp>

#include "scene/builtin/kinetic.h"

namespace gnomon::scene::kinetic {

MeshId make_column(Scene& scene, const Materials& m)
{
    MeshBuilder b;
    b.open_sky([](const glm::vec3& p, const glm::vec3& n) {
        return (0.70f + 0.25f * n.z) * (0.75f + 0.25f * glm::smoothstep(0.0f, 0.6f, p.y)) * (n.y < 0 ? 0.6f : 1.0f);
    });
    b.use(m.limestone);
    const float height = k_springing - k_arcade_floor;
    b.box({-0.29f, 0, -0.29f}, {0.29f, 0.11f, 0.29f}, 0.015f);
    // Base, shaft with entasis, neck and capital.
    std::vector<glm::vec2> p{{0.25f, 0.11f}};
    const auto bulge = [&](float r, float y, float size) {
        for (const glm::vec2& q : arc({r, y + size}, size, -1.35f, 1.35f, 6)) p.push_back(q);
    };
    bulge(0.225f, 0.11f, 0.045f);
    p.insert(p.end(), {{0.225f, 0.205f}, {0.205f, 0.225f}, {0.205f, 0.24f}});
    bulge(0.20f, 0.24f, 0.028f);
    p.insert(p.end(), {{0.198f, 0.30f}, {0.198f, 0.32f}, {0.188f, 0.35f}});
    const float top = height - 0.42f;
    for (int i = 0; i <= 14; ++i) {
        const float t = static_cast<float>(i) / 14;
        p.emplace_back(0.186f - 0.028f * t * t, glm::mix(0.37f, top, t));
    }
    bulge(0.158f, top, 0.022f);
    p.insert(p.end(), {{0.158f, top + 0.05f}, {0.158f, top + 0.14f}});
    for (int i = 0; i <= 8; ++i) {   // echinus: a bell that opens
        const float t = static_cast<float>(i) / 8;
        p.emplace_back(0.162f + 0.098f * t * t, top + 0.15f + 0.15f * t);
    }
    p.insert(p.end(), {{0.262f, top + 0.32f}, {0.2f, top + 0.325f}});
    b.lathe(make_outline(p, false), 32);
    // Eight leaves under the abacus.
    for (int i = 0; i < 8; ++i) {
        b.place(glm::rotate(glm::mat4(1), static_cast<float>(i) * 0.7854f, glm::vec3(0, 1, 0)));
        const glm::vec3 stem[] = {{0.165f, top + 0.06f, 0},
                                  {0.185f, top + 0.14f, 0},
                                  {0.235f, top + 0.225f, 0},
                                  {0.285f, top + 0.265f, 0},
                                  {0.315f, top + 0.26f, 0}};
        const float widths[] = {0.02f, 0.045f, 0.042f, 0.026f, 0.010f};
        std::vector<float> radii;
        const auto path = smooth_path(stem, 2);
        for (std::size_t k = 0; k < path.size(); ++k) {
            const float at = static_cast<float>(k) / 2;
            const auto j = std::min<std::size_t>(static_cast<std::size_t>(at), 3);
            radii.push_back(glm::mix(widths[j], widths[j + 1], at - static_cast<float>(j)));
        }
        b.tube(path, radii, 6);
    }
    b.place(glm::mat4(1));
    b.box({-0.29f, height - 0.10f, -0.29f}, {0.29f, height, 0.29f}, 0.015f);
    return add_mesh(scene, b, "column");
}

// With shuttered windows towards the yard.
void add_tower(Scene& scene, const Materials& m)
{
    MeshBuilder b;
    b.open_sky(open_sky);
    const float x0 = k_right_x - 0.3f, z1 = k_back_z + 0.3f, size = 3.4f, top = 6.1f;
    b.use(m.plaster);
    b.box({x0, -0.1f, z1 - size}, {x0 + size, top, z1}, 0.03f);
    b.use(m.limestone);
    b.box({x0 - 0.05f, -0.1f, z1 - size}, {x0 + size, 0.8f, z1 + 0.05f}, 0.03f);
    b.box({x0 - 0.06f, 4.42f, z1 - size}, {x0 + size, 4.56f, z1 + 0.06f}, 0.03f);
    b.box({x0 - 0.10f, top - 0.1f, z1 - size - 0.1f}, {x0 + size + 0.1f, top + 0.05f, z1 + 0.10f}, 0.03f);
    b.box({x0 - 0.20f, top + 0.05f, z1 - size - 0.2f}, {x0 + size + 0.2f, top + 0.16f, z1 + 0.20f}, 0.03f);
    for (const bool to_yard : {true, false}) {
        // Its own +z is out of the wall.
        const glm::mat4 wall =
            to_yard ? glm::mat4(placed({x0 + 1.5, 5.28, z1})) : glm::mat4(placed({x0, 5.28, z1 - 1.2}, -k_pi / 2));
        b.place(wall);
        b.use(m.limestone);
        b.box({-0.34f, -0.42f, -0.1f}, {0.34f, -0.33f, 0.09f}, 0.02f);
        b.use(m.iron);
        b.box({-0.24f, -0.33f, -0.1f}, {0.24f, 0.36f, 0.01f}, 0);
        b.use(m.blue);
        for (const float side : {-1.0f, 1.0f})
            b.box({side * 0.37f - 0.13f, -0.33f, 0}, {side * 0.37f + 0.13f, 0.36f, 0.05f}, 0.012f);
    }
    b.place(glm::mat4(1));
    b.use(m.roof);
    const glm::vec3 c(x0 + size / 2, top + 1.35f, z1 - size / 2);
    const float h = size / 2 + 0.3f;
    for (int side = 0; side < 4; ++side) {
        b.place(glm::translate(glm::mat4(1), c) *
                glm::rotate(glm::mat4(1), static_cast<float>(side) * static_cast<float>(k_pi / 2), glm::vec3(0, 1, 0)));
        constexpr int courses = 10;
        for (int i = 0; i < courses; ++i) {
            const float t0 = static_cast<float>(i) / courses, t1 = static_cast<float>(i + 1) / courses;
            const float y0 = -1.2f * t1, y1 = -1.2f * t0;
            b.flat_quad({-h * t1, y0 + 0.03f, h * t1}, {h * t1, y0 + 0.03f, h * t1}, {h * t0, y1, h * t0},
                        {-h * t0, y1, h * t0}, glm::normalize(glm::vec3(0, h, 1.2f)));
            b.flat_quad({-h * t1, y0, h * t1}, {h * t1, y0, h * t1}, {h * t1, y0 + 0.03f, h * t1},
                        {-h * t1, y0 + 0.03f, h * t1}, {0, 0, 1});
        }
    }
    add_object(scene, add_mesh(scene, b, "tower"), "tower", glm::dmat4(1));
}

}   // namespace gnomon::scene::kinetic
