// SPDX-License-Identifier: Apache-2.0
#include "shadow_culling/nah2009/paper_culling.h"

#include <algorithm>

#include "base/check.h"

namespace gnomon::shadow_culling {

void PaperCounters::add(const PaperCounters& o)
{
    rays += o.rays;
    skipped += o.skipped;
    dynamic_only += o.dynamic_only;
    extra_tests += o.extra_tests;
    for (std::size_t i = 0; i < full.size(); ++i) full[i] += o.full[i];
}

PaperOptions PaperOptions::as_printed()
{
    PaperOptions options;
    options.set_modes.remember_dynamic_blockers = true;
    options.set_modes.partially_occluded_stays = true;
    options.mobility = PaperMobility::by_clip;
    options.writes_at_once = true;
    return options;
}

PaperCulling::PaperCulling(const scene::SceneState& state, const ray::RayScene& rays, const PaperOptions& options)
    : state_(&state),
      options_(options),
      triangles_(state, rays, options.part_levels),
      modes_(triangles_.size(), static_cast<int>(state.scene().lights.size())),
      partly_seen_(triangles_.size(), 0),
      mobility_(state.scene().objects.size())
{
    const auto objects = static_cast<scene::ObjectId>(state.scene().objects.size());
    for (scene::ObjectId o = 0; o < objects; ++o) {
        if (options_.mobility == PaperMobility::by_frame) triangles_.set_dynamic(o, false);
        dynamic_objects_ += triangles_.object_is_dynamic(o);
        static_bounds_.push_back(triangles_.object_is_dynamic(o) ? Box3{} : bounds_of(o));
    }
}

void PaperCulling::begin_frame(const scene::SceneState& state, const ray::RayScene& rays)
{
    const scene::FrameChanges& changes = state.changes();
    if (options_.mobility == PaperMobility::by_clip) {
        begin_frame(state, rays, {changes.lights_moved, changes.promoted, {}});
        return;
    }
    mobility_.update(changes);
    begin_frame(state, rays, {changes.lights_moved, mobility_.became_dynamic(), mobility_.became_static()});
}

void PaperCulling::begin_frame(const scene::SceneState& state, const ray::RayScene& rays, const PaperChanges& changes)
{
    state_ = &state;
    triangles_.follow(rays);
    counters_ = {};

    // DEVIATION(Nah 2009, 2.2): the paper does not define the effect of lights that move and of objects that start or
    // stop. They clear the modes that they affect.
    for (const scene::LightId l : changes.lights) modes_.forget_light(static_cast<int>(l));
    for (const scene::ObjectId o : changes.started) start(o);
    for (const scene::ObjectId o : changes.stopped) stop(o);

    // DEVIATION(Nah 2009, 2.6): PARTIALLY_OCCLUDED does not last, because a triangle that is hidden in one view may be
    // seen whole in the next. It becomes INIT at the beginning of the frame; its shadow bits stay.
    for (const PrimitiveId primitive : begin_afresh_)
        if (modes_.occlusion(primitive) == OcclusionMode::partially_occluded)
            modes_.set_occlusion(primitive, OcclusionMode::init);
    begin_afresh_.clear();
}

void PaperCulling::start(scene::ObjectId object)
{
    if (triangles_.object_is_dynamic(object)) return;
    triangles_.set_dynamic(object, true);
    ++dynamic_objects_;
    forget_shadowed_by(static_bounds_[object]);
    static_bounds_[object] = Box3{};
    forget_modes(object);
}

void PaperCulling::stop(scene::ObjectId object)
{
    if (!triangles_.object_is_dynamic(object)) return;
    triangles_.set_dynamic(object, false);
    --dynamic_objects_;
    static_bounds_[object] = bounds_of(object);
    forget_shadowed_by(static_bounds_[object]);
    forget_modes(object);
}

Box3 PaperCulling::bounds_of(scene::ObjectId object) const
{
    return state_->scene().objects[object].removed ? Box3{} : triangles_.bounds(object);
}

void PaperCulling::forget_modes(scene::ObjectId object)
{
    for (PrimitiveId p = triangles_.first_of(object); p < triangles_.end_of(object); ++p) {
        modes_.forget(p);
        partly_seen_[p] = 0;
    }
}

void PaperCulling::forget_shadowed_by(const Box3& occluder)
{
    const scene::Scene& scene = state_->scene();
    const auto reaches = [&](const Box3& receiver) {
        for (scene::LightId l = 0; l < scene.lights.size(); ++l)
            if (may_shadow(scene.lights[l], state_->light(l), occluder, receiver)) return true;
        return false;
    };
    for (scene::ObjectId o = 0; o < static_bounds_.size(); ++o) {
        if (static_bounds_[o].empty() || !reaches(static_bounds_[o])) continue;
        for (PrimitiveId p = triangles_.first_of(o); p < triangles_.end_of(o); ++p) {
            glm::vec3 corners[3];
            triangles_.corners(p, corners);
            Box3 box;
            for (const glm::vec3& corner : corners) box.add(corner);
            if (reaches(box)) modes_.forget_shadow(p);
        }
    }
}

ShadowDecision PaperCulling::decide(PrimitiveId origin, int light, Notes& notes) const
{
    ++notes.counters.rays;
    ShadowDecision decision = test_shadow(modes_, origin, light);
    // While nothing is dynamic, the traversal of dynamic objects only has nothing to find.
    if (decision == ShadowDecision::dynamic_only && !any_dynamic()) decision = ShadowDecision::lit;
    notes.counters.skipped += decision == ShadowDecision::in_shadow || decision == ShadowDecision::lit;
    notes.counters.dynamic_only += decision == ShadowDecision::dynamic_only;
    if (decision == ShadowDecision::full_traversal)
        ++notes.counters.full[static_cast<std::size_t>(reason_of_full(origin, light))];
    return decision;
}

FullReason PaperCulling::reason_of_full(PrimitiveId origin, int light) const
{
    if (triangles_.is_dynamic(origin)) return FullReason::dynamic;
    if (modes_.occlusion(origin) != OcclusionMode::fully_rendered)
        return partly_seen_[origin] ? FullReason::partially_occluded : FullReason::not_seen;
    return modes_.shadow(origin, light) == ShadowMode::init ? FullReason::not_shadowed : FullReason::partly_shadowed;
}

void PaperCulling::note(PrimitiveId origin, int light, StaticPart static_part, bool dynamic_occluded, Notes& notes)
{
    // DEVIATION(Nah 2009, Table 3): `cullingResult` is nowhere assigned. Traversal of dynamic objects only counts as
    // culled and sets no bits: callers note only full traversals.
    // Dynamic primitives are never FULLY_RENDERED, so their shadow modes would never be read.
    if (triangles_.is_dynamic(origin)) return;
    const ShadowMode bits = shadow_bits(static_part, dynamic_occluded, options_.set_modes);
    if (bits == ShadowMode::init) return;
    if (options_.writes_at_once)
        modes_.set_shadow_now(origin, light, bits);
    else
        modes_.note_shadow(origin, light, bits, notes.touched);
}

void PaperCulling::see_pixel(const PrimaryHit& hit, PrimitiveId left, PrimitiveId upper, bool edge)
{
    GNOMON_CHECK(options_.writes_at_once);
    counters_.extra_tests += test_occlusion_now(hit, left, upper, edge, triangles_, modes_);
    if (hit.primitive != no_primitive) modes_.note_pixel(hit.primitive, rendered_);
}

bool PaperCulling::lets_light_through(scene::ObjectId object, std::uint32_t triangle) const
{
    const scene::Scene& scene = state_->scene();
    const scene::Mesh& mesh = scene.meshes[scene.objects[object].mesh];
    return scene.materials[mesh.part_of(triangle).material].surface_class() == scene::SurfaceClass::transparent;
}

void PaperCulling::see_image(std::span<const PrimaryHit> hits, std::size_t width)
{
    GNOMON_CHECK(width > 0 && hits.size() % width == 0);
    GNOMON_CHECK(!options_.writes_at_once);
    for (std::size_t begin = 0; begin < hits.size(); begin += width) {
        const auto row = hits.subspan(begin, width);
        const auto above = begin == 0 ? std::span<const PrimaryHit>{} : hits.subspan(begin - width, width);
        counters_.extra_tests +=
            test_occlusion(row, above, begin + width == hits.size(), triangles_, modes_, options_.occlusion_test)
                .extra_tests;
        for (const PrimaryHit& hit : row)
            if (hit.primitive != no_primitive) modes_.note_pixel(hit.primitive, rendered_);
    }
}

void PaperCulling::end_frame(std::span<Notes> notes)
{
    // Merge the results of the shadow rays, of primary and of other hits.
    for (Notes& n : notes) {
        for (const PrimitiveId primitive : n.touched) modes_.merge_shadow(primitive);
        n.touched.clear();
        counters_.add(n.counters);
        n.counters = {};
    }
    // Set the occlusion mode of every rendered primitive; update most_pixels after the comparison.
    for (const PrimitiveId primitive : rendered_) {
        const OcclusionMode after =
            occlusion_after(modes_.occlusion(primitive), modes_.marked(primitive), modes_.pixels(primitive),
                            modes_.most_pixels(primitive), options_.set_modes);
        modes_.set_occlusion(primitive, after);
        modes_.close_pixels(primitive);
        partly_seen_[primitive] = after == OcclusionMode::partially_occluded;
        if (after == OcclusionMode::partially_occluded && !options_.set_modes.partially_occluded_stays)
            begin_afresh_.push_back(primitive);
    }
    rendered_.clear();
}

bool may_shadow(const scene::Light& light, const scene::LightState& at, const Box3& occluder, const Box3& receiver)
{
    if (occluder.empty() || receiver.empty()) return false;
    const glm::dvec3 o(occluder.centre()), r(receiver.centre());
    // Bounding spheres of the boxes, enlarged by more than the rounding error.
    constexpr double k_slack = 1.00001;
    const double o_radius = 0.5 * k_slack * occluder.diagonal(), r_radius = 0.5 * k_slack * receiver.diagonal();

    if (light.type == scene::LightType::directional) {
        // Test the receiver's sphere, extruded towards the light.
        const glm::dvec3 to_light = -glm::dvec3(at.direction), d = o - r;
        const double along = glm::dot(d, to_light), reach = o_radius + r_radius;
        return along >= -reach && glm::length(d - along * to_light) <= reach;
    }
    // Test the cone from the light around the receiver's sphere against the one around the occluder's.
    const glm::dvec3 to_receiver = r - glm::dvec3(at.position), to_occluder = o - glm::dvec3(at.position);
    const double r_distance = glm::length(to_receiver), o_distance = glm::length(to_occluder);
    if (r_distance <= r_radius || o_distance <= o_radius) return true;
    if (o_distance - o_radius > r_distance + r_radius) return false;
    const double apart =
        std::acos(std::clamp(glm::dot(to_receiver, to_occluder) / (r_distance * o_distance), -1.0, 1.0));
    return apart <= k_slack * (std::asin(o_radius / o_distance) + std::asin(r_radius / r_distance)) + 1e-9;
}

}   // namespace gnomon::shadow_culling
