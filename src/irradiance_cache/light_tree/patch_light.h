// SPDX-License-Identifier: Apache-2.0
#pragma once
// The light of the patches of the static scene (patches/surface_patches.h), which the light tree holds beside the lit
// texels of light maps.
//
// A patch reflects what reaches it directly from emissive surfaces and from beyond the scene, which have no light maps,
// and all light that has bounced before. What light maps see lit is the first bounce of their lights: it is gathered
// from the maps' own leaves, and is here the light that bounces on. While a dynamic object occludes a texel or a part
// of an emissive surface, or reflects light to patches, the difference bounces on in the same way.
//
// Fluxes are functions of the present state, and all sums have a fixed order.

#include <memory>

#include "patches/open_places.h"
#include "patches/patch_bounces.h"
#include "patches/patch_emission.h"

namespace gnomon::irradiance_cache {

struct PatchLightOptions {
    /// Diffuse bounces; from 65 on, all.
    int bounces = 1;
    /// Emissive surfaces light the patches, instead of the lights that approximate them.
    bool emission = false;
    patches::PatchOptions patches;
    patches::EmissionOptions lights;
    double stop = 1e-3;       // patches::BounceOptions::stop,
    double stop_now = 1e-4;   // and of what dynamic objects change
};

/// A tree over the patches, four children a node. Quad q has the nodes 4 q ... 4 q + 3.
struct PatchTree {
    std::vector<std::uint32_t> children;   // by node: the quad of its children, after its own; scene::none
    std::vector<patches::PatchId> patch;   // by node: of a leaf; else k_no_patch
    std::vector<std::uint32_t> roots;      // quads
};
/// Patches that face the same way and lie together have a common ancestor.
PatchTree tree_over(std::span<const patches::Patch> patches);

class PatchLight {
 public:
    /// Makes the patches and links of the static scene.
    PatchLight(const scene::SceneState& state, const ray::RayScene& rays, const PatchLightOptions& options,
               Tasks& tasks);

    /// Whether patches would have any light to give.
    static bool wanted(const scene::Scene& scene, const PatchLightOptions& options, const scene::SizedLights& lights)
    {
        return options.bounces > 1 || !lights.empty() || patches::Surroundings::may_light(scene.background);
    }
    /// Whether light maps must say where they are lit.
    bool bounces() const { return options_.bounces > 1; }
    int bounce_count() const { return options_.bounces; }
    const patches::SurfacePatches& patches() const { return patches_; }
    const PatchTree& tree() const { return tree_; }
    /// By node of a quad of the tree: a sphere that encloses all places which are less than k_uneven_reach radii away
    /// from a patch below whose surface is uneven, so that its parts may see each other. Its radius is negative if
    /// there is none.
    struct Reach {
        float x[4] = {}, y[4] = {}, z[4] = {};
        float radius[4] = {-1, -1, -1, -1};
    };
    static constexpr float k_uneven_reach = 2;
    /// By quad.
    std::span<const Reach> uneven() const { return uneven_; }
    /// The node of that tree that is a patch.
    std::uint32_t node(patches::PatchId patch) const { return node_[patch]; }

    /// Follows one advance() of the state.
    /// @return  whether the light without dynamic objects changed
    bool follow(const scene::SceneState& state, const ray::RayScene& rays, const scene::SizedLights& lights,
                Tasks& tasks);
    /// Finds the light without dynamic objects.
    /// @param lit  radiant flux of the light maps' leaves, by patch
    void light_static(std::span<const glm::vec3> lit, Tasks& tasks);
    /// Finds the light of this frame past what dynamic objects occlude and block, without what they reflect.
    /// @param spheres  around dynamic objects, which may come between patches
    /// @param lost     of the light maps' flux, what dynamic objects occlude
    void light_past(const scene::SceneState& state, const ray::RayScene& rays,
                    std::span<const patches::BoundingSphere> spheres, std::span<const glm::vec3> lost, Tasks& tasks);
    /// Finds what dynamic objects reflect to the patches, and how it bounces. Call after light_past().
    /// @param irradiance  by patch; empty: none, as if light bounces once
    void receive(std::span<const glm::vec3> irradiance, Tasks& tasks);
    /// Adds what was received, times a factor by colour, to the light of this frame.
    void add_received(const glm::vec3& factor);
    /// Radiant exitance by patch, of its open part, that lights dynamic objects: of light_past(), and what receive()
    /// adds to it. Empty if light bounces once, or nothing is received.
    std::span<const glm::vec3> exitance_past() const { return past_; }
    std::span<const glm::vec3> exitance_received() const { return received_; }
    /// The part of a patch that no dynamic object covers now, by which the exitance of what is seen of it from near by
    /// is larger than its mean; 1 if all is covered.
    float open_part(patches::PatchId patch) const
    {
        return patch < open_.size() && open_[patch] > 0 ? open_[patch] : 1.0f;
    }
    const patches::Surroundings& surroundings() const { return surroundings_; }
    std::span<const glm::vec3> albedo() const { return albedo_; }

    /// What a surface there gets as indirect light without dynamic objects, roughly, by patch: that of a sky is
    /// smoothed over some dozens of patches that lie together and face the same way, because the few rays of one meet a
    /// narrow sky by chance. Negative where a patch is too black to tell.
    std::vector<glm::vec3> rough_irradiance() const;
    /// Radiant flux by patch: without dynamic objects, and now.
    std::span<const glm::vec3> static_flux() const { return static_flux_; }
    std::span<const glm::vec3> flux() const { return flux_; }
    /// Whether both differ.
    bool differs() const { return differs_; }

    std::size_t bytes() const;

 private:
    int sweeps() const;
    std::vector<glm::vec3> bounce_now(std::span<const glm::vec3> exitance, Tasks& tasks) const;
    void find_uneven();
    patches::PatchSurfaces surfaces() const { return {albedo_, counting_area_}; }

    PatchLightOptions options_;
    patches::Surroundings surroundings_;
    patches::SurfacePatches patches_;
    patches::PatchLinks links_;
    patches::PatchEmission emission_;
    PatchTree tree_;
    std::vector<Reach> uneven_;         // by quad of the tree
    std::vector<std::uint32_t> node_;   // by patch
    std::vector<glm::vec3> albedo_;
    std::vector<float> area_, counting_area_;   // the second times Patch::weight
    double all_ = 0;                            // the flux of all static light
    std::vector<glm::vec3> static_flux_, flux_, received_flux_;
    patches::BlockedLinks blocked_;            // by dynamic objects
    std::vector<glm::vec3> past_, received_;   // exitance that may bounce on
    std::vector<float> open_;                  // patches::open_parts()
    std::vector<glm::vec3> static_exitance_;   // that may bounce on, of light maps' leaves as well
    bool differs_ = false;
};

}   // namespace gnomon::irradiance_cache
