// SPDX-License-Identifier: Apache-2.0
#include "raster/edge_samples.h"

#include <algorithm>
#include <cmath>

#include "base/interruption.h"
#include "image/tone_map.h"

namespace gnomon::raster {

namespace {

constexpr int k_tile = 32;     // pixels a side, of the sums
constexpr float k_white = 1;   // luminance of exposed light from which on it counts less: the display's white
constexpr float k_least_square = 1e-4f;                            // of a distance in pixels
constexpr float k_share = 1.0f / (1 + scene::k_refined_samples);   // of a pixel, that one of its samples makes

float exposure_of(const shading::FrameBuffers& out, const AdaptiveOptions& options)
{
    return std::exp2(options.exposure ? *options.exposure : static_cast<float>(image::auto_exposure(out.color.data)));
}

int channels_of(const shading::FrameBuffers& out, bool layers, bool alpha)
{
    int channels = 3 + (alpha ? 1 : 0);
    if (layers)
        for (const ImageF* layer : {&out.direct, &out.indirect, &out.albedo, &out.shadow}) channels += layer->channels;
    return channels;
}

}   // namespace

EdgeSamples::EdgeSamples(const scene::Scene& scene, const scene::View& view, const shading::FrameBuffers& out,
                         bool layers, bool has_glass, bool alpha, const AdaptiveOptions& options)
    : scene_(scene),
      view_(view),
      single_(out),
      has_glass_(has_glass),
      options_(options),
      centres_(view.size),
      sums_(view.size, k_tile, channels_of(out, layers, alpha), k_white / exposure_of(out, options))
{
    options_.refine.exposure = exposure_of(out, options);
    int channels = 0;
    const auto add = [&](const ImageF& layer, int& first) {
        if (layer.data.empty()) return;
        first = channels;
        channels += layer.channels;
        layers_.push_back(&layer);
    };
    int color = 0, shadow = 0;
    add(out.color, color);
    if (alpha) add(out.alpha, alpha_);
    if (layers)
        add(out.direct, direct_), add(out.indirect, indirect_), add(out.albedo, albedo_), add(out.shadow, shadow);
}

// What a sample shows, as samples of the traced frame describe it.
shading::CentreSample EdgeSamples::surface_at(const DrawnSurfaces& drawn, std::size_t pixel) const
{
    shading::CentreSample sample;
    const std::uint32_t object = drawn.ids[2 * pixel];
    if (object == 0) return sample;
    const auto vector = [&](std::span<const float> from) {
        return glm::vec3(from[4 * pixel], from[4 * pixel + 1], from[4 * pixel + 2]);
    };
    sample.position = vector(drawn.position), sample.normal = vector(drawn.normal);
    sample.object = object - 1;
    sample.triangle = drawn.ids[2 * pixel + 1];
    sample.material = scene_.meshes[scene_.objects[sample.object].mesh].part_of(sample.triangle).material;
    sample.width = view_.pixel_width + view_.pixel_spread * glm::length(sample.position - view_.eye);
    // The light behind glass follows the reflectance in part only.
    if (has_glass_) return sample;
    const scene::Material& material = scene_.materials[sample.material];
    sample.reflectance = vector(drawn.diffuse);
    if (material.model == scene::ShadingModel::whitted && sample.reflectance != glm::vec3(0))
        sample.mirror = vector(drawn.specular);
    else
        sample.reflectance += vector(drawn.specular);
    sample.textured = material.base_color_texture.used();
    return sample;
}

void EdgeSamples::set_centres(const DrawnSurfaces& drawn)
{
    const Size size = centres_.size();
    std::size_t pixel = 0;
    for (int y = 0; y < size.height; ++y)
        for (int x = 0; x < size.width; ++x) centres_.at(x, y) = surface_at(drawn, pixel++);

    // Select pixels, and add the samples at the centres.
    const image::SampleWeights centre = image::sample_weights(options_.filter, glm::vec2(0.5f));
    const image::SampleWeights lone = image::lone_sample_weights(options_.filter);
    selected_.assign(pixel, 0);
    std::vector<float> values(static_cast<std::size_t>(sums_.channels()));
    pixel = 0;
    constexpr int k_rows = 16;   // at a time
    std::vector<std::uint8_t> found(k_rows * static_cast<std::size_t>(size.width));
    for (int y = 0; y < size.height; ++y) {
        interruption_point();
        if (y % k_rows == 0)
            centres_.find_more(y, std::min(y + k_rows, size.height), single_.color, options_.refine, found);
        for (int x = 0; x < size.width; ++x, ++pixel) {
            const auto in_rows = static_cast<std::size_t>(y % k_rows) * static_cast<std::size_t>(size.width);
            const bool more = found[in_rows + static_cast<std::size_t>(x)] ||
                              centres_.varies(x, y, single_.color, options_.refine) ||
                              (alpha_ >= 0 && centres_.covered_in_part(x, y));
            selected_[pixel] = more ? 1 : 0;
            refined_ += more ? 1 : 0;
            values_at(x, y, values.data());
            add_values(x, y, more ? centre : lone, more ? k_share : 1, values.data());
        }
    }
}

void EdgeSamples::add(int number, const DrawnSurfaces& drawn)
{
    interruption_point();
    const Size size = centres_.size();
    const glm::vec2 offset = scene::refined_offset(number);
    const image::SampleWeights weights = image::sample_weights(options_.filter, offset);
    std::vector<float> values(static_cast<std::size_t>(sums_.channels()));
    std::size_t pixel = 0;
    for (int y = 0; y < size.height; ++y)
        for (int x = 0; x < size.width; ++x, ++pixel) {
            if (!selected_[pixel]) continue;
            const shading::CentreSample sample = surface_at(drawn, pixel);
            const bool background = sample.width == 0 && !has_glass_;
            if (background) {
                std::fill(values.begin(), values.end(), 0.0f);
                std::copy_n(&drawn.own[4 * pixel], 3, values.begin());
                if (alpha_ >= 0)
                    values[static_cast<std::size_t>(alpha_)] = 1 - std::clamp(drawn.own[4 * pixel + 3], 0.0f, 1.0f);
            } else if (!take_light(x, y, offset, sample, values.data())) {
                values_at(x, y, values.data());   // nothing shows it: the pixel's own sample stands in for it
            }
            add_values(x, y, weights, k_share, values.data());
        }
}

// The layers of one sample a pixel.
void EdgeSamples::values_at(int x, int y, float* values) const
{
    for (const ImageF* layer : layers_) {
        std::copy_n(layer->pixel(x, y), layer->channels, values);
        values += layer->channels;
    }
}

// Takes the light of the pixels around a sample that show its surface, weighed by the inverse fourth power of their
// distance.
// @return  false: there are none
bool EdgeSamples::take_light(int x, int y, const glm::vec2& offset, const shading::CentreSample& own,
                             float* values) const
{
    const auto channels = static_cast<std::size_t>(sums_.channels());
    std::fill_n(values, channels, 0.0f);
    float sum = 0;
    std::vector<float> there(channels);
    for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx) {
            if (!centres_.inside(x + dx, y + dy)) continue;
            const shading::CentreSample& other = centres_.at(x + dx, y + dy);
            if (!shading::same_surface(own, other, options_.refine)) continue;
            const glm::vec2 apart = offset - 0.5f - glm::vec2(dx, dy);
            const float square = glm::dot(apart, apart) + k_least_square;
            const float weight = 1 / (square * square);
            sum += weight;
            values_at(x + dx, y + dy, there.data());
            const glm::vec3 by = shading::relit(glm::vec3(1), other.reflectance, own.reflectance);
            for (const int first : {0, direct_, indirect_})
                for (int c = 0; c < 3 && first >= 0; ++c)
                    there[static_cast<std::size_t>(first) + static_cast<std::size_t>(c)] *= by[c];
            for (std::size_t c = 0; c < channels; ++c) values[c] += weight * there[c];
        }
    if (!(sum > 0)) return false;
    for (std::size_t c = 0; c < channels; ++c) values[c] /= sum;
    const glm::vec3 albedo = own.reflectance + own.mirror;
    if (albedo_ >= 0 && !has_glass_)
        for (int c = 0; c < 3; ++c) values[albedo_ + c] = albedo[c];
    return true;
}

void EdgeSamples::add_values(int x, int y, const image::SampleWeights& weights, float share, const float* values)
{
    const int columns = (centres_.size().width + k_tile - 1) / k_tile;
    sums_.add(
        static_cast<std::size_t>(y / k_tile) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(x / k_tile),
        x % k_tile, y % k_tile, weights, share, values);
}

void EdgeSamples::resolve(shading::FrameBuffers& out) const
{
    const Size size = centres_.size();
    const int columns = (size.width + k_tile - 1) / k_tile, rows = (size.height + k_tile - 1) / k_tile;
    std::vector<ImageF*> to;
    for (ImageF* layer : {&out.color, &out.alpha, &out.direct, &out.indirect, &out.albedo, &out.shadow})
        if (std::find(layers_.begin(), layers_.end(), layer) != layers_.end()) to.push_back(layer);
    for (std::size_t tile = 0; tile < static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows); ++tile)
        sums_.resolve(tile, [&](int x, int y, const float* values) {
            for (ImageF* layer : to) {
                std::copy_n(values, layer->channels, layer->pixel(x, y));
                values += layer->channels;
            }
        });
}

}   // namespace gnomon::raster
