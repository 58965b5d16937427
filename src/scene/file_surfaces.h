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

}   // namespace gnomon::scene
