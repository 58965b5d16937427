// SPDX-License-Identifier: Apache-2.0
// Lit surfaces of dynamic objects, as virtual lights beside those of the light tree (light_tree.h).
#include <algorithm>
#include <functional>
#include <set>
#include <unordered_map>

#include "base/morton.h"
#include "irradiance_cache/light_tree/light_tree.h"
#include "irradiance_cache/light_tree/thin_leaves.h"
#include "light_views/texel_ray.h"

namespace gnomon::irradiance_cache {

namespace {

constexpr std::size_t k_rays_at_once = 256;   // by a thread

// Sums surfaces by owner and by the side of their object that they are on, and divides each sum by halves. Sides are
// those of the object's own space: they turn with it, and those of a box are its faces.
class Sides {
 public:
    Sides(std::vector<DynamicVirtualLight>& lights, std::vector<DynamicVirtualLight>& halves)
        : lights_(lights), halves_(halves)
    {
    }

    void add(const DynamicVirtualLight& part, const ray::ObjectGeometry& object)
    {
        const glm::vec3 n = object.to_world ? glm::transpose(glm::mat3(*object.to_world)) * part.normal : part.normal;
        const glm::vec3 size = glm::abs(n);
        const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
        const auto side = static_cast<std::uint32_t>(2 * axis + (n[axis] < 0 ? 1 : 0));
        const auto [at, first] =
            found_.try_emplace((static_cast<std::uint64_t>(part.owner) << 3) | side, sides_.size());
        if (first) sides_.emplace_back();
        sides_[at->second].push_back(static_cast<std::uint32_t>(parts_.size()));
        parts_.push_back(part), own_normals_.push_back(glm::normalize(n)), owners_.insert(part.owner);
    }

    void finish()
    {
        const int divisions = owners_.size() <= 2 ? 2 : owners_.size() <= 5 ? 1 : 0;
        for (std::vector<std::uint32_t>& side : sides_) divide(side, divisions);
    }

 private:
    static constexpr int k_most_divisions = 8;
    static constexpr float k_flat = 0.1f;   // spread of normals up to which a side is one light

    // Adds a light for a side, or more where it is curved: what faces the ground is darker than what faces the sky.
    void divide(std::span<std::uint32_t> some, int divisions)
    {
        glm::vec3 mean(0), squares(0);
        float area = 0;
        for (const std::uint32_t k : some) {
            const glm::vec3& n = own_normals_[k];
            mean += parts_[k].area * n, squares += parts_[k].area * n * n, area += parts_[k].area;
        }
        if (area > 0) mean /= area, squares = squares / area - mean * mean;
        if (divisions == 0 || !(1 - glm::dot(mean, mean) > k_flat)) {
            lights_.push_back(sum(some, 0));
            return;
        }
        const int axis = squares.x >= squares.y && squares.x >= squares.z ? 0 : squares.y >= squares.z ? 1 : 2;
        const auto middle = std::stable_partition(some.begin(), some.end(),
                                                  [&](std::uint32_t k) { return own_normals_[k][axis] < mean[axis]; });
        for (const std::span<std::uint32_t> half : {std::span(some.begin(), middle), std::span(middle, some.end())})
            if (!half.empty()) divide(half, divisions - 1);
    }

    // Means weighted by flux, and the surface nearest to the mean position as the sample.
    DynamicVirtualLight sum(std::span<std::uint32_t> some, int level)
    {
        DynamicVirtualLight light{.owner = parts_[some.front()].owner};
        Box3 box;
        for (const std::uint32_t k : some) {
            const DynamicVirtualLight& part = parts_[k];
            const float weight = luminance(part.flux);
            light.flux += part.flux, light.area += part.area;
            light.position += weight * part.position, light.normal += weight * part.normal;
            box.add(part.position);
        }
        const float flux = luminance(light.flux);
        if (flux > 0) light.position /= flux, light.normal /= flux;
        float nearest = k_infinity;
        for (const std::uint32_t k : some) {
            const float distance = glm::length(parts_[k].position - light.position);
            if (distance < nearest)
                nearest = distance, light.sample = parts_[k].sample, light.sample_normal = parts_[k].normal;
        }
        if (some.size() == 1) std::ranges::copy(parts_[some.front()].side, light.side);
        if (level == k_most_divisions || some.size() < 2 || !(flux > 0)) return light;
        // Split at the median of the longest axis.
        const glm::vec3 size = box.size();
        const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
        const auto middle = some.begin() + static_cast<std::ptrdiff_t>(some.size() / 2);
        std::nth_element(some.begin(), middle, some.end(), [&](std::uint32_t a, std::uint32_t b) {
            const float x = parts_[a].position[axis], y = parts_[b].position[axis];
            return x < y || (x == y && a < b);
        });
        const DynamicVirtualLight one = sum({some.begin(), middle}, level + 1),
                                  two = sum({middle, some.end()}, level + 1);
        light.halves = static_cast<std::uint32_t>(halves_.size());
        halves_.push_back(one), halves_.push_back(two);
        return light;
    }

    std::vector<DynamicVirtualLight>&lights_, &halves_;
    std::vector<DynamicVirtualLight> parts_;
    std::vector<glm::vec3> own_normals_;   // by part, in the space of its object
    std::set<std::uint32_t> owners_;
    std::vector<std::vector<std::uint32_t>> sides_;
    std::unordered_map<std::uint64_t, std::size_t> found_;
};

// Keeps the brightest lights, in their order.
void keep_brightest(std::vector<DynamicVirtualLight>& lights, std::size_t count)
{
    if (lights.size() > count) {
        std::vector<float> flux;
        for (const DynamicVirtualLight& light : lights) flux.push_back(luminance(light.flux));
        std::nth_element(flux.begin(), flux.begin() + static_cast<std::ptrdiff_t>(count), flux.end(), std::greater<>());
        const float least = flux[count];
        std::erase_if(lights, [&](const DynamicVirtualLight& light) { return !(luminance(light.flux) > least); });
    }
    std::erase_if(lights, [](const DynamicVirtualLight& light) { return light.flux == glm::vec3(0); });
}

}   // namespace

void LightTree::find_dynamics()
{
    dynamics_.clear();
    reflection_.forget();   // objects may have other meshes
    for (scene::ObjectId o = 0; o < state_->scene().objects.size(); ++o)
        if (state_->is_dynamic(o) && !state_->scene().objects[o].removed && takes_light(o)) dynamics_.push_back(o);
    dynamic_groups_.clear(), thin_groups_.clear();
    std::unordered_map<std::uint32_t, std::size_t> group_of_owner, thin_of_owner;
    for (const scene::ObjectId o : dynamics_) {
        const bool casts = casters_.casts(o);
        std::vector<std::vector<scene::ObjectId>>& groups = casts ? dynamic_groups_ : thin_groups_;
        const auto [at, first] = (casts ? group_of_owner : thin_of_owner).try_emplace(owner_of(o), groups.size());
        if (first) groups.emplace_back();
        groups[at->second].push_back(o);
    }
}

// Whether an object occludes light, or thins it.
bool LightTree::takes_light(scene::ObjectId object) const
{
    if (casters_.casts(object)) return true;
    const scene::Scene& scene = state_->scene();
    return std::ranges::any_of(scene.meshes[scene.objects[object].mesh].parts, [&](const scene::MeshPart& part) {
        return scene::thins_light(scene.materials[part.material]);
    });
}

// The texels of a view that a dynamic object covers if it is there.
light_views::Rect LightTree::footprint(const View& view, scene::ObjectId object) const
{
    if (!takes_light(object) || !state_->object_there(object)) return {};
    return light_views::footprint(view.projection, state_->object_matrix(object), casters_.box(object));
}

// Finds the lit surfaces of dynamic objects, in every frame in which one moves, and sums them by owner and by side.
void LightTree::gather_dynamic(Tasks& tasks)
{
    dynamic_.clear(), dynamic_halves_.clear();
    Sides sides(dynamic_, dynamic_halves_);
    ray::RayQueue queue;
    queue.purpose = ray::RayClass::indirect;
    ray::Hits hits;
    std::vector<double> measure;
    std::vector<std::uint32_t> texels;
    for (const View& view : views_) {
        // Select the texels of dynamic objects, in tree order; of large objects only every few.
        if (!view.on || view.dynamic_objects.rects.empty()) continue;
        const std::vector<std::uint32_t>& covers = view.dynamic_objects.covers;
        int step = 1;
        while (view.dynamic_objects.area / (static_cast<std::size_t>(step) * static_cast<std::size_t>(step)) >
               options_.dynamic_rays)
            step *= 2;
        texels.clear();
        const std::size_t cell = static_cast<std::size_t>(step) * static_cast<std::size_t>(step);
        for (std::size_t i = 0; i < covers.size(); i += cell) {
            if (i % k_leaves_of_block == 0 && view.dynamic_objects.in_block[i / k_leaves_of_block] == 0 &&
                cell < k_leaves_of_block) {
                i += k_leaves_of_block - cell;
                continue;
            }
            const auto begin = covers.begin() + static_cast<std::ptrdiff_t>(i);
            const auto end = covers.begin() + static_cast<std::ptrdiff_t>(std::min(i + cell, covers.size()));
            if (std::any_of(begin, end, [](std::uint32_t count) { return count > 0; }))
                texels.push_back(static_cast<std::uint32_t>(i));
        }
        if (texels.empty()) continue;
        // Cast a ray through each.
        queue.clear();
        measure.clear();
        for (const std::uint32_t i : texels) {
            const light_views::TexelRay r = light_views::texel_ray(view.projection, static_cast<int>(even_bits(i)),
                                                                   static_cast<int>(even_bits(i >> 1)));
            queue.push(r.origin, 0, r.direction, k_infinity);
            measure.push_back(r.measure * step * step);
        }
        hits.resize(texels.size());
        tasks.for_each((texels.size() + k_rays_at_once - 1) / k_rays_at_once, [&](std::size_t run, int) {
            const std::size_t first = run * k_rays_at_once;
            rays_->closest(queue, first, std::min(first + k_rays_at_once, texels.size()), hits, ray::Sides::both);
        });
        const std::vector<glm::vec3> factor =
            find_thin_leaves(state_->scene(), *rays_, queue, view.behind, ray::Against::everything, hits);
        for (std::size_t i = 0; i < texels.size(); ++i) {
            if (hits.object[i] == scene::none || !state_->is_dynamic(hits.object[i])) continue;
            const Leaf leaf = leaf_at(view, queue, hits, i, measure[i], factor);
            if (leaf.area > 0)
                sides.add(
                    {owner_of(leaf.object), leaf.position, leaf.normal, leaf.sample, leaf.normal, leaf.flux, leaf.area},
                    rays_->geometry(leaf.object));
        }
    }
    sides.finish();
    keep_brightest(dynamic_, options_.dynamic_lights);
    of_maps_ = dynamic_.size(), halves_of_maps_ = dynamic_halves_.size();
    reflectors_.clear();
    if (!patches_) return;
    // Add what the objects reflect of other light, as lights of their own: they have other areas.
    std::vector<std::vector<scene::ObjectId>> groups = dynamic_groups_;
    groups.insert(groups.end(), thin_groups_.begin(), thin_groups_.end());
    reflectors_ = reflection_.gather(*state_, *rays_, groups,
                                     {patches_->patches(), patches_->exitance_past(), patches_->surroundings(), sized_,
                                      std::max(patches_->bounce_count() - 1, 0)},
                                     tasks);
    add_reflectors();
}

// Sums the reflectors by owner and by side, in place of those before.
void LightTree::add_reflectors()
{
    dynamic_.resize(of_maps_), dynamic_halves_.resize(halves_of_maps_);
    std::vector<DynamicVirtualLight> others;
    Sides sides(others, dynamic_halves_);
    for (const patches::DynamicReflection::Reflector& r : reflectors_)
        sides.add({owner_of(r.object),
                   r.position,
                   r.normal,
                   r.sample,
                   r.normal,
                   r.flux,
                   r.area,
                   scene::none,
                   {r.side[0], r.side[1]}},
                  rays_->geometry(r.object));
    sides.finish();
    keep_brightest(others, options_.dynamic_lights);
    dynamic_.insert(dynamic_.end(), others.begin(), others.end());
}

// Adds the light that goes from dynamic objects to patches and back, again and again. Each time objects give off the
// same part more, as if it were spread over them as their first light is; the sum of that geometric series is exact for
// one object of one colour that is lit evenly.
// @return  by colour: the factor by which patches receive more
glm::vec3 LightTree::reflect_again()
{
    constexpr int k_least_bounces = 3;
    constexpr float k_most_part = 0.5f;
    if (patches_->bounce_count() < k_least_bounces || patches_->exitance_received().empty() || reflectors_.empty())
        return glm::vec3(1);
    const std::vector<glm::vec3> more =
        reflection_.again(patches_->exitance_received(), std::max(patches_->bounce_count() - 1, 0));
    glm::vec3 first(0), second(0), factor(1);
    for (std::size_t l = 0; l < of_maps_; ++l) first += dynamic_[l].flux;
    for (std::size_t k = 0; k < more.size(); ++k) first += reflectors_[k].flux, second += more[k];
    for (int colour = 0; colour < 3; ++colour)
        if (first[colour] > 0) factor[colour] = 1 / (1 - std::clamp(second[colour] / first[colour], 0.0f, k_most_part));
    for (std::size_t k = 0; k < more.size(); ++k) reflectors_[k].flux += factor * more[k];
    add_reflectors();
    return factor;
}

}   // namespace gnomon::irradiance_cache
