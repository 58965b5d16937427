// SPDX-License-Identifier: Apache-2.0
// The further samples of a tile's pixels (refinement.h).
#include <algorithm>

#include "base/interruption.h"
#include "base/morton.h"
#include "trace/tile_tracer.h"

namespace gnomon::trace {

namespace {

// Weight of a neighbour's light at a sample, by their distance along an axis in pixels.
float nearness(float distance)
{
    return std::max(0.0f, image::k_filter_radius - std::abs(distance));
}

glm::vec3 vector_at(const ImageF& image, int x, int y)
{
    const float* const c = image.pixel(x, y);
    return {c[0], c[1], c[2]};
}

}   // namespace

shading::CentreSample TileTracer::centre_sample(const shading::SurfacePoint& s, scene::ObjectId object,
                                                std::uint32_t triangle) const
{
    shading::CentreSample sample;
    sample.position = s.position, sample.normal = s.normal;
    sample.reflectance = s.diffuse + s.specular;
    sample.width = s.cone.width;
    sample.object = object;
    sample.material = scene_.meshes[scene_.objects[object].mesh].part_of(triangle).material;
    return sample;
}

void TileTracer::refine(const Tile& tile, const Refinement& refinement)
{
    tile_ = tile;
    find_refined(refinement);

    // Take a few samples of each pixel, and the others where these differ.
    constexpr int k_first = scene::k_first_refined_samples, k_all = scene::k_refined_samples;
    const auto channels = static_cast<std::size_t>(refinement.sums.channels());
    values_.resize(refined_.size() * k_all * channels);
    std::vector<std::uint32_t> chosen(refined_.size());
    for (std::uint32_t r = 0; r < refined_.size(); ++r) chosen[r] = r;
    take_samples(refinement, chosen, 0, k_first);
    std::erase_if(chosen, [&](std::uint32_t r) {
        const glm::ivec2 at = tile_.pixel_of_image(refined_[r].pixel);
        glm::vec3 low = shading::shown(vector_at(refinement.single.color, at.x, at.y), refinement.options.exposure);
        glm::vec3 high = low;
        for (std::size_t k = 0; k < k_first; ++k) {
            const float* const v = values_.data() + (r * k_all + k) * channels;
            const glm::vec3 c = shading::shown({v[0], v[1], v[2]}, refinement.options.exposure);
            low = glm::min(low, c), high = glm::max(high, c);
        }
        return shading::difference(high, low) <= refinement.options.spread;
    });
    take_samples(refinement, chosen, k_first, k_all);

    // Add the samples of all pixels, each with its share of the pixel.
    const std::size_t number = number_of(tile_);
    std::vector<std::uint32_t> refined_of(static_cast<std::size_t>(tile_.side) * static_cast<std::size_t>(tile_.side));
    for (std::uint32_t r = 0; r < refined_.size(); ++r) refined_of[refined_[r].pixel] = r + 1;
    std::vector<float> centre(channels);
    for (int y = 0; y < tile_.height; ++y)
        for (int x = 0; x < tile_.width; ++x) {
            const auto pixel = static_cast<std::uint32_t>(y * tile_.side + x);
            const std::uint32_t r = refined_of[pixel];
            const int further = r == 0 ? 0 : refined_[r - 1].samples;
            const float share = 1.0f / static_cast<float>(1 + further);
            std::size_t c = 0;
            for (const ImageF* layer : averaged_layers(refinement.single, options_)) {
                const float* const from = layer->pixel(tile_.x + x, tile_.y + y);
                for (int k = 0; k < layer->channels; ++k) centre[c++] = from[k];
            }
            refinement.sums.add(number, x, y, refinement.weights[0], share, centre.data());
            for (int k = 0; k < further; ++k)
                refinement.sums.add(number, x, y, refinement.weights[static_cast<std::size_t>(k) + 1], share,
                                    values_.data() +
                                        ((r - 1) * std::size_t{k_all} + static_cast<std::size_t>(k)) * channels);
        }
}

// Lists the tile's pixels that need more samples, in Morton order.
void TileTracer::find_refined(const Refinement& refinement)
{
    refined_.clear();
    const auto count = static_cast<std::uint32_t>(tile_.side * tile_.side);
    for (std::uint32_t code = 0; code < count; ++code) {
        const int x = static_cast<int>(even_bits(code)), y = static_cast<int>(even_bits(code >> 1));
        if (x >= tile_.width || y >= tile_.height) continue;
        if (refinement.centres.needs_more(tile_.x + x, tile_.y + y, refinement.single.color, refinement.options))
            refined_.push_back({static_cast<std::uint32_t>(y * tile_.side + x)});
    }
    counters_.samples.pixels += refined_.size();
}

// Takes samples of some refined pixels, and keeps their values.
// @param refined  indices
// @param first, end  numbers of the samples
void TileTracer::take_samples(const Refinement& refinement, std::span<const std::uint32_t> refined, int first, int end)
{
    const auto channels = static_cast<std::size_t>(refinement.sums.channels());
    const auto samples = static_cast<std::size_t>(end - first);
    const std::size_t at_once =
        std::max<std::size_t>(static_cast<std::size_t>(tile_.side) * static_cast<std::size_t>(tile_.side) / samples, 1);
    for (std::size_t begin = 0; begin < refined.size(); begin += at_once) {
        const auto some = refined.subspan(begin, std::min(at_once, refined.size() - begin));
        wanted_.clear();
        for (const std::uint32_t r : some) {
            for (int k = first; k < end; ++k) wanted_.push_back({refined_[r].pixel, static_cast<std::uint32_t>(k)});
            refined_[r].samples = end;
        }
        shade_samples(refinement, wanted_);
        for (std::size_t i = 0; i < wanted_.size(); ++i) {
            const std::size_t to = some[i / samples] * std::size_t{scene::k_refined_samples} + wanted_[i].number;
            values_of(i, values_.data() + to * channels);
        }
    }
}

// Computes the light of further samples: in color_ and the other sums, by their numbers in the list.
void TileTracer::shade_samples(const Refinement& refinement, std::span<const FurtherSample> samples)
{
    interruption_point();
    Stopwatch watch(times_);
    refinement_ = &refinement;
    samples_ = samples;
    clear_sums(samples.size());
    lobe_light_.clear();
    pixels_.resize(samples.size());
    primary_.clear();
    for (std::uint32_t i = 0; i < samples.size(); ++i) {
        pixels_[i] = samples[i].pixel;
        const glm::ivec2 at = tile_.pixel_of_image(samples[i].pixel);
        const glm::vec2 offset = scene::refined_offset(static_cast<int>(samples[i].number));
        queue_camera_ray(i, glm::vec2(at) + offset);
    }
    counters_.samples.taken += samples.size();
    counters_.primary_rays += samples.size();
    shade_sample(1, watch);

    // Add what rays of lobes brought: it stays unfiltered.
    for (std::size_t i = 0; i < samples.size() && !lobe_light_.empty(); ++i) color_[i] += lobe_light_[i];
    refinement_ = nullptr;
}

// Gives a further sample the light of the pixels around it that show the same surface, if these agree.
// @param point  a camera ray met it
bool TileTracer::take_light(const TilePoint& point, scene::ObjectId object, std::uint32_t triangle)
{
    const shading::CentreSample own = centre_sample(point.surface, object, triangle);
    const shading::RefineOptions& options = refinement_->options;
    const shading::FrameBuffers& single = refinement_->single;
    const FurtherSample& sample = samples_[point.pixel];
    const glm::ivec2 at = tile_.pixel_of_image(sample.pixel);
    const glm::vec2 offset = scene::refined_offset(static_cast<int>(sample.number)) - 0.5f;

    // Compare their light, as this surface would reflect it.
    float weights[9];
    glm::vec3 low(k_infinity), high(0), color(0);
    float sum = 0;
    for (int i = 0; i < 9; ++i) {
        const int dx = i % 3 - 1, dy = i / 3 - 1;
        weights[i] = 0;
        if (!refinement_->centres.inside(at.x + dx, at.y + dy)) continue;
        const shading::CentreSample& other = refinement_->centres.at(at.x + dx, at.y + dy);
        if (!shading::same_surface(own, other, options)) continue;
        weights[i] = nearness(offset.x - static_cast<float>(dx)) * nearness(offset.y - static_cast<float>(dy));
        const glm::vec3 light =
            shading::relit(vector_at(single.color, at.x + dx, at.y + dy), other.reflectance, own.reflectance);
        const glm::vec3 seen = shading::shown(light, options.exposure);
        low = glm::min(low, seen), high = glm::max(high, seen);
        color += weights[i] * light;
        sum += weights[i];
    }
    if (!(sum > 0) || shading::difference(high, low) > options.agree) {
        ++counters_.samples.shaded;
        return false;
    }

    // Take the mean, near pixels first.
    color_[point.pixel] = color / sum;
    const std::size_t lights = scene_.lights.size();
    for (int i = 0; i < 9; ++i) {
        const float weight = weights[i] / sum;
        if (weight == 0) continue;
        const int x = at.x + i % 3 - 1, y = at.y + i / 3 - 1;
        if (options_.backdrop_apart) backdrop_[point.pixel] += glm::vec3(weight * (1 - single.alpha.pixel(x, y)[0]));
        if (!options_.layers) continue;
        const glm::vec3& reflectance = refinement_->centres.at(x, y).reflectance;
        const auto take = [&](const ImageF& from) {
            return weight * shading::relit(vector_at(from, x, y), reflectance, own.reflectance);
        };
        direct_[point.pixel] += take(single.direct);
        indirect_color_[point.pixel] += take(single.indirect);
        for (std::size_t l = 0; l < lights; ++l)
            shadow_[point.pixel * lights + l] += weight * single.shadow.pixel(x, y)[l];
    }
    if (options_.layers) albedo_[point.pixel] = own.reflectance;
    return true;
}

// Gives the lobe of a further sample what rays of the pixels around it brought, where these show the same surface.
bool TileTracer::take_lobe(const TilePoint& point, const shadow_culling::ShadowPoint& at)
{
    if (!refinement_->lobes) return false;
    const shading::CentreSample own = centre_sample(point.surface, at.object, at.triangle);
    const glm::ivec2 pixel = pixel_of_image(point.pixel);
    glm::vec3 brought(0), weight(0);
    for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx) {
            const int x = pixel.x + dx, y = pixel.y + dy;
            if (!refinement_->centres.inside(x, y)) continue;
            if (!shading::same_surface(own, refinement_->centres.at(x, y), refinement_->options)) continue;
            brought += refinement_->lobes->at(x, y).filtered, weight += refinement_->lobes->at(x, y).weight;
        }
    if (weight == glm::vec3(0)) return false;
    glm::vec3 light(0);
    for (int c = 0; c < 3; ++c)
        if (weight[c] > 0) light[c] = point.throughput[c] * point.next.lobe_weight[c] * brought[c] / weight[c];
    color_[point.pixel] += light;
    return true;
}

}   // namespace gnomon::trace
