// SPDX-License-Identifier: Apache-2.0
#pragma once
// Declarations that the parts of builtin:kinetic share. Each part has a file; kinetic_scene.cpp assembles them.
//
// The courtyard in metres, +Y up, the camera on the +Z side: the sundial at the origin, a pool before it, arcades at
// the back and at the right, a balustrade with a view at the left, where the sun stands.

#include <span>

#include "base/random.h"
#include "scene/builtin/shapes.h"
#include "scene/scene.h"

namespace gnomon::scene::kinetic {

// Plan of the courtyard.
inline constexpr float k_bay = 2.4f;   // from column to column
inline constexpr int k_back_bays = 6;
inline constexpr int k_right_bays = 5;
inline constexpr float k_back_z = -6.2f;         // axis of the back arcade's columns
inline constexpr float k_right_x = 7.2f;         // axis of the right arcade's columns
inline constexpr float k_left_x = -7.2f;         // axis of the balustrade
inline constexpr float k_arcade_depth = 2.7f;    // from the columns' axis to the wall behind
inline constexpr float k_arcade_floor = 0.32f;   // two steps above the yard
inline constexpr float k_springing = 3.05f;      // where the arches begin
inline constexpr float k_eaves = 4.75f;          // top of the arcades' walls

// Time.
inline constexpr int k_frames = 120;
inline constexpr double k_fps = 24;
inline constexpr double k_end = (k_frames - 1) / k_fps;

struct Materials {
    MaterialId limestone, paving, plaster, marble, dial, terracotta, roof, iron, bronze, gold, mirror, water,
        pool_floor, glass, amber_glass, blue_glass, red, black, yellow, blue, white, bark, soil, ivy, orange_leaf,
        box_leaf, cypress, olive, lily, blossom, orange, flame, grass, hill_near, hill_far;
};
Materials add_materials(Scene& scene);

/// Fraction of the sky, 0 to 1, that a point of the courtyard sees: estimated by formula from the arcades' roofs, the
/// distance to the ground and the slope of the surface.
float open_sky(const glm::vec3& point, const glm::vec3& normal);

MeshId add_mesh(Scene& scene, MeshBuilder& builder, const char* name);
NodeId add_object(Scene& scene, MeshId mesh, const char* name, const glm::dmat4& local, NodeId parent = none);
/// A transform: rotation about +Y in radians, then translation.
glm::dmat4 placed(const glm::dvec3& at, double turn = 0, double scale = 1);

MeshId make_column(Scene& scene, const Materials& materials);
void add_arcades(Scene& scene, const Materials& materials);
void add_tower(Scene& scene, const Materials& materials);
void add_courtyard(Scene& scene, const Materials& materials);
void add_sundial(Scene& scene, const Materials& materials);
void add_ornaments(Scene& scene, const Materials& materials);
void add_trees(Scene& scene, const Materials& materials);
void add_climbers(Scene& scene, const Materials& materials);
void add_mobile(Scene& scene, const Materials& materials);
void add_landscape(Scene& scene, const Materials& materials);
void add_camera(Scene& scene);

}   // namespace gnomon::scene::kinetic
