// SPDX-License-Identifier: Apache-2.0
#pragma once
// Rays against a scene, on Embree. The only header of this folder that others need; no Embree type leaves it.
//
// Two scenes, because this Embree allows one level of instances: everything static, committed once and kept; and the
// dynamic objects, one instance per rigid group or deforming object, of which only the small top level is rebuilt, and
// only in frames in which one of them moved. Closest hit: the second scene starts with the first's distance. Any hit:
// the second is asked only where the first let the ray pass. 'Dynamic objects only' is simply the second scene.
//
// Repeatable by construction: trees are built by one thread from inputs that do not depend on earlier frames (a
// deforming mesh is built in its rest shape and refitted), so equal distances fall the same way every time. Robust mode
// throughout.

#include <cstdint>
#include <memory>
#include <span>

#include "ray/queue.h"
#include "scene/state.h"

namespace gnomon::ray {

/// What rays are tested against. `one_tree`: everything, in a single tree: what a ray tracer without our split would
/// do, for comparison (see keep_one_tree).
enum class Against : std::uint8_t { everything, static_only, dynamic_only, one_tree };
/// What closest-hit rays see of one-sided surfaces: both sides, or their front alone (camera and mirror rays).
enum class Sides : std::uint8_t { both, front };

/// How rays meet an object. `never`: it is squeezed flat by the matrix that places it. `roughly`: so aslant that rays
/// may meet it elsewhere than where its corners are.
enum class Meeting : std::uint8_t { never, roughly, truly };

/// One object's triangles as the rays meet them. Positions and normals are in world space if `to_world` is null, else
/// in a space that `to_world` takes to the world.
struct ObjectGeometry {
    const scene::Mesh* mesh = nullptr;   // triangles, texture coordinates, parts
    const glm::vec3* positions = nullptr;
    const glm::vec3* normals = nullptr;    // null: the triangle's own
    const glm::vec4* tangents = nullptr;   // null: none
    const glm::mat4* to_world = nullptr;
    const glm::mat3* normal_to_world = nullptr;   // inverse transpose, not normalised; null with to_world
    bool mirrored = false;   // world winding is the reverse of the mesh's: the front is clockwise in corners()

    /// World-space corners of one triangle.
    void corners(std::uint32_t triangle, glm::vec3 (&p)[3]) const
    {
        const glm::uvec3 index = mesh->triangles[triangle];
        for (int i = 0; i < 3; ++i) {
            const glm::vec3 q = positions[index[i]];
            p[i] = to_world ? transform_point(*to_world, q) : q;
        }
    }
};

struct Hit {
    float t = 0, u = 0, v = 0;
    scene::ObjectId object = scene::none;
    std::uint32_t triangle = 0;
};

struct RaySceneStatistics {
    std::uint64_t static_triangles = 0;   // in the static scene, flattened and instanced
    std::uint64_t instances = 0;          // in the dynamic objects' scene
    std::uint64_t bytes = 0;              // Embree's memory and our baked vertices
    double build_ms = 0;                  // everything, at construction
    std::uint64_t touched = 0;            // instances and refitted meshes handled by the last update
};

struct KdCounts;   // kdtree.h

class RayScene {
 public:
    /// Builds from the state's present. Keeps a reference to the state's scene, not to the state.
    explicit RayScene(const scene::SceneState& state);
    ~RayScene();
    RayScene(const RayScene&) = delete;
    RayScene& operator=(const RayScene&) = delete;

    /// Follows one advance() of the state it was built from. Cost: what moved, and the dynamic objects' top level if
    /// any did.
    void update(const scene::SceneState& state);

    /// Nearest surface along each ray; transparent ones count. rays[begin, end) only; hits must be sized. Thread-safe.
    /// @param against  all but `one_tree`
    void closest(const RayQueue& rays, std::size_t begin, std::size_t end, Hits& hits, Sides sides,
                 Against against = Against::everything) const;
    /// occluded[i] = 1 where something that blocks light lies between tnear and tfar of ray begin + i, else 0.
    /// Thread-safe.
    void occluded(const RayQueue& rays, std::size_t begin, std::size_t end, std::uint8_t* occluded,
                  Against against = Against::everything) const;

    /// The same by single rays: the twins of the packets, for tests and for lone rays.
    Hit closest_single(const glm::vec3& origin, float tnear, const glm::vec3& direction, float tfar, Sides sides) const;
    bool occluded_single(const glm::vec3& origin, float tnear, const glm::vec3& direction, float tfar,
                         Against against = Against::everything) const;

    /// Keeps one more tree over the same geometries and instances, rebuilt whenever something moves: the opponent of
    /// benchmarks, never used by a renderer.
    void keep_one_tree();

    /// From now on answers queues by a CountingKdTree instead of Embree: far slower, the same up to edges and surfaces
    /// in one place, and counted. For studies.
    void trace_on_kdtree(const scene::SceneState& state);
    /// What that tree did for rays of one purpose since the last update; zeros without it.
    KdCounts kdtree_work(RayClass purpose) const;

    const ObjectGeometry& geometry(scene::ObjectId object) const;
    /// Whether an object moves by itself: it deforms, or somebody moved it by hand, out of what stands still or out of
    /// its group.
    bool has_own_instance(scene::ObjectId object) const;
    /// Whether an object is among what moves: what `static_only` does not meet.
    bool moves(scene::ObjectId object) const;
    /// How rays meet it while it is visible.
    Meeting meeting(scene::ObjectId object) const;
    /// How many static objects somebody moved by hand for the first time. Counts up: what was remembered of static
    /// things is void then.
    std::uint32_t promoted() const;
    /// Around everything visible, as of the last update.
    Box3 bounds() const;
    RaySceneStatistics statistics() const;

    /// Rays traced together: 16 where the processor has AVX-512, else 8 (4 without AVX).
    static int packet_width();

 private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}   // namespace gnomon::ray
