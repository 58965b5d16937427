// SPDX-License-Identifier: Apache-2.0
#pragma once
// What importers find out once about surfaces whose files do not say it: which triangles of alpha mode BLEND are
// opaque, and which shells are outlines. Call before Scene::finish().

#include "scene/scene.h"

namespace gnomon::scene {

/// Gives the triangles of alpha mode BLEND whose alpha is 1 everywhere an opaque copy of their material: exporters mark
/// whole models as BLEND for a few hairs. A triangle is opaque if its factor and its vertex colours are, and every
/// texel of the finest level that a bilinear filter may read on it. Triangles of a mesh may change places. Cost: one
/// pass over the texels of such textures and over the triangles.
/// @param keep  materials whose alpha may change later: left alone
void find_solid_blends(Scene& scene, const std::vector<bool>& keep = {});

struct OutlineOptions {
    float reach = 0.05f;                    // of a shell's diagonal: how far the surface that it follows may be
    std::size_t samples = 200;              // vertices of a shell that are looked at
    std::size_t most_triangles = 500'000;   // of a scene: larger ones are not looked through
};
/// Finds inverted hulls, which toon shading draws around a body as its outline, and gives them a copy of their material
/// with Material::outline. A part of a mesh is one if it is one-sided and closed, all its connected pieces look
/// inwards, and everywhere another surface lies within a small distance of it. A room is none, because its walls have
/// nothing near them.
/// @return  the number of parts that were found
std::size_t find_outlines(Scene& scene, const OutlineOptions& options = {});

/// Turns normals that point away from the fronts of nearly all triangles of a part of a mesh: exporters that mirror a
/// mesh forget them. If such a part is one-sided, encloses a volume and is wound inwards, its triangles are turned
/// instead. Outlines stay as they are, so call find_outlines() before.
/// @return  the number of parts that were turned
std::size_t turn_surfaces(Scene& scene);

/// Finds domes of skies: objects that lie around all others and are far larger, and that are unlit, or opaque spheres
/// or halves of spheres with a floor in them, which may be as wide. They get a copy of their material with
/// Material::outline, because they must not keep the light of an environment from what they surround.
/// @return  the number of objects that were found
std::size_t find_sky_domes(Scene& scene);
inline constexpr float k_dome =
    6;   // diagonals of the rest that a dome has at least: what frames the rest stays inside
/// Whether something with this box is flat, level, and within a dome.
bool is_floor_of_dome(const Box3& box, const Box3& dome);

/// If every surface of a scene is entirely transparent, makes them opaque: some programs write a transparency where an
/// opacity is expected. Textures and animated values are not looked at: materials that have them count as visible.
/// @return  whether it did
bool show_invisible(Scene& scene);

/// Gives one-sided parts that enclose a volume and are wound inwards a copy of their material with Material::outline:
/// they are seen through from outside, and then let light in from there as well.
/// @return  the number of parts
std::size_t open_shells(Scene& scene);
/// Whether open_shells() would find any.
bool has_shells(const Scene& scene);

/// Gives meshes without tangents some, where a material has a normal map or is brushed: the mean over the triangles
/// around each vertex, as MikkTSpace has it, so that smooth surfaces have no facets. Meshes on which triangles with
/// mirrored texture coordinates share vertices keep those of their triangles, and so do textures that are turned by a
/// transform.
/// @return  the number of meshes
std::size_t add_tangents(Scene& scene);

/// Leaves out triangles where k_most_in_place of the same mesh, with the same corners and winding, are already:
/// thousands in one place are a mistake or an attack, nobody sees more than one, and no tree of boxes tells them apart.
/// Triangles without area and meshes that deform stay. A warning says how many. Cost: O(n log n) in the triangles of a
/// mesh.
/// @return  the number of triangles
std::size_t leave_out_repeats(Scene& scene);
inline constexpr std::size_t k_most_in_place = 64;

/// leave_out_repeats(), turn_surfaces(), find_sky_domes() and show_invisible(), with a warning for each repair.
void repair_surfaces(Scene& scene);

}   // namespace gnomon::scene
