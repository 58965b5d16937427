// SPDX-License-Identifier: Apache-2.0
#pragma once
// Moves a scene that lies far from the origin of its coordinates to it.
//
// Rays, bounds and cached places are kept in single precision, whose step grows with the coordinates: at 300,000 metres
// from the origin, as in models of cities in survey coordinates, a ray that leaves a surface starts 0.6 metres above
// it. The translations of root nodes are therefore reduced in double precision before anything is computed from them,
// and the library's interface adds what was subtracted to every position that it reports, and subtracts it from those
// that it takes (api::SceneStamps::origin).
//
// Cost: one matrix for each node; no vertex is visited.

#include "scene/scene.h"

namespace gnomon::scene {

/// Subtracts an origin from the world's coordinates if most of the scene's triangles lie far from the present one,
/// compared with their extent. The origin is a multiple of a power of two that is no smaller than the extent, so that
/// subtracting it from a vertex in single precision is exact. A function of the scene alone.
///
/// Unchanged: a scene near the origin; one in which a mesh that moves or deforms has vertices that are far from the
/// origin of its own coordinates, because rays are traced there; and one with skins, which joints place.
/// @pre finished
/// @return what was subtracted
glm::dvec3 bring_near(Scene& scene);

/// The track of a root node, with `origin` subtracted from its translation.
std::shared_ptr<const TransformTrack> nearer_track(std::shared_ptr<const TransformTrack> track,
                                                   const glm::dvec3& origin);

/// A matrix to the world whose origin differs by `offset`.
inline glm::dmat4 translated(glm::dmat4 to_world, const glm::dvec3& offset)
{
    if (offset != glm::dvec3(0)) to_world[3] += glm::dvec4(offset, 0);
    return to_world;
}

}   // namespace gnomon::scene
