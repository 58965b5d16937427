// SPDX-License-Identifier: Apache-2.0
// The samples of time and lens of a tile's pixels (blur.h).
#include "base/interruption.h"
#include "base/morton.h"
#include "trace/tile_tracer.h"

namespace gnomon::trace {

void TileTracer::blur(const Tile& tile, Blur& blur, int time)
{
    // List the samples of this time, pixel by pixel in Morton order.
    std::vector<FurtherSample> wanted;
    const auto count = static_cast<std::uint32_t>(tile.side * tile.side);
    for (std::uint32_t code = 0; code < count; ++code) {
        const int x = static_cast<int>(even_bits(code)), y = static_cast<int>(even_bits(code >> 1));
        if (x >= tile.width || y >= tile.height || !blur.active(tile.x + x, tile.y + y)) continue;
        const glm::ivec2 at(tile.x + x, tile.y + y);
        for (std::uint32_t number = blur.first_sample(); number < blur.end_sample(at.x, at.y); ++number)
            if (blur.time(at, number) == time)
                wanted.push_back({static_cast<std::uint32_t>(y * tile.side + x), number, 0});
    }
    if (wanted.empty()) return;

    begin_tile(tile);
    blur_ = &blur;
    std::vector<float> values(static_cast<std::size_t>(blur.channels()));
    for (std::size_t begin = 0; begin < wanted.size(); begin += count) {
        const auto some =
            std::span<const FurtherSample>(wanted).subspan(begin, std::min<std::size_t>(count, wanted.size() - begin));
        shade_blurred(some, blur);
        for (std::size_t i = 0; i < some.size(); ++i) {
            values_of(i, values.data());
            const glm::ivec2 at = tile_.pixel_of_image(some[i].pixel);
            blur.add(at.x, at.y, values.data());
            if (!blurred_lobes_.empty()) blur.add_lobe(at.x, at.y, blurred_lobes_[i]);
        }
    }
    blur_ = nullptr;
}

// Computes the light of samples: in color_ and the other sums, by their numbers in the list.
void TileTracer::shade_blurred(std::span<const FurtherSample> samples, const Blur& blur)
{
    interruption_point();
    Stopwatch watch(times_);
    samples_ = samples;
    clear_sums(samples.size());
    lobe_light_.clear(), blurred_lobes_.clear();
    pixels_.resize(samples.size());
    primary_.clear();
    const scene::Lens& lens = blur.options().lens;
    for (std::uint32_t i = 0; i < samples.size(); ++i) {
        pixels_[i] = samples[i].pixel;
        const glm::ivec2 at = tile_.pixel_of_image(samples[i].pixel);
        const BlurSample sample = blur.sample(at, samples[i].number);
        const glm::vec2 place = glm::vec2(at) + sample.offset;
        if (lens.sharp()) {
            queue_camera_ray(i, place);
            continue;
        }
        glm::vec3 origin, direction;
        float tnear, tfar;
        scene::lens_ray(view_, lens, place.x, place.y, sample.lens, origin, direction, tnear, tfar);
        Path path{i, glm::vec3(1), {view_.pixel_width, view_.pixel_spread}};
        path.straight = true;
        primary_.push(path, origin, tnear, direction, tfar);
    }
    counters_.samples.taken += samples.size();
    counters_.samples.shaded += samples.size();
    counters_.primary_rays += samples.size();
    shade_sample(1, watch);
    for (std::size_t i = 0; i < samples.size() && !lobe_light_.empty(); ++i) {
        color_[i] += lobe_light_[i];
        if (!blurred_lobes_.empty()) blurred_lobes_[i].light = lobe_light_[i];
    }
}

// Notes what the rays of a sample's lobe say about how much lobes reflect.
// @param counts  as how many rays each of them counts
void TileTracer::note_blurred_lobe(const TilePoint& point, float counts)
{
    if (blurred_lobes_.empty()) blurred_lobes_.resize(color_.size());
    const glm::vec3 weight = point.throughput * point.next.lobe_weight;
    blurred_lobes_[point.pixel] = {glm::vec3(0), weight.x + weight.y + weight.z, counts};
}

// Gives a sample the light that the image through the lens's centre shows of its place, if the pixels around there show
// its surface and agree.
bool TileTracer::take_still_light(const TilePoint& point, scene::ObjectId object, std::uint32_t triangle)
{
    const std::span<const ImageF* const> layers = blur_->still_layers();
    const shading::SurfacePoint& s = point.surface;
    if (layers.empty() || !centres_ || !blur_->shares() || view_.orthographic || point.behind) return false;
    const std::optional<glm::dvec2> place = view_.project(glm::dvec3(s.position));
    if (!place) return false;
    const glm::ivec2 at(glm::floor(*place));
    if (!centres_->inside(at.x - 1, at.y - 1) || !centres_->inside(at.x + 1, at.y + 1)) return false;
    // What depends on the view must change slowly with it.
    const bool same_from_everywhere = s.specular == glm::vec3(0) && !centres_->at(at.x, at.y).mirrors;
    if (!same_from_everywhere && (s.layered || s.transmitted != glm::vec3(0) ||
                                  s.model == scene::ShadingModel::whitted || !lens_turns_little(s)))
        return false;

    shading::RefineOptions options = options_.refine;
    options.exposure = blur_->exposure();
    shading::CentreSample own = centre_sample(s, object, triangle);
    const ImageF& color = *layers.front();
    glm::vec3 low(k_infinity), high(0);
    for (int i = 0; i < 9; ++i) {
        const glm::ivec2 there = at + glm::ivec2(i % 3 - 1, i / 3 - 1);
        const shading::CentreSample& other = centres_->at(there.x, there.y);
        if (!shading::same_surface(own, other, options)) return false;
        const float* const from = color.pixel(there.x, there.y);
        const glm::vec3 seen = shading::shown(
            shading::relit(glm::vec3(from[0], from[1], from[2]), other, own.reflectance), options.exposure);
        low = glm::min(low, seen), high = glm::max(high, seen);
    }
    if (shading::difference(high, low) > options.agree) return false;

    // Interpolate between the four pixels around.
    --counters_.samples.shaded;
    const glm::dvec2 from = glm::floor(*place - 0.5);
    const glm::vec2 part(*place - 0.5 - from);
    for (int k = 0; k < 4; ++k) {
        const glm::ivec2 there = glm::ivec2(from) + glm::ivec2(k & 1, k >> 1);
        const float near = ((k & 1) != 0 ? part.x : 1 - part.x) * (k >> 1 != 0 ? part.y : 1 - part.y);
        if (near == 0) continue;
        single_values(layers, there);
        add_share(point.pixel, own, centres_->at(there.x, there.y), near, single_values_.data());
    }
    return true;
}

// Whether the view turns by less than a surface's lobe is wide, between a place of the lens and its centre. The samples
// of a pixel turn it to all sides.
bool TileTracer::lens_turns_little(const shading::SurfacePoint& s) const
{
    constexpr float k_turn = 0.5f;   // in widths of the lobe
    const glm::vec3 turn = glm::normalize(view_.eye - s.position) - s.to_viewer;
    return glm::length(turn) <= k_turn * shading::lobe_width(s.roughness);
}

// Gives the lobe of a sample what the image through the lens's centre shows of it, where that shows its surface.
bool TileTracer::take_still_lobe(const TilePoint& point, const shadow_culling::ShadowPoint& at)
{
    const LobeImage* const lobes = blur_->lobes();
    if (!lobes || !centres_ || !blur_->shares() || view_.orthographic) return false;
    const shading::SurfacePoint& s = point.surface;
    if (!lens_turns_little(s)) return false;
    const std::optional<glm::dvec2> place = view_.project(glm::dvec3(s.position));
    if (!place) return false;

    // Interpolate between the pixels around.
    const shading::CentreSample own = centre_sample(s, at.object, at.triangle);
    const glm::dvec2 from = glm::floor(*place - 0.5);
    const glm::vec2 part(*place - 0.5 - from);
    glm::vec3 brought(0), weight(0);
    for (int k = 0; k < 4; ++k) {
        const glm::ivec2 there = glm::ivec2(from) + glm::ivec2(k & 1, k >> 1);
        if (!centres_->inside(there.x, there.y)) continue;
        if (!shading::same_surface(own, centres_->at(there.x, there.y), options_.refine)) continue;
        const float near = ((k & 1) != 0 ? part.x : 1 - part.x) * (k >> 1 != 0 ? part.y : 1 - part.y);
        const LobePixel& pixel = lobes->at(there.x, there.y);
        brought += near * pixel.filtered, weight += near * pixel.weight;
    }
    if (weight == glm::vec3(0)) return false;
    for (int c = 0; c < 3; ++c)
        if (weight[c] > 0)
            color_[point.pixel][c] += point.throughput[c] * point.next.lobe_weight[c] * (brought[c] / weight[c]);
    return true;
}

// Gives a sample the bounced light of the shutter's middle, where pixels around it show the same surface and agree in
// it.
TileTracer::Bounced TileTracer::take_still_bounced(const TilePoint& point, scene::ObjectId object,
                                                   std::uint32_t triangle)
{
    if (!centres_ || !indirect_ || is_estimate_ || point.behind) return Bounced::unknown;
    if (!blur_->shares()) return Bounced::unknown;
    shading::RefineOptions options = options_.refine;
    options.exposure = blur_->exposure();
    const FurtherSample& sample = samples_[point.pixel];
    const glm::ivec2 at = tile_.pixel_of_image(sample.pixel);
    const glm::vec2 offset = blur_->sample(at, sample.number).offset - 0.5f;
    return take_bounced(point, offset, centre_sample(point.surface, object, triangle), *centres_, options, nullptr);
}

}   // namespace gnomon::trace
