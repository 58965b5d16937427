// SPDX-License-Identifier: Apache-2.0
#include "light_quadtree/emitters.h"

#include <algorithm>

#include "base/check.h"
#include "light_quadtree/diffuse.h"
#include "ray/origin.h"

namespace gnomon::light_quadtree {

namespace {

constexpr NodeId k_none = scene::none;

float luminance(const glm::vec3& c)
{
    return 0.2126f * c.x + 0.7152f * c.y + 0.0722f * c.z;
}

std::uint32_t spread(std::uint32_t x)
{
    x &= 0xffff;
    x = (x | (x << 8)) & 0x00ff00ff;
    x = (x | (x << 4)) & 0x0f0f0f0f;
    x = (x | (x << 2)) & 0x33333333;
    return (x | (x << 1)) & 0x55555555;
}

// Leaves in Morton order: the children of a node lie together.
std::uint32_t morton(int x, int y)
{
    return spread(static_cast<std::uint32_t>(x)) | (spread(static_cast<std::uint32_t>(y)) << 1);
}

std::uint32_t gathered(std::uint32_t x)
{
    x &= 0x55555555;
    x = (x | (x >> 1)) & 0x33333333;
    x = (x | (x >> 2)) & 0x0f0f0f0f;
    x = (x | (x >> 4)) & 0x00ff00ff;
    return (x | (x >> 8)) & 0x0000ffff;
}

constexpr light_views::ProjectionOptions k_projection{.border = 0};   // views side by side, no overlap

// The ray of a texel, and what it stands for: its solid angle (perspective), or its area.
struct TexelRay {
    glm::vec3 origin, direction;   // unit
    double measure;
};

TexelRay texel_ray(const light_views::ViewProjection& view, int x, int y)
{
    const double texel = 2.0 / view.size;
    const auto cx = static_cast<float>((x + 0.5) * texel - 1), cy = static_cast<float>((y + 0.5) * texel - 1);
    const double cell =
        texel * texel * static_cast<double>(glm::length(view.across)) * static_cast<double>(glm::length(view.down));
    const glm::vec3 off = cx * view.across + cy * view.down;
    if (!view.perspective) return {view.origin + off, glm::normalize(view.forward), cell};
    const glm::vec3 direction = view.forward + off;
    const auto length = static_cast<double>(glm::length(direction));
    const double forward = glm::length(view.forward);
    return {view.origin, glm::normalize(direction), cell * forward / (length * length * length)};
}

}   // namespace

EmitterTree::EmitterTree(const scene::SceneState& state, const ray::RayScene& rays, const EmitterOptions& options,
                         Tasks& tasks)
    : options_(options), casters_(state), bounds_(light_views::clip_bounds(state.scene()))
{
    const scene::Scene& scene = state.scene();
    for (scene::ObjectId o = 0; o < scene.objects.size(); ++o)
        if (scene.objects[o].dynamic && casters_.casts(o)) dynamics_.push_back(o);
    for (scene::LightId l = 0; l < scene.lights.size(); ++l)
        for (int face = 0; face < light_views::view_count(scene.lights[l], bounds_, k_projection); ++face) {
            View& view = views_.emplace_back();
            view.light = l;
            view.face = face;
        }
    int side = options.side;
    while (side > options.least_side &&
           views_.size() * static_cast<std::size_t>(side) * static_cast<std::size_t>(side) > options.leaves)
        side /= 2;
    NodeId end = 0;
    for (View& view : views_) {
        view.side = side;
        while ((1 << view.levels) < side) ++view.levels;
        view.first = end;
        end = first_of_level(view, view.levels + 1);
        view.blocked.assign(static_cast<std::size_t>(side) * static_cast<std::size_t>(side), 0);
    }
    quads_.resize(end / 4);
    for (auto* lane : {&samples_.x, &samples_.y, &samples_.z, &flux_.r, &flux_.g, &flux_.b}) lane->resize(end);
    leaf_flux_.resize(end);
    children_.assign(end, k_none);
    for (const View& view : views_)
        for (int level = 1; level < view.levels; ++level)
            for (std::uint32_t i = 0; i < 1u << (2 * level); ++i)
                children_[first_of_level(view, level) + i] = first_of_level(view, level + 1) / 4 + i;
    tasks.for_each(views_.size(), [&](std::size_t v, int) { make_view(views_[v], state, rays); });
    find_roots();
}

void EmitterTree::find_roots()
{
    roots_.clear();
    for (const View& view : views_) {
        const EmitterQuad& top = quads_[view.first / 4];
        if (std::max({top.flux[0], top.flux[1], top.flux[2], top.flux[3]}) > 0) roots_.push_back(view.first / 4);
    }
}

void EmitterTree::set_flux(NodeId id, const glm::vec3& flux)
{
    flux_.r[id] = flux.x, flux_.g[id] = flux.y, flux_.b[id] = flux.z;
}

glm::vec3 EmitterTree::flux_of(NodeId id) const
{
    return {flux_.r[id], flux_.g[id], flux_.b[id]};
}

// Casts the static layer, builds the pyramid, and darkens what moving objects shadow.
void EmitterTree::make_view(View& view, const scene::SceneState& state, const ray::RayScene& rays)
{
    const scene::Scene& scene = state.scene();
    const scene::Light& light = scene.lights[view.light];
    const scene::LightState& at = state.light(view.light);
    const NodeId leaves = first_of_level(view, view.levels);
    const auto count = static_cast<std::uint32_t>(view.side * view.side);
    const NodeId end = leaves + count;
    std::fill(quads_.begin() + view.first / 4, quads_.begin() + end / 4, EmitterQuad{});
    for (NodeId id = view.first; id < end; ++id) set_flux(id, glm::vec3(0));
    std::fill_n(leaf_flux_.begin() + leaves, count, glm::vec3(0));
    std::fill(view.blocked.begin(), view.blocked.end(), 0);
    view.on = at.visible && light.color != glm::vec3(0) && !light.of_environment;
    view.movers.clear();
    if (!view.on) return;
    const auto projections = light_views::project(light, at, bounds_, view.side, k_projection);
    view.projection = projections[static_cast<std::size_t>(view.face)];

    // Cast one ray a leaf, in tree order: neighbours share packets.
    ray::RayQueue queue;
    queue.purpose = ray::RayClass::indirect;
    std::vector<double> measure(count);
    for (std::uint32_t i = 0; i < count; ++i) {
        const TexelRay r =
            texel_ray(view.projection, static_cast<int>(gathered(i)), static_cast<int>(gathered(i >> 1)));
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
    rays.closest(queue, 0, count, hits, ray::Sides::both, ray::Against::static_only);
    for (std::uint32_t i = 0; i < count; ++i) {
        if (hits.object[i] == scene::none) continue;
        const ray::ObjectGeometry& geometry = rays.geometry(hits.object[i]);
        glm::vec3 p[3];
        geometry.corners(hits.triangle[i], p);
        const float u = hits.u[i], v = hits.v[i];
        const glm::vec3 position = std::max(0.0f, 1 - u - v) * p[0] + u * p[1] + v * p[2];
        glm::vec3 normal = glm::cross(p[1] - p[0], p[2] - p[0]);
        const float length = glm::length(normal);
        if (!(length > 0)) continue;
        normal /= length;
        float cosine = -glm::dot(normal, queue.direction(i));
        if (cosine < 0) normal = -normal, cosine = -cosine;
        // The wide view of a directional light leaves out what the near one has.
        if (light.type == scene::LightType::directional && view.face == 1) {
            const glm::vec4 clip = projections[0].clip_from_world * glm::vec4(position, 1);
            if (std::abs(clip.x) <= 1 && std::abs(clip.y) <= 1) continue;
        }
        const scene::LightSample sample = scene::illuminate(light, at, position);
        if (sample.irradiance == glm::vec3(0)) continue;

        const double facing_area = view.projection.perspective
                                       ? measure[i] * static_cast<double>(hits.t[i]) * static_cast<double>(hits.t[i])
                                       : measure[i];
        const glm::vec3 exitance = exitance_per_irradiance(scene, geometry, hits.triangle[i], u, v);
        Node& leaf = node_of(leaves + i);
        leaf.position = position;
        leaf.normal = normal;
        leaf.area = static_cast<float>(facing_area) / std::max(cosine, options_.least_cosine);
        leaf.radius = std::sqrt(leaf.area * static_cast<float>(1 / k_pi));
        leaf.sample = position + ray::origin_lift(p) * normal;
        leaf_flux_[leaves + i] = exitance * sample.irradiance * static_cast<float>(facing_area);
        leaf.flux = luminance(leaf_flux_[leaves + i]);
        set_flux(leaves + i, leaf_flux_[leaves + i]);
    }

    // Pull up: means weighted by flux; four children in one fixed order.
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
            sum_children(id);
            if (!(node.flux > 0)) continue;
            node.position = position / node.flux;
            node.normal = normal / node.flux;
            float nearest = k_infinity;
            for (NodeId c = child; c < child + 4; ++c) {
                const Node& part = node_of(c);
                if (!(part.flux > 0)) continue;
                node.radius = std::max(node.radius, glm::length(part.position - node.position) + part.radius);
                const float distance = glm::length(part.sample - node.position);
                if (distance < nearest) nearest = distance, node.sample = part.sample;
            }
        }
    for (NodeId id = view.first; id < end; ++id) {
        const Node& node = node_of(id);
        EmitterQuad& quad = quads_[id / 4];
        const NodeId lane = id % 4;
        quad.x[lane] = node.position.x, quad.y[lane] = node.position.y, quad.z[lane] = node.position.z;
        quad.nx[lane] = node.normal.x, quad.ny[lane] = node.normal.y, quad.nz[lane] = node.normal.z;
        quad.radius[lane] = node.radius, quad.area[lane] = node.area, quad.flux[lane] = node.flux;
        samples_.x[id] = node.sample.x, samples_.y[id] = node.sample.y, samples_.z[id] = node.sample.z;
    }
    find_movers(view, state);
    block_leaves(view, view.movers, state, rays);
}

// Four children in one fixed order.
void EmitterTree::sum_children(NodeId id)
{
    glm::vec3 sum(0);
    for (NodeId c = 4 * children_[id]; c < 4 * children_[id] + 4; ++c) sum += flux_of(c);
    set_flux(id, sum);
}

void EmitterTree::find_movers(View& view, const scene::SceneState& state) const
{
    view.movers.clear();
    if (!view.on) return;
    for (const scene::ObjectId o : dynamics_) {
        const light_views::Rect rect = casters_.footprint(view.projection, state, o);
        if (!rect.empty()) view.movers.push_back(rect);
    }
}

// Asks for the leaves in some rectangles anew whether something that moves keeps the light from them, and repairs the
// flux above those that changed.
void EmitterTree::block_leaves(View& view, const std::vector<light_views::Rect>& where, const scene::SceneState& state,
                               const ray::RayScene& rays)
{
    if (where.empty()) return;
    const NodeId leaves = first_of_level(view, view.levels);
    std::vector<std::uint32_t> asked;
    for (const light_views::Rect& rect : where)
        for (int y = rect.y0; y < rect.y1; ++y)
            for (int x = rect.x0; x < rect.x1; ++x) {
                const std::uint32_t i = morton(x, y);
                if (quads_[(leaves + i) / 4].flux[i % 4] > 0) asked.push_back(i);
            }
    std::sort(asked.begin(), asked.end());
    asked.erase(std::unique(asked.begin(), asked.end()), asked.end());
    ray::RayQueue queue;
    queue.purpose = ray::RayClass::indirect;
    const scene::LightState& at = state.light(view.light);
    for (const std::uint32_t i : asked) {
        const glm::vec3 from = samples_.at(leaves + i);
        if (view.projection.perspective)
            queue.push(from, 0, at.position - from, options_.ray_end);
        else
            queue.push(from, 0, -at.direction, k_infinity);
    }
    std::vector<std::uint8_t> blocked(asked.size() + ray::k_packet_pad);
    rays.blocked(queue, 0, asked.size(), blocked.data(), ray::Against::dynamic_only);

    std::vector<std::uint32_t> dirty;
    for (std::size_t k = 0; k < asked.size(); ++k) {
        const std::uint32_t i = asked[k];
        if (view.blocked[i] == blocked[k]) continue;
        view.blocked[i] = blocked[k];
        set_flux(leaves + i, blocked[k] ? glm::vec3(0) : leaf_flux_[leaves + i]);
        dirty.push_back(i);
    }
    dirty_leaves_ += dirty.size();
    for (int level = view.levels - 1; level > 0; --level) {
        for (std::uint32_t& i : dirty) i >>= 2;
        dirty.erase(std::unique(dirty.begin(), dirty.end()), dirty.end());
        dirty_nodes_ += dirty.size();
        for (const std::uint32_t i : dirty) sum_children(first_of_level(view, level) + i);
    }
}

void EmitterTree::update(const scene::SceneState& state, const ray::RayScene& rays, Tasks& tasks)
{
    casters_.update(state);
    dirty_leaves_ = dirty_nodes_ = 0;
    const scene::FrameChanges& changes = state.changes();
    if (!changes.lights_moved.empty()) {
        tasks.for_each(views_.size(), [&](std::size_t v, int) {
            if (std::binary_search(changes.lights_moved.begin(), changes.lights_moved.end(), views_[v].light))
                make_view(views_[v], state, rays);
        });
        find_roots();
        ++geometry_version_, ++flux_version_;
    }
    if (changes.moved.empty() && changes.deformed.empty() && changes.appeared.empty() && changes.vanished.empty())
        return;
    for (View& view : views_) {
        if (!view.on || std::binary_search(changes.lights_moved.begin(), changes.lights_moved.end(), view.light))
            continue;
        std::vector<light_views::Rect> where = view.movers;
        find_movers(view, state);
        where.insert(where.end(), view.movers.begin(), view.movers.end());
        const std::uint64_t before = dirty_leaves_;
        block_leaves(view, where, state, rays);
        if (dirty_leaves_ != before) ++flux_version_;
    }
}

std::size_t EmitterTree::bytes() const
{
    return quads_.size() * sizeof(EmitterQuad) +
           children_.size() * (6 * sizeof(float) + sizeof(glm::vec3) + sizeof(NodeId));
}

}   // namespace gnomon::light_quadtree
