// SPDX-License-Identifier: Apache-2.0
// Soft light of a tile's first samples, computed at some pixels and interpolated between these.
//
// Every pixel traces its camera ray and finds its surface, its emission, and the light of points and suns, whose
// shadows have edges. What is left changes little from pixel to pixel in most places: the light of an environment
// image, of emissive surfaces and of bounces, and what rough surfaces mirror. It is computed at a lattice of pixels
// that are four apart. Then the pixels of a lattice half as wide take the mean of those next to them, as their own
// reflectance would show it, where all around them show the same surface and nearly as much light; elsewhere their
// light is computed, too. The other pixels follow in the same way. Mirrored light is decided apart.
//
// Without an image or emissive surfaces, every pixel gathers its bounced light.
//
// What a pixel takes depends on pixels of its tile alone.
#include <algorithm>
#include <array>

#include "base/interruption.h"
#include "trace/tile_tracer.h"

namespace gnomon::trace {

namespace {

constexpr int k_spacing = 4;   // of the pixels whose light is always computed; a power of two
// Difference of the light around a pixel, of all that is seen there, times the distance of these pixels.
constexpr float k_alike = 1 / 8.0f;
constexpr float k_same_normal = 0.9995f;    // cosine between a pixel's normal and the mean of those around it
constexpr float k_same_roughness = 0.02f;   // difference of a pixel's roughness from their mean
constexpr float k_same_cover = 0.02f;       // likewise, of how much of it covers what lies behind, and is coated

// Whether a row, or column, is one of those that are `step` apart; the last one is, too.
bool is_on(int y, int step, int end)
{
    return y % step == 0 || y == end - 1;
}

// The rows, or columns, of a lattice around one, with weights.
struct Rows {
    std::array<int, 3> at{};
    std::array<float, 3> weight{};
    int near = 0, all = 0;   // the first few are those next to it
};

Rows rows_around(int y, int step, int end)
{
    Rows rows;
    const auto add = [&](int at, float weight) {
        rows.at[static_cast<std::size_t>(rows.all)] = at;
        rows.weight[static_cast<std::size_t>(rows.all++)] = weight;
    };
    if (is_on(y, step, end)) {
        add(y, 1);
        rows.near = 1;
        if (y > 0) add((y - 1) / step * step, 0);
        if (y < end - 1) add(std::min(y + step, end - 1), 0);
        return rows;
    }
    const int before = y / step * step, after = std::min(before + step, end - 1);
    const float part = static_cast<float>(y - before) / static_cast<float>(after - before);
    add(before, 1 - part), add(after, part);
    rows.near = 2;
    return rows;
}

}   // namespace

// Pixels around one, whose light it may take.
struct TileTracer::Around {
    int step = 0;   // between them
    std::array<std::uint32_t, 9> pixel{};
    std::array<float, 9> weight{};      // sum to 1
    std::size_t near = 0, all = 0;      // the first few are those next to it; the others have no weight
    std::array<glm::vec3, 9> light{};   // of theirs, as the pixel would show it
    std::array<glm::vec3, 9> alike{};   // what must be alike
    std::array<float, 9> bright{};      // all that is seen there, of its largest channel
};

bool TileTracer::interpolates(int sample) const
{
    // Cached bounced light alone costs less than it takes to interpolate.
    const bool costly = sees_image_ || sized_.has_value();
    return costly && options_.interpolates && options_.adaptive && sample == 0 && centres_ && !shades_further() &&
           !is_estimate_ && !options_.random_lobes && !options_.backdrop_apart && !log_;
}

void TileTracer::shade_lattice(int sample, Stopwatch& watch)
{
    // Keep the light that every pixel has computed.
    std::swap(color_, sharp_);
    color_.assign(sharp_.size(), glm::vec3(0));
    highlights_.assign(sharp_.size(), glm::vec3(0));
    if (options_.layers) {
        std::swap(direct_, sharp_direct_), std::swap(indirect_color_, sharp_indirect_);
        for (auto* layer : {&direct_, &indirect_color_}) layer->assign(color_.size(), glm::vec3(0));
    }
    note_points();

    // Compute the light of the lattice, and interpolate that of others or compute it.
    std::size_t shaded = 0;
    for (int step = k_spacing; step > 0; step /= 2) {
        chosen_.assign(points_.size() - shaded, 0);
        std::size_t further = 0;
        for (std::size_t p = shaded; p < points_.size(); ++p) {
            if (lattice_[points_[p].pixel].step != step) continue;
            if (step < k_spacing && take_light_around(points_[p], 2 * step)) continue;
            chosen_[p - shaded] = 1;
            ++further;
        }
        if (further == 0) continue;
        move_chosen(shaded);
        add_soft_light(true, sample, shaded, shaded + further, watch);
        for (std::size_t p = shaded; p < shaded + further; ++p) {
            LatticePixel& pixel = lattice_[points_[p].pixel];
            pixel.image_by_lobe = points_[p].image_by_lobe, pixel.hidden = points_[p].hidden;
            pixel.open = points_[p].open;
        }
        shaded += further;
    }
    watch.end(FrameTimes::indirect);
    highlights_.clear();

    // Add it up, and do the same for what is mirrored.
    for (std::size_t i = 0; i < color_.size(); ++i) sharp_[i] += color_[i], color_[i] = glm::vec3(0);
    if (options_.layers) {
        for (std::size_t i = 0; i < color_.size(); ++i)
            direct_[i] += sharp_direct_[i], indirect_color_[i] += sharp_indirect_[i];
    }
    keep_lobes(sample);
    follow_lattice(sample, watch);
    for (std::size_t i = 0; i < color_.size(); ++i) color_[i] += sharp_[i];
    trace_lobes(sample, watch);
}

// Notes, by pixel, what interpolation compares.
void TileTracer::note_points()
{
    lattice_.assign(color_.size(), {});
    const auto side = static_cast<std::uint32_t>(tile_.side);
    for (const TilePoint& point : points_) {
        LatticePixel& pixel = lattice_[point.pixel];
        const shading::SurfacePoint& s = point.surface;
        pixel.diffuse = s.diffuse, pixel.specular = s.specular, pixel.normal = s.normal, pixel.roughness = s.roughness,
        pixel.coverage = s.coverage;
        if (s.layered) {
            pixel.coat = s.layers.coat, pixel.coat_roughness = s.layers.coat_roughness;
            pixel.coat_normal = s.layers.coat_normal;
        }
        const int x = static_cast<int>(point.pixel % side), y = static_cast<int>(point.pixel / side);
        pixel.step = k_spacing;
        while (!is_on(x, pixel.step, tile_.width) || !is_on(y, pixel.step, tile_.height)) pixel.step /= 2;
    }
}

// Moves the chosen ones of the points from `first` on before the others, and keeps the order of both.
void TileTracer::move_chosen(std::size_t first)
{
    const auto move = [&](auto& list, auto& rest) {
        rest.clear();
        std::size_t to = first;
        for (std::size_t p = first; p < list.size(); ++p)
            if (chosen_[p - first] != 0)
                list[to++] = list[p];
            else
                rest.push_back(list[p]);
        std::ranges::copy(rest, list.begin() + static_cast<std::ptrdiff_t>(to));
    };
    move(points_, followed_);
    std::vector<shadow_culling::ShadowPoint> shadow_points;
    std::vector<glm::vec3> normals;
    move(shadow_points_, shadow_points), move(normals_, normals);
}

// Finds the pixels of a lattice around a point that show its surface.
// @return  false: too few next to it do
bool TileTracer::find_around(const TilePoint& point, int step, Around& around) const
{
    const auto side = static_cast<std::uint32_t>(tile_.side);
    const int x = static_cast<int>(point.pixel % side), y = static_cast<int>(point.pixel / side);
    const Rows columns = rows_around(x, step, tile_.width), rows = rows_around(y, step, tile_.height);
    const glm::ivec2 image = tile_.pixel_of_image(point.pixel);
    const shading::CentreSample& own = centres_->at(image.x, image.y);
    const auto shows_it = [&](std::uint32_t pixel) {
        if (lattice_[pixel].step == 0) return false;
        const glm::ivec2 there = tile_.pixel_of_image(pixel);
        return shading::same_surface(own, centres_->at(there.x, there.y), options_.refine);
    };
    around = {.step = step};
    float sum = 0;
    for (const bool near : {true, false}) {
        for (std::size_t j = 0; j < static_cast<std::size_t>(rows.all); ++j)
            for (std::size_t i = 0; i < static_cast<std::size_t>(columns.all); ++i) {
                const bool is_near = static_cast<int>(i) < columns.near && static_cast<int>(j) < rows.near;
                if (is_near != near) continue;
                const std::uint32_t pixel =
                    static_cast<std::uint32_t>(rows.at[j]) * side + static_cast<std::uint32_t>(columns.at[i]);
                if (!shows_it(pixel)) continue;
                around.weight[around.all] = rows.weight[j] * columns.weight[i];
                sum += around.weight[around.all];
                around.pixel[around.all++] = pixel;
            }
        if (!near) continue;
        around.near = around.all;
        const auto wanted = static_cast<std::size_t>(columns.near * rows.near);
        if (around.near + (wanted == 4 ? 1 : 0) < wanted) return false;
    }
    for (float& weight : around.weight) weight /= sum;

    // The mean of their surfaces must be as the point's.
    glm::vec3 normal(0), coat_normal(0);
    float roughness = 0, coverage = 0, coat_roughness = 0, coat = 0;
    for (std::size_t i = 0; i < around.near; ++i) {
        const LatticePixel& pixel = lattice_[around.pixel[i]];
        normal += around.weight[i] * pixel.normal, roughness += around.weight[i] * pixel.roughness;
        coverage += around.weight[i] * pixel.coverage, coat += around.weight[i] * pixel.coat;
        coat_normal += around.weight[i] * pixel.coat_normal;
        coat_roughness += around.weight[i] * pixel.coat_roughness;
    }
    const shading::SurfacePoint& s = point.surface;
    const auto alike = [](const glm::vec3& mean, const glm::vec3& n) {
        return glm::dot(mean, n) >= k_same_normal * glm::length(mean);
    };
    if (!alike(normal, s.normal) || std::abs(roughness - s.roughness) > k_same_roughness) return false;
    if (std::abs(coverage - s.coverage) > k_same_cover) return false;
    if (!s.layered) return true;
    return alike(coat_normal, s.layers.coat_normal) && std::abs(coat - s.layers.coat) <= k_same_cover &&
           std::abs(coat_roughness - s.layers.coat_roughness) <= k_same_roughness;
}

// Whether the light of the pixels around one is nearly the same, as the one would show it.
bool TileTracer::is_alike(const Around& around) const
{
    glm::vec3 low(k_infinity), high(0);
    float bright = 0;
    for (std::size_t i = 0; i < around.all; ++i) {
        low = glm::min(low, around.alike[i]), high = glm::max(high, around.alike[i]);
        bright += around.weight[i] * around.bright[i];
    }
    return largest(high - low) * static_cast<float>(around.step) <= k_alike * bright;
}

// Gives a point the mean of the soft light of the pixels around it, if that is alike.
bool TileTracer::take_light_around(TilePoint& point, int step)
{
    Around around;
    if (!find_around(point, step, around)) return false;
    std::array<glm::vec3, 9> diffuse, specular;
    for (std::size_t i = 0; i < around.all; ++i) {
        const std::uint32_t from = around.pixel[i];
        diffuse[i] = shading::relit(glm::vec3(1), lattice_[from].diffuse, point.surface.diffuse);
        specular[i] = shading::relit(glm::vec3(1), lattice_[from].specular, point.surface.specular);
        around.light[i] = diffuse[i] * (color_[from] - highlights_[from]) + specular[i] * highlights_[from];
        // Rays of the lobe will show the image as the interpolated mean has it.
        around.alike[i] = around.light[i] + point.next.lobe_weight * lattice_[from].open;
        around.bright[i] = largest(around.alike[i] + diffuse[i] * sharp_[from]);
    }
    if (!is_alike(around)) return false;
    LatticePixel& pixel = lattice_[point.pixel];
    pixel.hidden = 0;
    for (std::size_t i = 0; i < around.near; ++i) {
        const std::uint32_t from = around.pixel[i];
        const LatticePixel& other = lattice_[from];
        const float weight = around.weight[i];
        color_[point.pixel] += weight * around.light[i];
        highlights_[point.pixel] += weight * specular[i] * highlights_[from];
        pixel.image_by_lobe += weight * other.image_by_lobe, pixel.hidden += weight * other.hidden;
        pixel.open += weight * other.open;
        const glm::ivec2 to = tile_.pixel_of_image(point.pixel), there = tile_.pixel_of_image(from);
        centres_->at(to.x, to.y).bounced += weight * diffuse[i] * centres_->at(there.x, there.y).bounced;
        if (!options_.layers) continue;
        // Highlights are direct light.
        direct_[point.pixel] +=
            weight * (diffuse[i] * (direct_[from] - highlights_[from]) + specular[i] * highlights_[from]);
        indirect_color_[point.pixel] += weight * diffuse[i] * indirect_color_[from];
    }
    point.image_by_lobe = pixel.image_by_lobe, point.hidden = pixel.hidden, point.open = pixel.open;
    return true;
}

// Gives a point the mean of what the pixels around it mirror, if that is alike.
bool TileTracer::take_mirrored_around(const TilePoint& point, int step)
{
    Around around;
    if (!find_around(point, step, around)) return false;
    for (std::size_t i = 0; i < around.all; ++i) {
        const std::uint32_t from = around.pixel[i];
        around.light[i] = shading::relit(color_[from], lattice_[from].specular, point.surface.specular);
        around.alike[i] = around.light[i];
        around.bright[i] = largest(sharp_[from] + color_[from]);
    }
    if (!is_alike(around)) return false;
    for (std::size_t i = 0; i < around.near; ++i) color_[point.pixel] += around.weight[i] * around.light[i];
    return true;
}

// Follows what surfaces mirror and let through: that of mirrors and glass at all pixels, that of others at the lattice,
// and where it is not alike.
void TileTracer::follow_lattice(int sample, Stopwatch& watch)
{
    followed_.clear();
    std::swap(points_, followed_);
    for (int step = k_spacing; step > 0; step /= 2) {
        clear_points();
        for (const TilePoint& point : followed_) {
            const shading::Continuation& next = point.next;
            const bool passes = next.refracted_weight != glm::vec3(0) || next.straight_weight != glm::vec3(0);
            const bool sharp = passes || largest(next.reflected_weight) > k_least_mirrored;
            if (sharp ? step < k_spacing : lattice_[point.pixel].step != step) continue;
            if (step < k_spacing && take_mirrored_around(point, 2 * step)) continue;
            points_.push_back(point);
        }
        if (points_.empty()) continue;
        queue_continuations(true);
        follow_paths(sample, watch);
    }
    clear_points();
}

}   // namespace gnomon::trace
