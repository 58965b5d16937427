// SPDX-License-Identifier: Apache-2.0
#pragma once
// The lights with size of a scene: its emissive surfaces, as planar polygons.
//
// Every triangle of an emissive material (textured or not, whatever other lights there are; unlit materials show a
// colour and emit nothing) belongs to one light. Two triangles of a part that share an edge and lie in one plane become
// one quadrilateral if that is convex, and polygons of one colour that touch in one plane form a flat figure, such as a
// disc. As long as a scene has no more figures than SizedLightOptions::most_lights, each is a light of its own. Beyond
// that, a tree over their polygons groups static and dynamic ones by place, and each of its leaves is one light. What
// emits within a cone is in groups of its own.
//
// A light has a fixed set of sample places, for its visibility: a (0, 2)-sequence [Sobol' 1967], the same for every
// point that the light is seen from. Place i is bit i of a visibility mask. Places are in Morton order, so that
// neighbours in the list are neighbours on the light.
//
// Cost: one pass over the emissive triangles, in frames in which one of them changed. Memory: 48 bytes a place.

#include <cstdint>
#include <span>
#include <vector>

#include "scene/face_tree.h"
#include "scene/sized_face.h"
#include "scene/state.h"

namespace gnomon::scene {

struct SizedLightOptions {
    int most_lights = 64;   // flat figures; a scene with more of them has most_clusters lights at the most
    int most_clusters = 16;
    int places = 256;           // of a light at the most; a power of two
    int places_in_all = 1024;   // of all lights together; halved places until they fit
    int least_places = 16;      // of a light, however many lights there are
    int cells = 8;              // a side, of the grid of mean radiances over a textured polygon
};

/// A sample place of a light.
struct SizedPlace {
    glm::vec3 position{0};
    std::uint32_t face = 0;   // of SizedLight::faces
    glm::vec3 radiance{0};    // there, filtered over the part that the place stands for
    float area = 0;           // of that part; the sum over all places is the light's area, up to rounding
};

struct SizedLight {
    std::vector<SizedFace> faces;   // one: a polygon; more: a flat figure or a cluster
    FaceTree tree;                  // over many faces
    std::vector<SizedPlace> places;
    /// Of a textured polygon: mean radiances over the cells [i / n, (i + 1) / n] x [j / n, (j + 1) / n] of the unit
    /// square (SizedFace::at), row by row (j); n = `cells`. Empty for a polygon of one radiance and for clusters.
    std::vector<glm::vec3> cell_radiance;
    int cells = 1;
    bool dynamic = false;   // its faces may move; static and dynamic faces are never in one light
    glm::vec3 centre{0};    // of a sphere around all faces
    float radius = 0;

    /// Of a light whose faces lie in one plane and have one front: a convex polygon around all of them, of three or
    /// four corners; the face itself if there is one only. Of a cluster: 0 corners.
    SizedFace outline{.corners = 0};
    bool is_flat() const { return outline.corners > 0; }

    /// Within which all faces emit.
    EmissionCone cone{};
};

/// What the lights stand for.
struct SizedLightCounts {
    std::uint64_t triangles = 0;   // emissive and visible
    std::uint64_t polygons = 0;    // faces
    std::uint64_t lights = 0;
};

class SizedLights {
 public:
    explicit SizedLights(const SizedLightOptions& options = {}) : options_(options) {}

    /// Follows the state, after its advance(). The first call and one with another state make everything anew.
    void update(const SceneState& state);

    /// Drops the lights: the next update() makes everything anew.
    void forget();

    std::span<const SizedLight> lights() const { return lights_; }
    bool empty() const { return lights_.empty(); }
    const SizedLightCounts& counts() const { return counts_; }
    const SizedLightOptions& options() const { return options_; }
    /// Increases whenever lights() changed in any way.
    std::uint32_t version() const { return version_; }
    std::size_t bytes() const;

 private:
    bool must_follow(const SceneState& state) const;
    void make(const SceneState& state);

    SizedLightOptions options_;
    const SceneState* state_ = nullptr;   // of the last update
    bool any_emissive_ = false;           // some object's material is
    std::vector<char> emissive_;          // by object
    std::vector<SizedLight> lights_;
    SizedLightCounts counts_;
    std::uint32_t version_ = 0;
};

/// Point i of the (0, 2)-sequence of `count` points in Morton order, in [0, 1); `count` is a power of two.
std::vector<glm::vec2> sequence_in_morton_order(int count);

}   // namespace gnomon::scene
