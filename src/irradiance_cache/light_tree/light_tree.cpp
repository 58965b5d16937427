// SPDX-License-Identifier: Apache-2.0
#include "irradiance_cache/light_tree/light_tree.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/check.h"
#include "base/interruption.h"
#include "base/morton.h"
#include "irradiance_cache/light_tree/thin_leaves.h"
#include "light_views/texel_ray.h"
#include "lighting/diffuse.h"
#include "ray/origin.h"

namespace gnomon::irradiance_cache {

namespace {

constexpr NodeId k_none = scene::none;

// Leaves in Morton order: the children of a node lie together.
std::uint32_t morton(int x, int y)
{
    return static_cast<std::uint32_t>(morton_code(static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y)));
}

constexpr std::size_t k_most_nodes = std::size_t{1} << k_node_bits;
constexpr int k_smallest_side = 2;   // one level
// Around what stands on a wide ground, texels must not be much wider than patches.
constexpr light_views::ProjectionOptions k_projection{.widening = 8, .border = 0};
constexpr std::uint32_t k_rays_at_once = 4096;   // between interruption points; a multiple of every packet's width

// The nodes of a view's pyramid, from the level of four nodes down.
std::size_t nodes_of(int side)
{
    return (4 * static_cast<std::size_t>(side) * static_cast<std::size_t>(side) - 4) / 3;
}

// Whether a light has views. Those that approximate an environment image have none, nor have those of emissive surfaces
// that light patches.
bool shines_into_views(const scene::Light& light, const LightTreeOptions& options)
{
    return !light.of_environment && !(options.patches.emission && light.of_surface);
}

bool has_views(const scene::Scene& scene, const LightTreeOptions& options)
{
    return std::ranges::any_of(scene.lights, [&](const auto& light) { return shines_into_views(light, options); });
}

// All lights if their views fit; else the strongest, in the scene's order.
std::vector<scene::LightId> bouncing_lights(const scene::Scene& scene, const light_views::SceneBounds& bounds,
                                            const LightTreeOptions& options)
{
    const auto views = [&](scene::LightId l) {
        return static_cast<std::size_t>(light_views::view_count(scene.lights[l], bounds, k_projection));
    };
    std::vector<scene::LightId> lights(scene.lights.size());
    std::iota(lights.begin(), lights.end(), 0u);
    std::erase_if(lights, [&](scene::LightId l) { return !shines_into_views(scene.lights[l], options); });
    std::stable_sort(lights.begin(), lights.end(), [&](scene::LightId a, scene::LightId b) {
        return luminance(scene.lights[a].color) > luminance(scene.lights[b].color);
    });
    std::size_t taken = 0, kept = 0;
    while (kept < lights.size() && taken + views(lights[kept]) <= options.views) taken += views(lights[kept++]);
    lights.resize(kept);
    std::sort(lights.begin(), lights.end());
    return lights;
}

}   // namespace

LightTree::LightTree(const scene::SceneState& state, const ray::RayScene& rays, const LightTreeOptions& options,
                     Tasks& tasks)
    : options_(options), casters_(state), sized_(options.patches.lights.lights), state_(&state), rays_(&rays)
{
    follow_bounds();
    build(tasks);
}

// Takes over the bounds of the views, which are costly to find and of no use without any.
// @return  whether they changed
bool LightTree::follow_bounds()
{
    if (!has_views(state_->scene(), options_) || state_->present_bounds() == bounds_) return false;
    bounds_ = state_->present_bounds();
    return true;
}

// The views of all lights that are in the tree, without places for their nodes.
std::vector<LightTree::View> LightTree::wanted_views() const
{
    const scene::Scene& scene = state_->scene();
    std::vector<View> views;
    for (const scene::LightId l : bouncing_lights(scene, bounds_, options_))
        for (int face = 0; face < light_views::view_count(scene.lights[l], bounds_, k_projection); ++face) {
            for (const bool behind : {false, true}) {
                if (behind && !rays_->thins_light()) continue;
                View& view = views.emplace_back();
                view.light = l, view.face = face, view.behind = behind;
            }
        }
    return views;
}

// Chooses the sides of the views, so that their leaves and nodes are not too many.
void LightTree::choose_sides(std::size_t patch_nodes)
{
    const scene::Scene& scene = state_->scene();
    const auto directional = [&](const View& view) {
        return scene.lights[view.light].type == scene::LightType::directional;
    };
    const auto suns = static_cast<std::size_t>(std::count_if(views_.begin(), views_.end(), directional));
    // Views of intermediate width do not make the others coarser.
    const auto is_between = [&](const View& view) { return directional(view) && view.face > 1; };
    const auto between = static_cast<std::size_t>(std::ranges::count_if(views_, is_between));
    const auto fitting = [&](std::size_t views, double share) {
        const auto leaves = static_cast<std::size_t>(share * static_cast<double>(options_.leaves));
        int side = options_.side;
        while (side > options_.least_side &&
               views * static_cast<std::size_t>(side) * static_cast<std::size_t>(side) > leaves)
            side /= 2;
        return side;
    };
    const bool apart = options_.directional > 0 && suns > 0 && suns < views_.size();
    const auto share = static_cast<double>(options_.directional);
    int of_suns = fitting((apart ? suns : views_.size()) - between, apart ? share : 1);
    int others = apart ? fitting(views_.size() - suns, 1 - share) : of_suns;
    const auto too_many = [&] {
        return suns * nodes_of(of_suns) + (views_.size() - suns) * nodes_of(others) + patch_nodes > k_most_nodes;
    };
    while (std::max(of_suns, others) > k_smallest_side && too_many()) {
        const int larger = std::max(of_suns, others);
        of_suns = std::min(of_suns, larger / 2), others = std::min(others, larger / 2);
    }
    for (View& view : views_) view.side = directional(view) ? of_suns : others;
}

// Makes everything from the present state.
void LightTree::build(Tasks& tasks)
{
    find_dynamics();
    make_patches(tasks);
    const std::size_t patch_nodes = patches_ ? patches_->tree().children.size() : 0;
    views_ = wanted_views();
    choose_sides(patch_nodes);
    views_of_.assign(state_->scene().lights.size(), {0, 0});
    NodeId end = 0;
    for (View& view : views_) {
        auto& [first_view, end_view] = views_of_[view.light];
        const auto number = static_cast<std::uint32_t>(&view - views_.data());
        if (end_view == 0) first_view = number;
        end_view = number + 1;
        const int side = view.side;
        while ((1 << view.levels) < side) ++view.levels;
        view.first = end;
        end = first_of_level(view, view.levels + 1);
        view.occluded.assign(static_cast<std::size_t>(side) * static_cast<std::size_t>(side), 0);
    }
    patch_first_ = end;
    end += static_cast<NodeId>(patch_nodes);
    quads_.assign(end / 4, {});
    GNOMON_CHECK(end <= k_most_nodes);
    samples_.places.assign(end, glm::vec4(0));
    samples_.leaves.resize(end);
    std::iota(samples_.leaves.begin(), samples_.leaves.end(), NodeId{0});
    differing_ = 0;
    for (Flux* flux : {&flux_, &static_flux_})
        for (auto* lane : {&flux->r, &flux->g, &flux->b}) lane->assign(end, 0.0f);
    children_.assign(end, k_none);
    for (const View& view : views_)
        for (int level = 1; level < view.levels; ++level)
            for (std::uint32_t i = 0; i < 1u << (2 * level); ++i)
                children_[first_of_level(view, level) + i] = first_of_level(view, level + 1) / 4 + i;
    for (NodeId n = 0; n < patch_nodes; ++n)
        if (const std::uint32_t below = patches_->tree().children[n]; below != scene::none)
            children_[patch_first_ + n] = patch_first_ / 4 + below;
    tasks.for_each(views_.size(), [&](std::size_t v, int) { make_view(views_[v]); });
    light_patches(tasks);
    find_roots();
    follow_light(tasks);
}

// Finds what dynamic objects occlude and reflect now.
void LightTree::follow_light(Tasks& tasks)
{
    if (patches_) {
        lost_ = lit_patches(true);
        block_patches(tasks);
    }
    gather_dynamic(tasks);
    receive_dynamic(tasks);
    light_patches_now(tasks);
    mark_changes();
}

void LightTree::find_roots()
{
    roots_.clear();
    const auto add = [&](NodeId quad) {
        const VirtualLightQuad& top = quads_[quad];
        if (std::max({top.flux[0], top.flux[1], top.flux[2], top.flux[3]}) > 0) roots_.push_back(quad);
    };
    for (const View& view : views_) add(view.first / 4);
    if (patches_)
        for (const std::uint32_t root : patches_->tree().roots) add(patch_first_ / 4 + root);
}

// The surface that a light map's ray hits, as a virtual point light. Its area is 0 if there is none.
// @param factor  as of find_thin_leaves()
LightTree::Leaf LightTree::leaf_at(const View& view, const ray::RayQueue& queue, const ray::Hits& hits, std::size_t i,
                                   double measure, std::span<const glm::vec3> factor) const
{
    if (!factor.empty() && factor[i] == glm::vec3(0)) return {};
    if (hits.object[i] == scene::none) return {};
    const scene::Scene& scene = state_->scene();
    const scene::Light& light = scene.lights[view.light];
    const scene::LightState& at = state_->light(view.light);
    const ray::ObjectGeometry& geometry = rays_->geometry(hits.object[i]);
    glm::vec3 p[3];
    geometry.corners(hits.triangle[i], p);
    const float u = hits.u[i], v = hits.v[i];
    const glm::vec3 position = std::max(0.0f, 1 - u - v) * p[0] + u * p[1] + v * p[2];
    glm::vec3 normal = glm::cross(p[1] - p[0], p[2] - p[0]);
    const float length = glm::length(normal);
    if (!(length > 0)) return {};
    normal /= length;
    float cosine = -glm::dot(normal, queue.direction(i));
    const bool front = cosine >= 0;
    if (!front) normal = -normal, cosine = -cosine;
    // A wide view of a directional light leaves out the part that the one before covers.
    if (light.type == scene::LightType::directional && view.face > 0) {
        const glm::vec4 clip = view.near_clip * glm::vec4(position, 1);
        if (std::abs(clip.x) <= 1 && std::abs(clip.y) <= 1) return {};
    }
    const scene::LightSample sample = scene::illuminate(light, at, position);
    if (sample.irradiance == glm::vec3(0)) return {};
    const auto t = static_cast<double>(hits.t[i]);
    const double facing_area = view.projection.perspective ? measure * t * t : measure;
    Leaf leaf;
    leaf.object = hits.object[i];
    leaf.front = front;
    leaf.position = position;
    leaf.normal = normal;
    leaf.area = static_cast<float>(facing_area) / std::max(cosine, options_.least_cosine);
    leaf.sample = position + ray::origin_lift(p) * normal;
    leaf.flux = lighting::exitance_per_irradiance(scene, geometry, hits.triangle[i], u, v) * sample.irradiance *
                static_cast<float>(facing_area);
    if (!factor.empty()) leaf.flux *= factor[i];
    return leaf;
}

// Traces the leaves of static surfaces and builds the pyramid above them.
void LightTree::make_view(View& view)
{
    const scene::Light& light = state_->scene().lights[view.light];
    const scene::LightState& at = state_->light(view.light);
    const NodeId leaves = first_of_level(view, view.levels);
    const auto count = static_cast<std::uint32_t>(view.side * view.side);
    const NodeId end = leaves + count;
    std::fill(quads_.begin() + view.first / 4, quads_.begin() + end / 4, VirtualLightQuad{});
    for (NodeId id = view.first; id < end; ++id) {
        flux_.set(id, glm::vec3(0)), static_flux_.set(id, glm::vec3(0));
        view.dirty.push_back(id);
    }
    std::fill(view.occluded.begin(), view.occluded.end(), 0);
    view.patch.assign(patches_ && patches_->bounces() ? count : 0, patches::PatchLinks::k_none);
    view.on = at.visible && light.color != glm::vec3(0) && !light.of_environment;
    view.dynamic_objects.clear(count), view.passes.clear(), view.stray = 0;
    if (!view.on) return;
    const auto projections = light_views::project(light, at, bounds_, view.side, k_projection);
    view.projection = projections[static_cast<std::size_t>(view.face)];
    if (view.face > 0) view.near_clip = projections[static_cast<std::size_t>(view.face) - 1].clip_from_world;

    // Cast one ray per leaf, in tree order, so that neighbours share packets.
    ray::RayQueue queue;
    queue.purpose = ray::RayClass::indirect;
    std::vector<double> measure(count);
    for (std::uint32_t i = 0; i < count; ++i) {
        const light_views::TexelRay r = light_views::texel_ray(view.projection, static_cast<int>(even_bits(i)),
                                                               static_cast<int>(even_bits(i >> 1)));
        queue.push(r.origin, 0, r.direction, k_infinity);
        measure[i] = r.measure;
    }
    struct Node {
        glm::vec3 position{0}, normal{0}, sample{0};
        float radius = 0, area = 0, flux = 0;
    };
    std::vector<Node> nodes(end - view.first);
    const auto node_of = [&](NodeId id) -> Node& { return nodes[id - view.first]; };
    ray::Hits hits;
    hits.resize(count);
    for (std::uint32_t i = 0; i < count; i += k_rays_at_once) {
        interruption_point();
        rays_->closest(queue, i, std::min(i + k_rays_at_once, count), hits, ray::Sides::both,
                       ray::Against::static_only);
    }
    const std::vector<glm::vec3> factor =
        find_thin_leaves(state_->scene(), *rays_, queue, view.behind, ray::Against::static_only, hits);
    for (std::uint32_t i = 0; i < count; ++i) {
        if (i % k_rays_at_once == 0) interruption_point();
        const Leaf leaf = leaf_at(view, queue, hits, i, measure[i], factor);
        if (!(leaf.area > 0)) continue;
        Node& node = node_of(leaves + i);
        node.position = leaf.position, node.normal = leaf.normal, node.sample = leaf.sample;
        node.area = leaf.area;
        node.radius = std::sqrt(leaf.area * static_cast<float>(1 / k_pi));
        node.flux = luminance(leaf.flux);
        static_flux_.set(leaves + i, leaf.flux), flux_.set(leaves + i, leaf.flux);
        view.stray = std::max(view.stray, stray_of(view, leaf.sample, i));
        if (!view.patch.empty()) note_patch(view, i, leaf, hits);
    }

    // Pull up: means weighted by flux, over the four children in a fixed order.
    for (int level = view.levels - 1; level > 0; --level)
        for (std::uint32_t i = 0; i < 1u << (2 * level); ++i) {
            const NodeId id = first_of_level(view, level) + i, child = 4 * children_[id];
            Node& node = node_of(id);
            glm::vec3 position(0), normal(0);
            for (NodeId c = child; c < child + 4; ++c) {
                const Node& part = node_of(c);
                if (!(part.flux > 0)) continue;
                node.flux += part.flux;
                node.area += part.area;
                position += part.flux * part.position;
                normal += part.flux * part.normal;
            }
            sum_children(flux_, id);
            static_flux_.set(id, flux_.at(id));
            if (!(node.flux > 0)) continue;
            node.position = position / node.flux;
            node.normal = normal / node.flux;
            float nearest = k_infinity;
            for (NodeId c = child; c < child + 4; ++c) {
                const Node& part = node_of(c);
                if (!(part.flux > 0)) continue;
                node.radius = std::max(node.radius, glm::length(part.position - node.position) + part.radius);
                if (const float distance = glm::length(part.sample - node.position); distance < nearest)
                    nearest = distance, node.sample = part.sample, samples_.leaves[id] = samples_.leaves[c];
            }
        }
    for (NodeId id = view.first; id < end; ++id) {
        const Node& node = node_of(id);
        VirtualLightQuad& quad = quads_[id / 4];
        const NodeId lane = id % 4;
        quad.x[lane] = node.position.x, quad.y[lane] = node.position.y, quad.z[lane] = node.position.z;
        quad.nx[lane] = node.normal.x, quad.ny[lane] = node.normal.y, quad.nz[lane] = node.normal.z;
        quad.radius[lane] = node.radius, quad.area[lane] = node.area, quad.flux[lane] = node.flux;
        samples_.places[id] = glm::vec4(node.sample, samples_.places[id].w);   // see mark_changes()
    }
    std::vector<light_views::Rect> where;
    find_dynamic(view, where);
    occlude_leaves(view, where);
}

// Sums the four children in a fixed order.
void LightTree::sum_children(Flux& flux, NodeId id) const
{
    glm::vec3 sum(0);
    for (NodeId c = 4 * children_[id]; c < 4 * children_[id] + 4; ++c) sum += flux.at(c);
    flux.set(id, sum);
}

void LightTree::DynamicFootprints::clear(std::size_t leaves)
{
    rects.clear();
    covers.assign(leaves, 0);
    in_block.assign((leaves + k_leaves_of_block - 1) / k_leaves_of_block, 0);
    area = 0;
}

void LightTree::DynamicFootprints::count(const light_views::Rect& rect, bool add)
{
    const std::uint32_t by = add ? 1 : ~0u;
    for (int y = rect.y0; y < rect.y1; ++y)
        for (int x = rect.x0; x < rect.x1; ++x) {
            const std::uint32_t i = morton(x, y);
            covers[i] += by, in_block[i / k_leaves_of_block] += by;
        }
    const auto of_rect = static_cast<std::size_t>(rect.area());
    area = add ? area + of_rect : area - of_rect;
}

light_views::Rect LightTree::DynamicFootprints::set(scene::ObjectId object, const light_views::Rect& rect)
{
    light_views::Rect before;
    if (const auto at = rects.find(object); at != rects.end()) {
        before = at->second;
        rects.erase(at);
    }
    if (before == rect && rect.empty()) return before;
    count(before, false);
    count(rect, true);
    if (!rect.empty()) rects.emplace(object, rect);
    return before;
}

// Finds the footprints of all dynamic objects in a view that has none yet.
void LightTree::find_dynamic(View& view, std::vector<light_views::Rect>& where) const
{
    for (const scene::ObjectId o : dynamics_) {
        const light_views::Rect rect = footprint(view, o);
        if (rect.empty()) continue;
        view.dynamic_objects.set(o, rect);
        where.push_back(rect);
    }
}

// By how many texels a leaf's sample, which lies above the surface, may lie outside of a footprint that covers the
// leaf: footprints are one texel wider than what they cover.
int LightTree::stray_of(const View& view, const glm::vec3& sample, std::uint32_t leaf)
{
    const glm::dvec4 clip = glm::dmat4(view.projection.clip_from_world) * glm::dvec4(glm::dvec3(sample), 1);
    if (!(clip.w > 0)) return view.side;
    const glm::dvec2 at = (0.5 * glm::dvec2(clip) / clip.w + 0.5) * static_cast<double>(view.side);
    const double off =
        std::max(std::abs(at.x - (even_bits(leaf) + 0.5)), std::abs(at.y - (even_bits(leaf >> 1) + 0.5)));
    constexpr double k_inside = 0.99;
    if (off < k_inside) return 0;
    return off < view.side ? static_cast<int>(std::ceil(off)) : view.side;
}

// Tests again whether dynamic objects occlude the leaves in some rectangles, or thin their light, and updates the flux
// of those that changed and of the nodes above them. A leaf that no footprint covers has all of its light, so that the
// result depends on the present state alone.
void LightTree::occlude_leaves(View& view, const std::vector<light_views::Rect>& where)
{
    if (where.empty()) return;
    const NodeId leaves = first_of_level(view, view.levels);
    // Select the lit leaves in the rectangles.
    std::vector<std::uint32_t> tested;
    for (const light_views::Rect& rect : where)
        for (int y = std::max(rect.y0 - view.stray, 0); y < std::min(rect.y1 + view.stray, view.side); ++y)
            for (int x = std::max(rect.x0 - view.stray, 0); x < std::min(rect.x1 + view.stray, view.side); ++x) {
                const std::uint32_t i = morton(x, y);
                if (quads_[(leaves + i) / 4].flux[i % 4] > 0) tested.push_back(i);
            }
    std::sort(tested.begin(), tested.end());
    tested.erase(std::unique(tested.begin(), tested.end()), tested.end());
    // Cast a ray from each to the light, against dynamic objects.
    ray::RayQueue queue;
    queue.purpose = ray::RayClass::indirect;
    const scene::LightState& at = state_->light(view.light);
    for (const std::uint32_t i : tested) {
        const glm::vec3 from = samples_.at(leaves + i);
        if (view.projection.perspective)
            queue.push(from, 0, at.position - from, options_.ray_end);
        else
            queue.push(from, 0, -at.direction, k_infinity);
    }
    std::vector<std::uint8_t> occluded(tested.size() + ray::k_packet_pad);
    rays_->occluded(queue, 0, tested.size(), occluded.data(), ray::Against::dynamic_only);
    const bool thins = rays_->thins_light();
    if (thins && view.passes.empty()) view.passes.assign(view.occluded.size(), glm::vec3(1));
    std::vector<glm::vec3> passes(view.passes.empty() ? 0 : tested.size(), glm::vec3(1));
    if (thins) rays_->let_through(queue, 0, tested.size(), passes.data(), ray::Against::dynamic_only);
    for (std::size_t k = 0; k < tested.size(); ++k) {
        if (view.dynamic_objects.covers[tested[k]] != 0) continue;
        occluded[k] = 0;
        if (!passes.empty()) passes[k] = glm::vec3(1);
    }

    // Set the flux of those that changed.
    std::vector<std::uint32_t> dirty;
    for (std::size_t k = 0; k < tested.size(); ++k) {
        const std::uint32_t i = tested[k];
        if (view.occluded[i] == occluded[k] && (passes.empty() || view.passes[i] == passes[k])) continue;
        view.occluded[i] = occluded[k];
        if (!passes.empty()) view.passes[i] = passes[k];
        const glm::vec3 flux = occluded[k] ? glm::vec3(0) : static_flux_.at(leaves + i);
        flux_.set(leaves + i, passes.empty() ? flux : flux * passes[k]);
        dirty.push_back(i);
        view.dirty.push_back(leaves + i);
    }
    dirty_leaves_ += dirty.size();
    // Sum the nodes above them, level by level.
    for (int level = view.levels - 1; level > 0; --level) {
        for (std::uint32_t& i : dirty) i >>= 2;
        dirty.erase(std::unique(dirty.begin(), dirty.end()), dirty.end());
        dirty_nodes_ += dirty.size();
        for (const std::uint32_t i : dirty) {
            sum_children(flux_, first_of_level(view, level) + i);
            view.dirty.push_back(first_of_level(view, level) + i);
        }
    }
}

// Marks the nodes whose flux differs from their static flux.
void LightTree::mark_changes()
{
    changed_.clear();
    for (View& view : views_) {
        changed_.insert(changed_.end(), view.dirty.begin(), view.dirty.end());
        for (const NodeId id : view.dirty) {
            float& mark = samples_.places[id].w;
            differing_ -= mark != 0;
            mark = flux_.at(id) == static_flux_.at(id) ? 0.0f : 1.0f;
            differing_ += mark != 0;
        }
        view.dirty.clear();
    }
    if (patches_changed_)
        for (NodeId id = patch_first_; id < size(); ++id) changed_.push_back(id);
    patches_changed_ = false;
}

std::uint32_t LightTree::owner_of(scene::ObjectId object) const
{
    const scene::GroupId group = state_->group_of(object);
    constexpr std::uint32_t k_alone = 1u << 31;   // differs from all groups and from k_no_owner
    return group == scene::none ? object | k_alone : group;
}

void LightTree::update(const scene::SceneState& state, const ray::RayScene& rays, Tasks& tasks)
{
    state_ = &state;
    rays_ = &rays;
    casters_.update(state);
    changed_.clear();
    dirty_leaves_ = dirty_nodes_ = 0;
    const scene::FrameChanges& changes = state.changes();
    bool relit = false;   // patches, without dynamic objects
    if (!follow_patches(tasks, relit) || follow_lights_and_bounds(tasks)) return;
    const bool promoted = !changes.promoted.empty(), all = promoted || !changes.materials_changed.empty();
    geometry_changed_ = all || relit || !changes.lights_moved.empty() || !changes.lights_relit.empty();
    const bool other_objects = !changes.added.empty() || !changes.removed.empty();
    if (promoted || other_objects || !changes.separated.empty()) find_dynamics();
    if (!changes.materials_changed.empty()) reflection_.forget();
    if (geometry_changed_) {
        tasks.for_each(views_.size(), [&](std::size_t v, int) {
            if (all || changes.light_changed(views_[v].light)) make_view(views_[v]);
        });
        light_patches(tasks);
        find_roots();
        ++geometry_version_, ++flux_version_;
    }
    const bool unchanged = changes.changed.empty();
    if (unchanged && !geometry_changed_) return;
    if (!unchanged && !all) follow_dynamic(changes);
    follow_light(tasks);
}

// Builds the tree anew in other bounds, or if lights that changed have another number of views or a brightness that
// makes other lights the strongest.
// @return  whether it did
bool LightTree::follow_lights_and_bounds(Tasks& tasks)
{
    const scene::FrameChanges& changes = state_->changes();
    if (!follow_bounds()) {
        if (changes.lights_moved.empty() && changes.lights_relit.empty() && changes.materials_changed.empty())
            return false;
        const std::vector<View> wanted = wanted_views();
        const bool same =
            std::equal(wanted.begin(), wanted.end(), views_.begin(), views_.end(), [](const View& a, const View& b) {
                return a.light == b.light && a.face == b.face && a.behind == b.behind;
            });
        if (same) return false;
    }
    rebuild(tasks);
    return true;
}

void LightTree::rebuild(Tasks& tasks)
{
    build(tasks);
    geometry_changed_ = true;
    ++geometry_version_, ++flux_version_;
}

void LightTree::follow_dynamic(const scene::FrameChanges& changes)
{
    for (View& view : views_) {
        interruption_point();
        if (!view.on || changes.light_changed(view.light)) continue;
        std::vector<light_views::Rect> where;
        for (const scene::ObjectId o : changes.changed) {
            if (!takes_light(o)) continue;
            const light_views::Rect now = footprint(view, o);
            where.push_back(view.dynamic_objects.set(o, now));
            where.push_back(now);
        }
        std::erase_if(where, [](const light_views::Rect& rect) { return rect.empty(); });
        const std::uint64_t before = dirty_leaves_;
        occlude_leaves(view, where);
        if (dirty_leaves_ != before) ++flux_version_;
    }
}

std::size_t LightTree::bytes() const
{
    std::size_t bytes = quads_.size() * sizeof(VirtualLightQuad) +
                        children_.size() * (10 * sizeof(float) + 2 * sizeof(NodeId)) +
                        patch_difference_.r.size() * 3 * sizeof(float);
    for (const View& view : views_) bytes += view.patch.size() * sizeof(std::uint16_t);
    if (patches_) bytes += patches_->bytes() + occluders_.bytes();
    return bytes;
}

}   // namespace gnomon::irradiance_cache
