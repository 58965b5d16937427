// SPDX-License-Identifier: Apache-2.0
#pragma once
// The implementation of RayScene. Private to this folder: build.cpp constructs it, update.cpp follows the scene from
// frame to frame, ray_scene.cpp traces rays.
//
// There are two Embree scenes: `still`, whose geometries have world-space vertices or are instances of meshes that many
// static objects share; and `moving`, where each solid is an instance of a BLAS of its own. Each object is in one of
// them.

#include <array>
#include <atomic>
#include <deque>
#include <memory>
#include <span>
#include <unordered_map>
#include <vector>

#include "ray/embree/embree.h"
#include "ray/embree/solid.h"
#include "ray/kdtree/kdtree.h"
#include "ray/portable/tree.h"
#include "ray/ray_scene.h"
#include "ray/traceable.h"

namespace gnomon::ray {

/// A BLAS and its instance in the dynamic scene: a rigid group, or one object.
struct Solid {
    SceneHandle tree;
    TriangleTree portable;   // the same for the portable ray tracer
    GeometryHandle instance;
    std::deque<GeometryRecord> records;   // by geometry id
    std::deque<BakedVertices> vertices;
    std::vector<scene::ObjectId> objects;
    scene::NodeId anchor = scene::none;   // whose world matrix places it; none: a skin, in world space
    bool deforming = false;
    bool has_points_at_rest = false,
         sorted_anew = false;   // deforming ones: has_points(); the tree is rebuilt, not refitted

    // Bounds of its triangles in the BLAS's space, and the margin that enlarges them (margin.cpp).
    Box3 box;
    float reach = 0;                             // largest coordinate in world space
    float margin = 0;                            // in the BLAS's space
    std::array<glm::vec3, 4> margin_corners{};   // two, padded
    GeometryHandle margin_geometry;
    /// Whether this is a solid, and not the place of one that was removed.
    bool is_there() const { return tree.get() != nullptr; }

    /// Call after all other geometries are attached. @pre box and margin are set
    void attach_margin(RTCDevice device);
    /// The caller commits the tree and its instance afterwards.
    void set_margin(float wanted);

    glm::mat4 to_world{1};
    glm::mat3 normal_to_world{1};
    bool mirrored = false;   // by to_world
    bool visible = true;     // in the scene's state
    Meeting meeting = Meeting::truly;
    bool has_volume = true;                  // to_world is regular; no ray hits a solid with a singular transform
    bool enabled = true;                     // in Embree: visible, with a regular transform
    unsigned id = RTC_INVALID_GEOMETRY_ID;   // in the dynamic scene; invalid: not attached
    std::uint64_t touched_at = 0;            // the update that last touched it
};

/// How rays hit an instance with this matrix.
Meeting meeting_by(const glm::mat4& m);
/// Largest coordinate of a transformed box and of the matrix's translation.
float reach_of(const Box3& box, const glm::mat4& to_world);
/// The margin of an instance's box, in its own space, in a scene with coordinates up to `reach`.
float margin_of(float reach, const glm::mat4& to_world);
/// Values of `reach` for which margin_of() certainly gives the same; all others must be tried.
struct ReachRange {
    float low = 0, high = k_infinity;
    bool contains(float reach) const { return low <= reach && reach <= high; }
};
/// @param margin  margin_of(reach, to_world)
ReachRange range_of(float margin, float reach, const glm::mat4& to_world);
/// Bounds of all triangles that rays can hit.
Box3 box_of(const std::vector<glm::vec3>& positions, const scene::Mesh& mesh);
/// Whether a triangle is a single point. Embree aborts when it refits a tree with a branch that is a single point; a
/// tree that is rebuilt may have one.
bool has_points(const std::vector<glm::vec3>& positions, const scene::Mesh& mesh);
/// Whether all coordinates are within the range that Embree accepts.
bool can_be_met(const std::vector<glm::vec3>& positions);

/// A static object that is an instance of a shared mesh.
struct Placed {
    scene::ObjectId object = scene::none;
    bool taken = false;   // promoted to a dynamic object
    const Solid* shared = nullptr;
    glm::mat4 to_world{1};
    glm::mat3 normal_to_world{1};
};

/// The object and the triangle of its mesh for the ids of an Embree hit.
struct Met {
    scene::ObjectId object;
    std::uint32_t triangle;
};

/// The largest of many values that change one at a time, in O(log n).
class Largest {
 public:
    /// All values are 0.
    void resize(std::size_t count);
    void set(std::size_t index, float value);
    float value() const { return tree_.empty() ? 0 : tree_[1]; }

 private:
    std::vector<float> tree_;   // the larger of each two; leaves in the second half
};

struct RayScene::Impl {
    EmbreeDevice device;
    std::shared_ptr<const scene::Scene> scene;
    Tasks* tasks = nullptr;   // share the building of a large tree; usually there
    int width = 8;

    // Static objects.
    SceneHandle still;
    std::deque<GeometryRecord> still_records;   // by geometry id
    std::deque<BakedVertices> still_vertices;
    std::unordered_map<scene::MeshId, std::unique_ptr<Solid>> shared_meshes;
    std::deque<Placed> still_instances;   // by geometry id - first_instance
    unsigned first_instance = 0;
    std::vector<std::vector<unsigned>> still_ids;   // by object: its geometry ids in `still`

    float still_reach = 0;       // largest coordinate
    float shared_reach = 0;      // that the margins of shared meshes are made for
    bool shared_taken = false;   // instances were promoted since then

    // Dynamic objects.
    SceneHandle moving;
    std::deque<Solid> solids;   // those that were removed leave their places to later ones
    std::vector<std::uint32_t> free_solids;
    std::vector<std::uint32_t> solid_of_instance;   // by instance id in `moving`
    std::vector<std::uint32_t> solid_of_group, solid_of_object;
    std::vector<std::uint32_t> touched;   // by this update
    Largest reaches;                      // by solid: of those that rays can hit
    ReachRange same_margins{1, 0};        // reaches that change no solid's margin; empty: not known

    SceneHandle one;   // static and dynamic, for comparison; usually absent

    // With the portable ray tracer, Embree's scenes hold the instances of the dynamic scene alone, and are never built.
    bool portable = false;
    RTCScene embree_scene(const SceneHandle& of) const { return portable ? nullptr : of.get(); }
    TriangleTree portable_still;
    SceneTree portable_still_scene, portable_moving_scene, portable_one_scene;
    std::size_t portable_bytes = 0;   // of all its trees, as of the last update

    std::unique_ptr<CountingKdTree> kdtree;   // traces instead of Embree; usually absent
    struct Sums {
        std::atomic<std::uint64_t> nodes{0}, tests{0};
    };
    mutable std::array<Sums, k_ray_classes> kdtree_sums;   // by RayClass, of this frame

    std::vector<ObjectGeometry> geometry;
    bool thins_light = false;   // any material does
    Box3 thin_box;              // contains all static triangles that thin light, with some room
    RaySceneStatistics statistics;
    std::uint64_t updates = 0;
    std::size_t baked_bytes = 0;

    // ../kdtree/queues.cpp
    void closest_on_kdtree(const RayQueue& rays, std::size_t begin, std::size_t end, Hits& hits, Sides sides,
                           Against against) const;
    void occluded_on_kdtree(const RayQueue& rays, std::size_t begin, std::size_t end, std::uint8_t* occluded,
                            Against against) const;
    void add_to_kdtree_sums(RayClass purpose, const KdCounts& counts) const;

    // build.cpp
    void build(const scene::SceneState& state);
    void add_still(const scene::SceneState& state, scene::ObjectId object);
    void add_still_instance(const scene::SceneState& state, scene::ObjectId object);
    void finish_shared();
    void add_group(const scene::SceneState& state, scene::GroupId group);
    /// Adds a solid for a deforming object, or for one that was promoted or separated from its group.
    void add_alone(const scene::SceneState& state, scene::ObjectId object);
    void measure_still(const scene::SceneState& state);
    void measure_thin(const scene::SceneState& state);
    static void measure(Solid& solid, const scene::SceneState& state);
    void finish(std::uint32_t solid, const scene::SceneState& state);
    void describe(scene::ObjectId object, const BakedVertices& vertices, const Solid* solid, bool mirrored);
    void bake(BakedVertices& vertices, const scene::Mesh& mesh, const glm::dmat4& matrix);
    std::uint32_t new_solid();
    void number_instances();
    void build_one_tree();
    void commit_still();
    void commit_moving();
    /// @param follow  the vertices moved
    void commit(Solid& solid, bool follow = false);
    SceneHandle new_scene(RTCBuildQuality quality, unsigned flags) const;

    // margin.cpp
    float present_reach() const;
    void note_reach(std::uint32_t solid);
    void note_all_reaches();
    float reach_of_shared() const;
    float shared_margin(const Solid& shared) const;
    void follow_shared_margins();
    /// Call before the dynamic scene is committed again. Commits the static scene if shared meshes need other margins.
    /// @param all  solids were added, or objects left their group; otherwise, only those in `touched` changed
    void follow_margins(bool all);
    void follow_margin(Solid& solid, float reach);

    // ../portable/queues.cpp
    void commit_portable_still();
    void commit_portable_moving();
    void build_portable_one();
    struct Scenes {
        std::array<const SceneTree*, 2> scene;
        std::size_t count;
        std::span<const SceneTree* const> span() const { return {scene.data(), count}; }
    };
    Scenes scenes_of(Against against) const;
    void count_portable_bytes();
    void closest_portably(const RayQueue& rays, std::size_t begin, std::size_t end, Hits& hits, Sides sides,
                          Against against) const;
    void occluded_portably(const RayQueue& rays, std::size_t begin, std::size_t end, std::uint8_t* occluded,
                           Against against) const;
    /// @param within  rays that miss this box have no hits; null: that is not known
    void thin_portably(const SceneTree& scene, const RayQueue& rays, std::size_t begin, std::size_t end,
                       const Box3* within, std::vector<ThinHit>& hits) const;
    Hit closest_single_portably(const glm::vec3& origin, float tnear, const glm::vec3& direction, float tfar,
                                Sides sides) const;
    bool occluded_single_portably(const glm::vec3& origin, float tnear, const glm::vec3& direction, float tfar,
                                  Against against) const;
    Box3 portable_bounds() const;

    // ray_scene.cpp
    Met met(unsigned geometry_id, unsigned instance, unsigned triangle, bool in_moving) const;

    // update.cpp
    void update(const scene::SceneState& state);
    void place(Solid& solid, const scene::SceneState& state);
    void show(Solid& solid, bool visible);
    void make_tree_of_one(Solid& solid);
    void refit(Solid& solid, const scene::SceneState& state);
    bool follow_overrides(const scene::SceneState& state);
    bool follow_edit(const scene::SceneState& state);
    void remove(scene::ObjectId object);
    void separate(scene::ObjectId object, Solid& group);
    std::uint32_t solid_of(scene::ObjectId object) const;
};

/// Inverse transpose up to a positive factor; exists for singular matrices, too.
glm::mat3 normal_matrix(const glm::mat4& m);
bool mirrors(const glm::dmat4& m);

}   // namespace gnomon::ray
