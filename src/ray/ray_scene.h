// SPDX-License-Identifier: Apache-2.0
#pragma once
// Traces rays against a scene, with Embree. Other folders need this header alone; it exposes no Embree type.
//
// There are two Embree scenes, because Embree 3 allows one level of instances. The static one is committed once. The
// dynamic one holds one instance (BLAS) per rigid group, deforming object, or object that a user override promoted or
// separated from its group; only its top level (TLAS) is rebuilt, and only in frames in which something in it changed.
// Closest-hit rays enter the dynamic scene with the distance found in the static one; any-hit rays enter it only if the
// static one did not occlude them.
//
// Results are reproducible: BVHs are built by one thread from inputs that do not depend on earlier frames (a deforming
// mesh is built in its rest shape and refitted), so that ties between equal distances are resolved the same way every
// time. Embree's robust mode is on throughout.

#include <cstdint>
#include <memory>
#include <span>

#include "base/instruction_set.h"
#include "base/memory_limit.h"
#include "ray/queue.h"
#include "scene/state.h"

namespace gnomon {
class Tasks;
}

namespace gnomon::ray {

/// The objects that rays are tested against. `one_tree`: everything, in a single BVH without the split into static and
/// dynamic objects, for comparison (see keep_one_tree).
enum class Against : std::uint8_t { everything, static_only, dynamic_only, one_tree };
/// The sides of one-sided surfaces that closest-hit rays can hit: both, or only the front (camera and mirror rays).
enum class Sides : std::uint8_t { both, front };

/// How well hits on an object agree with its vertices. `never`: its instance has a singular transform, and no ray hits
/// it. `roughly`: the transform is so skewed that rounding may move hits away from the transformed vertices.
enum class Meeting : std::uint8_t { never, roughly, truly };

/// One object's triangles as rays hit them. Positions and normals are in world space if `to_world` is null, else in a
/// space that `to_world` transforms to world space.
struct ObjectGeometry {
    const scene::Mesh* mesh = nullptr;   // triangles, texture coordinates, parts
    const glm::vec3* positions = nullptr;
    const glm::vec3* normals = nullptr;    // null: the triangle's own
    const glm::vec4* tangents = nullptr;   // null: none
    const glm::mat4* to_world = nullptr;
    const glm::mat3* normal_to_world = nullptr;   // inverse transpose, not normalised; null with to_world
    bool mirrored =
        false;   // the winding in world space is the reverse of the mesh's: corners() of a front run clockwise
    glm::vec3 axis{0, 0, -1};   // the object's -Z in the space of the positions

    /// The object's -Z in the world, of any length.
    glm::vec3 world_axis() const { return to_world ? glm::mat3(*to_world) * axis : axis; }

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
    std::uint64_t instances = 0;          // in the dynamic scene
    std::uint64_t bytes = 0;              // Embree's memory and the baked vertices
    double build_ms = 0;                  // of the whole construction
    std::uint64_t touched = 0;            // instances and meshes that the last update placed or refitted
};

struct KdCounts;   // kdtree.h

class RayScene {
 public:
    /// Builds from the present state: objects that are dynamic now become instances. Keeps a reference to the state's
    /// scene, not to the state.
    /// @param limit  on RaySceneStatistics::bytes
    /// @param tasks  share the building of a large tree, and outlive this; null: the caller's thread builds it
    /// @throws MissingError      memory ran out, or the limit is exceeded
    /// @throws InterruptedError  the current work was interrupted (base/interruption.h)
    explicit RayScene(const scene::SceneState& state, const MemoryLimit& limit = MemoryLimit{},
                      Arithmetic arithmetic = Arithmetic::portable, Tasks* tasks = nullptr);
    ~RayScene();
    RayScene(const RayScene&) = delete;
    RayScene& operator=(const RayScene&) = delete;

    /// Follows one advance() of the state it was built from. Cost: the objects that changed, and the TLAS if there are
    /// any; the trees of objects that were added, and O(solids) then; the static scene is committed again after a
    /// promotion.
    /// @throws MissingError, InterruptedError  as the constructor; it is then of no use
    void update(const scene::SceneState& state);

    /// Replaces the constructor's limit for later updates.
    void limit_memory(const MemoryLimit& limit);

    /// Finds the nearest surface along rays[begin, end), transparent ones included; hits must be sized. Thread-safe.
    /// @param against  all but `one_tree`
    void closest(const RayQueue& rays, std::size_t begin, std::size_t end, Hits& hits, Sides sides,
                 Against against = Against::everything) const;
    /// Sets occluded[i] to 1 where a surface that blocks light lies between tnear and tfar of ray begin + i, else to 0.
    /// Thread-safe.
    void occluded(const RayQueue& rays, std::size_t begin, std::size_t end, std::uint8_t* occluded,
                  Against against = Against::everything) const;

    /// Whether any surface thins light (scene::thins_light()).
    bool thins_light() const;
    /// Sets to[i] to the part of light that the thinning surfaces between tnear and tfar of ray begin + i let through:
    /// the product of let_through() (light_through.h), which does not depend on the order of the hits. Surfaces that
    /// block light are not looked for. Thread-safe.
    /// @param against  all but `one_tree`
    void let_through(const RayQueue& rays, std::size_t begin, std::size_t end, glm::vec3* to,
                     Against against = Against::everything) const;

    /// The same for a single ray: the reference implementation of the packets, also used for lone rays.
    Hit closest_single(const glm::vec3& origin, float tnear, const glm::vec3& direction, float tfar, Sides sides) const;
    bool occluded_single(const glm::vec3& origin, float tnear, const glm::vec3& direction, float tfar,
                         Against against = Against::everything) const;

    /// Also keeps a single BVH over the same geometries and instances, rebuilt whenever something moves. Benchmarks
    /// compare with it; no renderer uses it.
    void keep_one_tree();

    /// From now on traces queues with a CountingKdTree instead of Embree: far slower, with the same results except at
    /// edges and coincident surfaces, and with counts. For studies.
    void trace_on_kdtree(const scene::SceneState& state);
    /// The work of that tree for rays of one purpose since the last update; zeros without it.
    KdCounts kdtree_work(RayClass purpose) const;

    /// Of an object that was removed: without a mesh.
    const ObjectGeometry& geometry(scene::ObjectId object) const;
    /// How rays hit it while it is visible.
    Meeting meeting(scene::ObjectId object) const;
    /// Bounds of everything visible, as of the last update.
    Box3 bounds() const;
    RaySceneStatistics statistics() const;

    /// Rays per packet: 16 where the processor has AVX-512, 8 with AVX, else 4.
    static int packet_width();

 private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}   // namespace gnomon::ray
