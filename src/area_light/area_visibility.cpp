// SPDX-License-Identifier: Apache-2.0
#include "area_light/area_visibility.h"

#include <algorithm>

#include "ray/origin.h"
#include "scene/alpha_mask.h"

namespace gnomon::area_light {

namespace {

using visibility::ShadowPoint;
using visibility::TriangleId;

constexpr std::size_t k_rays_at_once = 1 << 14;
constexpr std::size_t k_points_at_once = 16;
constexpr std::size_t k_most_hole_maps = 256;

bool same_bits(const FlatLight& a, const FlatLight& b)
{
    return same_bits(a.outline, b.outline) &&
           std::equal(a.faces.begin(), a.faces.end(), b.faces.begin(), b.faces.end(),
                      [](const LightPolygon& x, const LightPolygon& y) { return same_bits(x, y); });
}

LightPolygon turned(const LightPolygon& polygon)
{
    LightPolygon back = polygon;
    std::reverse(back.corner.begin(), back.corner.begin() + back.corners);
    for (auto k = static_cast<std::size_t>(back.corners); k < back.corner.size(); ++k)
        back.corner[k] = back.corner[static_cast<std::size_t>(back.corners - 1)];
    back.normal = -back.normal;
    return back;
}

FlatLight turned(const FlatLight& light)
{
    FlatLight back(turned(light.outline));
    for (const LightPolygon& face : light.faces) back.faces.push_back(turned(face));
    return back;
}

Box3 box_of(const LightPolygon& polygon)
{
    Box3 box;
    for (int k = 0; k < polygon.corners; ++k) box.add(polygon.corner[static_cast<std::size_t>(k)]);
    return box;
}

}   // namespace

struct AreaVisibility::Side {
    AreaShadows shadows;
    LightCells cells;
    Side(const visibility::StaticTriangles& triangles, const FlatLight& light, const AreaOptions& options)
        : shadows(triangles, light, options), cells(shadows.places())
    {
    }
};

struct AreaVisibility::Light {
    AreaLight light;
    Box3 box;
    std::unique_ptr<Side> front, back;   // back: of a light that emits there, too
};

void VisibilityCounters::add(const VisibilityCounters& other)
{
    for (std::size_t k = 0; k < std::size(points); ++k) points[k] += other.points[k];
    rays += other.rays, dynamic_rays += other.dynamic_rays, triangles += other.triangles;
    dynamic_triangles += other.dynamic_triangles;
}

AreaVisibility::AreaVisibility(const scene::SceneState& state, const ray::RayScene& rays, const AreaOptions& options)
    : options_(options),
      rays_(&rays),
      triangles_(std::make_unique<visibility::StaticTriangles>(state, rays)),
      pairs_(std::make_unique<PlanarPairs>(*triangles_)),
      dynamic_(std::make_unique<visibility::DynamicBounds>(state, rays))
{
}

AreaVisibility::~AreaVisibility() = default;

void AreaVisibility::follow(const scene::SceneState& state, const ray::RayScene& rays,
                            std::span<const AreaLight> lights)
{
    rays_ = &rays, state_ = &state;
    if (hole_maps_.size() > k_most_hole_maps) hole_maps_.clear();   // of alphas that change
    const scene::FrameChanges& changes = state.changes();
    if (!changes.promoted.empty()) {
        lights_.clear();
        ++triangles_version_;
        triangles_ = std::make_unique<visibility::StaticTriangles>(state, rays);
        pairs_ = std::make_unique<PlanarPairs>(*triangles_);
        dynamic_ = std::make_unique<visibility::DynamicBounds>(state, rays);
    } else {
        triangles_->follow(state.scene());
        dynamic_->update(state, rays);
    }
    dynamic_triangles_.follow(state, rays, *dynamic_);
    if (first_of_object_.empty() || !changes.promoted.empty()) {
        first_of_object_.clear();
        for (scene::ObjectId o = 0; o < state.scene().objects.size(); ++o)
            if (const TriangleId first = triangles_->first_of(o); first != visibility::no_triangle)
                first_of_object_.emplace_back(first, o);
        std::sort(first_of_object_.begin(), first_of_object_.end());
    }
    // Keep what is known of lights that are the same, unless it has become too much.
    if (bytes_of_parts() > options_.most_bytes) lights_.clear();
    std::vector<std::unique_ptr<Light>> before = std::exchange(lights_, {});
    std::size_t next = 0;
    for (const AreaLight& light : lights) {
        const auto same = [&](const std::unique_ptr<Light>& old) {
            return old && old->light.two_sided == light.two_sided && old->light.dynamic == light.dynamic &&
                   same_bits(old->light.shape, light.shape);
        };
        // Most often all are, and in the same order.
        auto at = next < before.size() && same(before[next]) ? before.begin() + static_cast<std::ptrdiff_t>(next)
                                                             : std::find_if(before.begin(), before.end(), same);
        if (at != before.end()) {
            next = static_cast<std::size_t>(at - before.begin()) + 1;
            lights_.push_back(std::move(*at));
            continue;
        }
        auto made = std::make_unique<Light>(Light{light, box_of(light.shape.outline), nullptr, nullptr});
        made->front = std::make_unique<Side>(*triangles_, light.shape, options_);
        if (light.two_sided) made->back = std::make_unique<Side>(*triangles_, turned(light.shape), options_);
        lights_.push_back(std::move(made));
    }
}

const LightCells& AreaVisibility::cells(std::size_t light, bool back) const
{
    const Light& of = *lights_[light];
    return back && of.back ? of.back->cells : of.front->cells;
}

// The answers to one call of find().
class AreaVisibility::Query {
 public:
    Query(const AreaVisibility& owner, Scratch& scratch, std::span<const ShadowPoint> points,
          std::span<const std::uint32_t> asked, const Light& light, Answers& answers)
        : owner_(owner), scratch_(scratch), points_(points), asked_(asked), light_(light), answers_(answers)
    {
        answers.answer.assign(asked.size(), Answer::dark);
        answers.at.assign(asked.size(), 0);
        answers.back.assign(asked.size(), 0);
        answers.state.assign(asked.size(), PartState::open);
        answers.cells.clear();
        scratch.all_rays.clear(), scratch.dynamic_rays.clear();
        scratch.listed.clear();
        // Find the dynamic objects that may lie between any of the points and the light, and their triangles.
        Box3 box;
        for (const std::uint32_t p : asked) box.add(points[p].origin);
        scratch.blockers.clear(), scratch.boxes.clear(), scratch.dynamic.clear();
        if (!box.empty()) owner.dynamic_->select(box, light.box, scratch.boxes);
        for (const std::uint32_t index : scratch.boxes) {
            const visibility::DynamicTriangles::Blocker& blocker = owner.dynamic_triangles_.of(index);
            scratch.blockers.push_back({owner.dynamic_->box(index), &blocker});
            for (const visibility::StaticTriangle& triangle : blocker.triangles) {
                Box3 corners;
                for (const glm::vec3& p : triangle.p) corners.add(p);
                if (visibility::may_shadow(corners, box, light.box)) scratch.dynamic.push_back({corners, &triangle});
            }
        }
    }

    // Looks up what static objects hide from a point, and notes it where rays must decide.
    void look_up(std::uint32_t k)
    {
        const ShadowPoint& p = points_[asked_[k]];
        const LightPolygon& polygon = light_.light.shape.outline;
        const bool behind = glm::dot(polygon.normal, p.origin - polygon.corner[0]) < 0;
        if (behind && !light_.back) return;
        Side& side = behind ? *light_.back : *light_.front;
        answers_.back[k] = behind;
        const TriangleId first =
            p.object == scene::none ? visibility::no_triangle : owner_.triangles_->first_of(p.object);
        Part part;
        if (!light_.light.dynamic && first != visibility::no_triangle) {
            part = side.shadows.part_at(first + p.triangle, p.front, p.u, p.v, last_);
            ++scratch_.counters.points[static_cast<std::size_t>(part.state)];
        }
        answers_.state[k] = part.state;
        switch (part.state) {
            case PartState::unlit:
            case PartState::dark:
                return;
            case PartState::open:
                set_all_visible(k, side);
                scratch_.all_rays.push_back(k);
                return;
            case PartState::lit:
                answers_.answer[k] = Answer::lit;
                if (meets_dynamic(p)) scratch_.listed.push_back({nullptr, k});
                return;
            case PartState::listed:
                scratch_.listed.push_back({part.list, k});
                return;
        }
    }

    // Looks through the lists, each of them for all of its points in turn.
    void look_through_lists()
    {
        auto& listed = scratch_.listed;
        std::sort(listed.begin(), listed.end(), [](const auto& a, const auto& b) {
            return a.list != b.list ? std::less<>()(a.list, b.list) : a.asked < b.asked;
        });
        for (std::size_t first = 0, last = 0; first < listed.size(); first = last) {
            constexpr std::size_t k_group = 64;   // points, beyond which fewer dynamic triangles are near all of them
            while (last < listed.size() && last < first + k_group && listed[last].list == listed[first].list) ++last;
            look_through({listed.data() + first, last - first});
        }
    }

    // Traces rays from points to the cells that are visible so far, and clears those that are hidden.
    void trace(const std::vector<std::uint32_t>& of, ray::Against against, std::uint64_t& count)
    {
        for (const std::uint32_t k : of) {
            const ShadowPoint& p = points_[asked_[k]];
            const Side& side = answers_.back[k] ? *light_.back : *light_.front;
            const VisibleCells& visible = answers_.cells[answers_.at[k]];
            for (int c = 0; c < k_cells; ++c) {
                if (visible[static_cast<std::size_t>(c)] == 0) continue;
                const glm::vec3 way = side.cells.position(c) - p.origin;
                if (!(glm::dot(way, p.normal) > 0)) continue;   // it brings nothing
                scratch_.queue.push(p.origin, 0, way, ray::k_shadow_ray_end);
                scratch_.targets.push_back({answers_.at[k], static_cast<std::uint16_t>(c)});
            }
            if (scratch_.queue.size() >= k_rays_at_once) flush(against, count);
        }
        flush(against, count);
    }

 private:
    VisibleCells& make_partial(std::uint32_t k)
    {
        answers_.answer[k] = Answer::partial;
        answers_.at[k] = static_cast<std::uint32_t>(answers_.cells.size());
        return answers_.cells.emplace_back();
    }
    void set_all_visible(std::uint32_t k, const Side& side)
    {
        VisibleCells& cells = make_partial(k);
        for (int c = 0; c < k_cells; ++c)
            cells[static_cast<std::size_t>(c)] = static_cast<std::uint8_t>(side.cells.count(c));
    }
    void gather(const std::vector<TriangleId>& list)
    {
        scratch_.opaque_ids.clear(), scratch_.holed_at.clear();
        for (const TriangleId id : list)
            if (owner_.triangles_->role(id) == visibility::StaticTriangles::Role::opaque)
                scratch_.opaque_ids.push_back(id);
            else
                push_holed(id);
        owner_.pairs_->gather(*owner_.triangles_, scratch_.opaque_ids, scratch_.list);
        scratch_.holed.pad();
    }
    void push_holed(TriangleId id)
    {
        const auto& first = owner_.first_of_object_;
        const auto object = std::upper_bound(first.begin(), first.end(), std::pair(id, scene::none)) - 1;
        scratch_.holed.push((*owner_.triangles_)[id].p);
        scratch_.holed_at.push_back({object->second, id - object->first});
    }
    // Adds what triangles with holes hide, from the alpha where the lines to the places meet them.
    // @return  whether they hide any
    bool add_holed(const ShadowPoint& p, const LightPlaces& places, PlaceMask& blocked)
    {
        const scene::Scene& scene = owner_.state_->scene();
        bool any = false;
        for_each_blocker(p.origin, scratch_.holed, places, [&](std::size_t entry, const PlaceMask& mask) {
            const Scratch::Holed& at = scratch_.holed_at[entry];
            const scene::Mesh& mesh = *owner_.rays_->geometry(at.object).mesh;
            const scene::Material& material = scene.materials[mesh.part_of(at.triangle).material];
            glm::vec3 corner[3];
            for (std::size_t c = 0; c < 3; ++c)
                for (int axis = 0; axis < 3; ++axis)
                    corner[c][axis] = scratch_.holed.at(c, static_cast<std::size_t>(axis))[entry];
            const scene::TextureUse& use = material.base_color_texture;
            if (mesh.colors.empty() && use.used() && !mesh.texcoords[use.texcoord].empty()) {
                const glm::uvec3 index = mesh.triangles[at.triangle];
                glm::vec2 texcoord[3];
                for (int c = 0; c < 3; ++c) texcoord[c] = use.apply(mesh.texcoords[use.texcoord][index[c]]);
                any |= add_blocked_past_holes(p.origin, corner, texcoord, hole_map(material), places, mask, blocked);
            } else {
                any |= add_blocked_past_holes(
                    p.origin, corner,
                    [&](float u, float v) { return scene::cut_away(scene, mesh, material, at.triangle, u, v); }, places,
                    mask, blocked);
            }
        });
        return any;
    }
    // The map of a material's texture, made when it is first asked for.
    const HoleMap& hole_map(const scene::Material& material)
    {
        const auto& textures = owner_.state_->scene().textures;
        const scene::TextureId texture = material.base_color_texture.texture;
        const auto is_it = [&](const HoleMap& map) {
            return map.is_of(textures[texture], material.alpha, material.alpha_cutoff);
        };
        if (last_map_ && is_it(*last_map_)) return *last_map_;
        const std::lock_guard lock(owner_.hole_maps_mutex_);
        auto& maps = owner_.hole_maps_;
        auto at = std::ranges::find_if(maps, [&](const auto& map) { return is_it(*map); });
        if (at == maps.end())
            at = maps.insert(
                maps.end(), std::make_unique<HoleMap>(textures.shared(texture), material.alpha, material.alpha_cutoff));
        last_map_ = at->get();
        return *last_map_;
    }
    // Finds what a group of points sees past the triangles of one list and those of dynamic objects.
    void look_through(std::span<const Scratch::Listed> group)
    {
        TriangleList &still = scratch_.list, &dynamic = scratch_.dynamic_list;
        still.clear(), dynamic.clear(), scratch_.holed.clear();
        if (group.front().list) gather(*group.front().list);
        if (!scratch_.dynamic.empty()) {
            Box3 box;
            for (const auto& [list, k] : group) box.add(points_[asked_[k]].origin);
            for (const auto& [corners, triangle] : scratch_.dynamic)
                if (visibility::may_shadow(corners, box, light_.box)) dynamic.push(triangle->p);
            dynamic.pad();
        }
        // Short lists are looked through for several points at once.
        for (std::size_t first = 0, last = 0; first < group.size(); first = last) {
            const char back = answers_.back[group[first].asked];
            glm::vec3 origin[k_points_at_once];
            while (last < group.size() && last < first + k_points_at_once && answers_.back[group[last].asked] == back)
                origin[last - first] = points_[asked_[group[last].asked]].origin, ++last;
            PlaceMask blocked[k_points_at_once];
            std::fill_n(blocked, last - first, PlaceMask{});
            bool hides[k_points_at_once], moving_hides[k_points_at_once];
            const LightPlaces& places = (back ? *light_.back : *light_.front).shadows.places();
            const std::span points(origin, last - first);
            add_blocked(points, still, places, blocked, hides);
            add_blocked(points, dynamic, places, blocked, moving_hides);
            for (std::size_t k = 0; k < points.size(); ++k)
                answer(group[first + k].asked, places, hides[k] || moving_hides[k], blocked[k]);
        }
        scratch_.counters.triangles += group.size() * (still.size() + scratch_.holed.size());
        scratch_.counters.dynamic_triangles += group.size() * dynamic.size();
    }
    // Answers for a point, after all triangles without holes.
    void answer(std::uint32_t k, const LightPlaces& places, bool hides, PlaceMask& blocked)
    {
        const ShadowPoint& p = points_[asked_[k]];
        const bool holed_hides = scratch_.holed.size() > 0 && add_holed(p, places, blocked);
        if (!hides && !holed_hides && !meets_unlisted(p)) {
            answers_.answer[k] = Answer::lit;
            return;
        }
        VisibleCells cells;
        const int visible = count_visible(places, blocked, cells);
        const bool by_rays = visible > 0 && meets_unlisted(p);
        answers_.answer[k] = visible == 0 ? Answer::dark : Answer::lit;
        if (visible > 0 && (by_rays || visible < places.count())) make_partial(k) = cells;
        if (by_rays) scratch_.dynamic_rays.push_back(k);
    }
    bool meets(const Scratch::Blocker& blocker, const ShadowPoint& p) const
    {
        return visibility::may_shadow(blocker.box, Box3{p.origin, p.origin}, light_.box);
    }
    bool meets_dynamic(const ShadowPoint& p) const
    {
        return std::any_of(scratch_.blockers.begin(), scratch_.blockers.end(),
                           [&](const Scratch::Blocker& blocker) { return meets(blocker, p); });
    }
    // Whether a dynamic object may hide the light whose triangles are not listed.
    bool meets_unlisted(const ShadowPoint& p) const
    {
        return std::any_of(scratch_.blockers.begin(), scratch_.blockers.end(),
                           [&](const Scratch::Blocker& blocker) { return !blocker.of->listed && meets(blocker, p); });
    }
    void flush(ray::Against against, std::uint64_t& count)
    {
        const std::size_t rays = scratch_.queue.size();
        if (rays == 0) return;
        count += rays;
        scratch_.occluded.resize(rays + ray::k_packet_pad);
        owner_.rays_->occluded(scratch_.queue, 0, rays, scratch_.occluded.data(), against);
        for (std::size_t r = 0; r < rays; ++r)
            if (scratch_.occluded[r]) answers_.cells[scratch_.targets[r].cells][scratch_.targets[r].cell] = 0;
        scratch_.queue.clear(), scratch_.targets.clear();
    }

    const AreaVisibility& owner_;
    Scratch& scratch_;
    std::span<const ShadowPoint> points_;
    std::span<const std::uint32_t> asked_;
    const Light& light_;
    Answers& answers_;
    AreaShadows::LastPart last_;
    const HoleMap* last_map_ = nullptr;
};

void AreaVisibility::find(Scratch& scratch, std::span<const ShadowPoint> points, std::span<const std::uint32_t> asked,
                          std::size_t light, Answers& answers) const
{
    Query query(*this, scratch, points, asked, *lights_[light], answers);
    for (std::uint32_t k = 0; k < asked.size(); ++k) query.look_up(k);
    query.look_through_lists();
    query.trace(scratch.all_rays, ray::Against::everything, scratch.counters.rays);
    query.trace(scratch.dynamic_rays, ray::Against::dynamic_only, scratch.counters.dynamic_rays);
}

AreaCounters AreaVisibility::parts() const
{
    AreaCounters sum;
    for (const auto& light : lights_)
        for (const Side* side : {light->front.get(), light->back.get()}) {
            if (!side) continue;
            sum.add(side->shadows.counters());
        }
    return sum;
}

std::size_t AreaVisibility::bytes_of_parts() const
{
    std::size_t bytes = 0;
    for (const auto& light : lights_)
        for (const Side* side : {light->front.get(), light->back.get()})
            if (side) bytes += side->shadows.bytes() + sizeof *side;
    return bytes;
}

std::size_t AreaVisibility::bytes() const
{
    std::size_t maps = 0;
    {
        const std::lock_guard lock(hole_maps_mutex_);
        for (const auto& map : hole_maps_) maps += map->bytes();
    }
    return triangles_->bytes() + pairs_->bytes() + dynamic_triangles_.bytes() + bytes_of_parts() + maps;
}

}   // namespace gnomon::area_light
