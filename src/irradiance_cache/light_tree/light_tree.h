// SPDX-License-Identifier: Apache-2.0
#pragma once
// The light tree: the surfaces that the scene's lights shine on, as virtual point lights. Its leaves are pixels of
// light maps [Dachsbacher and Stamminger 2005], its nodes the maps' pyramids [Ki and Oh 2007, 3.1].
//
// Leaves lie on static surfaces alone. While a dynamic object occludes a leaf from its light, the leaf is dark. That
// changes the current flux of the leaf and of the nodes above it, and nothing else, so it pays to remember which nodes
// a surface point sees past static geometry.
//
// Light without a light map, from emissive surfaces and from beyond the scene, and light that has bounced more than
// once, start from patches of the static scene (patch_light.h), which are leaves of roots of their own.
//
// Cost: construction casts one ray per leaf. A frame casts rays against dynamic objects from the leaves in the
// footprints of those that changed, and updates the nodes above changed leaves (`dirty_leaves`, `dirty_nodes`). If
// anything changed, it also casts at most LightTreeOptions::dynamic_rays per view to find lit dynamic objects.
// Invariant: the flux of an updated tree equals that of a new one, bit for bit.

#include <atomic>
#include <span>
#include <unordered_map>
#include <vector>

#include "base/tasks.h"
#include "irradiance_cache/light_tree/patch_light.h"
#include "irradiance_cache/light_tree/patch_occluders.h"
#include "light_views/casters.h"
#include "patches/dynamic_reflection.h"
#include "ray/origin.h"
#include "ray/ray_scene.h"

namespace gnomon::irradiance_cache {

struct LightTreeOptions {
    int side = 256;                  // texels of a view, at most; a power of two
    std::size_t leaves = 1u << 17;   // of all views together, at most; views get smaller sides by halves
    // Fraction of the leaves for the views of directional lights where there are other lights, too. A sun lights far
    // more surface than a light in a room. 0: all views are alike.
    float directional = 0;
    int least_side = 16;          // smaller only if there were more nodes than k_node_bits can number
    std::size_t views = 6144;     // at most; six for a point light; the weakest lights are left out
    float least_cosine = 0.05f;   // bounds the area of surfaces at grazing angles
    float ray_end = ray::k_shadow_ray_end;
    std::size_t dynamic_rays = 4096;   // per view, to find lit dynamic objects
    std::size_t dynamic_lights = 64;   // at most; the darkest are left out
    PatchLightOptions patches;
};

using NodeId = std::uint32_t;
inline constexpr std::uint32_t k_node_bits = 18;   // of a node's number, at most

/// Four virtual point lights with the same parent: nodes of the tree, each of which represents the static leaves below
/// it.
struct VirtualLightQuad {
    float x[4], y[4], z[4];      // mean position, weighted by static flux
    float radius[4];             // of a sphere around it that encloses all leaves
    float nx[4], ny[4], nz[4];   // mean normal, weighted by static flux; shorter than 1 if normals differ
    // Of the surfaces, square units; over patches, that of the surfaces from which the static flux comes: less than all
    // below where some are brighter than others.
    float area[4];
    float flux[4];   // static flux, luminance; 0: no node
};

/// The surfaces of a dynamic object, or of a group, that are on one side of it and reflect light.
struct DynamicVirtualLight {
    std::uint32_t owner = 0;            // owner_of() the object
    glm::vec3 position{0}, normal{0};   // means weighted by flux; the normal is shorter than 1 if normals differ
    glm::vec3 sample{0};                // place for which visibility is tested
    glm::vec3 sample_normal{0};         // of the surface there, unit
    glm::vec3 flux{0};
    float area = 0;
    std::uint32_t halves = scene::none;   // LightTree::dynamic_halves(): the first of two that it consists of
    glm::vec3 side[2]{};                  // of the triangle around the position that it is; 0: it is of no known shape

    /// How far cosines at its surfaces reach to both sides of that of the mean normal (point_kernels.h).
    float reach() const { return std::sqrt(std::max(1 - glm::dot(normal, normal), k_least_spread)); }
    /// The mean cosine at its surfaces of a way to it, times the way's length, of those that face the way.
    float facing(const glm::vec3& to, float length) const
    {
        const float mean = -glm::dot(to, normal), most = reach() * length;
        const float within = std::max(std::min(mean, most) + most, 0.0f);
        return 0.25f * (within * within) / most + std::max(mean - most, 0.0f);
    }
    /// Whether its halves must stand for it at this squared distance, as a disk seen from near by would be wrong.
    bool is_near(float square) const { return square < near_square(); }
    float near_square() const { return halves != scene::none ? k_near * area : 0; }
    /// Whether it has no halves, and a disk would be wrong at this squared distance.
    bool is_wide(float square) const { return halves == scene::none && square < k_near * area; }

 private:
    static constexpr float k_near = 12, k_least_spread = 1e-6f;
};

/// Calls use(part) for the parts of a light that are small as seen from a point.
template <class Use>
void for_each_part(const DynamicVirtualLight& light, std::span<const DynamicVirtualLight> halves,
                   const glm::vec3& point, const Use& use)
{
    const glm::vec3 way = light.sample - point;
    if (!light.is_near(glm::dot(way, way))) return use(light);
    for (std::uint32_t k = light.halves; k < light.halves + 2; ++k) for_each_part(halves[k], halves, point, use);
}

/// The place to which a ray tells whether a point sees a light: its sample, or where the surface there faces away from
/// the point, that of the parts that bring most light, as facing_place() of nodes.
inline glm::vec3 facing_sample(const DynamicVirtualLight& light, std::span<const DynamicVirtualLight> halves,
                               const glm::vec3& point)
{
    const DynamicVirtualLight* at = &light;
    while (at->halves != scene::none && !(glm::dot(point - at->sample, at->sample_normal) > 0)) {
        const auto brings = [&](const DynamicVirtualLight& half) {
            const glm::vec3 to = half.sample - point;
            const float square = glm::dot(to, to);
            return luminance(half.flux) * half.facing(to, std::sqrt(square)) / (square * std::sqrt(square));
        };
        const DynamicVirtualLight &one = halves[at->halves], &two = halves[at->halves + 1];
        at = brings(one) >= brings(two) ? &one : &two;
    }
    return at->sample;
}

class LightTree {
 public:
    LightTree(const scene::SceneState& state, const ray::RayScene& rays, const LightTreeOptions& options, Tasks& tasks);

    /// Follows one advance() of the state, after the ray scene did. Rebuilds the views of lights that moved or were
    /// relit; all views if a static object was promoted to a dynamic one or a material changed; and the whole tree in
    /// other bounds, or if other lights or numbers of views are in it.
    void update(const scene::SceneState& state, const ray::RayScene& rays, Tasks& tasks);

    /// Nodes 4 q ... 4 q + 3.
    const VirtualLightQuad& quad(NodeId q) const { return quads_[q]; }
    /// All quads.
    std::span<const VirtualLightQuad> quads() const { return quads_; }
    /// The quad of a node's children; scene::none for leaves.
    NodeId children(NodeId id) const { return children_[id]; }
    /// The same for all nodes.
    std::span<const NodeId> children() const { return children_; }
    /// Flux by node: radiant exitance times area, which is pi times a diffuse surface's radiance times its area.
    struct Flux {
        std::vector<float> r, g, b;
        glm::vec3 at(NodeId id) const { return {r[id], g[id], b[id]}; }
        void set(NodeId id, const glm::vec3& flux) { r[id] = flux.x, g[id] = flux.y, b[id] = flux.z; }
    };
    /// In this frame.
    const Flux& flux() const { return flux_; }
    /// Without dynamic objects.
    const Flux& static_flux() const { return static_flux_; }
    /// Nodes from this one on are those over patches. Their flux differs from their static flux in every frame in which
    /// a dynamic object occludes any light, by the value at id - first_patch() + 1 of patch_difference().
    NodeId first_patch() const { return patch_first_; }
    const Flux& patch_difference() const { return patch_difference_; }
    /// Null: there are no patches.
    const PatchLight* patch_light() const { return patches_.get(); }
    /// The leaf that is a patch.
    NodeId node_of(patches::PatchId patch) const { return patch_first_ + patches_->node(patch); }
    bool any_patch_differs() const { return patches_ && patches_->differs(); }
    /// For the other nodes.
    bool differs(NodeId id) const { return samples_.places[id].w != 0; }
    bool any_differs() const { return differing_ > 0; }
    /// Nodes whose flux or differs() the last update may have changed; some twice.
    const std::vector<NodeId>& changed() const { return changed_; }
    const std::vector<DynamicVirtualLight>& dynamic_lights() const { return dynamic_; }
    /// Parts of these, and parts of parts.
    const std::vector<DynamicVirtualLight>& dynamic_halves() const { return dynamic_halves_; }
    /// A number for what moves together with a dynamic object: its rigid group, or the object alone.
    std::uint32_t owner_of(scene::ObjectId object) const;
    /// By node: a place just above the leaf nearest to the mean, for which visibility is tested. w is 1 if the flux
    /// differs from the static flux, else 0; both are read together.
    struct Samples {
        std::vector<glm::vec4> places;
        std::vector<NodeId> leaves;   // by node: the leaf that the place lies on
        glm::vec3 at(NodeId id) const { return glm::vec3(places[id]); }
    };
    const Samples& samples() const { return samples_; }
    /// Where rays to samples end, as a fraction of the way. A sample lies above its surface, so that a ray may go all
    /// the way, and must if nothing is to be seen through a sheet that the sample lies on. Without patches a ray ends
    /// before.
    float ray_end() const { return patches_ ? 1 : options_.ray_end; }
    /// Top quads of the views that have any flux.
    const std::vector<NodeId>& roots() const { return roots_; }
    /// Counts the updates that rebuilt nodes, after which lists of visible nodes are void.
    std::uint32_t geometry_version() const { return geometry_version_; }
    /// Whether the last update did.
    bool geometry_changed() const { return geometry_changed_; }
    /// Counts the updates that changed flux.
    std::uint32_t flux_version() const { return flux_version_; }

    /// The geometric mean of the widths of lit leaves, weighted by their static flux and how much it
    /// matters (DetailRegion::weight); 0 without light maps.
    float leaf_spacing() const;
    /// The width of the leaves around the place for which a node's visibility is tested. Not for patches.
    float leaf_width(NodeId id) const;
    /// The width that a light's leaf has where it lies on a surface; infinite where none of its views sees the place.
    /// @param cosine  of the angle of incidence
    float leaf_width(scene::LightId light, const glm::vec3& position, float cosine) const;

    std::size_t size() const { return children_.size(); }
    std::uint64_t dirty_leaves() const { return dirty_leaves_; }
    std::uint64_t dirty_nodes() const { return dirty_nodes_; }
    /// Rays from patches to lights of dynamic objects, for the present light.
    std::uint64_t rays_to_dynamic() const { return rays_to_dynamic_; }
    std::size_t bytes() const;

 private:
    static constexpr std::uint32_t k_leaves_of_block = 64;   // leaves that are counted together
    // The footprints of dynamic objects in a view. Cost of a change: its area.
    struct DynamicFootprints {
        std::unordered_map<scene::ObjectId, light_views::Rect> rects;   // not empty
        std::vector<std::uint32_t> covers;                              // by leaf, in tree order: how many rects
        std::vector<std::uint32_t> in_block;                            // by 64 leaves: the sum of these
        std::size_t area = 0;                                           // of all rects

        void clear(std::size_t leaves);
        /// Replaces an object's footprint, which may be empty, and returns the one before.
        light_views::Rect set(scene::ObjectId object, const light_views::Rect& rect);
        void count(const light_views::Rect& rect, bool add);
    };
    struct View {
        scene::LightId light = scene::none;
        int face = 0;
        bool behind = false;        // leaves lie behind surfaces that thin light (thin_leaves.h)
        int side = 0, levels = 0;   // 2^levels texels per side
        NodeId first = 0;           // its first node, a multiple of 4: level 1, level 2, ... in Morton order
        bool on = false;
        light_views::ViewProjection projection;
        glm::mat4 near_clip{1};   // of the same light's view before
        int stray = 0;            // texels by which leaves' samples lie beyond the margins of footprints
        DynamicFootprints dynamic_objects;
        std::vector<std::uint16_t> patch;   // by leaf, in tree order: the patch that it lies on; empty without bounces
        std::vector<std::uint8_t> occluded;   // by leaf, in tree order: by dynamic objects
        std::vector<glm::vec3> passes;        // likewise, what these let through; empty where nothing thins light
        std::vector<NodeId> dirty;            // flux changed in this frame
    };
    struct Leaf {
        scene::ObjectId object = scene::none;
        glm::vec3 position{0}, normal{0}, sample{0}, flux{0};
        float area = 0;
        bool front = true;   // the lit side, by the world winding
    };
    void build(Tasks& tasks);
    std::vector<View> wanted_views() const;
    void choose_sides(std::size_t patch_nodes);
    bool follow_bounds();
    bool follow_lights_and_bounds(Tasks& tasks);
    void rebuild(Tasks& tasks);
    void make_view(View& view);
    void note_patch(View& view, std::uint32_t leaf_number, const Leaf& leaf, const ray::Hits& hits) const;
    Leaf leaf_at(const View& view, const ray::RayQueue& queue, const ray::Hits& hits, std::size_t i, double measure,
                 std::span<const glm::vec3> factor) const;
    void follow_dynamic(const scene::FrameChanges& changes);
    void find_dynamic(View& view, std::vector<light_views::Rect>& where) const;
    bool takes_light(scene::ObjectId object) const;
    light_views::Rect footprint(const View& view, scene::ObjectId object) const;
    static int stray_of(const View& view, const glm::vec3& sample, std::uint32_t leaf);
    void occlude_leaves(View& view, const std::vector<light_views::Rect>& where);
    void mark_changes();
    void gather_dynamic(Tasks& tasks);
    void receive_dynamic(Tasks& tasks);
    void add_reflectors();
    glm::vec3 reflect_again();
    void find_dynamics();
    void find_roots();
    void make_patches(Tasks& tasks);
    bool follow_patches(Tasks& tasks, bool& relit);

    std::vector<glm::vec3> lit_patches(bool lost_only) const;
    void light_patches(Tasks& tasks);
    void follow_light(Tasks& tasks);
    void block_patches(Tasks& tasks);
    void light_patches_now(Tasks& tasks);
    void sum_children(Flux& flux, NodeId id) const;
    static NodeId first_of_level(const View& view, int level)
    {
        return view.first + ((1u << (2 * level)) - 4) / 3;   // level 1 is the first
    }

    LightTreeOptions options_;
    light_views::Casters casters_;
    light_views::SceneBounds bounds_;
    std::vector<View> views_;
    std::vector<std::pair<std::uint32_t, std::uint32_t>> views_of_;   // by light: the first of its views, and their end
    scene::SizedLights sized_;                                        // that light the patches
    std::unique_ptr<PatchLight> patches_;                             // null: they would have no light
    NodeId patch_first_ = 0;                                          // all nodes, without patches
    Flux patch_difference_;
    bool patches_changed_ = false;    // in this frame
    bool patches_differed_ = false;   // in the last one, from the light without dynamic objects
    std::vector<VirtualLightQuad> quads_;
    Samples samples_;
    Flux flux_, static_flux_;
    std::size_t differing_ = 0;
    std::vector<DynamicVirtualLight> dynamic_, dynamic_halves_;
    std::size_t of_maps_ = 0, halves_of_maps_ = 0;   // of these, light that light maps hold
    patches::DynamicReflection reflection_;
    std::vector<patches::DynamicReflection::Reflector> reflectors_;   // of other light
    std::vector<glm::vec3> lost_;       // flux of leaves that dynamic objects occlude, by patch
    std::vector<glm::vec3> received_;   // irradiance that dynamic objects reflect to patches
    PatchOccluders occluders_;          // that hide dynamic objects from patches
    const scene::SceneState* state_;
    const ray::RayScene* rays_;
    std::vector<NodeId> children_;
    std::vector<NodeId> roots_;
    std::vector<NodeId> changed_;                                // by the last update
    std::vector<scene::ObjectId> dynamics_;                      // dynamic objects that occlude or thin light
    std::vector<std::vector<scene::ObjectId>> dynamic_groups_;   // of these, by owner: those that occlude it
    std::vector<std::vector<scene::ObjectId>> thin_groups_;      // likewise, the others
    std::uint32_t geometry_version_ = 1, flux_version_ = 1;
    bool geometry_changed_ = false;
    std::atomic<std::uint64_t> dirty_leaves_ = 0, dirty_nodes_ = 0, rays_to_dynamic_ = 0;
};

}   // namespace gnomon::irradiance_cache
