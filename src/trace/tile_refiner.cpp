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

// Weight of the i-th of three values one apart, in the parabola through them.
// @param x  from the middle one
float second_order(float x, int i)
{
    return i == 0 ? x * (x - 1) / 2 : i == 1 ? 1 - x * x : x * (x + 1) / 2;
}

glm::vec3 vector_at(const ImageF& image, int x, int y)
{
    const float* const c = image.pixel(x, y);
    return {c[0], c[1], c[2]};
}

// The highlights and mirror images of a Phong surface do not follow its texture, which is that of its diffuse part.
void set_reflectance(const shading::SurfacePoint& s, shading::CentreSample& sample)
{
    const bool apart = s.model == scene::ShadingModel::whitted && s.diffuse != glm::vec3(0);
    sample.reflectance = apart ? s.diffuse : s.diffuse + s.specular;
    sample.mirror = apart ? s.specular : glm::vec3(0);
}

}   // namespace

shading::CentreSample TileTracer::centre_sample(const shading::SurfacePoint& s, scene::ObjectId object,
                                                std::uint32_t triangle) const
{
    shading::CentreSample sample;
    sample.position = s.position, sample.normal = s.normal;
    set_reflectance(s, sample);
    sample.width = s.cone.width;
    sample.object = object;
    sample.material = scene_.meshes[scene_.objects[object].mesh].part_of(triangle).material;
    sample.triangle = triangle;
    sample.apart = s.model == scene::ShadingModel::whitted;
    sample.textured = scene_.materials[sample.material].base_color_texture.used() && !s.layered;
    return sample;
}

void TileTracer::refine(const Tile& tile, const Refinement& refinement, RefinedPixels& pixels)
{
    tile_ = tile;
    refinement_ = &refinement;
    find_refined(pixels);
    constexpr int k_first = scene::k_first_refined_samples, k_all = scene::k_refined_samples;
    const auto channels = static_cast<std::size_t>(refinement.sums.channels());
    values_.resize(refined_.size() * k_all * channels);
    known_.resize(refined_.size() * k_first);

    // Take a few samples of each pixel, and the others where these differ, in what they cover if there is alpha.
    const bool alpha = !refinement.single.alpha.data.empty();
    std::vector<std::uint32_t> chosen(refined_.size());
    for (std::uint32_t r = 0; r < refined_.size(); ++r) chosen[r] = r;
    take_samples(refinement, chosen, 0, k_first);
    std::erase_if(chosen, [&](std::uint32_t r) {
        const glm::ivec2 at = tile_.pixel_of_image(refined_[r].pixel);
        glm::vec3 low = shading::shown(vector_at(refinement.single.color, at.x, at.y), refinement.options.exposure);
        glm::vec3 high = low;
        bool& several = refined_[r].several;
        const bool covered = refinement.centres.at(at.x, at.y).width > 0;
        bool covered_in_part = false;
        for (std::size_t k = 0; k < k_first; ++k) {
            const float* const v = values_.data() + (r * k_all + k) * channels;
            const glm::vec3 c = shading::shown({v[0], v[1], v[2]}, refinement.options.exposure);
            low = glm::min(low, c), high = glm::max(high, c);
            several = several || !shading::same_surface(refinement.centres.at(at.x, at.y), known_[r * k_first + k],
                                                        refinement.options);
            covered_in_part = covered_in_part || (known_[r * k_first + k].width > 0) != covered;
        }
        if (alpha && covered_in_part) return false;
        const shading::RefineOptions& options = refinement.options;
        return shading::difference(high, low) <= (several ? options.spread : options.light_spread);
    });
    take_samples(refinement, chosen, k_first, k_all);

    // Add the samples, each with its share of its pixel.
    const std::size_t number = number_of(tile_);
    for (std::size_t r = 0; r < refined_.size(); ++r) {
        const int further = refined_[r].samples;
        const float share = 1.0f / static_cast<float>(1 + further);
        const glm::ivec2 at = tile_.pixel_of_image(refined_[r].pixel);
        const int x = at.x - tile_.x, y = at.y - tile_.y;
        single_values(refinement.layers, at);
        refinement.sums.add(number, x, y, refinement.weights[0], share, single_values_.data());
        for (std::size_t k = 0; k < static_cast<std::size_t>(further); ++k)
            refinement.sums.add(number, x, y, refinement.weights[k + 1], share,
                                values_.data() + (r * k_all + k) * channels);
        pixels.set_refined(at, refined_[r].found);
    }
    refinement_ = nullptr;
}

void TileTracer::add_single(const Tile& tile, const Refinement& refinement, const RefinedPixels& pixels)
{
    tile_ = tile;
    refinement_ = &refinement;
    for (int y = 0; y < tile.height; ++y)
        for (int x = 0; x < tile.width; ++x) {
            if (!pixels.single(tile.x + x, tile.y + y)) continue;
            const glm::ivec2 at(tile.x + x, tile.y + y);
            if (refinement.centres.varies(at.x, at.y, refinement.single.color, refinement.options)) {
                add_texture(at, refinement);
                continue;
            }
            const bool color_alone = refinement.layers.size() == 1;
            if (!color_alone) single_values(refinement.layers, at);
            refinement.sums.add(number_of(tile), x, y, refinement.lone, 1,
                                color_alone ? refinement.layers[0]->pixel(at.x, at.y) : single_values_.data());
        }
    refinement_ = nullptr;
}

// The light of the pixels around one that shows a texture, per reflectance, and how much of it they mirror.
struct TileTracer::TextureLight {
    std::array<int, 9> pixels;   // of 3 x 3, those that show the same surface
    int count = 0;
    glm::vec3 mirrored[9];
};

// Adds a pixel of one sample as several that differ by the texture alone.
void TileTracer::add_texture(const glm::ivec2& at, const Refinement& refinement)
{
    const int samples = refinement.options.texture_samples;
    const float share = 1.0f / static_cast<float>(1 + samples);
    const std::size_t number = number_of(tile_);
    const int x = at.x - tile_.x, y = at.y - tile_.y;
    const shading::CentreSample& centre = refinement.centres.at(at.x, at.y);
    TextureLight light;
    find_texture_light(at, light);
    single_values(refinement.layers, at);
    refinement.sums.add(number, x, y, refinement.weights[0], share, single_values_.data());
    const shading::TriangleReflectance triangle(scene_, rays_.geometry(centre.object), centre.triangle);
    for (int k = 0; k < samples; ++k) {
        shading::CentreSample sample = centre;
        texture_sample(triangle, at, scene::refined_offset(k), sample);
        light_texture(light, scene::refined_offset(k) - 0.5f, sample);
        refinement.sums.add(number, x, y, refinement.weights[static_cast<std::size_t>(k) + 1], share,
                            single_values_.data());
    }
}

// Finds the pixels around one whose light its texture takes: those that show its surface, if they agree; else itself.
void TileTracer::find_texture_light(const glm::ivec2& at, TextureLight& light)
{
    const shading::RefineOptions& options = refinement_->options;
    const shading::CentreSample& own = refinement_->centres.at(at.x, at.y);
    glm::vec3 low(k_infinity), high(0);
    for (int i = 0; i < 9; ++i) {
        const glm::ivec2 there = at + glm::ivec2(i % 3 - 1, i / 3 - 1);
        if (!refinement_->centres.inside(there.x, there.y)) continue;
        const shading::CentreSample& other = refinement_->centres.at(there.x, there.y);
        if (!shading::same_surface(own, other, options)) continue;
        const glm::vec3 seen = shading::shown(
            shading::relit(vector_at(refinement_->single.color, there.x, there.y), other, own.reflectance),
            options.exposure);
        low = glm::min(low, seen), high = glm::max(high, seen);
        light.pixels[static_cast<std::size_t>(light.count++)] = i;
    }
    if (shading::difference(high, low) > options.agree) light.pixels[0] = 4, light.count = 1;

    // Divide by the reflectance: colour, direct and indirect light.
    const auto channels = static_cast<std::size_t>(refinement_->sums.channels());
    values_.resize(channels * 9);
    for (int j = 0; j < light.count; ++j) {
        const int i = light.pixels[static_cast<std::size_t>(j)];
        const glm::ivec2 there = at + glm::ivec2(i % 3 - 1, i / 3 - 1);
        const shading::CentreSample& other = refinement_->centres.at(there.x, there.y);
        single_values(refinement_->layers, there);
        light.mirrored[j] = other.mirrored;
        for (int c = 0; c < 3; ++c) single_values_[static_cast<std::size_t>(c)] -= other.mirrored[c];
        float* const to = values_.data() + static_cast<std::size_t>(j) * channels;
        std::copy(single_values_.begin(), single_values_.end(), to);
        const glm::vec3 by = 1.0f / (other.reflectance + shading::k_least_reflectance);
        scale_light(to, by);
    }
}
// Multiplies the light of a sample's values: colour, direct and indirect.
void TileTracer::scale_light(float* values, const glm::vec3& by) const
{
    const int layers = options_.backdrop_apart ? 4 : 3;
    for (int c = 0; c < 3; ++c) {
        values[c] *= by[c];
        if (options_.layers) values[layers + c] *= by[c], values[layers + 3 + c] *= by[c];
    }
}

// Makes the values of a place of a texture, in single_values_.
// @param offset  from the pixel's centre, in pixels
void TileTracer::light_texture(const TextureLight& light, const glm::vec2& offset, const shading::CentreSample& sample)
{
    // Interpolate as take_agreed() does.
    float weights[9], sum = 0;
    for (int j = 0; j < light.count; ++j) {
        const int i = light.pixels[static_cast<std::size_t>(j)];
        const glm::vec2 there(i % 3 - 1, i / 3 - 1);
        weights[j] = light.count == 9 ? second_order(offset.x, i % 3) * second_order(offset.y, i / 3)
                                      : nearness(offset.x - there.x) * nearness(offset.y - there.y);
        sum += weights[j];
    }
    const auto channels = static_cast<std::size_t>(refinement_->sums.channels());
    single_values_.assign(channels, 0);
    glm::vec3 mirrored(0);
    for (int j = 0; j < light.count; ++j) {
        const float weight = weights[j] / sum;
        const float* const from = values_.data() + static_cast<std::size_t>(j) * channels;
        for (std::size_t c = 0; c < channels; ++c) single_values_[c] += weight * from[c];
        mirrored += weight * light.mirrored[j];
    }
    scale_light(single_values_.data(), sample.reflectance + shading::k_least_reflectance);
    for (int c = 0; c < 3; ++c) single_values_[static_cast<std::size_t>(c)] += mirrored[c];

    // The parabolas may leave what is possible.
    for (float& value : single_values_) value = std::max(value, 0.0f);
    if (!options_.layers) return;
    const std::size_t layers = options_.backdrop_apart ? 4 : 3;
    const glm::vec3 albedo = sample.reflectance + sample.mirror;
    for (std::size_t c = 0; c < 3; ++c) single_values_[layers + 6 + c] = albedo[static_cast<int>(c)];
    for (std::size_t c = layers + 9; c < channels; ++c) single_values_[c] = std::min(single_values_[c], 1.0f);
}

// What the surface of a pixel's centre shows elsewhere in the pixel, in the plane of its triangle.
// @param sample  that of the centre; its position and its reflectance are replaced, unless the plane is not seen there,
//                or too far from the triangle
void TileTracer::texture_sample(const shading::TriangleReflectance& triangle, const glm::ivec2& at,
                                const glm::vec2& offset, shading::CentreSample& sample) const
{
    constexpr float k_beyond = 1;   // of the triangle, in its own sides
    const auto& p = triangle.corners();
    glm::vec3 origin, direction;
    float tnear, tfar;
    view_.ray(static_cast<float>(at.x) + offset.x, static_cast<float>(at.y) + offset.y, origin, direction, tnear, tfar);

    // Intersect the plane.
    const glm::vec3 a = p[1] - p[0], b = p[2] - p[0], normal = glm::cross(a, b), to = p[0] - origin;
    const float facing = glm::dot(normal, direction);
    const float t = glm::dot(normal, to) / facing;
    if (!(t > 0 && t < k_infinity)) return;
    const glm::vec3 turned = glm::cross(direction, to);
    const float u = -glm::dot(turned, b) / facing, v = glm::dot(turned, a) / facing;
    if (!(std::min(u, v) > -k_beyond && u + v < 1 + k_beyond)) return;

    shading::SurfacePoint s;
    triangle.find(u, v, t, direction, {view_.pixel_width, view_.pixel_spread}, s);
    sample.position = origin + t * direction;
    set_reflectance(s, sample);
}

// Lists the tile's selected pixels, in Morton order.
void TileTracer::find_refined(const RefinedPixels& pixels)
{
    refined_.clear();
    const auto count = static_cast<std::uint32_t>(tile_.side * tile_.side);
    for (std::uint32_t code = 0; code < count; ++code) {
        const int x = static_cast<int>(even_bits(code)), y = static_cast<int>(even_bits(code >> 1));
        if (x >= tile_.width || y >= tile_.height || !pixels.selected(tile_.x + x, tile_.y + y)) continue;
        refined_.push_back({static_cast<std::uint32_t>(y * tile_.side + x)});
    }
    counters_.samples.pixels += refined_.size();
}

// Whether a sample shows a surface that no pixel around has at its centre, and that differs from the pixel's.
bool TileTracer::finds_surface(const Refined& refined, const float* values, const shading::CentreSample& met) const
{
    const glm::ivec2 at = tile_.pixel_of_image(refined.pixel);
    for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx)
            if (refinement_->centres.inside(at.x + dx, at.y + dy) &&
                shading::same_surface(met, refinement_->centres.at(at.x + dx, at.y + dy), refinement_->options))
                return false;
    const float exposure = refinement_->options.exposure;
    return shading::difference(shading::shown({values[0], values[1], values[2]}, exposure),
                               shading::shown(vector_at(refinement_->single.color, at.x, at.y), exposure)) >
           refinement_->options.edge;
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
            for (int k = first; k < end; ++k) wanted_.push_back({refined_[r].pixel, static_cast<std::uint32_t>(k), r});
            refined_[r].samples = end;
        }
        shade_samples(wanted_);
        for (std::size_t i = 0; i < wanted_.size(); ++i) {
            const std::size_t to = some[i / samples] * std::size_t{scene::k_refined_samples} + wanted_[i].number;
            values_of(i, values_.data() + to * channels);
            Refined& pixel = refined_[some[i / samples]];
            pixel.found = pixel.found || finds_surface(pixel, values_.data() + to * channels, met_[i]);
            if (first == 0) known_[some[i / samples] * static_cast<std::size_t>(end) + wanted_[i].number] = met_[i];
        }
    }
}

// Computes the light of further samples: in color_ and the other sums, by their numbers in the list.
void TileTracer::shade_samples(std::span<const FurtherSample> samples)
{
    interruption_point();
    Stopwatch watch(times_);
    samples_ = samples;
    clear_sums(samples.size());
    met_.assign(samples.size(), {});
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
}

// Gives a further sample light that is known around it.
// @param point  a camera ray met it
// @return  false: its light must be computed
bool TileTracer::take_light(const TilePoint& point, scene::ObjectId object, std::uint32_t triangle)
{
    shading::CentreSample& own = met_[point.pixel];
    own = centre_sample(point.surface, object, triangle);
    // The last samples of a pixel of one surface are there for its light, which must agree.
    const FurtherSample& sample = samples_[point.pixel];
    const bool first = sample.number < scene::k_first_refined_samples;
    const bool several = refined_[sample.refined].several;
    bool taken = (first || !several) && take_agreed(sample, point.pixel, own);
    if (!first && !taken) taken = take_nearest(point, own, !several);
    if (!taken) ++counters_.samples.shaded;
    return taken;
}

// Takes the light of the pixels around a sample that show the same surface, if these agree.
// @param to  its number in the sums
bool TileTracer::take_agreed(const FurtherSample& sample, std::uint32_t to, shading::CentreSample& own)
{
    const shading::RefineOptions& options = refinement_->options;
    const shading::FrameBuffers& single = refinement_->single;
    const glm::ivec2 at = tile_.pixel_of_image(sample.pixel);
    const glm::vec2 offset = scene::refined_offset(static_cast<int>(sample.number)) - 0.5f;

    // Compare their light, as this surface would reflect it.
    float weights[9];
    glm::vec3 low(k_infinity), high(0);
    float sum = 0;
    int same = 0;
    for (int i = 0; i < 9; ++i) {
        const glm::ivec2 there = at + glm::ivec2(i % 3 - 1, i / 3 - 1);
        weights[i] = 0;
        if (!refinement_->centres.inside(there.x, there.y)) continue;
        const shading::CentreSample& other = refinement_->centres.at(there.x, there.y);
        if (!shading::same_surface(own, other, options)) continue;
        const glm::vec3 seen = shading::shown(
            shading::relit(vector_at(single.color, there.x, there.y), other, own.reflectance), options.exposure);
        low = glm::min(low, seen), high = glm::max(high, seen);
        ++same;
        const glm::vec2 apart = offset - glm::vec2(there - at);
        sum += weights[i] = nearness(apart.x) * nearness(apart.y);
    }
    if (!(sum > 0) || shading::difference(high, low) > options.agree) return false;

    // Interpolate: by a surface of second order through all nine, which blurs nothing; else by the mean, near ones
    // first.
    if (same == 9) {
        sum = 1;
        for (int i = 0; i < 9; ++i) weights[i] = second_order(offset.x, i % 3) * second_order(offset.y, i / 3);
    }
    for (int i = 0; i < 9; ++i) {
        if (weights[i] == 0) continue;
        const glm::ivec2 there = at + glm::ivec2(i % 3 - 1, i / 3 - 1);
        single_values(refinement_->layers, there);
        add_share(to, own, refinement_->centres.at(there.x, there.y), weights[i] / sum, single_values_.data());
    }
    // Near black, the parabolas may pass below it.
    color_[to] = glm::max(color_[to], glm::vec3(0));
    if (!options_.layers) return true;
    direct_[to] = glm::max(direct_[to], glm::vec3(0)),
    indirect_color_[to] = glm::max(indirect_color_[to], glm::vec3(0));
    for (std::size_t l = 0, lights = scene_.lights.size(); l < lights; ++l) {
        float& lit = shadow_[to * lights + l];
        lit = std::clamp(lit, 0.0f, 1.0f);
    }
    return true;
}

// Gives a further sample, whose other light is computed, the bounced light of the pixels around it that show the same
// surface, if these agree in it. It changes slowly over a surface, and is dear where only further samples show one, as
// that needs new cache points. So the nearest pixels that show the surface may be a few away.
TileTracer::Bounced TileTracer::take_bounced(const TilePoint& point)
{
    if (!indirect_ || is_estimate_ || point.behind) return Bounced::unknown;
    const glm::vec2 offset = scene::refined_offset(static_cast<int>(samples_[point.pixel].number)) - 0.5f;
    return take_bounced(point, offset, met_[point.pixel], refinement_->centres, refinement_->options,
                        &refinement_->single.color);
}

// @param offset  of the sample from its pixel's centre
// @param own     what the sample met
// @param color   optional: of the pixels; bounced light beside other light may differ more
TileTracer::Bounced TileTracer::take_bounced(const TilePoint& point, const glm::vec2& offset,
                                             const shading::CentreSample& own, const shading::CentreSamples& centres,
                                             const shading::RefineOptions& options, const ImageF* color)
{
    constexpr float k_least_square = 1e-4f;   // of a distance in pixels
    const glm::ivec2 at = tile_.pixel_of_image(samples_[point.pixel].pixel);
    glm::vec3 low(k_infinity), high(0), mean(0), others(color ? k_infinity : 0);
    float sum = 0;
    const auto look_at = [&](int dx, int dy) {
        const glm::ivec2 there = at + glm::ivec2(dx, dy);
        if (!centres.inside(there.x, there.y)) return;
        const shading::CentreSample& other = centres.at(there.x, there.y);
        if (!shading::same_surface(own, other, options)) return;
        const glm::vec3 bounced = shading::relit(other.bounced, other.reflectance, own.reflectance);
        low = glm::min(low, bounced), high = glm::max(high, bounced);
        if (color) {
            const glm::vec3 rest = vector_at(*color, there.x, there.y) - other.bounced;
            others = glm::min(others, glm::max(shading::relit(rest, other, own.reflectance), glm::vec3(0)));
        }
        const glm::vec2 apart = offset - glm::vec2(dx, dy);
        const float weight = 1 / (glm::dot(apart, apart) + k_least_square);
        mean += weight * bounced, sum += weight;
    };
    // Look at the 3 x 3 pixels around it, then at one ring of pixels after the other.
    for (int reach = 1; reach <= options.bounced_reach && sum == 0; ++reach)
        for (int dy = -reach; dy <= reach; ++dy) {
            const bool whole = reach == 1 || std::abs(dy) == reach;
            for (int dx = -reach; dx <= reach; dx += whole ? 1 : 2 * reach) look_at(dx, dy);
        }
    if (!(sum > 0)) return Bounced::unknown;

    const glm::vec3 dark = shading::shown(others + low, options.exposure);
    const glm::vec3 bright = shading::shown(others + high, options.exposure);
    if (shading::difference(bright, dark) > options.agree_bounced) return Bounced::disagrees;
    mean /= sum;
    color_[point.pixel] += mean;
    if (options_.layers) indirect_color_[point.pixel] += mean;
    return Bounced::taken;
}

// Takes the light of the samples near a sample that show the same surface: those at the centres of the pixels around
// it, and the first few of its own pixel.
// @param agreed  only if the nearest of them agree
bool TileTracer::take_nearest(const TilePoint& point, shading::CentreSample& own, bool agreed)
{
    constexpr int k_first = scene::k_first_refined_samples;
    constexpr float k_least_square = 1e-4f;   // of a distance in pixels
    constexpr std::size_t k_nearest = 3;      // that must agree
    const FurtherSample& sample = samples_[point.pixel];
    const glm::ivec2 at = tile_.pixel_of_image(sample.pixel);
    const glm::vec2 offset = scene::refined_offset(static_cast<int>(sample.number));
    const shading::CentreSample* const known = known_.data() + sample.refined * std::size_t{k_first};

    // Weigh them by the inverse square of the squared distance.
    const auto channels = static_cast<std::size_t>(refinement_->sums.channels());
    const float* const first_values = values_.data() + sample.refined * scene::k_refined_samples * channels;
    float weights[9 + k_first];
    float sum = 0;
    std::array<std::pair<float, glm::vec3>, k_nearest> nearest;
    nearest.fill({k_infinity, glm::vec3(0)});
    for (int i = 0; i < 9 + k_first; ++i) {
        weights[i] = 0;
        glm::vec2 apart;
        const shading::CentreSample* other = nullptr;
        glm::vec3 color;
        if (i < 9) {
            const glm::ivec2 there = at + glm::ivec2(i % 3 - 1, i / 3 - 1);
            if (!refinement_->centres.inside(there.x, there.y)) continue;
            other = &refinement_->centres.at(there.x, there.y);
            apart = offset - 0.5f - glm::vec2(there - at);
            color = vector_at(refinement_->single.color, there.x, there.y);
        } else {
            other = known + (i - 9);
            apart = offset - scene::refined_offset(i - 9);
            const float* const values = first_values + static_cast<std::size_t>(i - 9) * channels;
            color = {values[0], values[1], values[2]};
        }
        if (!shading::same_surface(own, *other, refinement_->options)) continue;
        const float square = glm::dot(apart, apart) + k_least_square;
        sum += weights[i] = 1 / (square * square);
        if (!agreed || !(square < nearest.back().first)) continue;
        nearest.back() = {
            square, shading::shown(shading::relit(color, *other, own.reflectance), refinement_->options.exposure)};
        for (std::size_t k = k_nearest - 1; k > 0 && nearest[k].first < nearest[k - 1].first; --k)
            std::swap(nearest[k], nearest[k - 1]);
    }
    if (!(sum > 0)) return false;
    if (agreed) {
        if (nearest.back().first == k_infinity) return false;
        glm::vec3 low(k_infinity), high(0);
        for (const auto& [square, color] : nearest) low = glm::min(low, color), high = glm::max(high, color);
        if (shading::difference(high, low) > refinement_->options.agree) return false;
    }
    for (int i = 0; i < 9 + k_first; ++i) {
        if (weights[i] == 0) continue;
        if (i < 9) {
            const glm::ivec2 there = at + glm::ivec2(i % 3 - 1, i / 3 - 1);
            single_values(refinement_->layers, there);
            add_share(point.pixel, own, refinement_->centres.at(there.x, there.y), weights[i] / sum,
                      single_values_.data());
        } else {
            add_share(point.pixel, own, known[i - 9], weights[i] / sum,
                      first_values + static_cast<std::size_t>(i - 9) * channels);
        }
    }
    return true;
}

// Adds a share of what another sample showed of a surface, at a sample's own reflectance.
// @param values  in the order of averaged_layers()
void TileTracer::add_share(std::uint32_t to, shading::CentreSample& own, const shading::CentreSample& of, float weight,
                           const float* values)
{
    const auto take = [&](const glm::vec3& mirrored) {
        const glm::vec3 light(values[0], values[1], values[2]);
        values += 3;
        return weight * (shading::relit(light - mirrored, of.reflectance, own.reflectance) + mirrored);
    };
    color_[to] += take(of.mirrored);
    own.mirrored += weight * of.mirrored;
    if (options_.backdrop_apart) backdrop_[to] += glm::vec3(weight * (1 - *values++));
    if (!options_.layers) return;
    direct_[to] += take(glm::vec3(0));
    indirect_color_[to] += take(glm::vec3(0));
    albedo_[to] += weight * (own.reflectance + own.mirror);
    values += 3;
    const std::size_t lights = scene_.lights.size();
    for (std::size_t l = 0; l < lights; ++l) shadow_[to * lights + l] += weight * values[l];
}

// The values of a pixel's first sample, in the order of averaged_layers().
void TileTracer::single_values(std::span<const ImageF* const> layers, const glm::ivec2& pixel)
{
    single_values_.clear();
    for (const ImageF* layer : layers) {
        const float* const from = layer->pixel(pixel.x, pixel.y);
        single_values_.insert(single_values_.end(), from, from + layer->channels);
    }
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
