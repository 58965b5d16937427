// SPDX-License-Identifier: Apache-2.0
#include "gnomon/frame.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/image.h"
#include "gnomon/error.h"
#include "image/tone_map.h"
#include "io/file/output_name.h"
#include "io/image/exr.h"
#include "io/image/image_file.h"

namespace gnomon {

namespace {

// Returns the bytes of one value.
template <class T>
const T* value_at(const Layer& layer, PixelFormat format, int x, int y, int channel)
{
    const int channels = static_cast<int>(layer.channels.size());
    if (layer.format != format)
        throw UsageError(fmt::format("layer '{}': its values are {}", layer.name,
                                     layer.format == PixelFormat::u32 ? "ids" : "no ids"));
    if (x < 0 || y < 0 || channel < 0 || x >= layer.size.width || y >= layer.size.height || channel >= channels)
        throw UsageError(fmt::format("layer '{}': no channel {} of pixel {} {}: there are {} of {} x {} pixels",
                                     layer.name, channel, x, y, channels, layer.size.width, layer.size.height));
    const auto* row = static_cast<const std::byte*>(layer.data) + y * layer.row_stride;
    return reinterpret_cast<const T*>(row + x * layer.pixel_stride) + channel;
}

template <class T>
std::span<const T> all_values(const Layer& layer, PixelFormat format)
{
    const auto pixels = static_cast<std::size_t>(layer.size.width) * static_cast<std::size_t>(layer.size.height);
    if (pixels == 0) return {};
    const auto pixel = static_cast<std::ptrdiff_t>(layer.channels.size() * sizeof(T));
    if (layer.pixel_stride != pixel || layer.row_stride != layer.size.width * pixel)
        throw UsageError(fmt::format("layer '{}': its values are not adjacent in memory", layer.name));
    return {value_at<T>(layer, format, 0, 0, 0), pixels * layer.channels.size()};
}

}   // namespace

float Layer::value(int x, int y, int channel) const
{
    return *value_at<float>(*this, PixelFormat::f32, x, y, channel);
}

std::uint32_t Layer::id(int x, int y, int channel) const
{
    return *value_at<std::uint32_t>(*this, PixelFormat::u32, x, y, channel);
}

std::span<const float> Layer::values() const
{
    return all_values<float>(*this, PixelFormat::f32);
}

std::span<const std::uint32_t> Layer::ids() const
{
    return all_values<std::uint32_t>(*this, PixelFormat::u32);
}

std::vector<float> Layer::copy() const
{
    const std::span<const float> all = values();
    return {all.begin(), all.end()};
}

const Layer* Frame::layer(const std::string& name) const
{
    for (const Layer& candidate : layers)
        if (candidate.name == name) return &candidate;
    return nullptr;
}

namespace {

void encode(std::span<const float> rgb, double exposure, ToneMap curve, std::span<std::uint8_t> out)
{
    image::encode_srgb8(rgb, exposure, curve, out);
}

void encode(std::span<const float> rgb, double exposure, ToneMap curve, std::span<std::uint16_t> out)
{
    image::encode_srgb16(rgb, exposure, curve, out);
}

float linear_of(std::uint8_t code)
{
    return linear_from_srgb8()[code];
}

float linear_of(std::uint16_t code)
{
    return linear_from_srgb(static_cast<float>(code) / 65535.0f);
}

// The layer of alpha; null if the frame has none.
const Layer* alpha_of(const Frame& frame)
{
    if (frame.layers.empty()) throw UsageError("a frame without layers has no image");
    return frame.background == BackgroundKind::environment ? nullptr : frame.layer("alpha");
}

template <class T>
std::vector<T> shown_with_alpha(const Frame& frame)
{
    const Layer* const alpha = alpha_of(frame);
    const std::span<const float> rgb = frame.layers.front().values();
    const std::size_t pixels = rgb.size() / 3;
    std::vector<float> apart(rgb.begin(), rgb.end());
    if (alpha)
        for (std::size_t i = 0; i < rgb.size(); ++i) {
            const float a = alpha->values()[i / 3];
            apart[i] = a > 0 ? rgb[i] / a : 0.0f;
        }
    std::vector<T> opaque(rgb.size()), values(pixels * 4);
    encode(apart, frame.exposure, frame.tonemap, opaque);
    for (std::size_t p = 0; p < pixels; ++p) {
        for (std::size_t c = 0; c < 3; ++c) values[4 * p + c] = opaque[3 * p + c];
        const float a = alpha ? std::clamp(alpha->values()[p], 0.0f, 1.0f) : 1.0f;
        values[4 * p + 3] = static_cast<T>(std::lround(std::numeric_limits<T>::max() * a));
    }
    return values;
}

template <class T>
std::vector<T> shown(const Frame& frame)
{
    const Layer* const alpha = alpha_of(frame);
    const std::span<const float> rgb = frame.layers.front().values();
    std::vector<T> values(rgb.size());
    if (!alpha) {
        encode(rgb, frame.exposure, frame.tonemap, values);
        return values;
    }
    // Tone-map colours as they are where they cover a pixel, and blend them as linear light.
    const std::vector<T> covering = shown_with_alpha<T>(frame);
    const std::span<const float> covered = alpha->values();
    std::vector<float> blended(rgb.size());
    for (std::size_t i = 0; i < rgb.size(); ++i) {
        const float behind =
            frame.background == BackgroundKind::color ? linear_from_srgb(frame.background_color[i % 3]) : 0.0f;
        const float a = covered[i / 3];
        blended[i] = a * linear_of(covering[i / 3 * 4 + i % 3]) + (1 - a) * behind;
    }
    encode(blended, 0, ToneMap::none, values);
    return values;
}

// What an .exr says beside its pixels.
io::ExrMetadata metadata_of(const Frame& frame)
{
    io::ExrMetadata metadata;
    metadata.frame = frame.frame;
    metadata.time = frame.time;
    metadata.fps = frame.fps;
    metadata.exposure = frame.exposure;
    metadata.instruction_set = frame.instruction_set;
    if (frame.view_size == frame.size) {   // otherwise, an overlay surrounds the view
        metadata.world_to_camera = frame.world_to_camera.m;
        metadata.world_to_image = frame.world_to_image.m;
    }
    return metadata;
}

}   // namespace

std::vector<std::uint8_t> Frame::to_srgb8() const
{
    return shown<std::uint8_t>(*this);
}

std::vector<std::uint16_t> Frame::to_srgb16() const
{
    return shown<std::uint16_t>(*this);
}

std::vector<std::uint8_t> Frame::to_srgb8_alpha() const
{
    return shown_with_alpha<std::uint8_t>(*this);
}

std::vector<std::uint16_t> Frame::to_srgb16_alpha() const
{
    return shown_with_alpha<std::uint16_t>(*this);
}

void Frame::write(const std::filesystem::path& file, const ImageOptions& options) const
{
    if (io::output_kind(file) == io::OutputKind::video)
        throw UsageError(fmt::format("{}: one image is not a video; write .png, .jpg or .exr", file.string()));
    if (options.quality < 0 || options.quality > 100)
        throw UsageError(fmt::format("{}: quality {}: expected 0 to 100", file.string(), options.quality));
    if (io::is_exr_name(file)) {
        std::vector<Layer> written = layers;
        for (Layer& layer : written)
            if (layer.name == "alpha") layer.name.clear();   // the image's channel A
        io::write_exr(file, size, written, options, metadata_of(*this));
        return;
    }
    const bool transparent = background == BackgroundKind::transparent && layer("alpha");
    const bool jpeg = io::is_jpeg_name(file);
    if (jpeg && transparent)
        throw UsageError(
            fmt::format("{}: a .jpg has no alpha, and the background is transparent: write .png or .exr, "
                        "or choose a background of one colour",
                        file.string()));
    Image8 image(size.width, size.height, transparent ? 4 : 3);
    image.data = transparent ? to_srgb8_alpha() : to_srgb8();
    if (jpeg)
        io::write_jpeg(file, image, options.quality);
    else
        io::write_png(file, image);
}

}   // namespace gnomon
