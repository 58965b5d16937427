// SPDX-License-Identifier: Apache-2.0
#include "irradiance_cache/light_tree/patch_light.h"

#include <algorithm>

#include "base/check.h"

namespace gnomon::irradiance_cache {

namespace {

using patches::PatchId;

constexpr int k_most_sweeps = 64;

int axis_of(const glm::vec3& n)
{
    const glm::vec3 a = glm::abs(n);
    return a.x >= a.y && a.x >= a.z ? 0 : a.y >= a.z ? 1 : 2;
}

// Makes the quad over some patches, and those below it.
class TreeMaker {
 public:
    TreeMaker(std::span<const patches::Patch> patches, PatchTree& tree) : patches_(patches), tree_(tree) {}

    std::uint32_t make(std::span<PatchId> some)
    {
        const auto quad = static_cast<std::uint32_t>(tree_.children.size() / 4);
        tree_.children.resize(tree_.children.size() + 4, scene::none);
        tree_.patch.resize(tree_.patch.size() + 4, patches::k_no_patch);
        std::span<PatchId> half[2], quarter[4];
        split(some, half);
        split(half[0], {quarter, 2});
        split(half[1], {quarter + 2, 2});
        for (std::size_t lane = 0; lane < 4; ++lane) {
            if (quarter[lane].size() == 1) tree_.patch[4 * quad + lane] = quarter[lane][0];
            if (quarter[lane].size() <= 1) continue;
            const std::uint32_t below = make(quarter[lane]);
            tree_.children[4 * quad + lane] = below;
        }
        return quad;
    }

 private:
    // Splits at the median of the longest axis.
    void split(std::span<PatchId> some, std::span<std::span<PatchId>> halves) const
    {
        const std::size_t middle = (some.size() + 1) / 2;
        if (some.size() > 1) {
            Box3 box;
            for (const PatchId p : some) box.add(patches_[p].position);
            const int axis = axis_of(box.size());
            std::nth_element(some.begin(), some.begin() + static_cast<std::ptrdiff_t>(middle), some.end(),
                             [&](PatchId a, PatchId b) {
                                 const float x = patches_[a].position[axis], y = patches_[b].position[axis];
                                 return x < y || (x == y && a < b);
                             });
        }
        halves[0] = some.first(middle), halves[1] = some.subspan(middle);
    }

    std::span<const patches::Patch> patches_;
    PatchTree& tree_;
};

}   // namespace

PatchTree tree_over(std::span<const patches::Patch> patches)
{
    std::vector<PatchId> facing[6];
    for (PatchId p = 0; p < patches.size(); ++p) {
        const glm::vec3& n = patches[p].normal;
        const int axis = axis_of(n);
        facing[2 * axis + (n[axis] < 0 ? 1 : 0)].push_back(p);
    }
    PatchTree tree;
    TreeMaker maker(patches, tree);
    for (std::vector<PatchId>& some : facing)
        if (!some.empty()) tree.roots.push_back(maker.make(some));
    return tree;
}

PatchLight::PatchLight(const scene::SceneState& state, const ray::RayScene& rays, const PatchLightOptions& options,
                       Tasks& tasks)
    : options_(options),
      surroundings_(state.scene().background),
      patches_(state, rays, options.patches, tasks),
      links_(patches::link_patches(patches_, state, rays, surroundings_, tasks)),
      emission_(patches_, options.lights),
      tree_(tree_over(patches_.patches())),
      albedo_(patches_.albedo(state.scene(), rays, tasks))
{
    for (const patches::Patch& patch : patches_.patches()) {
        area_.push_back(patch.area);
        counting_area_.push_back(patch.weight * patch.area);
    }
    node_.resize(area_.size());
    for (std::uint32_t n = 0; n < tree_.patch.size(); ++n)
        if (tree_.patch[n] != patches::k_no_patch) node_[tree_.patch[n]] = n;
    find_uneven();
}

// Children come after their parents.
void PatchLight::find_uneven()
{
    constexpr float k_even = 0.98f;   // square of the length of the mean normal
    constexpr float k_rounding = 1.0001f;
    uneven_.assign(tree_.patch.size() / 4, {});
    for (std::size_t n = tree_.patch.size(); n-- > 0;) {
        Reach& quad = uneven_[n / 4];
        const auto set = [&quad, lane = n % 4](const glm::vec3& centre, float radius) {
            quad.x[lane] = centre.x, quad.y[lane] = centre.y, quad.z[lane] = centre.z, quad.radius[lane] = radius;
        };
        if (tree_.patch[n] != patches::k_no_patch) {
            const patches::Patch& patch = patches_.patches()[tree_.patch[n]];
            if (glm::dot(patch.normal, patch.normal) < k_even)
                set(patch.position, k_rounding * k_uneven_reach * patch.radius);
        } else if (tree_.children[n] != scene::none) {
            const Reach& below = uneven_[tree_.children[n]];
            const auto centre_of = [&below](int child) {
                return glm::vec3(below.x[child], below.y[child], below.z[child]);
            };
            Box3 box;
            for (int child = 0; child < 4; ++child) {
                if (below.radius[child] < 0) continue;
                box.add(centre_of(child) - glm::vec3(below.radius[child]));
                box.add(centre_of(child) + glm::vec3(below.radius[child]));
            }
            if (box.empty()) continue;
            float radius = -1;
            for (int child = 0; child < 4; ++child)
                if (below.radius[child] >= 0)
                    radius = std::max(
                        radius, k_rounding * (glm::length(centre_of(child) - box.centre()) + below.radius[child]));
            set(box.centre(), radius);
        }
    }
}

int PatchLight::sweeps() const
{
    return std::min(options_.bounces - 1, k_most_sweeps);
}

bool PatchLight::follow(const scene::SceneState& state, const ray::RayScene& rays, const scene::SizedLights& lights,
                        Tasks& tasks)
{
    const bool reflects = !state.changes().materials_changed.empty();
    if (reflects) albedo_ = patches_.albedo(state.scene(), rays, tasks);
    if (reflects && (rays.thins_light() || !links_.passes.empty())) {
        surroundings_ = patches::Surroundings(state.scene().background);
        links_ = patches::link_patches(patches_, state, rays, surroundings_, tasks);
        emission_.forget();
    }
    const bool relit = emission_.update(state, rays, lights, tasks);
    return relit || reflects;
}

void PatchLight::light_static(std::span<const glm::vec3> lit, Tasks& tasks)
{
    const std::size_t count = area_.size();
    GNOMON_CHECK(!bounces() || lit.size() == count);
    static_flux_.assign(count, glm::vec3(0));
    std::vector<glm::vec3> direct(count);
    for (std::size_t p = 0; p < count; ++p) {
        direct[p] = albedo_[p] * (emission_.static_irradiance()[p] + links_.surroundings[p]);
        static_flux_[p] = area_[p] * direct[p];
    }
    if (bounces()) {
        for (std::size_t p = 0; p < count; ++p) direct[p] += lit[p] / area_[p];
        const patches::BounceOptions options{sweeps(), options_.stop, sweeps() == k_most_sweeps};
        const std::vector<glm::vec3> bounced = patches::bounce(links_, surfaces(), direct, 0, options, tasks);
        for (std::size_t p = 0; p < count; ++p) static_flux_[p] += area_[p] * bounced[p];
        all_ = patches::total_flux(surfaces(), direct) + patches::total_flux(surfaces(), bounced);
        // Of the last bounce that is asked for, nothing bounces on.
        static_exitance_ = std::move(direct);
        if (sweeps() > 1)
            for (std::size_t p = 0; p < count; ++p) static_exitance_[p] += bounced[p];
    }
    flux_ = static_flux_;
    differs_ = false;
}

void PatchLight::light_past(const scene::SceneState& state, const ray::RayScene& rays,
                            std::span<const patches::BoundingSphere> spheres, std::span<const glm::vec3> lost,
                            Tasks& tasks)
{
    received_flux_.clear(), received_.clear();
    blocked_ = patches::blocked_links(patches_, links_, state, rays, surroundings_, spheres, static_exitance_, tasks);
    open_ = patches::open_parts(patches_, rays, spheres, tasks);
    const std::size_t count = area_.size();
    std::vector<glm::vec3> difference(count);
    bool any = false;
    for (std::size_t p = 0; p < count; ++p) {
        difference[p] = albedo_[p] * (emission_.irradiance()[p] - emission_.static_irradiance()[p]);
        difference[p] -= albedo_[p] * blocked_.irradiance[p];
        any = any || difference[p] != glm::vec3(0);
    }
    past_ = static_exitance_;
    flux_ = static_flux_;
    differs_ = any || std::any_of(lost.begin(), lost.end(), [](const glm::vec3& v) { return v != glm::vec3(0); });
    if (!differs_) return;
    for (std::size_t p = 0; p < count; ++p) flux_[p] += area_[p] * difference[p];
    if (!bounces()) return;
    for (std::size_t p = 0; p < count; ++p) difference[p] -= lost[p] / area_[p];
    const std::vector<glm::vec3> bounced = bounce_now(difference, tasks);
    for (std::size_t p = 0; p < count; ++p) {
        flux_[p] += area_[p] * bounced[p];
        past_[p] = glm::max(past_[p] + difference[p] + (sweeps() > 1 ? bounced[p] : glm::vec3(0)), glm::vec3(0)) /
                   open_part(static_cast<PatchId>(p));
    }
}

void PatchLight::receive(std::span<const glm::vec3> irradiance, Tasks& tasks)
{
    if (irradiance.empty()) return;
    const std::size_t count = area_.size();
    received_.resize(count), received_flux_.resize(count);
    for (std::size_t p = 0; p < count; ++p) received_[p] = albedo_[p] * irradiance[p];
    const std::vector<glm::vec3> bounced = bounce_now(received_, tasks);
    for (std::size_t p = 0; p < count; ++p) {
        received_flux_[p] = area_[p] * (received_[p] + bounced[p]);
        if (sweeps() > 1) received_[p] += bounced[p];
    }
}

void PatchLight::add_received(const glm::vec3& factor)
{
    for (std::size_t p = 0; p < received_flux_.size(); ++p) {
        flux_[p] += factor * received_flux_[p];
        differs_ = differs_ || received_flux_[p] != glm::vec3(0);
    }
    if (differs_)
        for (glm::vec3& flux : flux_) flux = glm::max(flux, glm::vec3(0));
}

// How light that differs from that without dynamic objects bounces on.
std::vector<glm::vec3> PatchLight::bounce_now(std::span<const glm::vec3> exitance, Tasks& tasks) const
{
    const patches::BounceOptions options{sweeps(), options_.stop_now, sweeps() == k_most_sweeps};
    return patches::bounce(links_, surfaces(), exitance, all_, options, tasks, blocked_.links);
}

std::vector<glm::vec3> PatchLight::rough_irradiance() const
{
    constexpr std::size_t k_most = 128;   // patches that are looked at for each
    constexpr float k_reach = 4;          // of neighbours that count, in widths of a patch
    constexpr float k_black = 0.05f;      // an albedo that tells little of the light
    const std::span<const patches::Patch> all = patches_.patches();
    const std::span<const glm::vec3> sky = links_.surroundings;
    constexpr glm::vec3 k_unknown(-1);
    std::vector<glm::vec3> light(all.size(), k_unknown);
    for (PatchId p = 0; p < all.size(); ++p) {
        if (!(luminance(albedo_[p]) > k_black) || !(area_[p] > 0)) continue;
        // What emissive surfaces and images bring directly is not the indirect light of pixels; that of a sky is.
        const glm::vec3 direct = emission_.static_irradiance()[p] + (surroundings_.is_sky() ? glm::vec3(0) : sky[p]);
        const glm::vec3 exitance = glm::max(static_flux_[p] / area_[p] - albedo_[p] * direct, glm::vec3(0));
        light[p] = glm::vec3(luminance(exitance) / luminance(albedo_[p]));
        for (int colour = 0; colour < 3; ++colour)
            if (albedo_[p][colour] > k_black) light[p][colour] = exitance[colour] / albedo_[p][colour];
    }
    if (!surroundings_.is_sky()) return light;
    const auto smoothen = [&](std::span<const PatchId> some) {
        float area = 0;
        for (const PatchId p : some) area += area_[p];
        const float reach2 = k_reach * k_reach * area / static_cast<float>(some.size());
        for (const PatchId p : some) {
            glm::vec3 sum(0);
            float weights = 0;
            for (const PatchId q : some) {
                const glm::vec3 way = all[q].position - all[p].position;
                const float weight = area_[q] * std::max(1 - glm::dot(way, way) / reach2, 0.0f);
                sum += weight * sky[q], weights += weight;
            }
            if (weights > 0 && light[p] != k_unknown)
                light[p] = glm::max(light[p] + sum / weights - sky[p], glm::vec3(0));
        }
    };
    // In the order of the tree's leaves, patches that lie together follow each other.
    for (std::size_t r = 0; r < tree_.roots.size(); ++r) {
        const std::size_t end = r + 1 < tree_.roots.size() ? 4 * tree_.roots[r + 1] : tree_.patch.size();
        std::vector<PatchId> facing;
        for (std::size_t n = 4 * tree_.roots[r]; n < end; ++n)
            if (tree_.patch[n] != patches::k_no_patch) facing.push_back(tree_.patch[n]);
        for (std::size_t first = 0; first < facing.size(); first += k_most)
            smoothen(std::span(facing).subspan(first, std::min(k_most, facing.size() - first)));
    }
    return light;
}

std::size_t PatchLight::bytes() const
{
    return patches_.bytes() + links_.bytes() + emission_.bytes() + tree_.children.size() * 3 * sizeof(std::uint32_t) +
           area_.size() * (2 * sizeof(float) + sizeof(std::uint32_t) + 3 * sizeof(glm::vec3)) +
           (static_exitance_.size() + blocked_.irradiance.size() + past_.size() + received_.size() +
            received_flux_.size()) *
               sizeof(glm::vec3) +
           blocked_.links.size() * sizeof(patches::BlockedLink) + open_.size() * sizeof(float);
}

}   // namespace gnomon::irradiance_cache
