// SPDX-License-Identifier: Apache-2.0
#include "light_quadtree/light_map.h"

#include <algorithm>
#include <bit>

#include "base/bits.h"
#include "base/check.h"
#include "base/interruption.h"
#include "light_quadtree/ball_footprint.h"
#include "light_views/texel_ray.h"
#include "lighting/diffuse.h"

namespace gnomon::light_quadtree {

namespace {

// The radius of a rigid object's bounding ball about the centre of its box, in object space.
float bounding_radius(const scene::Scene& scene, const scene::Object& object)
{
    if (object.deforming) return 0;
    const scene::Mesh& mesh = scene.meshes[object.mesh];
    const glm::vec3 centre = mesh.bounds().centre();
    float square = 0;
    for (const glm::vec3& p : mesh.positions) square = std::max(square, glm::dot(p - centre, p - centre));
    return std::sqrt(square);
}

// The scale factor of a matrix if it is uniform, else 0.
double uniform_scale(const glm::dmat3& m)
{
    constexpr double k_uneven = 1e-4;   // tolerance on squared scales
    const double square = glm::dot(m[0], m[0]);
    for (int a = 0; a < 3; ++a)
        for (int b = 0; b < 3; ++b)
            if (!(std::abs(glm::dot(m[a], m[b]) - (a == b ? square : 0)) <= k_uneven * square)) return 0;
    return std::sqrt(square) * (1 + 4 * k_uneven);
}

}   // namespace

LightMap::LightMap(const scene::SceneState& state, const ray::RayScene& rays, const LightMapOptions& options,
                   Tasks& tasks)
    : options_(options), casters_(state), bounds_(state.present_bounds())
{
    GNOMON_CHECK(options.least_side >= k_tile && options.side >= options.least_side);
    const scene::Scene& scene = state.scene();
    for (const scene::ObjectId o : state.dynamic_objects()) ball_.push_back(bounding_radius(scene, scene.objects[o]));
    views_ = lay_out_views(scene, bounds_, options);
    const std::size_t end = views_.empty() ? 0 : views_.back().end();
    nodes_.resize(end);
    share_.assign(end, 0);
    if (options.separate_trees) {
        std::size_t uppers = 0;
        for (const View& view : views_) {
            first_upper_.push_back(uppers);
            uppers += view.node(view.levels, 0, 0) - view.first;
        }
        dynamic_nodes_.resize(uppers);
        dynamic_share_.assign(uppers, k_whole_share);
    }
    layers_.resize(views_.size());
    std::vector<Work> works(views_.size());
    tasks.for_each(views_.size(), [&](std::size_t v, int) { make_view(v, state, rays, works[v]); });
    for (const Work& work : works) work_.cast += work.cast;
}

light_views::Rect LightMap::footprint(const View& view, const scene::SceneState& state, scene::ObjectId object) const
{
    if (!view.on) return {};
    const light_views::Rect of_box = casters_.footprint(view.projection, state, object);
    const auto ball = static_cast<double>(ball_[state.dynamic_index(object)]);
    if (of_box.empty() || !(ball > 0)) return of_box;
    const glm::dmat4 world(state.object_matrix(object));
    const double scale = uniform_scale(glm::dmat3(world));
    if (!(scale > 0)) return of_box;
    const glm::dvec3 centre(world * glm::dvec4(glm::dvec3(casters_.box(object).centre()), 1));
    const auto of_ball = ball_footprint(view.projection, centre, scale * ball);
    return of_ball ? light_views::intersection(of_box, *of_ball) : of_box;
}

// Traces the static layer, builds the pyramid, and adds dynamic objects.
void LightMap::make_view(std::size_t v, const scene::SceneState& state, const ray::RayScene& rays, Work& work)
{
    View& view = views_[v];
    Layers& layers = layers_[v];
    // Reset the view's nodes and layers.
    const std::size_t end = view.end();
    std::fill(nodes_.begin() + static_cast<std::ptrdiff_t>(view.first),
              nodes_.begin() + static_cast<std::ptrdiff_t>(end), LightNode{});
    std::fill(share_.begin() + static_cast<std::ptrdiff_t>(view.first),
              share_.begin() + static_cast<std::ptrdiff_t>(end), k_whole_share);
    const int tiles = view.side() / k_tile;
    layers.slot.assign(static_cast<std::size_t>(tiles) * static_cast<std::size_t>(tiles), -1);
    layers.kept.clear();
    layers.reach.assign(layers.slot.size(), {});
    layers.footprints.assign(ball_.size(), {});
    if (options_.separate_trees) {
        const std::size_t first = upper(view, 0, 0, 0), count = view.node(view.levels, 0, 0) - view.first;
        std::fill_n(dynamic_nodes_.begin() + static_cast<std::ptrdiff_t>(first), count, LightNode{});
        std::fill_n(dynamic_share_.begin() + static_cast<std::ptrdiff_t>(first), count, k_whole_share);
    }
    aim_view(view, state, bounds_);
    if (!view.on) return;

    // Trace the static layer, tile by tile.
    for (int tile = 0; tile < tiles * tiles; ++tile) {
        interruption_point();
        Tile texels{};
        Distances& reach = layers.reach[static_cast<std::size_t>(tile)];
        reach.fill(k_infinity);
        cast_tile(view, tile, k_whole_tile, state, rays, ray::Against::static_only, texels, reach);
        for (int i = 0; i < k_tile * k_tile; ++i)
            nodes_[view.node(view.levels, tile % tiles * k_tile + i % k_tile, tile / tiles * k_tile + i / k_tile)] =
                texels[static_cast<std::size_t>(i)];
    }
    work.cast += static_cast<std::uint64_t>(view.side()) * static_cast<std::uint64_t>(view.side());
    // Build the pyramid, finest level first.
    for (int level = view.levels - 1; level >= 0; --level)
        for (int y = 0; y < 1 << level; ++y)
            for (int x = 0; x < 1 << level; ++x) make_node(view, level, x, y);

    // Add dynamic objects.
    for (std::size_t d = 0; d < ball_.size(); ++d)
        layers.footprints[d] = footprint(view, state, state.dynamic_objects()[d]);
    const light_views::Rect everywhere{0, 0, view.side(), view.side()};
    repair_view(
        v,
        options_.against_everything ? std::span(&everywhere, 1) : std::span<const light_views::Rect>(layers.footprints),
        state, rays, work);
}

// Traces the rays of a tile's texels in the mask, up to `reach`, and stores hits over the current contents. A tile's
// rays always form the same packets, independent of other tiles.
void LightMap::cast_tile(const View& view, int tile, TexelMask which, const scene::SceneState& state,
                         const ray::RayScene& rays, ray::Against against, Tile& texels, Distances& reach) const
{
    const scene::Scene& scene = state.scene();
    const scene::Light& light = scene.lights[view.light];
    const scene::LightState& at = state.light(view.light);
    const int tiles = view.side() / k_tile;
    const int left = tile % tiles * k_tile, top = tile / tiles * k_tile;
    const glm::vec3 axis = glm::normalize(view.projection.forward);
    light_views::ViewProjection outside_of;
    const bool outside = leaves_out(view, state, bounds_, outside_of);

    thread_local ray::RayQueue queue, onward;
    thread_local ray::Hits hits;
    thread_local std::vector<int> place, onward_place;
    queue.purpose = onward.purpose = ray::RayClass::indirect;
    queue.clear();
    place.clear();
    for (TexelMask left_over = which; left_over; left_over &= left_over - 1) {
        const int i = std::countr_zero(left_over);
        const light_views::TexelWay r = light_views::texel_way(view.projection, left + i % k_tile, top + i / k_tile);
        queue.push(r.origin, 0, r.direction, reach[static_cast<std::size_t>(i)]);
        place.push_back(i);
    }
    for (int pass = 0; pass <= options_.most_transparent && !queue.empty(); ++pass) {
        hits.resize(queue.size());
        rays.closest(queue, 0, queue.size(), hits, ray::Sides::both, against);
        onward.clear();
        onward_place.clear();
        for (std::size_t k = 0; k < queue.size(); ++k) {
            if (hits.object[k] == scene::none) continue;
            const ray::ObjectGeometry& geometry = rays.geometry(hits.object[k]);
            const std::uint32_t triangle = hits.triangle[k];
            // Pass through surfaces that do not occlude light.
            const scene::Material& material = scene.materials[geometry.mesh->part_of(triangle).material];
            if (material.surface_class() == scene::SurfaceClass::transparent) {
                onward.push(queue.origin(k), std::nextafter(hits.t[k], k_infinity), queue.direction(k),
                            reach[static_cast<std::size_t>(place[k])]);
                onward_place.push_back(place[k]);
                continue;
            }
            LightNode& texel = texels[static_cast<std::size_t>(place[k])];
            texel = {};
            reach[static_cast<std::size_t>(place[k])] = hits.t[k];
            glm::vec3 p[3];
            geometry.corners(triangle, p);
            const float u = hits.u[k], v = hits.v[k];
            const glm::vec3 position = std::max(0.0f, 1 - u - v) * p[0] + u * p[1] + v * p[2];
            glm::vec3 normal = glm::cross(p[1] - p[0], p[2] - p[0]);
            const float length = glm::length(normal);
            if (!(length > 0)) continue;
            normal /= length;
            float cosine = -glm::dot(normal, queue.direction(k));
            if (cosine < 0) normal = -normal, cosine = -cosine;
            // In the wide view of a directional light, skip texels that its near view covers.
            if (outside) {
                const glm::vec4 clip = outside_of.clip_from_world * glm::vec4(position, 1);
                if (std::abs(clip.x) <= 1 && std::abs(clip.y) <= 1) continue;
            }
            const auto t = static_cast<double>(hits.t[k]);
            const double measure =
                light_views::texel_measure(view.projection, left + place[k] % k_tile, top + place[k] / k_tile);
            const double facing_area = measure * (view.projection.perspective ? t * t : 1.0);
            texel.position = position;
            texel.normal = normal;
            texel.depth = glm::dot(position - view.projection.origin, axis) / view.depth_range;
            texel.area = static_cast<float>(facing_area) / std::max(cosine, options_.least_cosine);
            texel.flux = lighting::exitance_per_irradiance(scene, geometry, triangle, u, v) *
                         scene::illuminate(light, at, position).irradiance * static_cast<float>(facing_area);
            texel.members = 1;
        }
        std::swap(queue, onward);
        std::swap(place, onward_place);
    }
}

std::span<const LightMap::Tree> LightMap::trees() const
{
    static constexpr Tree k_one[] = {Tree::whole}, k_two[] = {Tree::static_objects, Tree::dynamic_objects};
    return options_.separate_trees ? std::span<const Tree>(k_two) : std::span<const Tree>(k_one);
}

// The place of a node above the texels in the tree of dynamic objects.
std::size_t LightMap::upper(const View& view, int level, int x, int y) const
{
    return first_upper_[view_number(view)] + view.node(level, x, y) - view.first;
}

// The static texel under one that may show a dynamic object; null where none has been.
const LightNode* LightMap::static_layer(const View& view, int x, int y) const
{
    const Layers& layers = layers_[view_number(view)];
    const int tiles = view.side() / k_tile;
    const std::int32_t slot = layers.slot[static_cast<std::size_t>(y / k_tile * tiles + x / k_tile)];
    if (slot < 0) return nullptr;
    return &layers.kept[static_cast<std::size_t>(slot)][static_cast<std::size_t>(y % k_tile * k_tile + x % k_tile)];
}

// A texel is of a dynamic object if it differs from the static layer.
LightMap::Tree LightMap::tree_of(const View& view, int x, int y) const
{
    if (!options_.separate_trees) return Tree::whole;
    const LightNode* const under = static_layer(view, x, y);
    return under && !same_bits(nodes_[view.node(view.levels, x, y)], *under) ? Tree::dynamic_objects
                                                                             : Tree::static_objects;
}

LightNode LightMap::node(Tree tree, const View& view, int level, int x, int y) const
{
    const LightNode& own = nodes_[view.node(level, x, y)];
    if (tree == Tree::whole) return own;
    if (level < view.levels) return tree == Tree::static_objects ? own : dynamic_nodes_[upper(view, level, x, y)];
    if (tree_of(view, x, y) == tree) return own;
    if (tree == Tree::dynamic_objects) return {};
    LightNode covered = *static_layer(view, x, y);
    covered.flux = glm::vec3(0);
    return covered;
}

Share LightMap::share(Tree tree, const View& view, int level, int x, int y) const
{
    return tree == Tree::dynamic_objects && level < view.levels ? dynamic_share_[upper(view, level, x, y)]
                                                                : share_[view.node(level, x, y)];
}

void LightMap::make_node(const View& view, int level, int x, int y)
{
    if (options_.separate_trees) {
        for (const Tree tree : trees()) {
            const LightNode four[4] = {
                node(tree, view, level + 1, 2 * x, 2 * y), node(tree, view, level + 1, 2 * x + 1, 2 * y),
                node(tree, view, level + 1, 2 * x, 2 * y + 1), node(tree, view, level + 1, 2 * x + 1, 2 * y + 1)};
            const bool dynamic = tree == Tree::dynamic_objects;
            LightNode& mean = dynamic ? dynamic_nodes_[upper(view, level, x, y)] : nodes_[view.node(level, x, y)];
            mean = mean_of(four);
            (dynamic ? dynamic_share_[upper(view, level, x, y)] : share_[view.node(level, x, y)]) =
                share_of(four, mean, options_.validity);
        }
        return;
    }
    const LightNode four[4] = {
        nodes_[view.node(level + 1, 2 * x, 2 * y)], nodes_[view.node(level + 1, 2 * x + 1, 2 * y)],
        nodes_[view.node(level + 1, 2 * x, 2 * y + 1)], nodes_[view.node(level + 1, 2 * x + 1, 2 * y + 1)]};
    const std::size_t id = view.node(level, x, y);
    nodes_[id] = mean_of(four);
    share_[id] = share_of(four, nodes_[id], options_.validity);
}

// Updates the tiles under some rectangles, and the nodes above texels that changed.
void LightMap::repair_view(std::size_t v, std::span<const light_views::Rect> where, const scene::SceneState& state,
                           const ray::RayScene& rays, Work& work)
{
    const View& view = views_[v];
    Layers& layers = layers_[v];
    const int tiles = view.side() / k_tile;
    const auto each_tile = [&](std::span<const light_views::Rect> rects, const auto& act) {
        for (const light_views::Rect& rect : rects) {
            if (rect.empty()) continue;
            for (int y = rect.y0 / k_tile; y <= (rect.y1 - 1) / k_tile; ++y)
                for (int x = rect.x0 / k_tile; x <= (rect.x1 - 1) / k_tile; ++x) act(rect, x, y);
        }
    };
    std::vector<int> dirty;
    each_tile(where, [&](const light_views::Rect&, int x, int y) { dirty.push_back(y * tiles + x); });
    if (dirty.empty()) return;
    std::sort(dirty.begin(), dirty.end());
    dirty.erase(std::unique(dirty.begin(), dirty.end()), dirty.end());

    // Find the texels that a dynamic object may cover. This depends on the current positions only, not on earlier
    // frames.
    std::vector<TexelMask> covered(layers.slot.size(), 0);
    each_tile(layers.footprints, [&](const light_views::Rect& rect, int x, int y) {
        const auto from = [](int low, int tile_at) { return std::max(low - tile_at * k_tile, 0); };
        const auto to = [](int high, int tile_at) { return std::min(high - tile_at * k_tile, k_tile); };
        const TexelMask row = (k_whole_row >> (k_tile - to(rect.x1, x))) & (k_whole_row << from(rect.x0, x));
        TexelMask& mask =
            covered[static_cast<std::size_t>(y) * static_cast<std::size_t>(tiles) + static_cast<std::size_t>(x)];
        for (int line = from(rect.y0, y); line < to(rect.y1, y); ++line) mask |= row << (line * k_tile);
    });

    std::vector<std::uint32_t> changed;   // x + side * y
    for (const int tile : dirty) {
        interruption_point();
        const int left = tile % tiles * k_tile, top = tile / tiles * k_tile;
        const auto texel = [&](int i) -> LightNode& {
            return nodes_[view.node(view.levels, left + i % k_tile, top + i / k_tile)];
        };
        // Keep the static layer when the first dynamic object covers the tile.
        std::int32_t& slot = layers.slot[static_cast<std::size_t>(tile)];
        if (slot < 0) {
            slot = static_cast<std::int32_t>(layers.kept.size());
            Tile& kept = layers.kept.emplace_back();
            for (int i = 0; i < k_tile * k_tile; ++i) kept[static_cast<std::size_t>(i)] = texel(i);
        }
        Tile now = layers.kept[static_cast<std::size_t>(slot)];
        if (const TexelMask mask = options_.against_everything ? k_whole_tile : covered[static_cast<std::size_t>(tile)];
            mask != 0) {
            if (options_.against_everything) {
                now = {};
                Distances reach;
                reach.fill(k_infinity);
                cast_tile(view, tile, mask, state, rays, ray::Against::everything, now, reach);
            } else {
                Distances reach = layers.reach[static_cast<std::size_t>(tile)];
                cast_tile(view, tile, mask, state, rays, ray::Against::dynamic_only, now, reach);
            }
            work.cast += static_cast<std::uint64_t>(std::popcount(mask));
        }
        for (int i = 0; i < k_tile * k_tile; ++i) {
            if (same_bits(texel(i), now[static_cast<std::size_t>(i)])) continue;
            texel(i) = now[static_cast<std::size_t>(i)];
            changed.push_back(static_cast<std::uint32_t>((top + i / k_tile) * view.side() + left + i % k_tile));
        }
    }
    work.dirty_texels += changed.size();

    // Update the pyramid upwards from the changed texels.
    for (int level = view.levels - 1; level >= 0; --level) {
        for (std::uint32_t& at : changed) {
            const std::uint32_t below = level + 1, x = at & ((1u << below) - 1), y = at >> below;
            at = (x >> 1) + ((y >> 1) << level);
        }
        std::sort(changed.begin(), changed.end());
        changed.erase(std::unique(changed.begin(), changed.end()), changed.end());
        work.dirty_nodes += changed.size();
        for (const std::uint32_t at : changed)
            make_node(view, level, static_cast<int>(at & ((1u << level) - 1)), static_cast<int>(at >> level));
    }
}

void LightMap::update(const scene::SceneState& state, const ray::RayScene& rays, Tasks& tasks)
{
    casters_.update(state);
    work_ = {};
    const scene::FrameChanges& changes = state.changes();
    const bool other_bounds = !(state.present_bounds() == bounds_);
    if (!changes.anything() && !other_bounds) return;
    // Make the map anew in other bounds, or if the lights have other views now. A promoted object leaves the static
    // layer: cast it anew, too. (A transparent one as well, because the rays behind it were traced in other packets.)
    const bool other_layout =
        !changes.lights_moved.empty() && !same_layout(views_, lay_out_views(state.scene(), bounds_, options_));
    if (other_bounds || other_layout || !changes.promoted.empty()) {
        remake(state, rays, tasks);
        return;
    }

    std::vector<Work> works(views_.size());
    std::vector<std::uint8_t> anew(views_.size(), 0);
    tasks.for_each(views_.size(), [&](std::size_t v, int) {
        if (!changes.materials_changed.empty() || changes.light_changed(views_[v].light)) {
            make_view(v, state, rays, works[v]);
            anew[v] = 1;
            return;
        }
        std::vector<light_views::Rect> where;
        for (const scene::ObjectId o : changes.changed) {
            light_views::Rect& rect = layers_[v].footprints[state.dynamic_index(o)];
            where.push_back(rect);
            rect = footprint(views_[v], state, o);
            where.push_back(rect);
        }
        repair_view(v, where, state, rays, works[v]);
    });
    bool changed = false;
    for (std::size_t v = 0; v < views_.size(); ++v) {
        work_.cast += works[v].cast;
        work_.dirty_texels += works[v].dirty_texels;
        work_.dirty_nodes += works[v].dirty_nodes;
        changed |= anew[v] || works[v].dirty_texels > 0;
    }
    if (changed) ++version_;
}

void LightMap::remake(const scene::SceneState& state, const ray::RayScene& rays, Tasks& tasks)
{
    const std::uint32_t before = version_;
    *this = LightMap(state, rays, options_, tasks);
    version_ = before + 1;
}

std::size_t LightMap::bytes() const
{
    std::size_t bytes = (nodes_.size() + dynamic_nodes_.size()) * (sizeof(LightNode) + 1);
    for (const Layers& layers : layers_)
        bytes += layers.slot.size() * (sizeof(std::int32_t) + sizeof(Distances)) + layers.kept.size() * sizeof(Tile);
    return bytes;
}

}   // namespace gnomon::light_quadtree
