// SPDX-License-Identifier: Apache-2.0
#include "irradiance_cache/points/point_light.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "irradiance_cache/light_tree/facing_place.h"
#include "irradiance_cache/near_field/near_light.h"
#include "irradiance_cache/points/covered_points.h"
#include "irradiance_cache/points/point_device.h"

namespace gnomon::irradiance_cache {

namespace {

// Light below this fraction of the static light is what rounding leaves of light that was taken away.
constexpr float k_rounding = 1e-5f;

// A point is local only if more than this fraction of its light comes from patches that are close.
constexpr float k_least_local = 0.25f;

// Whether a direction of the sky is above a point's surface.
bool above(const CachePoint& point, const glm::vec3& direction)
{
    return glm::dot(direction, point.horizon) > 0 && glm::dot(direction, point.normal) > 0;
}

// The directions of the sky that a point divides: those at the edges of openings. Lattice points divide all of them,
// because the edges would show as bands. Others do where they see so little that whole directions would err by more.
SkyMask divided_at_edges(const SkyLight& sky, const CachePoint& point, const SkyMask& all, const SkyMask& seen)
{
    constexpr float k_error = 0.2f;   // of what is seen: half of each direction at an edge, as if by chance
    if (!sky.divides()) return {};
    const SkyMask edges = sky.edges(all, seen);
    if (is_lattice(point.key)) return edges;
    const auto directions = static_cast<float>(seen.common(seen)), at_edges = static_cast<float>(edges.common(edges));
    return at_edges > 4 * k_error * k_error * directions * directions ? edges : SkyMask{};
}

// The directions of the sky that light a point.
const SkyLight& sky_over(const CacheFrame& frame, const CachePoint& point)
{
    return is_lattice(point.key) || point.owner != k_no_owner ? frame.sky : frame.sky_of_parts;
}

// Lambert's vector of a light's surface above a point's horizon, by the light's area: its dot product with the point's
// normal is irradiance by flux. Lights of no known shape are squares that overlap, so that there are no gaps between
// them; what of these lies below the horizon is taken to lie above it.
glm::vec3 form_vector(const CachePoint& point, const DynamicVirtualLight& light)
{
    constexpr float k_overlap = 9;   // areas
    const glm::vec3 middle = light.position - point.origin();
    const bool known = light.side[0] != glm::vec3(0);
    glm::vec3 corner[4];
    int corners = 3;
    float area = light.area;
    if (known) {
        corner[0] = middle - (light.side[0] + light.side[1]) / 3.0f;
        corner[1] = corner[0] + light.side[0], corner[2] = corner[0] + light.side[1];
    } else {
        area *= k_overlap;
        glm::vec3 x, y;
        make_basis(glm::normalize(light.normal), x, y);
        x *= 0.5f * std::sqrt(area), y *= 0.5f * std::sqrt(area);
        corner[0] = middle - x - y, corner[1] = middle + x - y, corner[2] = middle + x + y, corner[3] = middle - x + y;
        corners = 4;
        if (!(glm::dot(middle, point.normal) > 0)) return glm::vec3(0);
    }
    // Clip it at the horizon.
    glm::vec3 above[8];
    int count = 0;
    for (int i = 0; i < corners; ++i) {
        const glm::vec3 &a = corner[i], &b = corner[(i + 1) % corners];
        const float height = glm::dot(a, point.normal), next = glm::dot(b, point.normal);
        if (height > 0) above[count++] = a;
        if ((height > 0) != (next > 0)) above[count++] = a + (height / (height - next)) * (b - a);
    }
    // Sum the edges, whose order is unknown.
    glm::vec3 sum(0), twice_area(0);
    for (int i = 0; i < count; ++i) {
        twice_area += glm::cross(above[i], above[(i + 1) % count]);
        const glm::vec3 a = glm::normalize(above[i]), b = glm::normalize(above[(i + 1) % count]), c = glm::cross(a, b);
        const float sine = glm::length(c);
        if (sine > 0) sum += (std::atan2(sine, glm::dot(a, b)) / sine) * c;
    }
    if (!known) area = 0.5f * glm::length(twice_area);
    if (!(area > 0)) return glm::vec3(0);
    sum /= 2 * static_cast<float>(k_pi) * area;
    return glm::dot(sum, middle) < 0 ? -sum : sum;
}

}   // namespace

void OcclusionTester::test(const ray::RayQueue& queue, ray::Against against, std::vector<std::uint8_t>& occluded,
                           CacheCounters& counters) const
{
    const std::size_t count = queue.size();
    occluded.resize(count + ray::k_packet_pad);
    if (device)
        device->occluded(queue, occluded.data(), against);
    else
        rays->occluded(queue, 0, count, occluded.data(), against);
    counters.rays += count;
}

void StaticVisibility::clear()
{
    added_.clear();
    rays_.clear();
    near_.clear(), near_of_moving_.clear();
    moving_.clear();
    short_cast_ = 0;
    nodes_.clear();
    weights_.clear();
}

// Whether some of a point's short rays meet static surfaces.
bool StaticVisibility::is_surface_near(const CacheFrame& frame, const CachePoint& point)
{
    constexpr std::size_t k_rays = 16;   // a packet
    const NearLight& light = frame.near_field.light();
    const std::span<const glm::vec3> directions = light.directions();
    const std::size_t step = std::max<std::size_t>(directions.size() / k_rays, 1);
    glm::vec3 t, b;
    make_basis(point.normal, t, b);
    short_rays_.clear();
    for (std::size_t i = step / 2; i < directions.size(); i += step) {
        const glm::vec3& d = directions[i];
        short_rays_.push(point.origin(), 0, d.x * t + d.y * b + d.z * point.normal, frame.near_field.radius());
    }
    occluded_.resize(short_rays_.size() + ray::k_packet_pad);
    frame.rays->occluded(short_rays_, 0, short_rays_.size(), occluded_.data(), ray::Against::static_only);
    short_cast_ += short_rays_.size();
    return std::ranges::any_of(std::span(occluded_).first(short_rays_.size()), [](std::uint8_t o) { return o != 0; });
}

void StaticVisibility::add(const CacheFrame& frame, CachePoint& point, std::span<const NodeId> cut,
                           std::span<const float> weight)
{
    added_.push_back({&point, nodes_.size(), NearPatches::k_none});
    point.tint = glm::vec3(1);
    float nearest = 0;   // patch
    if (frame.lights.patch_light()) {
        cut_.assign(cut.begin(), cut.end()), cut_weights_.assign(weight.begin(), weight.end());
        added_.back().near = near_of(point).divide(frame.lights, point, cut_, cut_weights_, nearest);
        cut = cut_, weight = cut_weights_;
    }
    // Points on dynamic objects have the present near field, and none where no patch is within its radius.
    const NearOptions* near = &frame.near_field.light().options();
    if (point.owner != k_no_owner) {
        if (nearest < frame.near_field.radius() && is_surface_near(frame, point))
            moving_.push_back(&point);
        else
            near = nullptr;
    }
    if (point.owner == k_no_owner) {
        const std::uint32_t most = is_lattice(point.key) ? frame.options.tested : frame.options.tested_of_part;
        tested_.choose(frame.lights, {point.origin(), point.normal, point.horizon}, cut, weight, most);
        cut = tested_.nodes(), weight = tested_.weights();
    }
    for (std::size_t k = 0; k < cut.size(); ++k) add_node(frame, point, cut[k], weight[k], near);
}

// Queues a ray to a node.
// @param near  the near field, which is that of light maps; null for points that have none
void StaticVisibility::add_node(const CacheFrame& frame, const CachePoint& point, NodeId node, float weight,
                                const NearOptions* near)
{
    // The sum is irradiance for the point's own normal. For other normals it must stay bounded at grazing angles.
    constexpr float k_least_cosine = 0.1f;
    const glm::vec3 sample = frame.lights.samples().at(node) - point.origin();
    const float cosine = glm::dot(sample, point.normal) / glm::length(sample);
    if (!(glm::dot(sample, point.horizon) > 0) || !(cosine > 0)) return;
    const glm::vec3 to =
        facing_place(frame.lights, node, {point.origin(), point.normal, point.horizon}) - point.origin();
    const float distance = glm::length(to);
    float fraction = 1;
    if (near && node < frame.lights.first_patch())
        fraction = far_fraction(distance, near->radius_at(frame.lights.leaf_width(node)));
    if (!(fraction > 0)) return;
    rays_.push(point.origin(), 0, to, frame.lights.ray_end());
    nodes_.push_back(node);
    weights_.push_back(fraction * weight / std::max(cosine, k_least_cosine));
}

// Multiplies the weights of visible nodes by what static surfaces that thin light let through, and finds the points'
// tint.
void StaticVisibility::thin_nodes(const CacheFrame& frame)
{
    passes_.resize(rays_.size());
    frame.rays->let_through(rays_, 0, rays_.size(), passes_.data(), ray::Against::static_only);
    for (std::size_t a = 0; a < added_.size(); ++a) {
        const std::size_t last = a + 1 < added_.size() ? added_[a + 1].first : rays_.size();
        glm::vec3 tinted(0), grey(0);
        for (std::size_t r = added_[a].first; r < last; ++r) {
            if (occluded_[r]) continue;
            const glm::vec3 light = weights_[r] * frame.lights.static_flux().at(nodes_[r]);
            const float passes = luminance(passes_[r]);
            tinted += passes_[r] * light, grey += passes * light;
            weights_[r] *= passes;
            if (!(passes > 0)) occluded_[r] = 1;
        }
        for (int colour = 0; colour < 3; ++colour)
            if (grey[colour] > 0) added_[a].point->tint[colour] = tinted[colour] / grey[colour];
    }
}

// Adds the light of the nodes that a point sees, but for its near patches.
void StaticVisibility::add_close_nodes(const CacheFrame& frame, Added& added) const
{
    const CachePoint& point = *added.point;
    const float reach = k_close * lattice_spacing(point.key);
    for (const SeenNode seen : seen_) {
        const NodeId node = seen_node(seen);
        const glm::vec3 to = frame.lights.samples().at(node) - point.origin();
        const float distance = glm::length(to);
        // Irradiance that a unit of flux brings; times area, it is the form factor.
        const float weight = seen_weight(seen) * glm::dot(to, point.normal) / distance;
        const float light = weight * luminance(frame.lights.static_flux().at(node));
        if (node >= frame.lights.first_patch() && distance < reach)
            added.close += {light, weight * frame.lights.quad(node / 4).area[node % 4], 0, 0};
        else
            added.close.farther += light;
    }
}

// Adds what comes from farther patches that are about as bright as those that are close.
// @param nodes  of `seen_`: those of the cut, without near patches
void StaticVisibility::add_beyond(const CacheFrame& frame, std::size_t nodes, Added& added) const
{
    constexpr float k_as_bright = 0.5f;
    const CachePoint& point = *added.point;
    CloseLight& close = added.close;
    if (!(close.irradiance > k_least_local * (close.irradiance + close.farther))) return;
    const float reach = k_close * lattice_spacing(point.key);
    for (const SeenNode seen : std::span(seen_).first(nodes)) {
        const NodeId node = seen_node(seen);
        if (node < frame.lights.first_patch()) continue;
        const glm::vec3 to = frame.lights.samples().at(node) - point.origin();
        const float distance = glm::length(to), flux = luminance(frame.lights.static_flux().at(node));
        const float area = frame.lights.quad(node / 4).area[node % 4];
        if (distance < reach || flux * close.form_factor < k_as_bright * area * close.irradiance) continue;
        close.beyond += seen_weight(seen) * glm::dot(to, point.normal) / distance * flux;
    }
}

// The form factor of the patches that a point sees, as in CachePoint.
glm::vec3 StaticVisibility::facing_of_seen(const CacheFrame& frame, const CachePoint& point) const
{
    glm::vec3 facing(0);
    for (const SeenNode seen : seen_) {
        const NodeId node = seen_node(seen);
        if (node < frame.lights.first_patch()) continue;
        const glm::vec3 to = frame.lights.samples().at(node) - point.origin();
        const float area = frame.lights.quad(node / 4).area[node % 4];
        facing += to * (seen_weight(seen) * area / glm::length(to));
    }
    return facing;
}

// Finds how bright points are, and lattice points whose light is local: much of it comes from patches that are close
// by, small and far brighter than all that is farther, such as the sliver of ceiling above a luminous plate that is
// seen past the plate's edge. A spacing away there is nothing of it. At the foot of a wall close light is as much, but
// what is close goes on: other parts of the wall, or of a bright floor before it, take its place.
void StaticVisibility::find_local()
{
    constexpr float k_brighter = 4.0f;   // radiance of what is close over that of all else
    constexpr float k_goes_on = 0.1f;    // of close light: as much from beyond, as bright
    for (const Added& added : added_) {
        const CloseLight& close = added.close;
        const float all = close.irradiance + close.farther;
        const bool from_close =
            close.irradiance > k_least_local * all &&
            close.irradiance * (1 - close.form_factor) > k_brighter * close.form_factor * close.farther;
        const bool goes_on = close.beyond > k_goes_on * close.irradiance;
        added.point->local = from_close && !goes_on;
        added.point->steep = from_close && goes_on;
        added.point->brightness = all, added.point->sky_light = close.sky;
    }
}

std::ptrdiff_t StaticVisibility::trace_sky(const CacheFrame& frame, const OcclusionTester& tester,
                                           CacheCounters& counters)
{
    std::ptrdiff_t more = 0;
    if (frame.sky.any()) {
        see_sky(frame, tester, counters);
        more = divide_sky(frame, tester, counters);
    }
    find_local();
    return more;
}

// Adds light of the sky to a point's static light.
void StaticVisibility::add_sky(Added& added, const glm::vec3& light, const glm::vec3& direction)
{
    CachePoint& point = *added.point;
    const float arrives = luminance(light) * glm::dot(direction, point.normal);
    added.close.farther += arrives, added.close.sky += arrives;
    for (int colour = 0; colour < 3; ++colour) point.static_light[colour] += light[colour] * direction;
}

// Traces the queued rays to the sky, past static geometry.
// @param passes  output: by ray, what surfaces that thin light let through; empty where there are none
// @return  whether there are any
bool StaticVisibility::test_sky(const CacheFrame& frame, const OcclusionTester& tester, std::vector<glm::vec3>& passes,
                                CacheCounters& counters)
{
    tester.test(rays_, ray::Against::static_only, occluded_, counters);
    const bool thins = frame.rays->thins_light();
    passes.resize(thins ? rays_.size() : 0);
    if (thins) frame.rays->let_through(rays_, 0, rays_.size(), passes.data(), ray::Against::static_only);
    return thins;
}

// Finds which directions of the sky the points see. Adds the light of those that are not divided, and divides the
// others.
void StaticVisibility::see_sky(const CacheFrame& frame, const OcclusionTester& tester, CacheCounters& counters)
{
    rays_.clear();
    for (const Added& added : added_) {
        const SkyLight& sky = sky_over(frame, *added.point);
        for (std::size_t i = 0; i < sky.directions(); ++i)
            if (above(*added.point, sky.direction(i)))
                rays_.push(added.point->origin(), 0, sky.direction(i), k_infinity);
    }
    const bool thins = test_sky(frame, tester, sky_passes_, counters);
    std::size_t next = 0;
    for (Added& added : added_) {
        CachePoint& point = *added.point;
        const SkyLight& sky = sky_over(frame, point);
        SkyMask seen, all;
        const std::size_t first = added.sky_ray = next;
        for (std::size_t i = 0; i < sky.directions(); ++i) {
            if (!above(point, sky.direction(i))) continue;
            all.set(i);
            if (!occluded_[next++]) seen.set(i);
        }
        added.sky_above = all, added.sky_seen = seen;
        added.sky_edges = divided_at_edges(sky, point, all, seen);
        point.sky = seen.without(added.sky_edges);
        next = first;
        all.for_each([&](std::size_t i) {
            const std::size_t r = next++;
            if (point.sky.test(i))
                add_sky(added, thins ? sky.light(i) * sky_passes_[r] : sky.light(i), sky.direction(i));
        });
    }
}

// Divides the directions of the sky at the edges of openings, and adds the light of the parts that points see.
std::ptrdiff_t StaticVisibility::divide_sky(const CacheFrame& frame, const OcclusionTester& tester,
                                            CacheCounters& counters)
{
    rays_.clear();
    for (const Added& added : added_)
        added.sky_edges.for_each([&](std::size_t i) {
            for (const SkyLight::Part& part : sky_over(frame, *added.point).parts(i))
                rays_.push(added.point->origin(), 0, part.direction, k_infinity);
        });
    const bool thins = test_sky(frame, tester, passes_, counters);
    std::ptrdiff_t more = 0;
    std::size_t next = 0;
    for (Added& added : added_) {
        CachePoint& point = *added.point;
        const SkyLight& sky = sky_over(frame, point);
        more -= static_cast<std::ptrdiff_t>(point.divided_sky.size());
        std::vector<DividedDirection> divided;
        const std::size_t first = next;
        added.sky_edges.for_each([&](std::size_t i) {
            DividedDirection direction{static_cast<std::uint16_t>(i), 0};
            const std::span<const SkyLight::Part> parts = sky.parts(i);
            for (std::size_t k = 0; k < parts.size(); ++k)
                if (!occluded_[next++] && above(point, parts[k].direction))
                    direction.seen = static_cast<std::uint16_t>(direction.seen | (1u << k));
            divided.push_back(direction);
        });
        sky.take_back(added.sky_above, added.sky_seen, divided);
        // Add the light of the parts, and of the directions that are not divided after all.
        std::size_t kept = 0;
        next = first;
        added.sky_edges.for_each([&](std::size_t i) {
            const std::span<const SkyLight::Part> parts = sky.parts(i);
            const std::size_t ray = next;
            next += parts.size();
            const bool whole = kept == divided.size() || divided[kept].direction != i;
            const std::uint16_t seen = whole ? 0 : divided[kept++].seen;
            if (whole && added.sky_seen.test(i)) {
                point.sky.set(i);
                glm::vec3 light = sky.light(i);
                if (thins) light *= sky_passes_[added.sky_ray + added.sky_above.rank(i)];
                add_sky(added, light, sky.direction(i));
            }
            for (std::size_t k = 0; k < parts.size(); ++k)
                if ((seen >> k) & 1)
                    add_sky(added, thins ? parts[k].light * passes_[ray + k] : parts[k].light, parts[k].direction);
        });
        std::erase_if(divided, [](const DividedDirection& d) { return d.seen == 0; });
        divided.shrink_to_fit();
        point.divided_sky = std::move(divided);
        more += static_cast<std::ptrdiff_t>(point.divided_sky.size());
    }
    return more;
}

void PresentLight::clear()
{
    rays_.clear();
    contributions_.clear();
    bounce_rays_.clear();
    bounces_.clear();
    lit_.clear();
}

void PresentLight::add_if_unoccluded(const CacheFrame& frame, CachePoint& point, NodeId node, const glm::vec3& flux,
                                     const glm::vec3& direction)
{
    rays_.push(point.origin(), 0, frame.lights.samples().at(node) - point.origin(), frame.options.light_tree.ray_end);
    contributions_.push_back({&point, flux, direction});
}

void PresentLight::correct_sky(const CacheFrame& frame, CachePoint& point)
{
    const SkyLight& sky = sky_over(frame, point);
    if (!sky.any()) return;
    SkyMask divided;
    for (const DividedDirection& direction : point.divided_sky) divided.set(direction.direction);
    SkyMask hidden;
    SkyMask near;
    boxes_.clear();
    frame.dynamic_bounds.any(
        [&](const Sphere& sphere) {
            const glm::vec3 at = sphere.centre - point.origin();
            near = sky.towards(at, sphere.radius) & point.sky;
            if (!point.divided_sky.empty()) near |= sky.towards(at, sphere.radius, true) & divided;
            return near.any();
        },
        [&](const Sphere&, const MovingBox& box) {
            hidden |= near;
            boxes_.push_back(&box);
            return false;
        });
    // Collect the light of these directions, and of the visible parts of those that are divided, where boxes are in
    // the way.
    hidden_.clear();
    const auto hide = [&](const SkyLight::Part& part) {
        const auto meets = [&](const MovingBox* box) {
            return meets_way(*box, point.origin(), part.direction, k_infinity);
        };
        if (std::ranges::any_of(boxes_, meets)) hidden_.push_back(part);
    };
    (hidden & point.sky).for_each([&](std::size_t i) { hide({sky.direction(i), sky.light(i)}); });
    for (const DividedDirection& direction : point.divided_sky) {
        if (!hidden.test(direction.direction)) continue;
        const std::span<const SkyLight::Part> parts = sky.parts(direction.direction);
        for (std::size_t k = 0; k < parts.size(); ++k)
            if ((direction.seen >> k) & 1) hide(parts[k]);
    }
    // Static surfaces thin some of it.
    if (frame.rays->thins_light()) {
        hidden_rays_.clear();
        for (const SkyLight::Part& part : hidden_) hidden_rays_.push(point.origin(), 0, part.direction, k_infinity);
        passes_.resize(hidden_rays_.size());
        frame.rays->let_through(hidden_rays_, 0, hidden_rays_.size(), passes_.data(), ray::Against::static_only);
        for (std::size_t k = 0; k < hidden_.size(); ++k) hidden_[k].light *= passes_[k];
    }
    for (const SkyLight::Part& part : hidden_) {
        point.add_light(-part.light, part.direction);
        rays_.push(point.origin(), 0, part.direction, k_infinity);
        contributions_.push_back({&point, part.light, part.direction});
    }
}

void PresentLight::add_dynamic_lights(const CacheFrame& frame, CachePoint& point)
{
    if (frame.lights.dynamic_lights().empty()) return;
    const float already = luminance(point.irradiance(point.normal));
    // Adds a light that is small as seen from the point, or cannot be divided.
    const auto add = [&](const DynamicVirtualLight& light, bool tested) {
        const glm::vec3 to = light.sample - point.origin();
        const float square = glm::dot(to, to), distance = std::sqrt(square);
        const float cosine = glm::dot(to, point.normal), facing = light.facing(to, distance);
        if (!(facing > 0)) return;
        glm::vec3 direction;
        if (light.owner != point.owner && light.is_wide(square)) {
            direction = form_vector(point, light);
        } else {
            if (!(cosine > 0) || !(glm::dot(to, point.horizon) > 0)) return;
            // The kernel of a disk, as for nodes of the tree (point_kernels.h).
            const float kernel = facing / distance / (static_cast<float>(k_pi) * square + light.area);
            direction = to * (kernel / distance);
        }
        if (!tested && luminance(light.flux) * glm::dot(direction, point.normal) < frame.options.untested * already) {
            point.add_light(light.flux, direction);
            return;
        }
        const glm::vec3 place = facing_sample(light, frame.lights.dynamic_halves(), point.origin());
        bounce_rays_.push(point.origin(), 0, place - point.origin(), frame.options.light_tree.ray_end);
        bounces_.push_back({&point, light.flux, direction});
    };
    for (const DynamicVirtualLight& light : frame.lights.dynamic_lights()) {
        const glm::vec3 way = light.sample - point.origin();
        const bool near = light.owner == point.owner || light.is_near(glm::dot(way, way));
        for_each_part(light, frame.lights.dynamic_halves(), point.origin(),
                      [&](const DynamicVirtualLight& part) { add(part, near); });
    }
}

void PresentLight::finish(const CacheFrame& frame, const OcclusionTester& tester, CacheCounters& counters)
{
    add_arriving(tester, rays_, contributions_, ray::Against::dynamic_only, counters);
    for (CachePoint* point : lit_)
        if (point->owner == k_no_owner) point->covered_now = is_covered(frame, CoverablePoint(*point));
    // How small a part is, all other light tells: not what is left of it while some is in doubt.
    for (CachePoint* point : lit_) add_dynamic_lights(frame, *point);
    add_arriving(tester, bounce_rays_, bounces_, ray::Against::everything, counters);
}

void PresentLight::add_arriving(const OcclusionTester& tester, const ray::RayQueue& rays,
                                const std::vector<Contribution>& contributions, ray::Against against,
                                CacheCounters& counters)
{
    const std::size_t count = rays.size();
    if (count == 0) return;
    tester.test(rays, against, occluded_, counters);
    counters.rays_dynamic += count;
    if (tester.rays->thins_light()) {
        passes_.resize(count);
        tester.rays->let_through(rays, 0, count, passes_.data(), against);
        for (std::size_t r = 0; r < count; ++r)
            if (!occluded_[r])
                contributions[r].point->add_light(contributions[r].flux * passes_[r], contributions[r].direction);
        return;
    }
    for (std::size_t r = 0; r < count; ++r)
        if (!occluded_[r]) contributions[r].point->add_light(contributions[r].flux, contributions[r].direction);
}

void end_corrections(CachePoint& point)
{
    for (int colour = 0; colour < 3; ++colour) {
        glm::vec3& light = point.light[colour];
        const glm::vec3& all = point.static_light[colour];
        if (glm::dot(light, light) < k_rounding * k_rounding * glm::dot(all, all)) light = glm::vec3(0);
    }
}

}   // namespace gnomon::irradiance_cache
