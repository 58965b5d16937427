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
    lobe_light_.clear();
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
    for (std::size_t i = 0; i < samples.size() && !lobe_light_.empty(); ++i) color_[i] += lobe_light_[i];
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
