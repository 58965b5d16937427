// SPDX-License-Identifier: Apache-2.0
// The patches of the static scene in the light tree (light_tree.h): their nodes, and the light that they reflect.
#include <algorithm>
#include <cmath>
#include <utility>

#include "irradiance_cache/light_tree/light_tree.h"

namespace gnomon::irradiance_cache {

namespace {

constexpr float k_much = 0.1f;        // of the light of the brightest child
constexpr float k_most_covered = 4;   // areas of a patch that a light's leaves on it may have

void add_moved(const Box3& box, const glm::mat4& moved, Box3& to)
{
    for (int corner = 0; corner < 8; ++corner)
        to.add(
            transform_point(moved, glm::vec3(corner & 1 ? box.high.x : box.low.x, corner & 2 ? box.high.y : box.low.y,
                                             corner & 4 ? box.high.z : box.low.z)));
}

patches::BoundingSphere sphere_around(const Box3& box)
{
    constexpr float k_rounding = 1.001f;
    return {box.centre(), 0.5f * box.diagonal() * k_rounding};
}

}   // namespace

// Decides whether there are patches, and makes them if there are none.
void LightTree::make_patches(Tasks& tasks)
{
    if (options_.patches.emission) sized_.update(*state_);
    if (!PatchLight::wanted(state_->scene(), options_.patches, sized_)) {
        patches_.reset();
        return;
    }
    if (patches_) return;
    occluders_.forget();
    patches_ = std::make_unique<PatchLight>(*state_, *rays_, options_.patches, tasks);
    patches_->follow(*state_, *rays_, sized_, tasks);
}

// Lets the patches follow the state. Builds the tree anew if the static scene changed, or if patches have light that
// had none before, or have none any more.
// @param relit  out: whether their light without dynamic objects changed
// @return  false if the tree was built anew
bool LightTree::follow_patches(Tasks& tasks, bool& relit)
{
    if (options_.patches.emission) sized_.update(*state_);
    const bool wanted = PatchLight::wanted(state_->scene(), options_.patches, sized_);
    const scene::FrameChanges& changes = state_->changes();
    if (patches_ && (!wanted || !changes.promoted.empty())) patches_.reset();
    if (patches_) relit = patches_->follow(*state_, *rays_, sized_, tasks);
    if (wanted == (patches_ != nullptr) && (patches_ || patch_first_ == size())) return true;
    follow_bounds();
    rebuild(tasks);
    return false;
}

// Notes the patch that a leaf of a light map lies on.
void LightTree::note_patch(View& view, std::uint32_t leaf_number, const Leaf& leaf, const ray::Hits& hits) const
{
    const patches::PatchId patch =
        patches_->patches().patch_at(*rays_, leaf.object, hits.triangle[leaf_number], hits.u[leaf_number],
                                     hits.v[leaf_number], leaf.front, leaf.sample);
    if (patch != patches::k_no_patch) view.patch[leaf_number] = static_cast<std::uint16_t>(patch);
}

// Sums the flux of the light maps' leaves by patch: of all, or of those that dynamic objects occlude. A leaf may be far
// larger than the patch on which its middle lies, where a light shines on more than its map resolves. Then all of its
// light would make the patch many times as bright as the surface is: no more counts than a few times the patch's area
// brings. What is occluded costs a pass over the marks of a view's leaves if there is none.
std::vector<glm::vec3> LightTree::lit_patches(bool lost_only) const
{
    std::vector<glm::vec3> lit;
    if (!patches_->bounces()) return lit;
    const std::span<const patches::Patch> all = patches_->patches().patches();
    lit.assign(all.size(), glm::vec3(0));
    std::vector<float> covered(all.size());         // by patch: the area of a view's leaves
    std::vector<std::uint8_t> wanted(all.size());   // by patch: whether any of them counts
    for (const View& view : views_) {
        if (!view.on || view.patch.empty()) continue;
        const NodeId leaves = first_of_level(view, view.levels);
        const auto lost = [&](std::size_t i) {
            return view.occluded[i] != 0 || (!view.passes.empty() && view.passes[i] != glm::vec3(1));
        };
        const auto counts = [&](std::size_t i) {
            return view.patch[i] != patches::PatchLinks::k_none && (!lost_only || lost(i));
        };
        std::fill(wanted.begin(), wanted.end(), 0);
        bool any = false;
        for (std::size_t i = 0; i < view.patch.size(); ++i)
            if (counts(i)) wanted[view.patch[i]] = 1, any = true;
        if (!any) continue;
        std::fill(covered.begin(), covered.end(), 0.0f);
        for (std::size_t i = 0; i < view.patch.size(); ++i) {
            const NodeId leaf = leaves + static_cast<NodeId>(i);
            if (view.patch[i] != patches::PatchLinks::k_none && wanted[view.patch[i]] != 0 &&
                quads_[leaf / 4].flux[leaf % 4] > 0)
                covered[view.patch[i]] += quads_[leaf / 4].area[leaf % 4];
        }
        for (std::size_t i = 0; i < view.patch.size(); ++i) {
            if (!counts(i)) continue;
            const NodeId leaf = leaves + static_cast<NodeId>(i);
            const glm::vec3 flux = lost_only ? static_flux_.at(leaf) - flux_.at(leaf) : static_flux_.at(leaf);
            const float most = k_most_covered * all[view.patch[i]].area, area = covered[view.patch[i]];
            lit[view.patch[i]] += area > most ? most / area * flux : flux;
        }
    }
    return lit;
}

// Makes the nodes over the patches, by their light without dynamic objects.
void LightTree::light_patches(Tasks& tasks)
{
    if (!patches_) return;
    patches_->light_static(lit_patches(false), tasks);
    const PatchTree& tree = patches_->tree();
    const std::span<const patches::Patch> all = patches_->patches().patches();
    for (std::size_t q = tree.children.size() / 4; q-- > 0;)
        for (std::size_t lane = 0; lane < 4; ++lane) {
            const std::size_t n = 4 * q + lane;
            const NodeId id = patch_first_ + static_cast<NodeId>(n);
            VirtualLightQuad& quad = quads_[id / 4];
            glm::vec3 position(0), normal(0), sample(0), flux(0);
            NodeId leaf = id;   // that the sample lies on
            float radius = 0, area = 0;
            if (tree.patch[n] != patches::k_no_patch) {
                const patches::Patch& patch = all[tree.patch[n]];
                position = patch.position, normal = patch.normal, sample = patch.sample;
                radius = patch.radius, area = patch.area, flux = patches_->static_flux()[tree.patch[n]];
            } else if (tree.children[n] != scene::none) {
                // Means weighted by flux, over the four children in a fixed order.
                const NodeId first = patch_first_ + 4 * tree.children[n];
                const VirtualLightQuad& below = quads_[first / 4];
                float weight = 0, squares = 0;
                for (NodeId c = 0; c < 4; ++c) {
                    if (!(below.flux[c] > 0)) continue;
                    flux += static_flux_.at(first + c);
                    weight += below.flux[c];
                    squares += below.flux[c] * (below.flux[c] / below.area[c]);
                    position += below.flux[c] * glm::vec3(below.x[c], below.y[c], below.z[c]);
                    normal += below.flux[c] * glm::vec3(below.nx[c], below.ny[c], below.nz[c]);
                }
                if (weight > 0) position /= weight, normal /= weight;
                // The area of evenly lit surfaces with as much light: what is all but dark does not count.
                if (squares > 0) area = weight * (weight / squares);
                // The place that is nearest to the mean, of children that give much of the light: others may lie behind
                // a wall.
                const float least = k_much * *std::max_element(below.flux, below.flux + 4);
                float nearest = k_infinity;
                for (NodeId c = 0; c < 4; ++c) {
                    if (!(below.flux[c] > 0)) continue;
                    const glm::vec3 at(below.x[c], below.y[c], below.z[c]);
                    radius = std::max(radius, glm::length(at - position) + below.radius[c]);
                    if (below.flux[c] < least) continue;
                    const glm::vec3 place = samples_.at(first + c);
                    const float distance = glm::length(place - position);
                    if (distance < nearest) nearest = distance, sample = place, leaf = samples_.leaves[first + c];
                }
            }
            quad.x[lane] = position.x, quad.y[lane] = position.y, quad.z[lane] = position.z;
            quad.nx[lane] = normal.x, quad.ny[lane] = normal.y, quad.nz[lane] = normal.z;
            quad.radius[lane] = radius, quad.area[lane] = area, quad.flux[lane] = luminance(flux);
            samples_.places[id] = glm::vec4(sample, 0), samples_.leaves[id] = leaf;
            static_flux_.set(id, flux), flux_.set(id, flux);
        }
    patch_difference_ = {};
    patches_changed_ = true;
}

// Finds what dynamic objects keep from the patches now.
void LightTree::block_patches(Tasks& tasks)
{
    std::vector<patches::BoundingSphere> spheres;
    for (const auto* groups : {&dynamic_groups_, &thin_groups_})
        for (const std::vector<scene::ObjectId>& group : *groups) {
            Box3 box;
            for (const scene::ObjectId o : group)
                if (state_->object_visible(o) && !casters_.box(o).empty())
                    add_moved(casters_.box(o), state_->object_matrix(o), box);
            if (!box.empty()) spheres.push_back(sphere_around(box));
        }
    patches_->light_past(*state_, *rays_, spheres, lost_, tasks);
}

// Follows what dynamic objects occlude and reflect now.
void LightTree::light_patches_now(Tasks& tasks)
{
    if (!patches_) return;
    patches_->receive(received_, tasks);
    const glm::vec3 factor = reflect_again();
    patches_->add_received(factor);
    const bool before = std::exchange(patches_differed_, patches_->differs());
    if (!before && !patches_->differs()) return;
    const PatchTree& tree = patches_->tree();
    const std::size_t count = tree.children.size();
    for (auto* lane : {&patch_difference_.r, &patch_difference_.g, &patch_difference_.b}) lane->assign(count + 1, 0.0f);
    for (std::size_t n = count; n-- > 0;) {
        const NodeId id = patch_first_ + static_cast<NodeId>(n);
        if (tree.patch[n] != patches::k_no_patch)
            flux_.set(id, patches_->flux()[tree.patch[n]]);
        else if (tree.children[n] != scene::none)
            sum_children(flux_, id);
        patch_difference_.set(static_cast<NodeId>(n) + 1, flux_.at(id) - static_flux_.at(id));
    }
    patches_changed_ = true;
    ++flux_version_;
}

}   // namespace gnomon::irradiance_cache
