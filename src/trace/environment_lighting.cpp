// SPDX-License-Identifier: Apache-2.0
#include "trace/environment_lighting.h"

#include <algorithm>
#include <bit>
#include <limits>
#include <numeric>

#include "base/interruption.h"
#include "shading/glossy.h"
#include "trace/sized_lighting.h"

namespace gnomon::trace {

namespace {

using environment_light::FromCells;
using environment_light::Guides;

constexpr int k_lattice = 4;                // pixels between points that guide others
constexpr std::size_t k_least_guides = 3;   // of the four around a point, that are on its surface
constexpr float k_least_alignment = 0.8f;   // cosine between the normals of a point and its guides
constexpr float k_most_footprints = 12;     // between them, in widths of a pixel on the surface
constexpr float k_least_cosine = 0.1f;      // of the view, for that width
constexpr std::uint32_t k_between = 0xffffffff;
constexpr std::uint32_t k_nobody = 0xffffffff;
constexpr int k_passes = 2;                   // of points with guides
constexpr float k_passes_alike = 1 / 64.0f;   // difference of what surfaces let through, up to which it is interpolated
// Of a path, times the share of the pixel: up to here, a point in mirrors and glass that no others guide and that
// guides none is answered coarsely, and so is every such point that the camera sees: it has no neighbours beside which
// steps show. A cell that is wrong is a hundredth of its light, times this.
constexpr float k_coarse_throughput = 0.25f;

glm::vec3 interpolated(std::span<const glm::vec3> of_places, const PlaceLattice::Around& around)
{
    glm::vec3 sum(0);
    for (std::size_t i = 0; i < around.place.size(); ++i) sum += around.weight[i] * of_places[around.place[i]];
    return sum;
}

FromCells interpolated(std::span<const FromCells> of_places, const PlaceLattice::Around& around)
{
    FromCells sum;
    for (std::size_t i = 0; i < around.place.size(); ++i) {
        sum.irradiance += around.weight[i] * of_places[around.place[i]].irradiance;
        sum.hidden += around.weight[i] * of_places[around.place[i]].hidden;
    }
    return sum;
}

// Whether two points lie on one smooth piece of surface.
bool continue_each_other(const TilePoint& a, const TilePoint& b)
{
    const shading::SurfacePoint &s = a.surface, &t = b.surface;
    if (glm::dot(s.geometric_normal, t.geometric_normal) < k_least_alignment) return false;
    const glm::vec3 way = t.position - s.position;
    const float distance = glm::length(way);
    const float cosine = std::max(glm::dot(s.geometric_normal, s.to_viewer), k_least_cosine);
    return distance <= k_most_footprints * s.cone.width / cosine;
}

}   // namespace

std::unique_ptr<EnvironmentTechnique> EnvironmentTechnique::of_every_ray(double sun_diameter)
{
    environment_light::EnvironmentOptions options;
    options.image = false;
    options.sun_diameter = sun_diameter;
    options.cells.disc_level = 5;
    options.cells.groups = false;
    options.proofs.first_asks = std::numeric_limits<int>::max();
    auto technique = std::make_unique<EnvironmentTechnique>(options);
    technique->every_ray_ = true;
    return technique;
}

void EnvironmentTechnique::begin_frame(const FrameContext& frame, std::size_t tiles)
{
    light_.follow(frame.state, frame.rays, &frame.tasks);
    remembers_ = begun_;
    begun_ = true;
    const std::size_t sets = 1 + light_.suns().size();
    if (memories_.size() != tiles || memories_.empty() || memories_[0].size() != sets) {
        memories_.clear();
        memories_.resize(tiles);
        for (auto& of_tile : memories_) of_tile.resize(sets);
    }
    for (auto& of_tile : memories_)
        for (std::size_t set = 0; set < sets; ++set) {
            if (set == 0 ? version_ != light_.version() : suns_version_ != light_.suns_version()) of_tile[set].forget();
            of_tile[set].begin_frame();
        }
    // What moves hides cells from shared places.
    const std::shared_ptr<const scene::Environment> image =
        light_.empty() ? nullptr : frame.state.scene().background.environment;
    if (image != image_ || version_ != light_.version() || light_.anything_moves() || rough_ != was_rough_)
        shared_places_.forget();
    was_rough_ = rough_;
    shared_places_.begin_frame();
    place_groups_.begin_frame(frame.state.base());
    image_ = image;
    version_ = light_.version(), suns_version_ = light_.suns_version();
}

std::size_t EnvironmentTechnique::bytes() const
{
    std::size_t bytes = light_.bytes() + shared_places_.bytes() + place_groups_.bytes();
    for (const auto& of_tile : memories_)
        for (const environment_light::PointMemory& memory : of_tile) bytes += memory.bytes();
    return bytes;
}

bool EnvironmentLighting::has_sun(scene::LightId light) const
{
    return std::ranges::any_of(technique_.light().suns(), [&](const auto& sun) { return sun->light == light; });
}

// Finds the points around one on a lattice of pixels.
// @param points    indices in the batch
// @param answered  so many of them, from the first on, may be guides
// @return  of pass 0: too few are of its surface
Guides EnvironmentLighting::guides_of(const PointBatch& batch, std::span<const std::uint32_t> points, std::uint32_t k,
                                      std::size_t answered, int step, int pass) const
{
    const Tile& tile = batch.tile;
    const auto side = static_cast<std::uint32_t>(tile.side);
    const TilePoint& point = batch.points[points[k]];
    const auto x = static_cast<int>(point.pixel % side), y = static_cast<int>(point.pixel / side);
    // The lattice ends with the tile's last pixels.
    const int x0 = x / step * step, x1 = x % step == 0 || x == tile.width - 1 ? x : std::min(x0 + step, tile.width - 1);
    const int y0 = y / step * step,
              y1 = y % step == 0 || y == tile.height - 1 ? y : std::min(y0 + step, tile.height - 1);
    const int left = x1 == x ? x : x0, top = y1 == y ? y : y0;
    // Bilinear weights; one of both columns, or rows, where these are the same.
    const float fx = x1 > left ? static_cast<float>(x - left) / static_cast<float>(x1 - left) : 0,
                fy = y1 > top ? static_cast<float>(y - top) / static_cast<float>(y1 - top) : 0;
    Guides guides;
    std::size_t found = 0;
    float sum = 0;
    for (int corner = 0; corner < 4; ++corner) {
        const int gx = corner % 2 == 0 ? left : x1, gy = corner < 2 ? top : y1;
        const std::uint32_t guide =
            asked_of_pixel_[static_cast<std::uint32_t>(gy) * side + static_cast<std::uint32_t>(gx)];
        if (guide >= answered || batch.shadow_points[points[guide]].object != batch.shadow_points[points[k]].object ||
            !continue_each_other(point, batch.points[points[guide]]))
            continue;
        guides.weight[found] = (corner % 2 == 0 ? 1 - fx : fx) * (corner < 2 ? 1 - fy : fy);
        sum += guides.weight[found];
        guides.corner[found++] = guide;
    }
    if (found < k_least_guides || !(sum > 0)) return {};
    for (float& weight : guides.weight) weight /= sum;
    for (; found < guides.corner.size(); ++found) guides.corner[found] = guides.corner[0];
    guides.pass = static_cast<std::uint8_t>(pass);
    // Blocks of the finer lattice come after those of the wider one.
    const auto blocks = side / k_lattice;
    const auto wide = static_cast<std::uint32_t>(step);
    guides.block = (step == k_lattice ? 0 : blocks * blocks) + static_cast<std::uint32_t>(y0) / wide * (side / wide) +
                   static_cast<std::uint32_t>(x0) / wide;
    guides.number = static_cast<std::uint32_t>((y - y0) * k_lattice + (x - x0));
    return guides;
}

// Gives the points between those of a lattice of pixels these as guides, where they are of one surface: first those of
// a lattice that is half as wide, then all others these.
// @param points    indices in the batch
// @param answered  so many of them, from the first on, may be guides
void EnvironmentLighting::find_guides(const PointBatch& batch, std::span<const std::uint32_t> points,
                                      std::size_t answered)
{
    const Tile& tile = batch.tile;
    const auto side = static_cast<std::uint32_t>(tile.side);
    guides_.assign(points.size(), {});
    if (batch.scattered()) return;
    asked_of_pixel_.assign(std::size_t{side} * side, k_nobody);
    for (std::uint32_t k = 0; k < points.size(); ++k) asked_of_pixel_[batch.points[points[k]].pixel] = k;
    for (std::uint32_t k = 0; k < points.size(); ++k) {
        const TilePoint& point = batch.points[points[k]];
        const auto x = static_cast<int>(point.pixel % side), y = static_cast<int>(point.pixel / side);
        const auto on = [&](int step) {
            return (x % step == 0 || x == tile.width - 1) && (y % step == 0 || y == tile.height - 1);
        };
        if (on(k_lattice)) continue;
        // Where points of the finer lattice are not asked, those of the wider one are guides.
        const int first = on(k_lattice / 2) ? k_lattice : k_lattice / 2;
        for (int step = first; step <= k_lattice && guides_[k].pass == 0; step *= 2)
            guides_[k] = guides_of(batch, points, k, answered, step, first == k_lattice ? 1 : 2);
    }
    for (std::size_t k = 0; k < guides_.size(); ++k)
        if (guides_[k].pass != 0)
            for (const std::uint32_t corner : guides_[k].corner) guides_[corner].guides = true;
}

// For what moves, gives the points of the lattice of pixels others of a lattice twice as wide as guides. Most of what
// static objects leave is clear of moving ones at all points of a tile, or hidden.
// @param points  as in find_guides(); those that have guides_ are asked
void EnvironmentLighting::find_guides_of_moving(const PointBatch& batch, std::span<const std::uint32_t> points)
{
    const Tile& tile = batch.tile;
    const auto side = static_cast<std::uint32_t>(tile.side);
    moving_guides_ = guides_;
    if (batch.scattered()) return;
    for (std::uint32_t k = 0; k < guides_.size(); ++k) {
        Guides& own = moving_guides_[k];
        if (own.pass != 0) {
            ++own.pass;
            continue;
        }
        const TilePoint& point = batch.points[points[k]];
        const auto x = static_cast<int>(point.pixel % side), y = static_cast<int>(point.pixel / side);
        constexpr int k_wide = 2 * k_lattice;
        const bool wide = (x % k_wide == 0 || x == tile.width - 1) && (y % k_wide == 0 || y == tile.height - 1);
        if (wide || own.coarse || !own.guides) continue;
        const Guides found = guides_of(batch, points, k, guides_.size(), k_wide, 1);
        if (found.pass == 0 || std::ranges::any_of(found.corner, [&](std::uint32_t c) { return guides_[c].coarse; }))
            continue;
        own = found;
        own.guides = true;
    }
}

// Finds what the asked points see: by the lattice's places where these are alike, else by themselves.
// @param before  of the asked points, those that are answered already
void EnvironmentLighting::find_seen(const PointBatch& batch, std::size_t tile, std::size_t before)
{
    const environment_light::EnvironmentLight& light = technique_.light();
    lattice_.find(batch, asked_);
    const std::span<const visibility::ShadowPoint> between = lattice_.places();
    asked_places_.resize(between.size());
    std::iota(asked_places_.begin(), asked_places_.end(), 0u);
    const Guides as_asked{.coarse = technique_.rough(), .rough = technique_.rough()};
    guides_.assign(technique_.rough() ? between.size() : 0, as_asked);
    if (!between.empty())
        light.visibility().find(scratch_, between, asked_places_, guides_, technique_.memory(tile), lattice_seen_);
    lattice_light_.resize(between.size());
    lattice_passes_.assign(passing_.any() ? between.size() : 0, glm::vec3(1));
    for (std::size_t p = 0; p < between.size(); ++p) {
        const std::span<const std::uint64_t> seen = lattice_seen_.of(p);
        lattice_light_[p] = light.light().from_cells(between[p].normal, seen, lattice_seen_.partial_of(p));
        if (passing_.any())
            lattice_passes_[p] =
                passing_.from_cells(between[p].normal, between[p].origin, light.visibility().cells(), seen);
    }

    apart_.clear();
    apart_at_.assign(asked_.size(), k_between);
    for (std::size_t k = 0; k < asked_.size(); ++k) {
        if (is_between(k)) continue;
        apart_at_[k] = static_cast<std::uint32_t>(apart_.size());
        apart_.push_back(asked_[k]);
    }
    places_.find(batch, apart_);
    // Points that may follow will need guides, too.
    follow_.insert(follow_.begin(), places_.own_points().begin(), places_.own_points().end());
    find_guides(batch, follow_, places_.own());
    guides_.resize(places_.own());
    for (std::size_t k = 0; k < guides_.size(); ++k) {
        const float share = batch.share_of(batch.points[places_.own_points()[k]]);
        const bool small = share <= k_coarse_throughput;
        guides_[k].coarse = guides_[k].pass == 0 && (small || (batch.primary && !guides_[k].guides));
        guides_[k].unless_dark = share > k_coarse_throughput;
    }
    if (technique_.rough()) guides_.assign(guides_.size(), as_asked);
    asked_places_.resize(places_.own());
    std::iota(asked_places_.begin(), asked_places_.end(), 0u);
    if (light.anything_moves()) find_guides_of_moving(batch, follow_);
    light.visibility().find(own_scratch_, places_.places(), asked_places_, guides_, technique_.memory(tile), seen_,
                            before, moving_guides_);
    if (passing_.any()) find_passing(batch, before);
    find_shared();
}

// Finds what surfaces that thin light let through to points with places of their own: guides first. Where these agree,
// it is interpolated between them.
void EnvironmentLighting::find_passing(const PointBatch& batch, std::size_t before)
{
    const environment_light::EnvironmentLight& light = technique_.light();
    own_passes_.resize(before);
    own_passes_.resize(places_.own(), glm::vec3(1));
    for (int pass = 0; pass <= k_passes; ++pass)
        for (std::size_t k = before; k < own_passes_.size(); ++k) {
            const Guides& guides = guides_[k];
            if (guides.pass != pass) continue;
            if (pass > 0) {
                glm::vec3 least(k_infinity), most(0), between(0);
                for (std::size_t i = 0; i < guides.corner.size(); ++i) {
                    const glm::vec3& passes = own_passes_[guides.corner[i]];
                    least = glm::min(least, passes), most = glm::max(most, passes);
                    between += guides.weight[i] * passes;
                }
                const glm::vec3 apart = most - least;
                if (std::max({apart.x, apart.y, apart.z}) <= k_passes_alike) {
                    own_passes_[k] = between;
                    continue;
                }
            }
            const std::uint32_t p = places_.own_points()[k];
            const TilePoint& point = batch.points[p];
            const bool direct = (batch.primary || point.straight) && batch.most_share == 1 && !technique_.rough();
            own_passes_[k] =
                passing_.from_cells(point.surface.normal, batch.shadow_points[p].origin, light.visibility().cells(),
                                    seen_.of(k), direct ? PassingLight::k_rays : PassingLight::k_rays_in_mirrors);
        }
}

// Finds what shared places see: coarsely, and each place once for all tiles.
void EnvironmentLighting::find_shared()
{
    const environment_light::EnvironmentLight& light = technique_.light();
    PlaceMemory& memory = technique_.shared_places();
    const std::span<const visibility::ShadowPoint> places = places_.places().subspan(places_.own());
    shared_.assign(places.size(), nullptr);
    claimed_.clear();
    const auto evaluate = [&] {
        guides_.assign(claimed_.size(), {.coarse = true, .rough = technique_.rough()});
        light.visibility().find(scratch_, places, claimed_, guides_, nullptr, shared_seen_);
    };
    const auto publish = [&](PlaceMemory::Place& place, std::size_t k) {
        memory.publish(place, shared_seen_.of(k),
                       light.light().from_cells(places[claimed_[k]].normal, shared_seen_.of(k), {}));
    };
    try {
        claimed_.reserve(places.size());
        for (std::uint32_t k = 0; k < places.size(); ++k) {
            bool is_own = false;
            shared_[k] = &memory.find(places_.shared_keys()[k], is_own);
            if (is_own) claimed_.push_back(k);
        }
        if (!claimed_.empty()) evaluate();
        for (std::size_t k = 0; k < claimed_.size(); ++k) publish(*shared_[claimed_[k]], k);
    } catch (...) {
        for (const std::uint32_t k : claimed_) memory.abandon(*shared_[k]);
        throw;
    }

    // Wait for those of other threads; evaluate what these abandoned.
    claimed_.clear();
    for (std::uint32_t k = 0; k < places.size(); ++k)
        if (!PlaceMemory::wait(*shared_[k])) claimed_.push_back(k);
    if (claimed_.empty()) return;
    interruption_point();
    evaluate();
    abandoned_.resize(claimed_.size());
    for (std::size_t k = 0; k < claimed_.size(); ++k) {
        shared_[claimed_[k]] = &abandoned_[k];
        publish(abandoned_[k], k);
    }
}

// Whether the places around an asked point are alike.
bool EnvironmentLighting::is_between(std::size_t k) const
{
    const PlaceLattice::Around& around = lattice_.around()[k];
    if (!around.any()) return false;
    float least = k_infinity, most = 0;
    for (const std::uint32_t place : around.place) {
        const glm::vec3& irradiance = lattice_light_[place].irradiance;
        const float light = luminance(passing_.any() ? lattice_passes_[place] * irradiance : irradiance);
        least = std::min(least, light), most = std::max(most, light);
    }
    return most - least <= lattice_.options().alike * most;
}

// Interpolates what the places around a point see.
void EnvironmentLighting::see_between(const PlaceLattice::Around& around)
{
    const environment_light::SeenCells& seen = lattice_seen_;
    between_mask_.assign(seen.words, 0);
    between_partial_.clear(), between_leaves_.clear();
    // Find the cells on which they do not agree, or of which one sees a share.
    for (const std::uint32_t place : around.place)
        for (const environment_light::PartialCell& cell : seen.partial_of(place)) between_leaves_.push_back(cell.leaf);
    for (std::size_t w = 0; w < seen.words; ++w) {
        const std::uint64_t a = seen.of(around.place[0])[w], b = seen.of(around.place[1])[w],
                            c = seen.of(around.place[2])[w];
        between_mask_[w] = a & b & c;
        for (std::uint64_t other = (a | b | c) & ~between_mask_[w]; other != 0; other &= other - 1)
            between_leaves_.push_back(
                static_cast<std::uint32_t>(64 * w + static_cast<std::size_t>(std::countr_zero(other))));
    }
    std::ranges::sort(between_leaves_);
    between_leaves_.erase(std::unique(between_leaves_.begin(), between_leaves_.end()), between_leaves_.end());
    for (const std::uint32_t leaf : between_leaves_) {
        float share = 0;
        for (std::size_t i = 0; i < around.place.size(); ++i) {
            const std::span<const environment_light::PartialCell> partial = seen.partial_of(around.place[i]);
            const auto at = std::ranges::lower_bound(partial, leaf, {}, &environment_light::PartialCell::leaf);
            const bool whole = (seen.of(around.place[i])[leaf / 64] >> (leaf % 64) & 1) != 0;
            share += around.weight[i] * (at != partial.end() && at->leaf == leaf ? at->share : whole ? 1.0f : 0.0f);
        }
        between_partial_.push_back({leaf, std::clamp(share, 0.0f, 1.0f)});
        const std::uint64_t bit = std::uint64_t{1} << (leaf % 64);
        between_mask_[leaf / 64] = share >= 0.5f ? between_mask_[leaf / 64] | bit : between_mask_[leaf / 64] & ~bit;
    }
}

// Whether a point could reflect light of the image.
bool EnvironmentLighting::may_reflect(const TilePoint& point)
{
    const shading::SurfacePoint& s = point.surface;
    if (s.model == scene::ShadingModel::unlit) return false;
    // A smooth surface shows the image in the rays that it reflects.
    const bool blurred = point.next.unresolved_weight != glm::vec3(0);
    return s.diffuse != glm::vec3(0) || blurred || image_share(s) != 0;
}

void EnvironmentLighting::light_some(const PointBatch& batch, std::size_t tile, std::size_t first, std::size_t end,
                                     const AddReflected& add)
{
    interruption_point();
    if (first == 0) reflected_.clear(), by_lobes_.clear(), hidden_.clear(), asked_.clear();
    reflected_.resize(batch.points.size(), 0);
    by_lobes_.resize(batch.points.size());
    hidden_.resize(batch.points.size(), 1);
    const std::size_t before = asked_.size();
    follow_.clear();
    for (auto p = static_cast<std::uint32_t>(first); p < batch.points.size(); ++p)
        if (may_reflect(batch.points[p])) (p < end ? asked_ : follow_).push_back(p);
    if (asked_.size() == before) return;
    find_seen(batch, tile, before);
    const environment_light::EnvironmentLight& light = technique_.light();
    for (std::size_t k = before; k < asked_.size(); ++k) {
        const TilePoint& point = batch.points[asked_[k]];
        const shading::SurfacePoint& s = point.surface;
        std::span<const std::uint64_t> seen;
        std::span<const environment_light::PartialCell> partial;
        const PlaceMemory::Place* shared = nullptr;
        glm::vec3 horizon = s.geometric_normal;   // of the triangle that decided the cells
        const PlaceLattice::Around* between = apart_at_[k] == k_between ? &lattice_.around()[k] : nullptr;
        const std::size_t shared_rays = point.straight ? PassingLight::k_rays : PassingLight::k_rays_in_mirrors;
        const float highlight = image_share(s);
        const glm::vec3 albedo = highlight > 0 ? shading::glossy_albedo(s) : glm::vec3(0);
        // Rays of the lobe show the image where they meet nothing.
        const glm::vec3 by_rays = highlight * point.next.lobe_weight;
        const glm::vec3 weight =
            (1 - highlight) * point.next.unresolved_weight + highlight * s.coverage * albedo - by_rays;
        // On a plane, the light itself is interpolated.
        const bool lobe = weight != glm::vec3(0) || by_rays != glm::vec3(0);
        const bool plane = between && !lobe && s.normal == s.geometric_normal;
        if (between && !plane) {
            see_between(*between);
            seen = between_mask_, partial = between_partial_;
        } else if (!between) {
            const std::uint32_t place = places_.place_of(apart_at_[k]);
            if (place < places_.own())
                seen = seen_.of(place), partial = seen_.partial_of(place);
            else
                shared = shared_[place - places_.own()], seen = shared->seen(),
                horizon = places_.places()[place].normal;
        }
        const bool seen_smoothly = !plane && s.smooth_normal != horizon;
        if (seen_smoothly) {
            // Others may share the place.
            smooth_seen_.assign(seen.begin(), seen.end());
            light.mirrored().add(horizon, s.smooth_normal, smooth_seen_);
            seen = smooth_seen_;
        }
        glm::vec3 radiance(0), by_lobe(0);
        if (s.diffuse != glm::vec3(0)) {
            const FromCells from_cells = plane ? interpolated(lattice_light_, *between)
                                         : shared && s.normal == horizon && !seen_smoothly
                                             ? shared->from_cells()
                                             : light.light().from_cells(s.normal, seen, partial);
            const glm::vec3& irradiance = from_cells.irradiance;
            if (!passing_.any()) hidden_[asked_[k]] = std::clamp(from_cells.hidden, 0.0f, 1.0f);
            if (highlight < 1)
                radiance += (1 - highlight) * shading::reflect_irradiance(s, point.next, glm::vec3(0), irradiance);
            // What the lobe does not reflect reaches the diffuse layer.
            if (highlight > 0)
                radiance +=
                    highlight * (glm::vec3(1) - albedo) * shading::reflect_irradiance(s, {}, glm::vec3(0), irradiance);
        }
        float reflected = 0;
        if (lobe) {
            const environment_light::SeenByLobe of_image = light.light().seen_by({.to_viewer = s.to_viewer,
                                                                                  .mirrored = point.next.reflected,
                                                                                  .normal = s.normal,
                                                                                  .horizon = s.smooth_normal,
                                                                                  .roughness = s.roughness,
                                                                                  .f0 = luminance(s.specular),
                                                                                  .f90 = s.f90,
                                                                                  .round = technique_.rough()},
                                                                                 seen, partial);
            by_lobe = weight * of_image.light;
            radiance += by_lobe;
            reflected = luminance(by_rays * of_image.light);
            by_lobes_[asked_[k]] = {highlight * of_image.share, highlight * of_image.open};
        }
        if (passing_.any() && radiance != glm::vec3(0)) {
            const glm::vec3 passes = between  ? interpolated(lattice_passes_, *between)
                                     : shared ? passing_.from_cells(s.normal, batch.shadow_points[asked_[k]].origin,
                                                                    light.visibility().cells(), seen, shared_rays)
                                              : own_passes_[places_.place_of(apart_at_[k])];
            radiance *= passes, by_lobe *= passes;
        }
        reflected_[asked_[k]] = luminance(radiance) + reflected;
        add(point, radiance, by_lobe);
    }
}

void EnvironmentLighting::light_by_suns(
    const PointBatch& batch, std::size_t tile, const scene::SceneState& state,
    const std::function<void(const TilePoint&, const glm::vec3&, scene::LightId, float)>& add)
{
    using environment_light::EnvironmentLight;
    const EnvironmentLight& light = technique_.light();
    const float reach = static_cast<float>(0.5 * light.options().sun_diameter);
    for (std::size_t i = 0; i < light.suns().size(); ++i) {
        interruption_point();
        const environment_light::Sun& sun = *light.suns()[i];
        const scene::Light& source = state.scene().lights[sun.light];
        const glm::vec3 to_light = -state.light(sun.light).direction;
        asked_.clear(), between_.clear(), between_points_.clear();
        for (std::uint32_t p = 0; p < batch.points.size(); ++p) {
            const shading::SurfacePoint& s = batch.points[p].surface;
            if (s.model == scene::ShadingModel::unlit) continue;
            // Up to the disc's rim.
            if (glm::dot(s.normal, to_light) <= -reach || glm::dot(s.smooth_normal, to_light) <= -reach) continue;
            if (s.smooth_normal == s.geometric_normal || glm::dot(s.geometric_normal, to_light) >= reach) {
                asked_.push_back(p);
                continue;
            }
            // What is proven of triangles does not hold for a point above them.
            const visibility::ShadowPoint& at = batch.shadow_points[p];
            between_.push_back(p);
            between_points_.push_back(
                {.origin = shading::smooth_origin(rays_.geometry(at.object), at.triangle, at.u, at.v, s),
                 .normal = s.smooth_normal});
        }
        const auto add_seen = [&](std::uint32_t p, const glm::vec3& origin, std::span<const std::uint64_t> seen) {
            const TilePoint& point = batch.points[p];
            float share = EnvironmentLight::visible_share(sun, point.surface.normal, seen);
            if (share == 0) return;
            glm::vec3 radiance = reflect_sun(sun, point.surface, to_light, source.color, seen, share);
            if (passing_.any()) {
                const glm::vec3 passes = passing_.from_cells(point.surface.normal, origin, sun.cells, seen);
                radiance *= passes, share *= luminance(passes);
            }
            add(point, radiance, sun.light, share);
        };
        if (!between_.empty()) {
            between_asked_.resize(between_.size());
            std::iota(between_asked_.begin(), between_asked_.end(), 0u);
            sun.visibility->find(scratch_, between_points_, between_asked_, {}, nullptr, between_seen_);
            for (std::size_t k = 0; k < between_.size(); ++k)
                add_seen(between_[k], between_points_[k].origin, between_seen_.of(k));
        }
        if (asked_.empty()) continue;
        if (technique_.every_ray())
            guides_.clear();
        else
            find_guides(batch, asked_, asked_.size());
        sun.visibility->find(scratch_, batch.shadow_points, asked_, guides_,
                             technique_.every_ray() ? nullptr : technique_.memory(tile, static_cast<int>(i)), seen_);
        for (std::size_t k = 0; k < asked_.size(); ++k)
            add_seen(asked_[k], batch.shadow_points[asked_[k]].origin, seen_.of(k));
    }
}

// @param share  of the sun's light, that is visible
glm::vec3 EnvironmentLighting::reflect_sun(const environment_light::Sun& sun, const shading::SurfacePoint& surface,
                                           const glm::vec3& to_light, const glm::vec3& color,
                                           std::span<const std::uint64_t> seen, float share) const
{
    if (technique_.every_ray()) {
        const glm::vec3 part = color / static_cast<float>(sun.cells.leaves());
        glm::vec3 radiance(0);
        for (std::size_t leaf = 0; leaf < sun.cells.leaves(); ++leaf)
            if (seen[leaf / 64] >> (leaf % 64) & 1)
                radiance += shading::reflect_light(surface, sun.cells.direction(leaf), part);
        return radiance;
    }
    // The disc in a mirror is as bright as the top of a lobe that is half as wide as the disc.
    shading::SurfacePoint s = surface;
    const auto reach = static_cast<float>(0.5 * technique_.light().options().sun_diameter);
    const float alpha = s.roughness * s.roughness;
    s.roughness = std::sqrt(std::sqrt(alpha * alpha + 0.25f * reach * reach));
    return share * shading::reflect_light(s, to_light, color);
}

}   // namespace gnomon::trace
