// SPDX-License-Identifier: Apache-2.0
// What patches receive of the light of dynamic objects (light_tree.h).
#include <algorithm>
#include <array>
#include <numeric>
#include <unordered_map>

#include "base/interruption.h"
#include "irradiance_cache/light_tree/light_tree.h"
#include "irradiance_cache/light_tree/patch_kernels.h"

namespace gnomon::irradiance_cache {

namespace {

constexpr float k_untested = 0.02f;   // of a patch's light: less is added without a ray
static_assert(PatchRows::k_most == PatchOccluders::k_run);

// The kernel of a disk, as for points and in receive_untested().
float kernel(const DynamicVirtualLight& light, const patches::Patch& patch)
{
    const glm::vec3 to = light.sample - patch.sample;
    const float square = glm::dot(to, to);
    const float cosine = glm::dot(to, patch.normal), facing = light.facing(to, std::sqrt(square));
    if (!(cosine > 0) || !(facing > 0)) return 0.0f;
    return facing * cosine / (square * (static_cast<float>(k_pi) * square + light.area));
}

// An owner of lights: what encloses the places that are tested, and what hides them.
struct Owner {
    Box3 box;
    Sphere around;
    PatchOccluders::OfOwner* occluders;
};

// The lights of a frame.
struct Lights {
    std::span<const DynamicVirtualLight> lights, halves;
    std::vector<Owner> owners;
    std::vector<std::uint32_t> owner;   // by light: its number among these
};

// Notes the owners of all lights.
Lights find_owners(std::span<const DynamicVirtualLight> lights, std::span<const DynamicVirtualLight> halves,
                   PatchOccluders& occluders, std::size_t patches)
{
    Lights result{lights, halves, {}, {}};
    occluders.limit();
    std::unordered_map<std::uint32_t, std::uint32_t> numbers;
    for (const DynamicVirtualLight& light : lights) {
        const auto [at, first] = numbers.try_emplace(light.owner, static_cast<std::uint32_t>(result.owners.size()));
        if (first) result.owners.push_back({{}, {}, &occluders.of(light.owner, patches)});
        result.owner.push_back(at->second);
        result.owners[at->second].box.add(light.sample);
    }
    for (const DynamicVirtualLight& half : halves)
        if (const auto at = numbers.find(half.owner); at != numbers.end())
            result.owners[at->second].box.add(half.sample);
    for (Owner& owner : result.owners) owner.around = {owner.box.centre(), 0.5f * k_grown * owner.box.diagonal()};
    return result;
}

// Lights a run of patches.
class Receiver {
 public:
    Receiver(const Lights& lights, const ray::RayScene& rays, const scene::Scene& scene,
             std::span<const patches::Patch> all, std::size_t first, float ray_end)
        : lights_(lights),
          scene_rays_(rays),
          scene_(scene),
          all_(all),
          first_(first),
          ray_end_(ray_end),
          hidden_(lights.owners.size() * PatchRows::k_most)
    {
        queue_.purpose = ray::RayClass::indirect;
    }

    /// @param received  out: by patch of all
    void receive(PatchRows& rows, std::span<glm::vec3> received)
    {
        find_tested(rows);
        push_rays(rows.count);
        for (std::size_t k = 0; k < rows.count; ++k)
            received[first_ + k] = {rows.received[0][k], rows.received[1][k], rows.received[2][k]};
        if (queue_.empty()) return;
        std::vector<std::uint8_t> occluded(queue_.size() + ray::k_packet_pad);
        scene_rays_.occluded(queue_, 0, queue_.size(), occluded.data());
        std::vector<glm::vec3> passes(scene_rays_.thins_light() ? queue_.size() : 0);
        if (!passes.empty()) scene_rays_.let_through(queue_, 0, queue_.size(), passes.data(), ray::Against::everything);
        for (std::size_t r = 0; r < arriving_.size(); ++r)
            if (!occluded[r])
                received[first_ + arriving_[r].patch] +=
                    passes.empty() ? arriving_[r].irradiance : arriving_[r].irradiance * passes[r];
        remember_occluders(occluded);
    }
    /// The rays that were cast.
    std::size_t rays() const { return queue_.size() + searches_; }

 private:
    enum class Hidden : std::uint8_t { unknown, none, some, all };
    struct Arriving {
        std::uint16_t patch;
        std::uint32_t owner;
        glm::vec3 irradiance;
    };

    const patches::Patch& patch(std::size_t k) const { return all_[first_ + k]; }
    Hidden& hidden(std::uint32_t owner, std::size_t k) { return hidden_[owner * PatchRows::k_most + k]; }

    // Whether all lights of an owner are hidden from a patch by what is remembered.
    bool is_hidden(std::uint32_t owner, std::size_t k)
    {
        Hidden& is = hidden(owner, k);
        if (is == Hidden::unknown) {
            const Owner& of = lights_.owners[owner];
            const TriangleShadow* const shadow = of.occluders->find(first_ + k);
            const bool all = shadow && shadow->hides(of.around.centre - patch(k).sample, of.around.radius);
            is = all ? Hidden::all : Hidden::none;
        }
        return is == Hidden::all;
    }

    // Finds which lights need rays, and sorts them by patch: rays from one place stay together in packets.
    void find_tested(PatchRows& rows)
    {
        std::vector<std::pair<std::uint16_t, std::uint32_t>> by_light;   // patch and light
        std::array<std::uint16_t, PatchRows::k_most> tested;
        for (std::uint32_t l = 0; l < lights_.lights.size(); ++l) {
            const std::size_t count = receive_untested(rows, lights_.lights[l], k_untested, tested.data());
            for (std::size_t t = 0; t < count; ++t) {
                const std::uint16_t k = tested[t];
                if (!is_hidden(lights_.owner[l], k)) by_light.emplace_back(k, l), ++begin_[k + 1u];
            }
        }
        std::partial_sum(begin_.begin(), begin_.end(), begin_.begin());
        tested_.resize(by_light.size());
        for (const auto& [k, light] : by_light) tested_[begin_[k]++] = light;
    }

    // After find_tested(), begin_[k] is the end of the lights of patch k.
    void push_rays(std::size_t count)
    {
        for (std::size_t k = 0, l = 0; k < count; ++k)
            for (const patches::Patch& from = patch(k); l < begin_[k]; ++l) {
                const DynamicVirtualLight& light = lights_.lights[tested_[l]];
                const std::uint32_t owner = lights_.owner[tested_[l]];
                const TriangleShadow* const shadow = lights_.owners[owner].occluders->find(first_ + k);
                for_each_part(light, lights_.halves, from.sample, [&](const DynamicVirtualLight& part) {
                    const float of_part = kernel(part, from);
                    if (!(of_part > 0)) return;
                    const glm::vec3 to = facing_sample(part, lights_.halves, from.sample) - from.sample;
                    if (shadow && shadow->hides(to, 0)) {
                        hidden(owner, k) = Hidden::some;
                        return;
                    }
                    queue_.push(from.sample, 0, to, ray_end_);
                    arriving_.push_back({static_cast<std::uint16_t>(k), owner, of_part * part.flux});
                });
            }
    }

    // Where rays were occluded, and nothing that is remembered hid any part of the owner, looks for what hides its
    // middle.
    void remember_occluders(std::span<const std::uint8_t> occluded)
    {
        ray::RayQueue queue;
        queue.purpose = ray::RayClass::indirect;
        std::vector<std::pair<std::uint16_t, std::uint32_t>> of;   // by ray: patch and owner
        for (std::size_t r = 0; r < arriving_.size(); ++r) {
            const auto [k, owner, irradiance] = arriving_[r];
            if (!occluded[r] || hidden(owner, k) != Hidden::none) continue;
            hidden(owner, k) = Hidden::some;
            queue.push(patch(k).sample, 0, lights_.owners[owner].around.centre - patch(k).sample, 1);
            of.emplace_back(k, owner);
        }
        if (queue.empty()) return;
        searches_ = queue.size();
        ray::Hits hits;
        hits.resize(queue.size());
        scene_rays_.closest(queue, 0, queue.size(), hits, ray::Sides::both, ray::Against::static_only);
        for (std::size_t r = 0; r < of.size(); ++r) {
            const scene::ObjectId object = hits.object[r];
            if (object == scene::none || scene_rays_.meeting(object) != ray::Meeting::truly) continue;
            const ray::ObjectGeometry& geometry = scene_rays_.geometry(object);
            const scene::Material& material = scene_.materials[geometry.mesh->part_of(hits.triangle[r]).material];
            if (material.surface_class() != scene::SurfaceClass::opaque) continue;
            glm::vec3 corners[3];
            geometry.corners(hits.triangle[r], corners);
            const auto [k, owner] = of[r];
            if (const auto shadow = TriangleShadow::behind(corners, patch(k).sample))
                lights_.owners[owner].occluders->remember(first_ + k, *shadow);
        }
    }

    const Lights& lights_;
    const ray::RayScene& scene_rays_;
    const scene::Scene& scene_;
    std::span<const patches::Patch> all_;
    std::size_t first_;
    float ray_end_;
    std::vector<Hidden> hidden_;                                 // by owner and patch
    std::array<std::uint32_t, PatchRows::k_most + 1> begin_{};   // by patch: of the lights that are tested
    std::vector<std::uint32_t> tested_;
    ray::RayQueue queue_;
    std::vector<Arriving> arriving_;   // by ray
    std::size_t searches_ = 0;         // rays that looked for occluders
};

}   // namespace

// Finds what dynamic objects reflect to patches. Lights of which a patch would reflect next to nothing are added
// without a ray.
void LightTree::receive_dynamic(Tasks& tasks)
{
    received_.clear();
    rays_to_dynamic_ = 0;
    if (!patches_ || !patches_->bounces() || dynamic_.empty()) return;
    const std::span<const patches::Patch> all = patches_->patches().patches();
    received_.assign(all.size(), glm::vec3(0));
    const Lights lights = find_owners(dynamic_, dynamic_halves_, occluders_, all.size());
    tasks.for_each((all.size() + PatchRows::k_most - 1) / PatchRows::k_most, [&](std::size_t run, int) {
        interruption_point();
        const std::size_t first = run * PatchRows::k_most;
        PatchRows rows;
        rows.count = std::min(PatchRows::k_most, all.size() - first);
        for (std::size_t k = 0; k < rows.count; ++k) {
            const patches::Patch& patch = all[first + k];
            for (int i = 0; i < 3; ++i) rows.sample[i][k] = patch.sample[i], rows.normal[i][k] = patch.normal[i];
            rows.albedo[k] = luminance(patches_->albedo()[first + k]);
            rows.already[k] = luminance(patches_->static_flux()[first + k]) / patch.area;
        }
        Receiver receiver(lights, *rays_, state_->scene(), all, first, options_.ray_end);
        receiver.receive(rows, received_);
        rays_to_dynamic_ += receiver.rays();
    });
}

}   // namespace gnomon::irradiance_cache
