// SPDX-License-Identifier: Apache-2.0
// LONG: the life of a surface point from key to light is one story, told in the order in which a frame tells it.
#include "irradiance_cache/irradiance_cache.h"

#include <algorithm>

namespace gnomon::irradiance_cache {

namespace {

// What a point may be interpolated from: facing the same way (and k_plane).
constexpr float k_facing = 0.7f;
// Light that is taken away again leaves rounding behind, not darkness: less than this share of what there was is none.
constexpr float k_rounding = 1e-5f;
// Where nothing else is left: this far.
constexpr float k_plane_around = 2.0f;
// The way to it may end this share of the spacing short: less than a pixel, or the foot of a wall takes light from the
// anchors inside the wall, which have none, and is a dark line.
constexpr float k_room = 0.005f;
// At the very foot anchors on both sides of the wall reach a pixel. Those on its viewer's side are the right ones; so
// it is taken to lie this share of the spacing nearer to the viewer, along the surface: more than what ways may lack
// even where the viewer stands off by some ten degrees alone.
constexpr float k_towards_viewer = 0.04f;
// Together with at least this much bilinear weight.
constexpr float k_least_weight = 0.02f, k_full_weight = 0.15f;
// Shares of a point's light that may be taken from a level that is a little too coarse.
constexpr float k_least_rest = 0.02f;

}   // namespace

void VisibleCounters::add(const VisibleCounters& o)
{
    rays += o.rays, rays_dynamic += o.rays_dynamic;
    new_points += o.new_points, summed_points += o.summed_points, moving_points += o.moving_points;
    near_points += o.near_points;
    nodes += o.nodes;
}

VisibleLight::VisibleLight(const scene::SceneState& state, const ray::RayScene& rays, const VisibleOptions& options,
                           Tasks& tasks)
    : options_(options),
      state_(&state),
      rays_(&rays),
      emitters_(state, rays, options.emitters, tasks),
      sky_(state.scene().background),
      casters_(state),
      first_triangle_(first_triangles(state.scene()))
{
    find_together();
}

// What moves together, if it casts shadows.
void VisibleLight::find_together()
{
    together_.clear();
    promoted_ = rays_->promoted();
    for (scene::ObjectId o = 0; o < state_->scene().objects.size(); ++o) {
        if (!rays_->moves(o) || !casters_.casts(o)) continue;
        const std::uint32_t owner = emitters_.owner_of(o);
        const auto at = std::find_if(together_.begin(), together_.end(),
                                     [&](const Together& together) { return together.owner == owner; });
        if (at == together_.end())
            together_.push_back({owner, {o}});
        else
            at->objects.push_back(o);
    }
}

VisibleLight::~VisibleLight() = default;

std::unique_ptr<VisibleLight::Batch> VisibleLight::make_batch() const
{
    return std::make_unique<Batch>();
}

void VisibleLight::begin_frame(const scene::SceneState& state, const ray::RayScene& rays, Tasks& tasks)
{
    state_ = &state;
    rays_ = &rays;
    counters_ = {};
    spent_rays_ = 0;
    lacking_ = false;
    if (failed_) forget_hints();   // some may wait for ever for who failed
    failing_ = failed_ = false;
    failure_ = nullptr;
    const bool first = frame_++ == 0;
    const scene::FrameChanges& changes = state.changes();
    if (!first) {
        casters_.update(state);
        emitters_.update(state, rays, tasks);
    }
    const bool promoted = rays.promoted() != promoted_;
    if (promoted) forget_what_stood_still();
    follow_radius(first);
    if (first || promoted || !changes.moved.empty() || !changes.deformed.empty() || !changes.appeared.empty() ||
        !changes.vanished.empty())
        enclose_dynamic();
    if (engine_) engine_->begin_frame(emitters_, dynamic_);
}

// Somebody moved by hand what stood still: what points saw past it, and where they lie, is void. From now on it moves.
void VisibleLight::forget_what_stood_still()
{
    find_together();
    points_.clear([this](const RememberedPoint& point) { forget_seen(point); });
    hints_.reset();
}

// What an engine keeps for a point that goes.
void VisibleLight::forget_seen(const RememberedPoint& point)
{
    if (engine_ && point.count > 0) engine_->forget({point.kept, point.count});
}

void VisibleLight::enclose_dynamic()
{
    const scene::SceneState& state = *state_;
    ++dynamic_version_;
    dynamic_.clear();
    for (const Together& together : together_) {
        std::vector<Sphere> spheres;
        for (const scene::ObjectId o : together.objects) {
            if (!state.object_visible(o)) continue;
            const Box3& box = casters_.box(o);
            if (box.empty()) continue;
            const glm::mat4 m = state.object_matrix(o);
            Box3 world;
            for (int corner = 0; corner < 8; ++corner)
                world.add(transform_point(
                    m, glm::vec3(corner & 1 ? box.high.x : box.low.x, corner & 2 ? box.high.y : box.low.y,
                                 corner & 4 ? box.high.z : box.low.z)));
            spheres.push_back({world.centre(), 0.5f * world.diagonal() * k_grown});
        }
        dynamic_.add(std::move(spheres));
    }
}

RememberedPoint* VisibleLight::want(Batch& batch, AnchorKey key)
{
    // Neighbouring pixels want the same few anchors.
    auto& recent = batch.recent[(key * 0x9e3779b97f4a7c15ull) >> (64 - Batch::k_recent_bits)];
    if (recent.key == key && recent.frame == frame_) return recent.point;
    RememberedPoint& point = points_.at(key);
    recent = {key, frame_, &point};
    std::uint32_t claimed = point.claimed.load(std::memory_order_relaxed);
    if (claimed != frame_ && point.claimed.compare_exchange_strong(claimed, frame_))
        batch.claimed.push_back(&point);
    else if (point.ready.load(std::memory_order_acquire) != frame_)
        batch.awaited.push_back(&point);
    return &point;
}

bool VisibleLight::shade(Batch& batch, std::span<const IndirectPoint> points, glm::vec3* irradiance)
{
    try {
        return shade_points(batch, points, irradiance);
    } catch (...) {
        if (!failing_.exchange(true)) {
            failure_ = std::current_exception();
            failed_.store(true, std::memory_order_release);
        }
        throw;
    }
}

bool VisibleLight::shade_points(Batch& batch, std::span<const IndirectPoint> points, glm::vec3* irradiance)
{
    batch.pending = false;
    batch.wanted.clear();
    batch.parts.clear();
    batch.moving.resize(points.size());
    bool near = false;   // some point is near enough to the viewer for near light
    for (std::size_t i = 0; i < points.size(); ++i) {
        batch.moving[i] = rays_->moves(points[i].object) || !(points[i].width > 0);
        near = near || (!batch.moving[i] && points[i].width < 2 * near_width_);
    }
    batch.pixels.choose(points, batch.moving);
    batch.near_share.assign(points.size(), 1);
    for (const std::uint32_t i : batch.pixels.reckoned()) {
        irradiance[i] = glm::vec3(0);
        if (batch.moving[i])
            batch.parts.push_back({i, 1, 0, nullptr, glm::vec3(0)});   // anchored to itself
        else
            batch.wanted.push_back({i, detail_of(options_.widest * points[i].width).level, 0, 1, glm::vec3(0)});
    }
    // From coarse to fine, as far as each point needs.
    while (!batch.wanted.empty()) {
        find_cells(batch, points);
        serve(batch);
        fill_cells(batch);
        blend_level(batch, points, irradiance);
    }
    shade_parts(batch, points, irradiance);
    if (batch.pending) return false;
    batch.pixels.fill(irradiance);
    if (near && hints_) {
        batch.pixels.fill(batch.near_share.data());
        add_near_light(batch, points, irradiance);
    }
    if (most_rays_ == 0) return true;
    for (std::size_t i = 0; i < points.size(); ++i) batch.light_sum += irradiance[i];
    batch.light_count += points.size();
    return true;
}

// Takes from the present cells what they can tell, and leaves in `wanted` what needs finer ones.
void VisibleLight::blend_level(Batch& batch, std::span<const IndirectPoint> points, glm::vec3* irradiance)
{
    LatticeLight& light = batch.light;
    light.resize(batch.wanted.size());
    batch.around.resize(batch.wanted.size());
    for (const Batch::Cell& cell : batch.cells)
        interpolate_cell(cell.anchors, {k_plane * spacing_of(cell.level), k_facing, true}, batch.lattice, cell.first,
                         cell.end - cell.first, light);
    std::size_t kept = 0;
    for (std::size_t k = 0; k < batch.wanted.size(); ++k) {
        Batch::Wanted wanted = batch.wanted[k];
        const IndirectPoint& point = points[wanted.point];
        const glm::vec3 between(light.r[k], light.g[k], light.b[k]);
        const float spacing = spacing_of(wanted.level);
        // The widest level fades in, the finest one out.
        const float narrowest = options_.narrowest * point.width, finest = faded(2 * spacing / narrowest - 1);
        float share = faded(options_.widest * point.width / spacing - 1) * finest;
        share *= std::clamp((light.weight[k] - k_least_weight) / (k_full_weight - k_least_weight), 0.0f, 1.0f);
        share = wanted.rest * share;
        // If no more than this is missing, it would not be seen; the sum of all shares is 1 all the same.
        if (const float rest = wanted.rest - share; rest < 2 * k_least_rest)
            share = std::min(wanted.rest, wanted.rest - 2 * std::max(rest - k_least_rest, 0.0f));
        irradiance[wanted.point] += share * between;
        if (!near_at(spacing)) batch.near_share[wanted.point] -= share;
        wanted.rest -= share;
        if (!(wanted.rest > 0)) continue;
        if (spacing > narrowest) {
            if (faded(spacing / narrowest - 1) < 1) wanted.around = around(batch, k);
            --wanted.level;
            batch.wanted[kept++] = wanted;
            continue;
        }
        batch.parts.push_back({wanted.point, finest * wanted.rest, 0, nullptr, around(batch, k)});
        if (finest < 1) batch.parts.push_back({wanted.point, (1 - finest) * wanted.rest, 0, nullptr, wanted.around});
    }
    batch.wanted.resize(kept);
}

// What a level says where it cannot say much: at the foot of a wall few anchors do, and the others stand inside it.
glm::vec3 VisibleLight::around(Batch& batch, std::size_t k) const
{
    const glm::vec3 between(batch.light.r[k], batch.light.g[k], batch.light.b[k]);
    if (between != glm::vec3(0)) return between;
    const Batch::Wanted& wanted = batch.wanted[k];
    interpolate_cell(batch.cells[wanted.cell].anchors, {k_plane_around * spacing_of(wanted.level), k_facing, false},
                     batch.lattice, k, 1, batch.around);
    return {batch.around.r[k], batch.around.g[k], batch.around.b[k]};
}

// Puts what is wanted in the order of its cells, so that a cell is looked up once and its points stand side by side.
void VisibleLight::find_cells(Batch& batch, std::span<const IndirectPoint> points)
{
    batch.cells.clear();
    batch.claimed.clear();
    batch.awaited.clear();
    batch.found.clear();
    std::size_t slots = Batch::k_least_slots;
    while (slots < 2 * batch.wanted.size()) slots *= 2;
    batch.slots.assign(slots, 0);
    LatticeCursor cursor;
    std::uint32_t current = 0;
    for (Batch::Wanted wanted : batch.wanted) {
        const LatticeCursor::Step step = cursor.go(points[wanted.point], wanted.level);
        if (step == LatticeCursor::Step::outside) {
            batch.parts.push_back({wanted.point, wanted.rest, 0, nullptr, glm::vec3(0)});
            continue;
        }
        const LatticeCell& cell = cursor.cell();
        if (step == LatticeCursor::Step::other) current = cell_of(batch, cell, wanted.level);
        ++batch.cells[current].end;
        wanted.cell = current;
        batch.found.push_back({wanted, cell.x, cell.y});
    }
    std::size_t end = 0;
    for (Batch::Cell& cell : batch.cells) {
        cell.first = end;
        end += cell.end;
        cell.end = cell.first;
    }
    batch.wanted.resize(end);
    batch.lattice.resize(end);
    LatticePoints& lattice = batch.lattice;
    for (const Batch::Found& found : batch.found) {
        const std::size_t k = batch.cells[found.wanted.cell].end++;
        batch.wanted[k] = found.wanted;
        const IndirectPoint& p = points[found.wanted.point];
        const glm::vec3 aside = p.to_viewer - glm::dot(p.to_viewer, p.geometric_normal) * p.geometric_normal;
        const glm::vec3 at = p.position + k_towards_viewer * spacing_of(found.wanted.level) * aside;
        lattice.x[k] = at.x, lattice.y[k] = at.y, lattice.z[k] = at.z;
        lattice.gx[k] = p.geometric_normal.x, lattice.gy[k] = p.geometric_normal.y,
        lattice.gz[k] = p.geometric_normal.z;
        lattice.nx[k] = p.normal.x, lattice.ny[k] = p.normal.y, lattice.nz[k] = p.normal.z;
        lattice.fx[k] = found.x, lattice.fy[k] = found.y;
    }
}

// The number of a cell among those of this batch, which wants its anchors if it is new.
std::uint32_t VisibleLight::cell_of(Batch& batch, const LatticeCell& cell, int level)
{
    const std::uint64_t mixed = (cell.key[0] ^ (cell.key[3] << 1)) * 0x9e3779b97f4a7c15ull;
    const std::size_t mask = batch.slots.size() - 1;
    std::size_t slot = (mixed >> 32) & mask;
    for (; batch.slots[slot] != 0; slot = (slot + 1) & mask) {
        const Batch::Cell& other = batch.cells[batch.slots[slot] - 1];
        if (std::equal(cell.key, cell.key + 4, other.key)) return batch.slots[slot] - 1;
    }
    Batch::Cell& made = batch.cells.emplace_back();
    std::copy(cell.key, cell.key + 4, made.key);
    made.anchors.axis = lattice_axis(cell.key[0]);
    made.level = level;
    made.first = made.end = 0;
    for (int c = 0; c < 4; ++c) made.point[c] = want(batch, cell.key[c]);
    batch.slots[slot] = static_cast<std::uint32_t>(batch.cells.size());
    return batch.slots[slot] - 1;
}

void VisibleLight::fill_cells(Batch& batch) const
{
    for (Batch::Cell& made : batch.cells) {
        CellAnchors& cell = made.anchors;
        const int b = (cell.axis + 1) % 3, c = (cell.axis + 2) % 3;
        for (int i = 0; i < 4; ++i) {
            const RememberedPoint& from = *made.point[i];
            batch.pending = batch.pending || from.waits;
            const glm::vec3 p = from.position, n = from.normal;
            // No plane goes through what is not there.
            cell.x[i] = from.exists ? p.x : k_infinity, cell.y[i] = p.y, cell.z[i] = p.z;
            cell.nx[i] = n.x, cell.ny[i] = n.y, cell.nz[i] = n.z;
            const float room = k_room * lattice_spacing(from.key);
            // Nothing is open to what is not there.
            const auto open = [&](int way) {   // across what ends it
                return from.free[way] + room * std::sqrt(1 + from.slope(way) * from.slope(way));
            };
            cell.low_b[i] = from.exists ? p[b] - open(0) : k_infinity;
            cell.high_b[i] = p[b] + open(1);
            cell.low_c[i] = p[c] - open(2);
            cell.high_c[i] = p[c] + open(3);
            for (int way = 0; way < 4; ++way) cell.slope[way][i] = from.slope(way);
            for (int colour = 0; colour < 3; ++colour)
                for (int axis = 0; axis < 3; ++axis) cell.light[3 * colour + axis][i] = from.light[colour][axis];
        }
    }
}

// Brings all claimed points up to this frame, and waits for those of others.
void VisibleLight::serve(Batch& batch)
{
    if (!batch.claimed.empty()) {
        const std::uint64_t before = batch.counters.rays;
        put_off(batch);
        place(batch);
        if (engine_) {
            wait(batch);
        } else {
            see(batch);
            sum(batch);
        }
        for (const auto* points : {&batch.claimed, &batch.put_off})
            for (RememberedPoint* point : *points) point->ready.store(frame_, std::memory_order_release);
        spent_rays_ += batch.counters.rays - before;
    }
    // Nobody waits before having published what it claimed.
    for (const RememberedPoint* point : batch.awaited)
        await([&] { return point->ready.load(std::memory_order_acquire) == frame_; });
}

// Takes from the claimed points those that must wait for a later frame. What moves never waits.
void VisibleLight::put_off(Batch& batch)
{
    batch.put_off.clear();
    if (!out_of_rays()) return;
    const auto moves = [&](AnchorKey key) {
        if (is_lattice(key)) return false;
        const auto after = std::upper_bound(first_triangle_.begin(), first_triangle_.end(), part_of(key).triangle);
        return rays_->moves(static_cast<scene::ObjectId>(after - first_triangle_.begin() - 1));
    };
    const std::uint32_t version = emitters_.geometry_version();
    std::erase_if(batch.claimed, [&](RememberedPoint* point) {
        if (point->version == version || moves(point->key)) return false;
        batch.put_off.push_back(point);
        return true;
    });
    if (!batch.put_off.empty()) lacking_ = true;
}

// What moves is cut anew in every frame, and less finely.
CutOptions VisibleLight::cut_options(const RememberedPoint& point) const
{
    CutOptions options = options_.cut;
    if (point.owner != k_no_owner) options.error = options_.moving_error, options.estimate = options_.moving_estimate;
    return options;
}

// The rays that ask which nodes of its cut a point sees, and what a unit of flux of each brings.
void VisibleLight::push_ways(Batch& batch, const RememberedPoint& point, std::span<const NodeId> cut,
                             std::span<const float> weight) const
{
    const bool parted = point.owner == k_no_owner && (!is_lattice(point.key) || near_at(lattice_spacing(point.key)));
    for (std::size_t k = 0; k < cut.size(); ++k) {
        const glm::vec3 to = emitters_.samples().at(cut[k]) - point.origin();
        const float distance = glm::length(to);
        const float cosine = glm::dot(to, point.normal) / distance;
        if (!(glm::dot(to, point.geometric_normal) > 0) || !(cosine > 0)) continue;
        // At the point's own normal the sum is irradiance; at grazing angles it must not explode elsewhere.
        constexpr float k_least_cosine = 0.1f;
        // Near light comes to static points by rays of its own.
        const float share = parted ? far_share(distance, near_.options().radius) : 1;
        if (!(share > 0)) continue;
        batch.rays.push(point.origin(), 0, to, options_.emitters.ray_end);
        batch.entries.push_back(cut[k]);
        batch.entry_weight.push_back(share * weight[k] / std::max(cosine, k_least_cosine));
    }
}

// Leaves in `occluded` which rays do not arrive.
void VisibleLight::ask(Batch& batch, const ray::RayQueue& rays, ray::Against against) const
{
    const std::size_t count = rays.size();
    batch.occluded.resize(count + ray::k_packet_pad);
    if (engine_ && engine_->traces())
        engine_->occluded(rays, batch.occluded.data(), against);
    else
        rays_->occluded(rays, 0, count, batch.occluded.data(), against);
    batch.counters.rays += count;
}

// Asks for new points what they see past everything static.
void VisibleLight::see(Batch& batch)
{
    const std::uint32_t version = emitters_.geometry_version();
    std::size_t begin = 0;
    while (begin < batch.claimed.size()) {
        // Some points at a time: their rays fill packets and stay in the cache.
        constexpr std::size_t k_rays = 4096;
        batch.rays.clear();
        batch.entries.clear();
        batch.entry_weight.clear();
        batch.fresh.clear();
        std::size_t next = begin;
        for (; next < batch.claimed.size() && batch.rays.size() < k_rays; ++next) {
            RememberedPoint& point = *batch.claimed[next];
            if (!point.exists || point.version == version || is_near(point.key)) continue;
            cut_tree(emitters_, cut_options(point), point.origin(), point.normal, batch.cut, batch.cut_weight,
                     batch.stack);
            batch.fresh.push_back({&point, batch.entries.size()});
            push_ways(batch, point, batch.cut, batch.cut_weight);
        }
        begin = next;
        const std::size_t count = batch.rays.size();
        ask(batch, batch.rays, ray::Against::static_only);
        for (std::size_t f = 0; f < batch.fresh.size(); ++f) {
            RememberedPoint& point = *batch.fresh[f].point;
            const std::size_t first = batch.fresh[f].first;
            const std::size_t last = f + 1 < batch.fresh.size() ? batch.fresh[f + 1].first : count;
            std::uint32_t seen = 0;
            for (std::size_t e = first; e < last; ++e) seen += !batch.occluded[e];
            const std::uint32_t padded = (seen + k_seen_step - 1) / k_seen_step * k_seen_step;
            points_.resized(point.count, seen);
            point.count = seen;
            point.seen = std::make_unique<SeenNode[]>(padded);
            std::uint32_t k = 0;
            for (std::size_t e = first; e < last; ++e)
                if (!batch.occluded[e]) point.seen[k++] = pack_seen(batch.entries[e], batch.entry_weight[e]);
            sum_seen(emitters_, point.seen.get(), padded, point.origin(), point.still);
            point.version = version;
            point.dynamic_version = 0;
            ++batch.counters.new_points;
            batch.counters.nodes += seen;
        }
        if (sky_.any()) see_sky(batch);
    }
    see_near(batch);
    for (RememberedPoint* point : batch.claimed)
        if (!point->exists) point->version = version;
}

// Asks for the fresh points what they see of the sky past everything static.
void VisibleLight::see_sky(Batch& batch)
{
    batch.rays.clear();
    const auto faces = [&](const RememberedPoint& point, std::size_t i) {
        const glm::vec3 d = sky_.direction(i);
        return glm::dot(d, point.geometric_normal) > 0 && glm::dot(d, point.normal) > 0;
    };
    for (const Batch::Fresh& fresh : batch.fresh)
        for (std::size_t i = 0; i < k_sky_directions; ++i)
            if (faces(*fresh.point, i)) batch.rays.push(fresh.point->origin(), 0, sky_.direction(i), k_infinity);
    ask(batch, batch.rays, ray::Against::static_only);
    std::size_t r = 0;
    for (const Batch::Fresh& fresh : batch.fresh) {
        RememberedPoint& point = *fresh.point;
        point.sky = {};
        for (std::size_t i = 0; i < k_sky_directions; ++i) {
            if (!faces(point, i) || batch.occluded[r++]) continue;
            point.sky.set(i);
            for (int colour = 0; colour < 3; ++colour) point.still[colour] += sky_.light(i)[colour] * sky_.direction(i);
        }
    }
}

// Takes away the directions that something moving may hide, until it is known that it does not.
void VisibleLight::shade_sky(Batch& batch, RememberedPoint& point)
{
    SkyMask hidden;
    SkyMask near;
    dynamic_.any(
        [&](const Sphere& sphere) {
            near = sky_.towards(sphere.centre - point.origin(), sphere.radius) & point.sky;
            return near.any();
        },
        [&](const Sphere&) {
            hidden |= near;
            return false;
        });
    hidden.for_each([&](std::size_t i) {
        add_light(point, -sky_.light(i), sky_.direction(i));
        batch.rays.push(point.origin(), 0, sky_.direction(i), k_infinity);
        batch.shares.push_back({&point, sky_.light(i), sky_.direction(i)});
    });
}

// Present light: still light, and what dynamic objects change of it: what they keep off, and what comes from them.
void VisibleLight::sum(Batch& batch)
{
    const EmitterTree::Flux &still = emitters_.still_flux(), &flux = emitters_.flux();
    const EmitterTree::Samples& samples = emitters_.samples();
    batch.rays.clear();
    batch.shares.clear();
    batch.bounce_rays.clear();
    batch.bounces.clear();
    batch.summed.clear();
    for (RememberedPoint* p : batch.claimed) {
        RememberedPoint& point = *p;
        if (!point.exists || point.dynamic_version == dynamic_version_ || is_near(point.key)) continue;
        batch.summed.push_back(p);
        ++batch.counters.summed_points;
        point.dynamic_version = dynamic_version_;
        std::copy(point.still, point.still + 3, point.light);
        if (dynamic_.empty() && !emitters_.any_differs()) continue;
        batch.changed.clear();
        find_changed(emitters_, point.seen.get(), point.count, point.origin(), dynamic_, batch.changed);
        for (const ChangedNode& changed : batch.changed) {
            const SeenNode seen = point.seen[changed.place];
            const NodeId node = seen_node(seen);
            const glm::vec3 to = samples.at(node) - point.origin();
            const glm::vec3 direction = to * (seen_weight(seen) / glm::length(to));
            const glm::vec3 now = flux.at(node);
            if (!changed.crossed) {
                add_light(point, now - still.at(node), direction);
                continue;
            }
            add_light(point, -still.at(node), direction);
            if (now == glm::vec3(0)) continue;
            // It is added again once it is known to arrive.
            batch.rays.push(point.origin(), 0, to, options_.emitters.ray_end);
            batch.shares.push_back({&point, now, direction});
        }
        if (sky_.any()) shade_sky(batch, point);
        bounce_off_dynamic(batch, point);
    }
    add_what_arrives(batch, batch.rays, batch.shares, ray::Against::dynamic_only);
    add_what_arrives(batch, batch.bounce_rays, batch.bounces, ray::Against::everything);
    for (RememberedPoint* point : batch.summed) end_sum(*point);
}

// What dynamic objects keep off to the last is nothing, or a point in the dark would pass for one with light.
void VisibleLight::end_sum(RememberedPoint& point)
{
    for (int colour = 0; colour < 3; ++colour) {
        glm::vec3& light = point.light[colour];
        const glm::vec3& still = point.still[colour];
        if (glm::dot(light, light) < k_rounding * k_rounding * glm::dot(still, still)) light = glm::vec3(0);
    }
}

void VisibleLight::add_light(RememberedPoint& point, const glm::vec3& flux, const glm::vec3& direction)
{
    for (int colour = 0; colour < 3; ++colour) point.light[colour] += flux[colour] * direction;
}

// Light from what moves. Where it is a small part of a point's light nobody asks what stands between.
void VisibleLight::bounce_off_dynamic(Batch& batch, RememberedPoint& point)
{
    if (emitters_.dynamic_objects().empty()) return;
    const float still = luminance(at_part(point, point.normal));
    for (const DynamicEmitter& emitter : emitters_.dynamic_objects()) {
        const glm::vec3 to = emitter.sample - point.origin();
        const float square = glm::dot(to, to), distance = std::sqrt(square);
        const float cosine = glm::dot(to, point.normal), facing = -glm::dot(to, emitter.normal);
        if (!(cosine > 0) || !(facing > 0) || !(glm::dot(to, point.geometric_normal) > 0)) continue;
        if (emitter.owner == point.owner) continue;
        const float kernel =
            facing / distance / (static_cast<float>(k_pi) * square + emitter.area);   // of a disk, as for the tree
        const glm::vec3 direction = to * (kernel / distance);
        if (luminance(emitter.flux) * glm::dot(direction, point.normal) < options_.unasked * still) {
            add_light(point, emitter.flux, direction);
            continue;
        }
        batch.bounce_rays.push(point.origin(), 0, to, options_.emitters.ray_end);
        batch.bounces.push_back({&point, emitter.flux, direction});
    }
}

void VisibleLight::add_what_arrives(Batch& batch, ray::RayQueue& rays, const std::vector<Share>& shares,
                                    ray::Against against)
{
    const std::size_t count = rays.size();
    if (count == 0) return;
    ask(batch, rays, against);
    batch.counters.rays_dynamic += count;
    for (std::size_t r = 0; r < count; ++r)
        if (!batch.occluded[r]) add_light(*shares[r].point, shares[r].flux, shares[r].direction);
}

void VisibleLight::end_frame(std::span<const std::unique_ptr<Batch>> batches)
{
    glm::dvec3 light(0);
    std::uint64_t count = 0;
    for (const auto& batch : batches) {
        if (!batch) continue;
        counters_.add(batch->counters);
        batch->counters = {};
        light += batch->light_sum, count += batch->light_count;
        batch->light_sum = glm::dvec3(0), batch->light_count = 0;
        for (auto& recent : batch->recent) recent = {};
    }
    if (hints_) hints_->end_frame();
    average_ = count > 0 ? glm::vec3(light / static_cast<double>(count)) : glm::vec3(0);
    points_.drop_unseen(frame_, options_.memory, [this](const RememberedPoint& point) { forget_seen(point); });
}

}   // namespace gnomon::irradiance_cache
